#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require

// Red, green and blue -> codes (hue_code.h), a lane per eight pixels of a row: 24 bytes in, a texel out. A
// colour without a depth becomes a code beyond every valid one (engine/scene/frames.hpp).

#include "shaders/hue_code.h"
#include "shaders/surface_codes.h"

layout(local_size_x = hue_codes_group) in;
layout(push_constant, std430) uniform Push { HueCodesPush push; };
layout(set = 0, binding = 0, std430) readonly buffer Colours { uint colours[]; };
layout(set = 0, binding = 1, std430) writeonly buffer Codes { uvec4 out_codes[]; };

void main() {
    const uint texels = (push.width + 7u) >> 3;
    const uint texel = gl_GlobalInvocationID.x, row = gl_GlobalInvocationID.y;
    if (texel >= texels || row >= push.height) return;
    uint words[6];
    [[unroll]] for (int k = 0; k < 6; ++k) words[k] = colours[row * push.in_pitch + 6u * texel + uint(k)];
    uint codes[8];
    [[unroll]] for (int k = 0; k < 8; ++k) {
        uint rgb[3];
        [[unroll]] for (int c = 0; c < 3; ++c)
            rgb[c] = bitfieldExtract(words[(3 * k + c) / 4], 8 * ((3 * k + c) % 4), 8);
        codes[k] = hue_is_valid(rgb[0], rgb[1], rgb[2], push.least_sum) ? hue_code(rgb[0], rgb[1], rgb[2])
                                                                        : no_hue_code;
    }
    out_codes[row * push.out_pitch + texel] = uvec4(codes[0] | codes[1] << 16, codes[2] | codes[3] << 16,
                                                    codes[4] | codes[5] << 16, codes[6] | codes[7] << 16);
}
