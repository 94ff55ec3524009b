#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require

// Which tiles have triangles to draw -> lists of them. All lanes take equally many tiles, in order, and each
// begins to write where the lanes before it end.

#include "shaders/tile_lists.h"

layout(local_size_x = LIST_TILES_LANES) in;
layout(push_constant, std430) uniform Push {
    CutTilesPush push;
};
layout(set = 0, binding = 0, std430) readonly buffer Classes {
    uint classes[];
};
layout(set = 0, binding = 1, std430) writeonly buffer Lists {
    TileListsHeader header;
    uint tiles[];
};

shared uint whole_of[LIST_TILES_LANES], mixed_of[LIST_TILES_LANES];

void main() {
    const uint lane = gl_LocalInvocationID.x;
    const uint share = (push.tiles + LIST_TILES_LANES - 1u) / LIST_TILES_LANES;
    const uint first = min(lane * share, push.tiles), end = min(first + share, push.tiles);
    uint whole = 0u, mixed = 0u;
    for (uint tile = first; tile < end; ++tile) {
        const uint sort = classes[tile];
        whole += sort == whole_tile ? 1u : 0u;
        mixed += sort == mixed_tile ? 1u : 0u;
    }
    whole_of[lane] = whole;
    mixed_of[lane] = mixed;
    barrier();

    uint all_whole = 0u, all_mixed = 0u, whole_at = 0u, mixed_at = 0u;
    for (uint other = 0u; other < LIST_TILES_LANES; ++other) {
        if (other == lane) {
            whole_at = all_whole;
            mixed_at = all_mixed;
        }
        all_whole += whole_of[other];
        all_mixed += mixed_of[other];
    }
    mixed_at += all_whole;
    if (lane == 0u) header = tile_lists_header(all_whole, all_mixed);
    for (uint tile = first; tile < end; ++tile) {
        const uint sort = classes[tile];
        if (sort == whole_tile) tiles[whole_at++] = tile;
        if (sort == mixed_tile) tiles[mixed_at++] = tile;
    }
}
