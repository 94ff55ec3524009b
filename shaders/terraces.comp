#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

// One pass of terrace removal over working codes (docs/conventions.md): a lane goes along a row, texel by
// texel, and keeps three texels each of its own row and of those `tap` above and below. Taps that are farther
// away than a texel are whole texels away, and are loaded separately.

#include "shaders/surface_codes.h"

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const int tap = 8;      // pixels from the centre to its taps: at most 8, or a multiple of 8
layout(constant_id = 2) const uint is_last = 0u;  // 1: codes are doubled, and held near what they were before all passes
layout(constant_id = 3) const uint has_levels = 0u;  // 1: levels differ in distance; 0: all are push.step apart
layout(push_constant, std430) uniform Push { TerracesPush push; };
layout(set = 0, binding = 0) uniform utextureBuffer finer_texels;
layout(set = 0, binding = 1) uniform utextureBuffer first_texels;  // before all passes
layout(set = 0, binding = 2, std430) writeonly buffer Codes { u64vec2 out_codes[]; };

#include "shaders/texels.h"
#include "shaders/code_curve.h"

const uint most_level = 2900u;
/// The distance of levels at a code.
int level_at(uint code) {
    if (has_levels == 0u) return int(push.step);
    const uint level = max(curve_at(push.levels, code), curve_at(push.steps, code)) >> push.fraction;
    return int(clamp(level, push.step, most_level));
}

/// By how much a code may change, before it is doubled.
int most_of(int level) { return (4 * level + 3 * int(push.noise)) >> 2; }
const bool is_wide = tap > 8;
int gate_of(int level) { return is_wide ? most_of(level) : (5 * level + 3 * int(push.noise)) >> 2; }

/// Eight codes of a row; outside the picture all are invalid. An invalid code needs no care: it is so large
/// that every second difference with it is beyond twice the gate, where the tent is 0 (terrace_range).
Eight load(int row, int texel) {
    const int last = int(push.width - 1u) >> 3;
    const bool inside = row >= 0 && row < int(push.height) && texel >= 0 && texel <= last;
    const int there = clamp(row, 0, int(push.height) - 1) * int(push.pitch) + clamp(texel, 0, last);
    const uvec4 codes = texelFetch(finer_texels, there);
    return unpacked_halves(inside ? codes : uvec4(no_finer_code | no_finer_code << 16));
}

/// Three texels of a row, the one in question in the middle.
struct Span {
    int v[24];
};

Span moved_on(Span span, int row, int texel) {
    const Eight next = load(row, texel);
    [[unroll]] for (int k = 0; k < 16; ++k) span.v[k] = span.v[k + 8];
    [[unroll]] for (int k = 0; k < 8; ++k) span.v[16 + k] = int(next.v[k]);
    return span;
}

/// Tents, which are 2 clamp(s, -gate, gate) - clamp(s, -2 gate, 2 gate), of two second differences.
int tents(int a, int b, int gate) {
    const int wide = 2 * gate;
    return 2 * (clamp(a, -gate, gate) + clamp(b, -gate, gate)) - (clamp(a, -wide, wide) + clamp(b, -wide, wide));
}

/// Codes around a texel, `tap` pixels away.
struct Around {
    Eight w, e, nw, n, ne, sw, s, se;
};

Around loaded_around(int row, int texel) {
    const int away = tap >> 3;
    return Around(load(row, texel - away), load(row, texel + away), load(row - tap, texel - away), load(row - tap, texel),
                  load(row - tap, texel + away), load(row + tap, texel - away), load(row + tap, texel),
                  load(row + tap, texel + away));
}

Around taken_around(Span above, Span here, Span below) {
    const int near = is_wide ? 8 : tap;
    Around around;
    [[unroll]] for (int k = 0; k < 8; ++k) {
        const int x = 8 + k;
        around.w.v[k] = uint(here.v[x - near]);
        around.e.v[k] = uint(here.v[x + near]);
        around.nw.v[k] = uint(above.v[x - near]);
        around.n.v[k] = uint(above.v[x]);
        around.ne.v[k] = uint(above.v[x + near]);
        around.sw.v[k] = uint(below.v[x - near]);
        around.s.v[k] = uint(below.v[x]);
        around.se.v[k] = uint(below.v[x + near]);
    }
    return around;
}

void main() {
    const uint lane = gl_GlobalInvocationID.x, texels = (push.width + 7u) >> 3;
    const uint row = push.along_x != 0u ? lane / push.segments : lane % push.height;
    const uint segment = push.along_x != 0u ? lane % push.segments : lane / push.height;
    if (row >= push.height || segment >= push.segments) return;
    const int y = int(row), first = int(segment * push.segment_texels);
    const int end = min(first + int(push.segment_texels), int(texels));

    const int even_gate = gate_of(int(push.step));
    Span above, here, below;
    if (!is_wide)
        [[unroll]] for (int n = -1; n <= 0; ++n) {
            above = moved_on(above, y - tap, first + n);
            here = moved_on(here, y, first + n);
            below = moved_on(below, y + tap, first + n);
        }
    for (int texel = first; texel < end; ++texel) {
        Eight centres;
        Around around;
        if (is_wide) {
            centres = load(y, texel);
            around = loaded_around(y, texel);
        } else {
            above = moved_on(above, y - tap, texel + 1);
            here = moved_on(here, y, texel + 1);
            below = moved_on(below, y + tap, texel + 1);
            [[unroll]] for (int k = 0; k < 8; ++k) centres.v[k] = uint(here.v[8 + k]);
            around = taken_around(above, here, below);
        }
        const int at = y * int(push.pitch) + texel;
        Eight was;
        if (is_last != 0u || has_levels != 0u) was = unpacked_halves(texelFetch(first_texels, at));
        uint codes[8];
        [[unroll]] for (int k = 0; k < 8; ++k) {
            const int centre = int(centres.v[k]), twice = 2 * centre;
            const int gate = has_levels != 0u ? gate_of(level_at(was.v[k])) : even_gate;
            const int straight = tents(int(around.w.v[k] + around.e.v[k]) - twice, int(around.n.v[k] + around.s.v[k]) - twice, gate);
            const int diagonal = tents(int(around.nw.v[k] + around.se.v[k]) - twice, int(around.ne.v[k] + around.sw.v[k]) - twice, gate);
            const int sum = 2 * straight + diagonal;
            int code = centre + ((sum + 8) >> 4);
            if (is_last != 0u) {
                const int most = most_of(level_at(was.v[k]));
                const int least = 2 * (int(was.v[k]) - most), range = 4 * most;
                code = clamp(2 * centre + ((sum + 4) >> 3), least, least + range);
            }
            codes[k] = centre == int(no_finer_code) ? no_finer_code : uint(code);
        }
        out_codes[at] = packed(codes);
    }
}
