#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require

// A vertex of a tile's triangles or of its gaps, read from the lattice.

#include "shaders/cut_rule.h"
#include "shaders/edges.h"
#define GAP_LATTICE
#include "shaders/gap_fill.h"
#include "shaders/tile_lists.h"
#include "shaders/view_mesh.h"

layout(constant_id = 0) const bool is_mixed = false;
layout(constant_id = 1) const bool fills_gaps = false;

layout(push_constant, std430) uniform Push {
    MeshPush push;
};
layout(set = 0, binding = MESH_Q, std430) readonly buffer Lattice {
    float q_at[];
};
layout(set = 0, binding = MESH_COLOURS, std430) readonly buffer Colours {
    uint colour_at[];
};
layout(set = 0, binding = MESH_TILES, std430) readonly buffer Tiles {
    TileListsHeader header;
    uint tiles[];
};
layout(set = 0, binding = MESH_EDGES, std430) readonly buffer MovedVertices {
    uvec2 moved_vertices[];
};

layout(location = 0) out vec3 colour;

invariant gl_Position;

// Corners of a cell's triangles: the lower one, then the upper one.
const uvec2 corners[6] = uvec2[6](uvec2(0, 0), uvec2(1, 0), uvec2(1, 1), uvec2(0, 0), uvec2(1, 1), uvec2(0, 1));

float q_of(uvec2 at) {
    return q_at[at.y * push.pitch + at.x];
}

float gap_q(ivec2 at) {
    return q_of(uvec2(at));
}

vec3 gap_colour(ivec2 at) {
    const uint packed_colour = colour_at[uint(at.y) * push.pitch + uint(at.x)];
    return vec3(packed_colour & 255u, packed_colour >> 8 & 255u, packed_colour >> 16 & 255u);
}

bool is_drawn(uvec2 a, uvec2 b, uvec2 c) {
    if (fills_gaps) return is_gap(ivec2(a), ivec2(b), ivec2(c));
    return push.is_turned != 0u ? !triangle_is_cut(q_of(a), q_of(b), q_of(c))
                                : !triangle_has_hole(q_of(a), q_of(b), q_of(c));
}

void main() {
    const uint tile = tiles[(is_mixed ? header.whole_tiles : 0u) + uint(gl_InstanceIndex)];
    const uvec2 origin = uvec2(tile % push.tiles_x, tile / push.tiles_x) * MESH_TILE;
    const uvec2 last = uvec2(push.width, push.height) - 1u;
    const uint vertex = uint(gl_VertexIndex);
    uvec2 at, base = uvec2(0u);
    if (is_mixed) {
        const uint cell = vertex / 6u, corner = vertex % 6u, first = corner / 3u * 3u;
        const uvec2 cell_at = origin + uvec2(cell % MESH_TILE, cell / MESH_TILE);
        const bool is_there = all(lessThan(cell_at, last));
        base = min(cell_at, last);
        at = base + corners[corner];
        if (!is_there || !is_drawn(base + corners[first], base + corners[first + 1u], base + corners[first + 2u])) {
            gl_Position = vec4(2.0f, 2.0f, 0.0f, 1.0f);
            colour = vec3(0.0f);
            return;
        }
    } else {
        // Beyond the picture's last row and column triangles have no area.
        at = min(origin + uvec2(vertex % MESH_TILE_SIDE, vertex / MESH_TILE_SIDE), last);
    }
    const uint index = at.y * push.pitch + at.x;
    vec3 place = vec3(at, abs(q_of(at)));
    // Pixel centres on the last cells' last sides belong to them: these sides are moved on, in their plane.
    const uvec2 ends = min(uvec2(equal(at, last)), at);
    const float before = abs(q_of(at - ends));
    place += push.beyond * vec3(ends, before == 0.0f ? 0.0f : place.z - before);
    if (push.is_turned != 0u && moved_vertices[index].x != 0u)
        place = edge_place(moved_vertices[index], at.x, at.y);
    gl_Position = view_clip(push.rows, place.x, place.y, place.z);
    const vec3 bytes =
        fills_gaps ? gap_fill(ivec2(base), ivec2(push.width, push.height)) : gap_colour(ivec2(at));
    colour = bytes / 255.0f;
}
