// SPDX-License-Identifier: Apache-2.0
// Interface of the kernels raster.comp and raster_large.comp and their callers. Compiled as GLSL and as C++.
//
// raster.comp draws a tile of 16x16 cells with a lane for each column of cells, which marches down, so that a
// cell costs two new vertices. It leaves cells that reach before the near plane, or over RASTER_LARGE_CELL
// subpixels, in a list for raster_large.comp, which draws each with a whole workgroup; so it does with cells
// that have a gap to fill (gap_fill.h).
//
// A pixel is z's bits above the colour's (PackedColour): z > 0 and larger when nearer, so the greatest is the
// nearest; 0 is empty.
// Threads: any; nothing here keeps state.
#ifndef TOUCHABLE_SHADERS_RASTER_H
#define TOUCHABLE_SHADERS_RASTER_H

#include "shaders/view_project.h"

#ifdef __cplusplus
namespace touchable {
using uint = unsigned int;
#endif

#define RASTER_TILE 16
#define RASTER_LANES 16
#define RASTER_LARGE_LANES 8
/// 64 pixels: products of two such lengths, and their differences, fit into 32 bits.
#define RASTER_LARGE_CELL 16384

#define RASTER_Q 0        // words
#define RASTER_COLOURS 1  // words
#define RASTER_PIXELS 2  // 64 bits each
#define RASTER_LARGE 3   // RASTER_LARGE_HEADER, then cells: room for all there are
#define RASTER_EDGES 4   // moved vertices (shaders/edges.h); any buffer if none are moved
#define RASTER_TILES 5   // of raster.comp: what to draw (shaders/tile_lists.h)

struct RasterPush {
    ViewRows rows;
    uint width, height;                  // of the lattice
    uint pitch;                          // vertices from one row of q and colours to the next
    uint tiles_x;                        // tiles in a row of it
    uint picture_width, picture_height;  // pixels
    uint picture_pitch;                  // pixels from one row of them to the next
    uint is_turned;                      // 0: the clip's own view, every vertex at its pixel
    uint fills_gaps;                     // 0: no
};

/// Words before the cells (row * pitch + column): workgroups in x, y, z, and how many cells follow.
#define RASTER_LARGE_HEADER 4
/// Added to a cell of which only gaps are left to draw.
#define RASTER_GAPS_ALONE 0x80000000u
#define RASTER_MOST_GROUPS 4096u

#ifdef __cplusplus
}  // namespace touchable
#endif

#endif
