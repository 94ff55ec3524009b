// SPDX-License-Identifier: Apache-2.0
// How the solids that stand for fingers look, in pictures drawn by the CPU and on a GPU. Compiled as GLSL and
// as C++ (with GLM). Colours are light, 0 to 1 a channel; directions are unit vectors, world axes.
// Threads: any; nothing here keeps state.
#ifndef TOUCHABLE_SHADERS_SOLID_LIGHT_H
#define TOUCHABLE_SHADERS_SOLID_LIGHT_H

#ifdef __cplusplus
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
namespace touchable {
using glm::dot;
using glm::max;
using glm::min;
using glm::normalize;
using glm::vec3;
#define SOLID_FUNCTION inline
#else
#define SOLID_FUNCTION
#endif

/// Light of a smooth solid that is slightly glossy.
SOLID_FUNCTION vec3 solid_light(vec3 colour, vec3 normal, vec3 to_eye) {
    const vec3 key = vec3(-0.5425900f, 0.6412428f, 0.5425900f);
    const float facing = max(0.0f, dot(normal, to_eye));
    const float diffuse = 0.30f + 0.12f * normal.y + 0.55f * max(0.0f, dot(normal, key)) + 0.12f * facing;
    const float gloss = max(0.0f, dot(normal, normalize(key + to_eye)));
    const float gloss2 = gloss * gloss, gloss4 = gloss2 * gloss2, gloss8 = gloss4 * gloss4;
    return colour * diffuse + 0.28f * gloss8 * gloss8 * gloss8 * gloss8 * gloss8;
}

/// How much a transparent solid hides of what is behind it: more towards its rim, as a bubble does, and less
/// if it is behind something itself. `facing`: cosine between the normal and the direction to the eye, > 0.
SOLID_FUNCTION float veil(float opacity, float facing, bool is_behind) {
    const float rim = (1.0f - facing) * (1.0f - facing);
    return min(opacity * (is_behind ? 0.75f : 1.0f) * (0.45f + 1.3f * rim), 1.0f);
}

/// The share of light left on a surface at a share (0 to 1) of the reach of a ball's shadow. `darkness`: 0 to
/// 1, in its middle.
SOLID_FUNCTION float shadow_light(float squared_share, float darkness) {
    const float fade = 1.0f - squared_share;
    return 1.0f - darkness * fade * fade;
}

#ifdef __cplusplus
}  // namespace touchable
#endif
#undef SOLID_FUNCTION

#endif
