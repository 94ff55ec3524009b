#version 460
#extension GL_GOOGLE_include_directive : require

// A corner of what a ball's shadow may reach on the screen.

#include "shaders/view_marks.h"

layout(set = 0, binding = 0, std430) readonly buffer Shadows {
    ShadowRecord shadows[];
};

layout(location = 0) flat out uint shadow;

void main() {
    const vec4 bounds = shadows[gl_InstanceIndex].bounds;
    const bool right = gl_VertexIndex == 1 || gl_VertexIndex == 3 || gl_VertexIndex == 4;
    const bool below = gl_VertexIndex == 2 || gl_VertexIndex == 4 || gl_VertexIndex == 5;
    shadow = uint(gl_InstanceIndex);
    gl_Position = vec4(right ? bounds.z : bounds.x, below ? bounds.w : bounds.y, 0.0f, 1.0f);
}
