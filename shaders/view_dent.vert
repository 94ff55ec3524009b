#version 460
#extension GL_GOOGLE_include_directive : require

// A corner of what a dent may reach on the screen.

#include "shaders/dents.h"

layout(set = 0, binding = 0, std430) readonly buffer Dents {
    DentHeader header;
    DentRecord dents[];
};

void main() {
    const vec4 bounds = dents[gl_InstanceIndex].bounds;
    const bool right = gl_VertexIndex == 1 || gl_VertexIndex == 3 || gl_VertexIndex == 4;
    const bool below = gl_VertexIndex == 2 || gl_VertexIndex == 4 || gl_VertexIndex == 5;
    gl_Position = vec4(right ? bounds.z : bounds.x, below ? bounds.w : bounds.y, 0.0f, 1.0f);
}
