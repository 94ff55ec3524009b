#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_shader_atomic_int64 : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

// Draws triangles of a tile, small on the screen, into packed pixels.

#include "shaders/raster_common.h"
#include "shaders/tile_lists.h"

layout(local_size_x = RASTER_LANES) in;

layout(set = 0, binding = RASTER_TILES, std430) readonly buffer Tiles {
    TileListsHeader header;
    uint tiles[];
};

struct Corner {
    ivec2 at;  // subpixels
    float z, q;
    float share;  // 1 / w
    vec3 colour;  // times share
    bool in_front;  // of the near plane
};

Corner corner(uint i, uint j) {
    const uint index = j * push.pitch + i;
    Corner c;
    c.q = q_at(index);
    const Projected seen = projected(index, i, j);
    const vec4 clip = seen.clip;
    c.share = 1.0f / clip.w;
    c.colour = seen.colour * c.share;
    c.in_front = clip.z <= clip.w;
    c.z = clip.z / clip.w;
    c.at = ivec2(view_subpixels(clip.x / clip.w, float(push.picture_width)),
                 view_subpixels(clip.y / clip.w, float(push.picture_height)));
    return c;
}

// Twice the signed area of a, b, p.
int edge(ivec2 a, ivec2 b, ivec2 p) {
    return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
}

// A triangle's three edge functions at a pixel, turned so that inside is positive, and their steps to the
// right and down. A pixel centre on an upper or left edge is inside; `least`: the least values inside.
// `is_last`: one on the edge from b to c is, too.
struct Edges {
    ivec3 here, right, down, least;
    float scale;  // 1 / twice the area; 0 for a triangle without one
};

Edges edges_of(ivec2 a, ivec2 b, ivec2 c, ivec2 p, bool is_last) {
    const int area = edge(a, b, c);
    const int turn = area < 0 ? -1 : 1;
    const ivec3 dx = turn * ivec3(b.x - a.x, c.x - b.x, a.x - c.x);
    const ivec3 dy = turn * ivec3(b.y - a.y, c.y - b.y, a.y - c.y);
    Edges e;
    e.here = turn * ivec3(edge(a, b, p), edge(b, c, p), edge(c, a, p));
    e.right = -dy * VIEW_SUBPIXELS;
    e.down = dx * VIEW_SUBPIXELS;
    const bvec3 upper = bvec3(uvec3(equal(dy, ivec3(0))) & uvec3(greaterThan(dx, ivec3(0))));
    e.least = ivec3(1) - ivec3(uvec3(lessThan(dy, ivec3(0))) | uvec3(upper));
    if (is_last) e.least.y = 0;
    e.scale = area == 0 ? 0.0f : 1.0f / float(abs(area));
    return e;
}

bool inside(Edges e, ivec3 here) {
    return e.scale > 0.0f && all(greaterThanEqual(here, e.least));
}

/// What a triangle has at a pixel: z, or 0 outside of it, and its colour.
struct Sample {
    float z;
    vec3 colour;
};
Sample sample_at(Edges e, ivec3 here, Corner a, Corner b, Corner c) {
    const float of_b = float(here.z) * e.scale, of_c = float(here.x) * e.scale;
    const float share = a.share + of_b * (b.share - a.share) + of_c * (c.share - a.share);
    return Sample(inside(e, here) ? a.z + of_b * (b.z - a.z) + of_c * (c.z - a.z) : 0.0f,
                  (a.colour + of_b * (b.colour - a.colour) + of_c * (c.colour - a.colour)) / share);
}

void leave_to_large(uint cell) {
    const uint slot = atomicAdd(large_count, 1u);
    if (slot < push.width * push.height) {
        large_cells[slot] = cell;
        atomicMax(groups_x, min(slot + 1u, RASTER_MOST_GROUPS));
    }
}

/// Whether a cell has a gap that is filled.
bool has_gap(Corner top_left, Corner top_right, Corner bottom_right, Corner bottom_left) {
    if (push.fills_gaps == 0u || top_left.q == 0.0f || bottom_right.q == 0.0f) return false;
    return (top_right.q != 0.0f && is_cut(top_left.q, top_right.q, bottom_right.q)) ||
           (bottom_left.q != 0.0f && is_cut(top_left.q, bottom_right.q, bottom_left.q));
}

