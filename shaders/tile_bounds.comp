#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

// Parts of bounds -> bounds, a lane per tile: its own strips, and the first row of the strip below them.

#include "shaders/surface_codes.h"

layout(local_size_x = tile_bounds_group) in;
layout(push_constant, scalar) uniform Push { TileBoundsPush push; };
layout(set = 0, binding = 0, scalar) readonly buffer Parts { uvec2 parts[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Tops { uvec2 tops[]; };
layout(set = 0, binding = 2, scalar) writeonly buffer Tiles { uvec2 tiles[]; };

void main() {
    const uint tile = gl_GlobalInvocationID.x;
    if (tile >= push.tiles_x * push.tiles_y) return;
    const uint tx = tile % push.tiles_x, ty = tile / push.tiles_x;
    uint least = 65535u, greatest = 0u, any_invalid = 0u;
    for (uint k = 0u; k <= strips_per_tile; ++k) {
        const uint strip = strips_per_tile * ty + k;
        if (strip >= push.strips) break;
        uvec2 part;
        if (k < strips_per_tile) part = parts[strip * push.tiles_x + tx];
        else part = tops[(ty + 1u) * push.tiles_x + tx];
        least = min(least, part.x & 0xFFFFu);
        greatest = max(greatest, part.x >> 16);
        any_invalid |= part.y;
    }
    // As TileBounds lies in memory.
    tiles[tile] = uvec2(least | greatest << 16, any_invalid != 0u ? 1u : 0u);
}
