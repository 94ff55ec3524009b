#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require

// Codes in rows of whole texels -> rows without gaps, as in a SurfaceFrame: then the CPU reads them where
// they were copied to. Two neighbours a lane.

#include "shaders/surface_codes.h"

layout(local_size_x = pack_rows_group) in;
layout(push_constant, std430) uniform Push { PackRowsPush push; };
layout(set = 0, binding = 0, std430) readonly buffer Codes { uint codes[]; };
layout(set = 0, binding = 1, std430) writeonly buffer Packed { uint out_codes[]; };

uint code(uint n) {
    const uint x = n % push.width, words = codes[n / push.width * push.pitch + x / 2u];
    return x % 2u == 0u ? words & 0xFFFFu : words >> 16;
}

void main() {
    const uint word = gl_GlobalInvocationID.x, n = 2u * word;
    if (n >= push.count) return;
    out_codes[word] = code(n) | (n + 1u < push.count ? code(n + 1u) << 16 : 0u);
}
