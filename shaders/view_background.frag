#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require

// The picture's background: a colour for each row.

#include "shaders/view_screen.h"

layout(set = 0, binding = SCREEN_BACKGROUND, std430) readonly buffer Background {
    uint background[];
};

layout(location = 0) out vec4 drawn;

void main() {
    drawn = unpackUnorm4x8(background[uint(gl_FragCoord.y)]);
}
