#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require

// q of every vertex, eroded -> where those at edges are drawn.

#include "shaders/edges.h"

layout(local_size_x = EDGES_LANES) in;
layout(push_constant, std430) uniform Push {
    EdgesPush push;
};
layout(set = 0, binding = EDGES_Q) uniform utextureBuffer q_words;
layout(set = 0, binding = EDGES_MOVED, std430) writeonly buffer Moved {
    uvec2 moved[];
};

float edge_q(EdgeLattice lattice, ivec2 at) {
    return uintBitsToFloat(texelFetch(q_words, at.y * lattice.pitch + at.x).x);
}

void main() {
    const uint x = gl_GlobalInvocationID.x, y = gl_WorkGroupID.y;
    if (x >= push.pitch) return;
    uvec2 words = uvec2(0u);
    if (x < push.width) {
        const EdgeLattice lattice = lattice_of(push);
        const EdgeMove move = edge_move(lattice, ivec2(x, y));
        if (move.by != ivec2(0) || move.q != edge_q(lattice, ivec2(x, y)))
            words = uvec2(floatBitsToUint(move.q), (uint(move.by.x) & 255u) | (uint(move.by.y) & 255u) << 8);
    }
    moved[y * push.pitch + x] = words;
}
