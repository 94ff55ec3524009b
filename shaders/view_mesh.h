// SPDX-License-Identifier: Apache-2.0
// Interface of the shaders view_mesh.vert and view_mesh.frag and their caller. Compiled as GLSL and as C++.
//
// An instance is a tile of 16x16 cells. If no triangle of it is cut, its 17x17 vertices are shared by the
// triangles of an index list that is the same for all tiles. Else each cell is two triangles of their own,
// six vertices, and a triangle that is cut shrinks to a point, which draws nothing. Gaps are drawn in the same way,
// by the triangles that are cut.
// Threads: any; nothing here keeps state.
#ifndef TOUCHABLE_SHADERS_VIEW_MESH_H
#define TOUCHABLE_SHADERS_VIEW_MESH_H

#include "shaders/view_project.h"

#ifdef __cplusplus
namespace touchable {
using uint = unsigned int;
#endif

#define MESH_TILE 16
#define MESH_TILE_CELLS 256
#define MESH_TILE_SIDE 17  // vertices

#define MESH_Q 0
#define MESH_COLOURS 1
#define MESH_TILES 2  // what to draw (shaders/tile_lists.h)
#define MESH_EDGES 3  // moved vertices (shaders/edges.h); any buffer if none are moved

struct MeshPush {
    ViewRows rows;
    uint width, height;  // of the lattice
    uint pitch;          // vertices from one row of q and colours to the next
    uint tiles_x;        // tiles in a row of it
    uint is_turned;      // 0: the clip's own view, every vertex at its pixel
    float beyond;        // there a subpixel, in cells; otherwise 0
};

#ifdef __cplusplus
}  // namespace touchable
#endif

#endif
