#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require

// A corner of the part of the screen that a ball's shadow may reach.

#include "shaders/view_marks.h"
#include "shaders/view_quad.h"

layout(set = 0, binding = 0, std430) readonly buffer Shadows {
    ShadowRecord shadows[];
};

layout(location = 0) flat out uint shadow;

void main() {
    const vec4 bounds = shadows[gl_InstanceIndex].bounds;
    shadow = uint(gl_InstanceIndex);
    gl_Position = vec4(mix(bounds.xy, bounds.zw, quad_corner()), 0.0f, 1.0f);
}
