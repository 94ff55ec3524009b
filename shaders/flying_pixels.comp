#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

// Pulls pixels that hang between two surfaces to one (docs/conventions.md): a lane per texel of eight.
// Invalid codes stay as stored.

#include "shaders/surface_codes.h"
#include "shaders/texels.h"
#include "shaders/code_curve.h"

layout(local_size_x = flying_pixels_group) in;
layout(constant_id = 0) const uint sample_bytes = 2u;
layout(push_constant, std430) uniform Push { FlyingPixelsPush push; };
layout(set = 0, binding = 0) uniform utextureBuffer stored_texels;
layout(set = 0, binding = 1, std430) writeonly buffer Codes { u64vec2 out_codes[]; };

const int none = -1;

/// A code, or `none` where it is invalid or outside the picture.
int code_at(int x, int y) {
    const int there_x = clamp(x, 0, int(push.width) - 1), there_y = clamp(y, 0, int(push.height) - 1);
    const int per_texel = sample_bytes == 1u ? 16 : 8, per_word = per_texel / 4;
    const uint word = texelFetch(stored_texels, there_y * int(push.in_pitch) + there_x / per_texel)[there_x / per_word % 4];
    const uint code = sample_bytes == 1u ? bitfieldExtract(word, 8 * (there_x % 4), 8) : bitfieldExtract(word, 16 * (there_x % 2), 16);
    const bool valid = there_x == x && there_y == y && code_is_in_range(code, push.valid) && !code_is_excluded(code, push.valid);
    return valid ? int(code) : none;
}

bool differ(int a, int b, int gate) { return abs(a - b) > gate; }

/// Where a line away from a pixel meets a surface: its code, `none` for nowhere, and the steps to there. ramp_end of
/// engine/surface/flying_pixels.hpp.
ivec2 ramp_end(int code, int next_code, int gate, int x, int y, int dx, int dy) {
    int before = code, here = next_code, next = code_at(x + 2 * dx, y + 2 * dy);
    bool is_ramp = differ(before, here, gate);
    for (int n = 2; n < int(most_ramp_steps); ++n) {
        const int beyond = next < 0 ? none : code_at(x + (n + 1) * dx, y + (n + 1) * dy);
        if (beyond < 0) break;
        const bool steps_on = differ(here, next, gate);
        is_ramp = is_ramp && steps_on && (next > here) == (here > before);
        if (n > 2 && !is_ramp) break;
        if (!differ(next, beyond, gate)) return ivec2(next, steps_on ? n : 1);
        before = here;
        here = next;
        next = beyond;
    }
    return ivec2(none, 0);
}

/// Takes the nearer side of a line into `landed` and `widest`, if a pixel hangs between both.
void judge(int code, int gate, int x, int y, int dx, int dy, inout int landed, inout int widest) {
    const int next_a = code_at(x - dx, y - dy), next_b = code_at(x + dx, y + dy);
    if (next_a < 0 || next_b < 0 || max(abs(code - next_a), abs(code - next_b)) <= gate) return;
    const ivec2 a = ramp_end(code, next_a, gate, x, y, -dx, -dy);
    if (a.x < 0) return;
    const ivec2 b = ramp_end(code, next_b, gate, x, y, dx, dy);
    if (b.x < 0 || a.y + b.y > int(most_ramp_steps)) return;
    const int low = min(a.x, b.x), high = max(a.x, b.x);
    if (code - low <= 2 * gate || high - code <= 2 * gate) return;
    const int side = code - low <= high - code ? low : high;
    if (high - low < widest || (high - low == widest && side >= landed)) return;
    landed = side;
    widest = high - low;
}

uint landed_code(int x, int y, uint stored) {
    const int code = int(stored), gate = int(max(curve_at(push.gate, stored), 1u));
    int landed = code, widest = 0;
    judge(code, gate, x, y, 1, 0, landed, widest);
    judge(code, gate, x, y, 0, 1, landed, widest);
    judge(code, gate, x, y, 1, 1, landed, widest);
    judge(code, gate, x, y, 1, -1, landed, widest);
    return uint(landed);
}

void main() {
    const uint texel = gl_GlobalInvocationID.x, y = gl_GlobalInvocationID.y;
    if (texel >= push.out_pitch) return;
    const uint row = y * push.in_pitch;
    uint codes[8];
    if (sample_bytes == 1u) {
        const uvec4 bytes = texelFetch(stored_texels, int(row + (texel >> 1)));
        const uvec2 words = (texel & 1u) == 0u ? bytes.xy : bytes.zw;
        [[unroll]] for (int k = 0; k < 8; ++k) codes[k] = bitfieldExtract(words[k / 4], 8 * (k % 4), 8);
    } else {
        codes = unpacked_halves(texelFetch(stored_texels, int(row + texel))).v;
    }
    for (int k = 0; k < 8; ++k) {
        const uint x = 8u * texel + uint(k);
        const bool valid = code_is_in_range(codes[k], push.valid) && !code_is_excluded(codes[k], push.valid);
        if (x < push.width && valid) codes[k] = landed_code(int(x), int(y), codes[k]);
    }
    out_codes[y * push.out_pitch + texel] = packed(codes);
}
