// SPDX-License-Identifier: Apache-2.0
// Shared by raster.comp and raster_large.comp; GLSL alone.
#ifndef TOUCHABLE_SHADERS_RASTER_COMMON_H
#define TOUCHABLE_SHADERS_RASTER_COMMON_H

#include "shaders/cut_rule.h"
#include "shaders/edges.h"
#define GAP_LATTICE
#include "shaders/gap_fill.h"
#include "shaders/raster.h"

layout(push_constant, std430) uniform Push {
    RasterPush push;
};
layout(set = 0, binding = RASTER_Q) uniform utextureBuffer q_words;
layout(set = 0, binding = RASTER_COLOURS) uniform utextureBuffer colour_words;
layout(set = 0, binding = RASTER_PIXELS, std430) buffer Pixels {
    uint64_t pixels[];
};
layout(set = 0, binding = RASTER_LARGE, std430) buffer Large {
    uint groups_x, groups_y, groups_z, large_count;
    uint large_cells[];
};
layout(set = 0, binding = RASTER_EDGES, std430) readonly buffer MovedVertices {
    uvec2 moved_vertices[];
};

float q_at(uint vertex) {
    return uintBitsToFloat(texelFetch(q_words, int(vertex)).x);
}

uint colour_at(uint vertex) {
    return texelFetch(colour_words, int(vertex)).x;
}

vec3 unpacked(uint colour) {
    return vec3(colour & 255u, colour >> 8 & 255u, colour >> 16 & 255u);
}

/// A vertex in clip space, and its colour.
struct Projected {
    vec4 clip;
    vec3 colour;
};
Projected projected(uint vertex, uint x, uint y) {
    uvec2 moved = uvec2(0u);
    if (push.is_turned != 0u) moved = moved_vertices[vertex];
    const vec3 colour = unpacked(colour_at(vertex));
    if (moved.x == 0u) return Projected(view_clip(push.rows, float(x), float(y), abs(q_at(vertex))), colour);
    const vec3 place = edge_place(moved, x, y);
    return Projected(view_clip(push.rows, place.x, place.y, place.z), colour);
}

float gap_q(ivec2 at) {
    return q_at(uint(at.y) * push.pitch + uint(at.x));
}

vec3 gap_colour(ivec2 at) {
    return unpacked(colour_at(uint(at.y) * push.pitch + uint(at.x)));
}

/// Cuts by the rule of this view.
bool is_cut(float q0, float q1, float q2) {
    return push.is_turned != 0u ? triangle_is_cut(q0, q1, q2) : triangle_has_hole(q0, q1, q2);
}

void plot(int x, int y, float z, vec3 colour) {
    const uvec3 byte = uvec3(colour + 0.5f);
    const uint packed_colour = byte.r | byte.g << 8 | byte.b << 16 | 255u << 24;
    atomicMax(pixels[uint(y) * push.picture_pitch + uint(x)],
              uint64_t(floatBitsToUint(z)) << 32 | uint64_t(packed_colour));
}

#endif
