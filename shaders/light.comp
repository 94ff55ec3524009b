#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

// q and colour of every vertex -> its lit colour.

#include "shaders/cut_rule.h"
#include "shaders/light.h"
#include "shaders/surface_light.h"

layout(local_size_x = LIGHT_LANES) in;
layout(constant_id = 0) const uint has_colour = 1u;
layout(constant_id = 1) const uint is_lit = 1u;

layout(push_constant, std430) uniform Push {
    LightPush push;
};
layout(set = 0, binding = LIGHT_Q) uniform utextureBuffer q_texels;
layout(set = 0, binding = LIGHT_RGB) uniform utextureBuffer rgb_texels;
// In the widest words: stores cost by the word.
layout(set = 0, binding = LIGHT_COLOURS, std430) writeonly buffer Colours {
    u64vec4 colours[];
};

#define SEEN 16   // columns of q around the lane's, from 4 before them on
#define CELLS 13  // columns of cells whose triangles light them, from 3 before them on

struct Row {
    float q[SEEN];
};

/// 0 beyond the lattice, where all triangles are cut.
Row load(int y, int lane_column) {
    const bool is_row = y >= 0 && y < int(push.height);
    const int start = is_row ? y * int(push.pitch) : 0;
    Row row;
    [[unroll]] for (int n = 0; n < SEEN / 4; ++n) {
        const int texel = 2 * lane_column - 1 + n;
        const bool is_there = is_row && texel >= 0 && texel < int(push.pitch);
        const vec4 four = uintBitsToFloat(texelFetch(q_texels, start + clamp(texel, 0, int(push.pitch) - 1)));
        [[unroll]] for (int k = 0; k < 4; ++k) row.q[4 * n + k] = is_there ? four[k] : 0.0f;
    }
    return row;
}

/// Normal of a triangle through (x, y, q), towards the camera, with its area as length; 0 if it is cut.
vec3 normal_of(float x, float y, float q, float to_right, float down, float q1, float q2) {
    const float weight =
        triangle_is_cut(q, q1, q2) ? 0.0f : push.unit / (q * push.unit * (q1 * push.unit) * (q2 * push.unit));
    return vec3(-push.fx * to_right, push.fy * down, q - to_right * (x - push.cx) - down * (y - push.cy)) * weight;
}

/// Sums of five neighbours.
struct Sums {
    vec3 of[CELLS - 4];
};
Sums sums_of_five(vec3 values[CELLS]) {
    vec3 two[CELLS - 1];
    [[unroll]] for (int n = 0; n < CELLS - 1; ++n) two[n] = values[n] + values[n + 1];
    Sums sums;
    [[unroll]] for (int n = 0; n < CELLS - 4; ++n) sums.of[n] = two[n] + two[n + 2] + values[n + 4];
    return sums;
}

/// What a row of cells adds to the sums of the rows of vertices around it.
struct Shares {
    vec3 upper[LIGHT_COLUMNS];  // of vertices at the cells' upper corners alone
    vec3 lower[LIGHT_COLUMNS];  // of those at the lower ones
};
Shares shares_of(Row upper, Row lower, float x, float y) {
    vec3 right[CELLS], left[CELLS];
    [[unroll]] for (int n = 0; n < CELLS; ++n) {
        const float q00 = upper.q[n + 1], q10 = upper.q[n + 2], q01 = lower.q[n + 1], q11 = lower.q[n + 2];
        right[n] = normal_of(x + float(n - 3), y, q00, q10 - q00, q11 - q10, q10, q11);
        left[n] = normal_of(x + float(n - 3), y, q00, q11 - q01, q01 - q00, q01, q11);
    }
    const Sums rights = sums_of_five(right), lefts = sums_of_five(left);
    // A vertex is a corner of both triangles of the cells to its lower right and upper left, of the right
    // triangle of the cell to its lower left, and of the left one of the cell to its upper right.
    Shares shares;
    [[unroll]] for (int n = 0; n < LIGHT_COLUMNS; ++n) {
        shares.upper[n] = rights.of[n + 1] + rights.of[n] + lefts.of[n + 1];
        shares.lower[n] = rights.of[n] + lefts.of[n] + lefts.of[n + 1];
    }
    return shares;
}

