#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require

// q of every vertex -> which tiles have triangles to draw.

#include "shaders/cut_rule.h"
#include "shaders/tile_lists.h"

layout(local_size_x = CUT_TILES_LANES) in;
layout(push_constant, std430) uniform Push {
    CutTilesPush push;
};
layout(set = 0, binding = 0) uniform utextureBuffer q_texels;
layout(set = 0, binding = 1, std430) writeonly buffer Classes {
    uint classes[];
};

/// A row of a tile's vertices.
struct Row {
    float q[CUT_TILES_CELLS + 1];
};

Row load(uint y, uint tx) {
    const int start = int(y * push.pitch);
    Row row;
    [[unroll]] for (int n = 0; n < 4; ++n) {
        const vec4 four = uintBitsToFloat(texelFetch(q_texels, start + 4 * int(tx) + n));
        [[unroll]] for (int k = 0; k < 4; ++k) row.q[4 * n + k] = four[k];
    }
    // Beyond the last texel no cell uses it.
    const uint beyond = min(4u * tx + 4u, push.pitch - 1u);
    row.q[16] = uintBitsToFloat(texelFetch(q_texels, start + int(beyond))).x;
    return row;
}

void main() {
    const uint tile = gl_GlobalInvocationID.x;
    if (tile >= push.tiles) return;
    const uint tx = tile % push.tiles_x, ty = tile / push.tiles_x;
    const uint first = ty * CUT_TILES_CELLS, end = min(first + CUT_TILES_CELLS, push.height - 1u);
    const uint columns = push.width - 1u - tx * CUT_TILES_CELLS;  // of cells, here and to the right
    bool any_cut = false, any_shown = false;
    Row upper = load(first, tx);
    for (uint y = first; y < end; ++y) {
        const Row lower = load(y + 1u, tx);
        [[unroll]] for (int k = 0; k < CUT_TILES_CELLS; ++k) {
            const bool is_there = uint(k) < columns;
            const bool no_lower = triangle_is_cut(upper.q[k], upper.q[k + 1], lower.q[k + 1]);
            const bool no_upper = triangle_is_cut(upper.q[k], lower.q[k + 1], lower.q[k]);
            any_cut = any_cut || (is_there && (no_lower || no_upper));
            // What is eroded, q below 0, leaves gaps to fill.
            const bool is_hole = triangle_has_hole(abs(upper.q[k]), abs(upper.q[k + 1]), abs(lower.q[k + 1])) &&
                                 triangle_has_hole(abs(upper.q[k]), abs(lower.q[k + 1]), abs(lower.q[k]));
            any_shown = any_shown || (is_there && !is_hole);
        }
        upper = lower;
    }
    classes[tile] = any_shown ? (any_cut ? mixed_tile : whole_tile) : empty_tile;
}
