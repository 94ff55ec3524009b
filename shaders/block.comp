#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

// Stored values -> codes or their lower median of 3x3 or 5x5, validity and tile bounds, in one pass that
// suits GPUs: a lane takes 8 neighbours of 4 rows, row after row, and a workgroup the 16 x 2 tiles of
// block_width x block_height pixels. strip.h suits software Vulkan.
//
// A tile's bounds include the first pixels of the tiles to its right and below. If these are another
// workgroup's, they are filtered here, too, so that no other kernel has to join workgroups' bounds.

#include "shaders/median3.h"
#include "shaders/median5.h"
#include "shaders/surface_codes.h"
#include "shaders/texels.h"

layout(local_size_x = block_lanes_x, local_size_y = block_lanes_y) in;
layout(constant_id = 0) const uint side = 3u;  // of the window; 1: codes are only decoded
layout(constant_id = 1) const uint sample_bytes = 2u;
layout(constant_id = 2) const uint may_be_invalid = 1u;
layout(constant_id = 3) const uint may_be_excluded = 1u;
layout(constant_id = 4) const uint to_finer = 0u;
layout(constant_id = 5) const uint looked_up = 0u;

layout(push_constant, std430) uniform Push { BlockPush push; };
layout(set = 0, binding = 0, std430) readonly buffer Stored { uvec4 stored[]; };
layout(set = 0, binding = 0, std430) readonly buffer StoredPairs { uvec2 stored_pairs[]; };
layout(set = 0, binding = 0, std430) readonly buffer StoredWords { uint stored_words[]; };
layout(set = 0, binding = 1, std430) writeonly buffer Codes { uvec4 out_codes[]; };
layout(set = 0, binding = 2, std430) writeonly buffer Validity { uint out_validity[]; };
layout(set = 0, binding = 3, std430) writeonly buffer Tiles { uvec2 out_tiles[]; };
/// Working codes of all stored ones, two in a word, the lower code in the lower half.
layout(set = 0, binding = 4, std430) readonly buffer Table { uint working_codes[]; };

const uint tiles_x = block_width / tile_cells, tiles_y = block_height / tile_cells;
shared uint tile_least[tiles_y][tiles_x], tile_greatest[tiles_y][tiles_x], tile_invalid[tiles_y][tiles_x];
/// Validity of each lane's pixels, 8 bits a row.
shared uint lane_valid[block_lanes_y][block_lanes_x];

bool is_valid(uint code) {
    if (may_be_invalid == 0u) return true;
    return code_is_in_range(code, push.valid) && (may_be_excluded == 0u || !code_is_excluded(code, push.valid));
}

/// Columns 8 `texel` - 2 to 8 `texel` + 9 of a row; beyond the picture they repeat its border.
uint[12] load(uint row, uint texel) {
    uint v[12];
    const bool first = texel == 0u, last = 8u * texel + 8u >= push.width;
    if (sample_bytes == 1u) {
        const uint at = 2u * push.in_pitch * row + texel;
        const uvec2 words = stored_pairs[at];
        [[unroll]] for (int k = 0; k < 8; ++k) v[k + 2] = bitfieldExtract(words[k / 4], 8 * (k % 4), 8);
        const uint before = first ? 0u : stored_words[2u * at - 1u], after = last ? 0u : stored_words[2u * at + 2u];
        v[0] = bitfieldExtract(before, 16, 8);
        v[1] = before >> 24;
        v[10] = after & 0xFFu;
        v[11] = bitfieldExtract(after, 8, 8);
    } else {
        const uint at = push.in_pitch * row + texel;
        const Eight codes = unpacked_halves(stored[at]);
        [[unroll]] for (int k = 0; k < 8; ++k) v[k + 2] = codes.v[k];
        const uint before = first ? 0u : stored_words[4u * at - 1u], after = last ? 0u : stored_words[4u * at + 4u];
        v[0] = before & 0xFFFFu;
        v[1] = before >> 16;
        v[10] = after & 0xFFFFu;
        v[11] = after >> 16;
    }
    if (first) v[0] = v[1] = v[2];
    if (8u * texel + 10u > push.width)
        [[unroll]] for (int k = 3; k < 12; ++k) v[k] = 8u * texel + uint(k) < push.width + 2u ? v[k] : v[k - 1];
    return v;
}

