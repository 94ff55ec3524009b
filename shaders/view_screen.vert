#version 460
// SPDX-License-Identifier: Apache-2.0

// One triangle over the whole picture, as far away as can be.

void main() {
    const vec2 at = vec2(gl_VertexIndex == 1 ? 3.0f : -1.0f, gl_VertexIndex == 2 ? 3.0f : -1.0f);
    gl_Position = vec4(at, 0.0f, 1.0f);
}
