#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

// Codes of a pair of frames -> q of every pixel, to be drawn.

#include "shaders/blend_rule.h"
#include "shaders/unproject.h"

layout(local_size_x = UNPROJECT_LANES) in;
layout(constant_id = 0) const uint is_pair = 1u;
layout(constant_id = 1) const uint has_heights = 1u;
layout(constant_id = 2) const uint is_range = 1u;
layout(constant_id = 3) const uint is_inverse = 0u;
layout(constant_id = 4) const uint is_from_top = 0u;
layout(constant_id = 5) const uint is_log = 0u;

layout(push_constant, std430) uniform Push {
    UnprojectPush push;
};
layout(set = 0, binding = UNPROJECT_CODES) uniform utextureBuffer codes;
layout(set = 0, binding = UNPROJECT_VALIDITY, std430) readonly buffer Validity {
    uint validity[];
};
layout(set = 0, binding = UNPROJECT_HEIGHTS) uniform utextureBuffer heights;
layout(set = 0, binding = UNPROJECT_NEXT_CODES) uniform utextureBuffer next_codes;
layout(set = 0, binding = UNPROJECT_NEXT_VALIDITY, std430) readonly buffer NextValidity {
    uint next_validity[];
};
layout(set = 0, binding = UNPROJECT_NEXT_HEIGHTS) uniform utextureBuffer next_heights;
// In the widest words: stores cost by the word.
layout(set = 0, binding = UNPROJECT_Q, std430) writeonly buffer Q {
    u64vec4 q_at[];
};

// The n-th 16 bits.
uint part(uvec4 texel, int n) {
    return n % 2 == 0 ? texel[n / 2] & 0xffffu : texel[n / 2] >> 16;
}

float depth_of(uint code) {
    const float m = float(is_from_top != 0u ? push.code_max - code : code);
    if (is_log != 0u) return push.base + push.from_shift * grown(push.step * m, push.step_low * m);
    const float length_of_code = push.base + push.step * m;
    return is_inverse != 0u ? 1.0f / length_of_code - push.shift : length_of_code;
}

uint64_t pair_of(float first, float second) {
    return packUint2x32(uvec2(floatBitsToUint(first), floatBitsToUint(second)));
}

// Eight pixels of a row from column `x`; bits 0 to 7 say which are valid. v2: the square of their rays' v.
u64vec4 eight(uint row, uint texel, uint x, uint valids, uint next_valids, float v2) {
    // Beyond the last texel of a row no pixel is valid, whatever the code.
    const int at = int(row * push.pitch + min(texel, push.pitch - 1u));
    const uvec4 code = texelFetch(codes, at);
    uvec4 next_code = uvec4(0u), height = uvec4(0u), next_height = uvec4(0u);
    if (is_pair != 0u) next_code = texelFetch(next_codes, at);
    if (has_heights != 0u && push.height_per_code != 0.0f) height = texelFetch(heights, at);
    if (is_pair != 0u && has_heights != 0u && push.next_height_per_code != 0.0f)
        next_height = texelFetch(next_heights, at);

    float q[8];
    [[unroll]] for (int n = 0; n < 8; ++n) {
        float depth = depth_of(part(code, n));
        if (has_heights != 0u) depth -= push.height_per_code * float(part(height, n));
        bool valid = (valids >> n & 1u) != 0u;
        if (is_pair != 0u) {
            float next_depth = depth_of(part(next_code, n));
            if (has_heights != 0u) next_depth -= push.next_height_per_code * float(part(next_height, n));
            const bool next_valid = (next_valids >> n & 1u) != 0u;
            // If there is nothing half-way, the pixel takes the state of the frame nearer in time.
            const bool mixes = valid && next_valid && depths_mix(depth, next_depth, push.reach);
            const bool is_next = !mixes && push.blend >= 0.5f;
            const float mixed = depth * push.rest + next_depth * push.blend;
            depth = mixes ? mixed : (is_next ? next_depth : depth);
            valid = is_next ? next_valid : valid;
        }
        float ray = 1.0f;
        if (is_range != 0u) {
            const float u = (float(x + uint(n)) - push.cx) * push.per_fx;
            ray = sqrt(u * u + v2 + 1.0f);
        }
        q[n] = valid ? ray / depth : 0.0f;
    }
    return u64vec4(pair_of(q[0], q[1]), pair_of(q[2], q[3]), pair_of(q[4], q[5]), pair_of(q[6], q[7]));
}

void main() {
    const uint word = gl_GlobalInvocationID.x, row = word / push.words, column = word % push.words;
    if (row >= push.height) return;
    const float v = (float(row) - push.cy) * push.per_fy;
    const uint valids = validity[word];
    uint next_valids = 0u;
    if (is_pair != 0u) next_valids = next_validity[word];
    [[unroll]] for (uint k = 0u; k < 4u; ++k) {
        const uint texel = 4u * column + k;
        q_at[4u * word + k] = eight(row, texel, 8u * texel, valids >> 8u * k, next_valids >> 8u * k, v * v);
    }
}