/// Rows `y` - 2 to `y` + 2, or those that the filter reads.
struct Window {
    uint rows[5][12];
};

Window load_window(uint texel, uint y) {
    Window window;
    [[unroll]] for (int k = 0; k < 5; ++k)
        if (abs(k - 2) <= int(side / 2u))
            window.rows[k] = load(uint(clamp(int(y) + k - 2, 0, int(push.height) - 1)), texel);
    return window;
}

bool has_invalid(Window window) {
    const int reach = int(side / 2u);
    bool any = false;
    [[unroll]] for (int k = 0; k < 5; ++k)
        [[unroll]] for (int n = 0; n < 12; ++n)
            if (abs(k - 2) <= reach && n >= 2 - reach && n < 10 + reach) any = any || !is_valid(window.rows[k][n]);
    return any;
}

// Callers pass a constant `all_valid`, so that the fast variants contain no work for invalid codes.

uint[8] medians3(Window window, bool all_valid) {
    Ranked3 columns[10];
    [[unroll]] for (int k = 0; k < 10; ++k) {
        uint v[3], invalid = 0u;
        [[unroll]] for (int n = 0; n < 3; ++n) {
            const bool valid = all_valid || is_valid(window.rows[n + 1][k + 1]);
            v[n] = valid ? window.rows[n + 1][k + 1] : 65535u;
            invalid += valid ? 0u : 1u;
        }
        sort3(v);
        columns[k] = balanced3(v, invalid);
    }
    uint medians[8];
    [[unroll]] for (int k = 0; k < 8; k += 2) {
        const Pair3 pair = paired3(columns[k + 1], columns[k + 2]);
        medians[k] = median_of(pair, columns[k]);
        medians[k + 1] = median_of(pair, columns[k + 3]);
    }
    return medians;
}

uint[8] medians5(Window window, bool all_valid) {
    Ranked5 columns[12];
    [[unroll]] for (int k = 0; k < 12; ++k) {
        uint v[5], invalid = 0u;
        [[unroll]] for (int n = 0; n < 5; ++n) {
            const bool valid = all_valid || is_valid(window.rows[n][k]);
            v[n] = valid ? window.rows[n][k] : 65535u;
            invalid += valid ? 0u : 1u;
        }
        sort5(v);
        columns[k] = balanced5(v, invalid);
    }
    uint medians[8];
    Pair5 pair = paired5(columns[1], columns[2]);
    [[unroll]] for (int k = 0; k < 8; k += 2) {
        const Pair5 next = paired5(columns[k + 3], columns[k + 4]);
        const Quad5 quad = joined5(pair, next);
        medians[k] = median_of(quad, columns[k]);
        medians[k + 1] = median_of(quad, columns[k + 5]);
        pair = next;
    }
    return medians;
}

uint[8] filtered(Window window) {
    if (side == 3u) {
        if (may_be_invalid != 0u && has_invalid(window)) return medians3(window, false);
        return medians3(window, true);
    }
    if (side == 5u) {
        if (may_be_invalid != 0u && has_invalid(window)) return medians5(window, false);
        return medians5(window, true);
    }
    uint codes[8];
    [[unroll]] for (int k = 0; k < 8; ++k) codes[k] = window.rows[2][k + 2];
    return codes;
}

/// WorkingCodes::of, if filters work on these.
uint scaled(uint code) {
    if (to_finer == 0u) return code;
    return looked_up == 0u ? code * push.factor : working_codes[code >> 1u] >> (16u * (code & 1u)) & 0xFFFFu;
}

/// Least and greatest valid code of some pixels, and whether one is invalid.
struct Bounds {
    uint least, greatest;
    bool any_invalid;
};
const Bounds no_bounds = Bounds(65535u, 0u, false);

Bounds joined(Bounds a, Bounds b) {
    return Bounds(min(a.least, b.least), max(a.greatest, b.greatest), a.any_invalid || b.any_invalid);
}

/// Tiles are counted from the workgroup's first; those of other workgroups are ignored.
void bound(int tx, int ty, Bounds bounds) {
    if (tx < 0 || ty < 0 || tx >= int(tiles_x) || ty >= int(tiles_y)) return;
    atomicMin(tile_least[ty][tx], bounds.least);
    atomicMax(tile_greatest[ty][tx], bounds.greatest);
    if (bounds.any_invalid) atomicOr(tile_invalid[ty][tx], 1u);
}