/// Whether the cell is left to raster_large.comp. `is_last`: in its row, and in its column, of the own view.
bool draw_cell(Corner top_left, Corner top_right, Corner bottom_right, Corner bottom_left, bvec2 is_last) {
    const bool no_lower = is_cut(top_left.q, top_right.q, bottom_right.q);
    const bool no_upper = is_cut(top_left.q, bottom_right.q, bottom_left.q);
    if (no_lower && no_upper) return false;
    if (no_lower) top_right = top_left;  // a triangle without area is not drawn
    if (no_upper) bottom_left = top_left;

    const ivec2 low = min(min(top_left.at, top_right.at), min(bottom_right.at, bottom_left.at));
    const ivec2 high = max(max(top_left.at, top_right.at), max(bottom_right.at, bottom_left.at));
    const ivec2 size = high - low;
    const bool in_front =
        top_left.in_front && top_right.in_front && bottom_right.in_front && bottom_left.in_front;
    // If part of a cell is behind the eye, its corners do not tell where it is seen.
    const bool is_large = !in_front || max(size.x, size.y) >= RASTER_LARGE_CELL;
    const int half_pixel = VIEW_SUBPIXELS / 2;
    const ivec2 picture = ivec2(push.picture_width, push.picture_height);
    const ivec2 first = max((low + (half_pixel - 1)) >> 8, ivec2(0));
    const ivec2 last = min((high - half_pixel) >> 8, picture - 1);
    const bool on_screen = all(lessThanEqual(first, last));
    if (is_large) return !in_front || on_screen;
    if (!on_screen) return false;

    const ivec2 start = first * VIEW_SUBPIXELS + half_pixel;
    const Edges lower = edges_of(top_left.at, top_right.at, bottom_right.at, start, is_last.x);
    const Edges upper = edges_of(top_left.at, bottom_right.at, bottom_left.at, start, is_last.y);
    ivec3 lower_row = lower.here, upper_row = upper.here, in_lower = lower_row, in_upper = upper_row;
    ivec2 at = first;
    // One loop, not two, and one pixel to write: lanes of a software GPU wait for each other at every loop's
    // end, and go through atomics one after the other.
    while (at.y <= last.y) {
        const Sample low_one = sample_at(lower, in_lower, top_left, top_right, bottom_right);
        const Sample up_one = sample_at(upper, in_upper, top_left, bottom_right, bottom_left);
        const bool is_lower = low_one.z > up_one.z;
        const float z = is_lower ? low_one.z : up_one.z;
        if (z > 0.0f) plot(at.x, at.y, z, is_lower ? low_one.colour : up_one.colour);
        const bool row_ends = at.x >= last.x;
        lower_row += row_ends ? lower.down : ivec3(0);
        upper_row += row_ends ? upper.down : ivec3(0);
        in_lower = row_ends ? lower_row : in_lower + lower.right;
        in_upper = row_ends ? upper_row : in_upper + upper.right;
        at = row_ends ? ivec2(first.x, at.y + 1) : ivec2(at.x + 1, at.y);
    }
    return false;
}

void main() {
    const uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (group >= header.whole_tiles + header.mixed_tiles) return;
    const uint tile = tiles[group];
    const uint i = tile % push.tiles_x * RASTER_TILE + gl_LocalInvocationID.x;
    const uint first_row = tile / push.tiles_x * RASTER_TILE;
    const uint end = min(first_row + RASTER_TILE, push.height - 1u);
    if (i + 1u >= push.width) return;
    const uvec2 own_end = push.is_turned == 0u ? uvec2(push.width, push.height) : uvec2(0u);
    uint large_rows = 0u, gap_rows = 0u;
    Corner top_left = corner(i, first_row), top_right = corner(i + 1u, first_row);
    for (uint j = first_row; j < end; ++j) {
        const Corner bottom_left = corner(i, j + 1u), bottom_right = corner(i + 1u, j + 1u);
        const bvec2 is_last = equal(uvec2(i, j) + 2u, own_end);
        if (draw_cell(top_left, top_right, bottom_right, bottom_left, is_last)) large_rows |= 1u << (j - first_row);
        else if (has_gap(top_left, top_right, bottom_right, bottom_left)) gap_rows |= 1u << (j - first_row);
        top_left = bottom_left;
        top_right = bottom_right;
    }
    // Here, because a software GPU executes the atomics even if no lane needs them.
    for (; large_rows != 0u; large_rows &= large_rows - 1u)
        leave_to_large((first_row + uint(findLSB(large_rows))) * push.pitch + i);
    for (; gap_rows != 0u; gap_rows &= gap_rows - 1u)
        leave_to_large(((first_row + uint(findLSB(gap_rows))) * push.pitch + i) | RASTER_GAPS_ALONE);
}
