// SPDX-License-Identifier: Apache-2.0
// The corner of a square for each of the six vertices of two triangles. GLSL alone.
#ifndef TOUCHABLE_SHADERS_VIEW_QUAD_H
#define TOUCHABLE_SHADERS_VIEW_QUAD_H

/// x: whether it is on the right; y: whether it is below.
bvec2 quad_corner() {
    const int vertex = gl_VertexIndex;
    return bvec2(vertex == 1 || vertex == 3 || vertex == 4, vertex == 2 || vertex == 4 || vertex == 5);
}

#endif
