#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require

// A corner of the part of the screen that a dent may reach.

#include "shaders/dents.h"
#include "shaders/view_quad.h"

void main() {
    const vec4 bounds = dents[gl_InstanceIndex].bounds;
    gl_Position = vec4(mix(bounds.xy, bounds.zw, quad_corner()), 0.0f, 1.0f);
}
