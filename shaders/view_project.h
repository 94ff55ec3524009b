// SPDX-License-Identifier: Apache-2.0
// Projects a vertex of the lattice to the screen, in one order of float operations, so that painters agree on
// its place. Compiled as GLSL and as C++ (with GLM).
// Threads: any; nothing here keeps state.
#ifndef TOUCHABLE_SHADERS_VIEW_PROJECT_H
#define TOUCHABLE_SHADERS_VIEW_PROJECT_H

#ifdef __cplusplus
#include <cmath>
#include <glm/vec4.hpp>
namespace touchable {
using glm::vec4;
using std::floor;
#define VIEW_FUNCTION inline
#define VIEW_PRECISE
#else
#define VIEW_FUNCTION
#define VIEW_PRECISE precise
#endif

/// Steps of a pixel to which screen positions are rounded, as triangle hardware does.
#define VIEW_SUBPIXELS 256
/// Positions are kept within this many subpixels of the screen's corner: 2 million pixels.
#define VIEW_GUARD 536870912.0f

/// Rows of the matrix that takes (x, y, 1, q) to clip space.
struct ViewRows {
    vec4 x, y, z, w;
};

VIEW_FUNCTION float view_row(vec4 row, float x, float y, float q) {
    VIEW_PRECISE float sum = row.x * x;
    sum = sum + row.y * y;
    sum = sum + row.z;
    sum = sum + row.w * q;
    return sum;
}

VIEW_FUNCTION vec4 view_clip(ViewRows rows, float x, float y, float q) {
    return vec4(view_row(rows.x, x, y, q), view_row(rows.y, x, y, q), view_row(rows.z, x, y, q),
                view_row(rows.w, x, y, q));
}

/// One coordinate of clip space over w, on a screen of `size` pixels, in whole subpixels: the nearest one.
VIEW_FUNCTION int view_subpixels(float ndc, float size) {
    VIEW_PRECISE float at = (ndc * 0.5f + 0.5f) * (size * float(VIEW_SUBPIXELS));
    at = at < -VIEW_GUARD ? -VIEW_GUARD : (at > VIEW_GUARD ? VIEW_GUARD : at);
    return int(floor(at + 0.5f));
}

#ifdef __cplusplus
}  // namespace touchable
#endif
#undef VIEW_FUNCTION
#undef VIEW_PRECISE

#endif
