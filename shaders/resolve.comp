#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

// Packed pixels -> colours and z.

#include "shaders/resolve.h"

layout(local_size_x = RESOLVE_LANES) in;
layout(push_constant, std430) uniform Push {
    ResolvePush push;
};
layout(set = 0, binding = RESOLVE_PIXELS) uniform utextureBuffer pixels;
layout(set = 0, binding = RESOLVE_BACKGROUND, std430) readonly buffer Background {
    uint background[];
};
// In the widest words: stores cost by the word.
layout(set = 0, binding = RESOLVE_COLOURS, std430) writeonly buffer Colours {
    u64vec4 colours[];
};
layout(set = 0, binding = RESOLVE_Z, std430) writeonly buffer Z {
    u64vec4 z[];
};

void main() {
    const uint at = gl_GlobalInvocationID.x, row = at / push.steps;
    if (row >= push.height) return;
    const uint empty = background[row];
    u64vec4 colour, depth;
    [[unroll]] for (int n = 0; n < 4; ++n) {
        const uvec4 two = texelFetch(pixels, int(4u * at) + n);  // colour and z, twice
        colour[n] = packUint2x32(uvec2(two.y != 0u ? two.x : empty, two.w != 0u ? two.z : empty));
        depth[n] = packUint2x32(two.yw);
    }
    colours[at] = colour;
    z[at] = depth;
}
