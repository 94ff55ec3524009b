// SPDX-License-Identifier: Apache-2.0
// Interface of the kernels erode.comp and edges.comp, the shaders that draw from their output, and C++.
//
// A lane for each vertex erodes q (edge_rule.h); in the clip's own view it fills holes. Then, for turned views,
// one finds from it where the vertex is drawn: two words, the bits of q there, 0 if the vertex is drawn at its
// pixel, and from the lowest byte on the move in x and in y.
// Threads: any; nothing here keeps state.
#ifndef TOUCHABLE_SHADERS_EDGES_H
#define TOUCHABLE_SHADERS_EDGES_H

#include "shaders/edge_rule.h"

#ifdef __cplusplus
namespace touchable {
using uint = unsigned int;
#endif

#define EDGES_LANES 64

#define EDGES_Q 0      // words
#define EDGES_MOVED 1  // of erode.comp a word, of edges.comp two each, rows as long as q's

struct EdgesPush {
    uint width, height;  // of the lattice
    uint pitch;          // vertices of a row of q
    float ratio;         // of cut_rule.h
    float steepest;      // of edge_rule.h
    uint is_turned;      // 0: the clip's own view, which erodes nothing
    uint fills_gaps;     // and then shows colours where depth is missing
};

#ifndef __cplusplus
/// Where a vertex is drawn, in pixels of the lattice, and its q there, from these two words.
vec3 edge_place(uvec2 moved, uint x, uint y) {
    const ivec2 by = ivec2(bitfieldExtract(int(moved.y), 0, 8), bitfieldExtract(int(moved.y), 8, 8));
    return vec3(vec2(x, y) + vec2(by) / float(EDGE_UNIT), uintBitsToFloat(moved.x));
}
EdgeLattice lattice_of(EdgesPush push) {
    return EdgeLattice(int(push.width), int(push.height), int(push.pitch), push.ratio, push.steepest);
}
#else
}  // namespace touchable
#endif

#endif
