// SPDX-License-Identifier: Apache-2.0
// Interface of the shaders view_ball, view_frustum, view_thread and view_shadow and their caller: fingers,
// drawn by triangle hardware. GLSL and C++ (with GLM). World axes and scene units; colours are light.
//
// A ball is an instance of a square in which rays are cast pixel by pixel, the mantle of a frustum an
// instance of a pattern of triangles. A thread is an instance for each stretch between two points: a ribbon
// that faces the eye and looks round. All are half a pixel larger than their size, and fade over the
// outermost pixel, which makes their edges smooth.
// Threads: any; nothing here keeps state.
#ifndef TOUCHABLE_SHADERS_VIEW_MARKS_H
#define TOUCHABLE_SHADERS_VIEW_MARKS_H

#ifdef __cplusplus
#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>
namespace touchable {
using glm::mat4;
using glm::vec4;
using uint = unsigned int;
#endif

#define MARKS_SIDES 24         // of a frustum's ends
#define MARKS_RING_CORNERS 25  // vertices: the last is the first again

struct SolidRecord {
    vec4 foot;   // of a ball its centre; w: radius at the first ring
    vec4 along;  // unit, from the first ring to the second; w: radius at that
    vec4 ends;   // height of either ring along the axis, normal along and away from it
    vec4 light;  // w: opacity
};

struct ThreadRecord {
    vec4 at;     // w: radius
    vec4 light;  // w: 1 if a stretch leads here from the point before, else 0
};

struct ShadowRecord {
    mat4 share_from_pixel;  // (x, y, z, 1) -> homogeneous, from the ball's centre in shares of its reach
    vec4 bounds;            // clip space: least x and y, greatest x and y
    vec4 darkness;          // x: in its middle, 0 to 1
};

struct MarksPush {
    mat4 clip_from_world;
    vec4 eye;        // w: pixels of an object as large as its distance
    uint is_behind;  // transparent solids: their parts that are behind something
    uint is_veil;    // transparent solids
};

#ifdef __cplusplus
}  // namespace touchable
#else
layout(push_constant, std430) uniform Push {
    MarksPush push;
};
#endif

#endif
