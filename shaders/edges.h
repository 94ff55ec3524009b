// Interface of the kernel edges.comp, the shaders that draw from its output, and C++.
//
// A lane for each vertex finds from q where it is drawn at edges (edge_rule.h): two words a vertex, the bits
// of q there, 0 if the vertex is drawn at its pixel, and from the lowest byte on the move in x, in y, and the
// shade. Views from the clip's own place do not use it.
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
#define EDGES_MOVED 1  // two words each, rows as long as q's

struct EdgesPush {
    uint width, height;  // of the lattice
    uint pitch;          // vertices of a row of q
    float ratio;         // of cut_rule.h
    uint are_values;     // colours are of a scale and not shaded
};

#ifndef __cplusplus
/// Where a vertex is drawn, in pixels of the lattice, and its q there, from these two words.
vec3 edge_place(uvec2 moved, uint x, uint y) {
    const ivec2 by = ivec2(bitfieldExtract(int(moved.y), 0, 8), bitfieldExtract(int(moved.y), 8, 8));
    return vec3(vec2(x, y) + vec2(by) / float(EDGE_UNIT), uintBitsToFloat(moved.x));
}
/// The share of its colour.
float edge_light(uvec2 moved) {
    return float(moved.y >> 16) / float(EDGE_UNIT);
}
#else
}  // namespace touchable
#endif

#endif
