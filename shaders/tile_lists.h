// SPDX-License-Identifier: Apache-2.0
// Interface of the kernels cut_tiles.comp and list_tiles.comp, those that draw from their lists, and C++.
//
// cut_tiles.comp tells for each tile of 16x16 cells, with a lane each, whether shaders/cut_rule.h keeps all
// of its triangles, or some, or none (all have a hole). list_tiles.comp, a single workgroup, lists the first
// two kinds in the order of tiles, so that a picture does not depend on the order of execution.
// Threads: any; nothing here keeps state.
#ifndef TOUCHABLE_SHADERS_TILE_LISTS_H
#define TOUCHABLE_SHADERS_TILE_LISTS_H

#ifdef __cplusplus
namespace touchable {
using uint = unsigned int;
#define TILE_LISTS_FUNCTION inline
#else
#define TILE_LISTS_FUNCTION
#endif

#define CUT_TILES_CELLS 16
#define CUT_TILES_LANES 8
#define LIST_TILES_LANES 64

const uint empty_tile = 0u, whole_tile = 1u, mixed_tile = 2u;

struct CutTilesPush {
    uint width, height;     // of the lattice
    uint pitch;             // texels of a row of q
    uint tiles_x, tiles;    // tiles in a row, and in all
};

/// Precedes the lists of tiles (row * tiles_x + column): the whole ones, then the mixed ones, each ascending.
/// It has three indirect commands: a dispatch with a workgroup for every listed tile, in rows short enough
/// for every device, where workgroups beyond the last tile do nothing; an indexed draw with an instance for
/// every whole tile; and a draw with an instance for every mixed one.
struct TileListsHeader {
    uint groups_x, groups_y, groups_z;
    uint whole_indices, whole_tiles, first_index, vertex_offset, first_whole;
    uint mixed_vertices, mixed_tiles, first_vertex, first_mixed;
};
#define TILE_LISTS_ROW 32768u
#define TILE_LISTS_CORNERS 1536u  // of a tile's triangles: 16 * 16 * 6

TILE_LISTS_FUNCTION TileListsHeader tile_lists_header(uint whole, uint mixed) {
    const uint all = whole + mixed;
    TileListsHeader header;
    header.groups_x = all < TILE_LISTS_ROW ? all : TILE_LISTS_ROW;
    header.groups_y = (all + TILE_LISTS_ROW - 1u) / TILE_LISTS_ROW;
    header.groups_z = 1u;
    header.whole_indices = header.mixed_vertices = TILE_LISTS_CORNERS;
    header.whole_tiles = whole;
    header.mixed_tiles = mixed;
    header.first_index = header.vertex_offset = header.first_whole = 0u;
    header.first_vertex = header.first_mixed = 0u;
    return header;
}

#ifdef __cplusplus
}  // namespace touchable
#endif
#undef TILE_LISTS_FUNCTION

#endif
