#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

// The temporal filter over working codes (docs/conventions.md), a lane per texel of eight: codes remembered
// from the frame before and those of this one become the codes that are shown and remembered.

#include "shaders/surface_codes.h"
#include "shaders/texels.h"
#include "shaders/code_curve.h"

layout(local_size_x = temporal_group) in;
layout(push_constant, std430) uniform Push { TemporalPush push; };
layout(set = 0, binding = 0) uniform utextureBuffer new_texels;
layout(set = 0, binding = 1) uniform utextureBuffer old_texels;
layout(set = 0, binding = 2, std430) writeonly buffer Codes { u64vec2 out_codes[]; };
/// For each texel, two bits a code: for how many frames the code has only been held.
layout(set = 0, binding = 3, std430) buffer Held { uint held[]; };

const uint hold_frames = 3u;

uint smoothed(uint code, uint before) {
    const uint distance = max(code, before) - min(code, before), gate = curve_at(push.gate, code);
    const uint tent = 2u * min(distance, gate) - min(distance, 2u * gate), kept = 3u * tent / 4u;
    return code > before ? code - kept : code + kept;
}

void main() {
    const uint x = gl_GlobalInvocationID.x;
    if (x >= push.pitch) return;
    const uint texel = gl_GlobalInvocationID.y * push.pitch + x;
    const Eight now = unpacked_halves(texelFetch(new_texels, int(texel)));
    const Eight before = unpacked_halves(texelFetch(old_texels, int(texel)));
    const uint was_held = held[texel];
    uint codes[8], is_held = 0u;
    [[unroll]] for (int k = 0; k < 8; ++k) {
        const bool there = code_is_in_range(now.v[k], push.valid);
        const bool known = push.begins == 0u && code_is_in_range(before.v[k], push.valid);
        const uint times = was_held >> 2 * k & 3u;
        const bool holds = !there && known && times < hold_frames;
        codes[k] = there ? (known ? smoothed(now.v[k], before.v[k]) : now.v[k]) : holds ? before.v[k] : push.none;
        is_held |= holds ? times + 1u << 2 * k : 0u;
    }
    out_codes[texel] = packed(codes);
    held[texel] = is_held;
}
