// SPDX-License-Identifier: Apache-2.0
// How a surface that gives way under fingers looks, for the shaders view_dent, their caller and the CPU's
// twin. Compiled as GLSL and as C++ (with GLM). World axes, scene units.
//
// A finger moves the place of the surface under it by `moved`; places around it move less the farther they
// are, and not at all from `reach` on. A pixel shows the place that has moved to it.
// Threads: any; nothing here keeps state.
#ifndef TOUCHABLE_SHADERS_DENTS_H
#define TOUCHABLE_SHADERS_DENTS_H

#include "shaders/surface_light.h"

#ifdef __cplusplus
#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
namespace touchable {
using glm::dot;
using glm::mat4;
using glm::max;
using glm::vec3;
using glm::vec4;
using uint = unsigned int;
#define DENT_FUNCTION inline
#else
#define DENT_FUNCTION
#endif

struct DentRecord {
    vec4 centre;  // w: 1 / reach
    vec4 normal;  // unit, on the side that fingers come from
    vec4 moved;   // at most half of the reach: beyond, places would pass each other
    vec4 bounds;  // of the screen, clip space: least x and y, greatest x and y
};

/// Before the records, in the same buffer.
struct DentHeader {
    mat4 world_from_pixel;  // (x, y, z, 1) -> homogeneous
    mat4 pixel_from_world;  // (X, Y, Z, 1) -> homogeneous
    uint count;
    uint unused[3];
};

/// How much of a finger's motion a place at `share` (from its middle, in shares of the reach) follows, 1 to
/// 0.
DENT_FUNCTION float dent_share(vec3 share) {
    const float rest = 1.0f - dot(share, share);
    return rest > 0.0f ? rest * rest * rest : 0.0f;
}

/// The vector to add to a surface's unit normal there: the slope of the dent, exaggerated twofold, as relief
/// on maps. `moved` in shares of the reach.
DENT_FUNCTION vec3 dent_slope(vec3 share, vec3 normal, vec3 moved) {
    const float rest = 1.0f - dot(share, share), depth = -dot(moved, normal);
    if (!(rest > 0.0f)) return vec3(0.0f);
    return (-12.0f * rest * rest * depth) * (share - normal * dot(share, normal));
}

/// The factor of a surface's colour (brightness, 0 to 1 a channel) when its unit normal changes, and what is
/// added: twice the change of light, and some gloss, without which dents in a dark one would be invisible.
struct DentLight {
    float factor, gloss;
};
DENT_FUNCTION DentLight dent_light(vec3 before, vec3 after) {
    const float change = (0.45f + 0.7f * light_on(after)) / (0.45f + 0.7f * light_on(before));
    const float factor = change * change;
    DentLight light;
    light.factor = factor;
    light.gloss = 0.2f * max(0.0f, factor - 1.0f);
    return light;
}

#ifdef __cplusplus
}  // namespace touchable
#else
layout(set = 0, binding = 0, std430) readonly buffer Dents {
    DentHeader header;
    DentRecord dents[];
};
#endif
#undef DENT_FUNCTION

#endif