/// Processes a texel's pixels in some rows, and returns the bits of valid ones. `texel` and `top` are counted
/// from the workgroup's first. Another workgroup's pixels only count for bounds.
uint take(uint texel, uint top, uint rows) {
    const uint column = gl_WorkGroupID.x * block_lanes_x + texel, first = gl_WorkGroupID.y * block_height + top;
    const bool is_own = texel < block_lanes_x && top < block_height;
    if (8u * column >= push.width) return 0u;
    const uint columns = push.width - 8u * column;
    uint all = 0u;
    Bounds own = no_bounds, left = no_bounds, above = no_bounds, corner = no_bounds;
    for (uint n = 0u; n < rows && first + n < push.height; ++n) {
        const Window window = load_window(column, first + n);
        uint codes[8] = filtered(window);
        [[unroll]] for (int k = 0; k < 8; ++k) {
            const bool inside = uint(k) < columns, valid = inside && is_valid(window.rows[2][k + 2]);
            const Bounds pixel = Bounds(valid ? codes[k] : 65535u, valid ? codes[k] : 0u, inside && !valid);
            own = joined(own, pixel);
            if (k == 0) left = joined(left, pixel);
            if (valid) all |= 1u << (8u * n + uint(k));
            // shaders/terraces.comp knows invalid codes by no_finer_code.
            codes[k] = valid ? scaled(codes[k]) : to_finer != 0u ? no_finer_code : 0u;
        }
        if (n == 0u) {
            above = own;
            corner = left;
        }
        if (!is_own) continue;
        const uint at = (first + n) * push.out_pitch + column;
        out_codes[at] = packed_halves(codes);
    }
    if (to_finer != 0u || first >= push.height) return all;
    const int tx = int(texel / 2u), ty = int(top / tile_cells);
    bound(tx, ty, own);
    if (texel % 2u == 0u) bound(tx - 1, ty, left);
    if (top % tile_cells != 0u) return all;
    bound(tx, ty - 1, above);
    if (texel % 2u == 0u) bound(tx - 1, ty - 1, corner);
    return all;
}

/// A word of validity is four texels of a row: each of four neighbouring lanes assembles one row's.
void write_validity(uint lane, uint strip) {
    const uint row = lane % 4u, word = (gl_WorkGroupID.x * block_lanes_x + lane) / 4u,
               y = gl_WorkGroupID.y * block_height + 4u * strip + row;
    if (word >= push.validity_words || y >= push.height) return;
    uint bits = 0u;
    [[unroll]] for (uint k = 0u; k < 4u; ++k)
        bits |= bitfieldExtract(lane_valid[strip][lane - row + k], int(8u * row), 8) << (8u * k);
    out_validity[y * push.validity_words + word] = bits;
}

void write_tile(uint tx, uint ty) {
    const uint x = gl_WorkGroupID.x * tiles_x + tx, y = gl_WorkGroupID.y * tiles_y + ty;
    if (x >= push.tiles_x || y >= push.tiles_y) return;
    // As TileBounds lies in memory.
    out_tiles[y * push.tiles_x + x] = uvec2(tile_least[ty][tx] | tile_greatest[ty][tx] << 16, tile_invalid[ty][tx]);
}

void main() {
    const uint lane = gl_LocalInvocationIndex, tx = lane % tiles_x, ty = lane / tiles_x;
    if (ty < tiles_y) {
        tile_least[ty][tx] = 65535u;
        tile_greatest[ty][tx] = tile_invalid[ty][tx] = 0u;
    }
    barrier();
    const uint x = gl_LocalInvocationID.x, strip = gl_LocalInvocationID.y;
    lane_valid[strip][x] = take(x, 4u * strip, 4u);
    // The row below and the column to the right, a row for each lane.
    if (to_finer == 0u) {
        if (lane <= block_lanes_x) take(lane, block_height, 1u);
        else if (lane <= block_lanes_x + block_height) take(block_lanes_x, lane - block_lanes_x - 1u, 1u);
    }
    barrier();
    write_validity(x, strip);
    if (to_finer == 0u && ty < tiles_y) write_tile(tx, ty);
}