/// The lane's colours at a row: six words of three bytes each.
struct Bytes {
    uint word[6];
};
Bytes load_rgb(int y, int lane_column) {
    Bytes bytes;
    if (has_colour == 0u) return bytes;
    const int first = (y * int(push.pitch) * 4 + lane_column * LIGHT_COLUMNS) * 3 / 4;  // word
    const uvec4 a = texelFetch(rgb_texels, first / 4), b = texelFetch(rgb_texels, first / 4 + 1);
    const bool is_whole = first % 4 == 0;  // else it begins in the middle of a texel
    bytes.word[0] = is_whole ? a.x : a.z;
    bytes.word[1] = is_whole ? a.y : a.w;
    bytes.word[2] = is_whole ? a.z : b.x;
    bytes.word[3] = is_whole ? a.w : b.y;
    bytes.word[4] = is_whole ? b.x : b.z;
    bytes.word[5] = is_whole ? b.y : b.w;
    return bytes;
}
uint byte_at(Bytes bytes, int n) {
    return bytes.word[n / 4] >> 8 * (n % 4) & 255u;
}

uint packed_colour(vec3 colour) {
    const uvec3 byte = uvec3(colour + 0.5f);
    return byte.r | byte.g << 8 | byte.b << 16 | 255u << 24;
}

void store(int y, int lane_column, uint word[LIGHT_COLUMNS]) {
    colours[(y * int(push.pitch) * 4) / LIGHT_COLUMNS + lane_column] =
        u64vec4(packUint2x32(uvec2(word[0], word[1])), packUint2x32(uvec2(word[2], word[3])),
                packUint2x32(uvec2(word[4], word[5])), packUint2x32(uvec2(word[6], word[7])));
}

void shade(int y, int lane_column, vec3 normals[LIGHT_COLUMNS], Row row) {
    const Bytes bytes = load_rgb(y, lane_column);
    uint word[LIGHT_COLUMNS];
    [[unroll]] for (int n = 0; n < LIGHT_COLUMNS; ++n) {
        const float squared = dot(normals[n], normals[n]);
        const vec3 normal = squared > 0.0f ? normals[n] * inversesqrt(squared) : vec3(0.0f, 0.0f, 1.0f);
        const float light = light_on(normal);
        if (has_colour != 0u) {
            const vec3 colour = vec3(byte_at(bytes, 3 * n), byte_at(bytes, 3 * n + 1), byte_at(bytes, 3 * n + 2));
            word[n] = packed_colour(lit_colour(colour, light, push.strength));
        } else {
            word[n] = packed_colour(lit_clay((row.q[n + 4] - push.far_q) * push.per_q_range, light));
        }
    }
    store(y, lane_column, word);
}

void copy_rows(int first, int end, int lane_column) {
    for (int y = first; y < end; ++y) {
        const Bytes bytes = load_rgb(y, lane_column);
        uint word[LIGHT_COLUMNS];
        [[unroll]] for (int n = 0; n < LIGHT_COLUMNS; ++n)
            word[n] = byte_at(bytes, 3 * n) | byte_at(bytes, 3 * n + 1) << 8 | byte_at(bytes, 3 * n + 2) << 16 |
                      255u << 24;
        store(y, lane_column, word);
    }
}

void main() {
    const int lane = int(gl_GlobalInvocationID.x);
    const int lanes_in_row = (int(push.width) + LIGHT_COLUMNS - 1) / LIGHT_COLUMNS;
    const int lane_column = lane % lanes_in_row;
    const int first = lane / lanes_in_row * LIGHT_STRIP, end = min(first + LIGHT_STRIP, int(push.height));
    if (first >= end) return;
    if (is_lit == 0u) {
        copy_rows(first, end, lane_column);
        return;
    }
    // Sums so far of the rows of vertices 2 and 1 above a row of cells, at it, and 1 and 2 below.
    vec3 sums[5][LIGHT_COLUMNS];
    [[unroll]] for (int r = 0; r < 5; ++r)
        [[unroll]] for (int n = 0; n < LIGHT_COLUMNS; ++n) sums[r][n] = vec3(0.0f);
    const float x = float(lane_column * LIGHT_COLUMNS);
    Row upper = load(first - 3, lane_column);
    for (int y = first - 3; y < end + 2; ++y) {
        const Row lower = load(y + 1, lane_column);
        const Shares shares = shares_of(upper, lower, x, float(y));
        vec3 done[LIGHT_COLUMNS];
        [[unroll]] for (int n = 0; n < LIGHT_COLUMNS; ++n) {
            const vec3 both = shares.upper[n] + shares.lower[n];
            done[n] = sums[0][n] + shares.upper[n];
            sums[0][n] = sums[1][n] + both;
            sums[1][n] = sums[2][n] + both;
            sums[2][n] = sums[3][n] + both;
            sums[3][n] = sums[4][n] + both;
            sums[4][n] = shares.lower[n];
        }
        // The shade of clay needs q of its own row again.
        if (y - 2 >= first) {
            Row own;
            if (has_colour == 0u) own = load(y - 2, lane_column);
            shade(y - 2, lane_column, done, own);
        }
        upper = lower;
    }
}
