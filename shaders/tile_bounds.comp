#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require

// Parts of bounds -> bounds, a lane per pair of tiles: their own strips, and the row below them.

#include "shaders/surface_codes.h"

layout(local_size_x = tile_bounds_group) in;
layout(push_constant, std430) uniform Push { TileBoundsPush push; };
layout(set = 0, binding = 0) uniform utextureBuffer parts;
layout(set = 0, binding = 1) uniform utextureBuffer codes;
layout(set = 0, binding = 2, std430) readonly buffer Validity { uint validity[]; };
layout(set = 0, binding = 3, std430) writeonly buffer Tiles { uvec2 tiles[]; };

/// Joins bounds of a tile, in the form of parts.
uvec2 joined(uvec2 a, uvec2 b) {
    return uvec2(min(a.x & 0xFFFFu, b.x & 0xFFFFu) | max(a.x & ~0xFFFFu, b.x & ~0xFFFFu), a.y | b.y);
}

/// The part of a pixel, which is the `bit`th of a word of validity.
uvec2 part_of(uint code, uint valid_bits, uint inside_bits, uint bit) {
    if ((inside_bits >> bit & 1u) == 0u) return uvec2(no_part, 0u);
    return (valid_bits >> bit & 1u) != 0u ? uvec2(code | code << 16, 0u) : uvec2(no_part, 1u);
}

void bound(uint pair) {
    const uint word = pair % push.words, ty = pair / push.words;
    uvec2 left = uvec2(no_part, 0u), right = left;
    for (uint k = 0u; k < strips_per_tile; ++k) {
        const uint strip = strips_per_tile * ty + k;
        if (strip >= push.strips) break;
        const uvec4 part = texelFetch(parts, int(strip * push.words + word));
        left = joined(left, part.xy);
        right = joined(right, part.zw);
    }
    const uint row = tile_cells * (ty + 1u);
    if (row < push.height) {
        const uint at = row * push.words + word, columns = push.width - 32u * word;
        const uint valid = validity[at], inside = columns >= 32u ? ~0u : (1u << columns) - 1u;
        [[unroll]] for (uint k = 0u; k < 16u; k += 2u) {
            const uint texel = row * push.pitch + 4u * word + k / 8u, last = push.pitch * push.height - 1u;
            const uint left_codes = texelFetch(codes, int(min(texel, last)))[k / 2u % 4u];
            const uint right_codes = texelFetch(codes, int(min(texel + 2u, last)))[k / 2u % 4u];
            left = joined(left, part_of(left_codes & 0xFFFFu, valid, inside, k));
            left = joined(left, part_of(left_codes >> 16, valid, inside, k + 1u));
            if (k == 0u) left = joined(left, part_of(right_codes & 0xFFFFu, valid, inside, 16u));
            right = joined(right, part_of(right_codes & 0xFFFFu, valid, inside, k + 16u));
            right = joined(right, part_of(right_codes >> 16, valid, inside, k + 17u));
        }
        if (columns > 32u) {
            const uint code = texelFetch(codes, int(row * push.pitch + 4u * word + 4u)).x & 0xFFFFu;
            right = joined(right, part_of(code, validity[at + 1u], 1u, 0u));
        }
    }
    // As TileBounds lies in memory.
    const uint tile = ty * push.tiles_x + 2u * word;
    if (2u * word < push.tiles_x) tiles[tile] = uvec2(left.x, min(left.y, 1u));
    if (2u * word + 1u < push.tiles_x) tiles[tile + 1u] = uvec2(right.x, min(right.y, 1u));
}

void main() {
    const uint lane = gl_GlobalInvocationID.x;
    if (lane < push.words * push.tiles_y) bound(lane);
}
