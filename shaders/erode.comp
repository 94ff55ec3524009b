#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require

// q of every vertex -> as it is drawn: negative where it is eroded.

#include "shaders/edges.h"
#include "shaders/gap_fill.h"

layout(local_size_x = EDGES_LANES) in;
layout(push_constant, std430) uniform Push {
    EdgesPush push;
};
layout(set = 0, binding = EDGES_Q) uniform utextureBuffer q_words;
layout(set = 0, binding = EDGES_MOVED, std430) writeonly buffer Eroded {
    float eroded[];
};

float edge_q(EdgeLattice lattice, ivec2 at) {
    return uintBitsToFloat(texelFetch(q_words, at.y * lattice.pitch + at.x).x);
}

void main() {
    const uint x = gl_GlobalInvocationID.x, y = gl_WorkGroupID.y;
    if (x >= push.pitch) return;
    float q = 0.0f;
    if (x < push.width && push.is_turned != 0u) {
        q = edge_eroded_q(lattice_of(push), ivec2(x, y));
    } else if (x < push.width) {
        q = edge_q(lattice_of(push), ivec2(x, y));
        if (q == 0.0f && push.fills_gaps != 0u) q = HOLE_Q;
    }
    eroded[y * push.pitch + x] = q;
}
