// SPDX-License-Identifier: Apache-2.0
// Light on the surface, as light.comp and its twin (player/view/drawn_surface.cpp) compute it. Compiled as
// GLSL and as C++ (with GLM). Colours: 0 to 255 a channel, as brightness.
// Threads: any; nothing here keeps state.
#ifndef TOUCHABLE_SHADERS_SURFACE_LIGHT_H
#define TOUCHABLE_SHADERS_SURFACE_LIGHT_H

#ifdef __cplusplus
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
namespace touchable {
using glm::clamp;
using glm::dot;
using glm::max;
using glm::mix;
using glm::vec3;
#define LIGHT_FUNCTION inline
#else
#define LIGHT_FUNCTION
#endif

/// Light on a surface with this normal (unit, world axes), 0 to about 1: a key light, a fill light against
/// black shadows, and the sky.
LIGHT_FUNCTION float light_on(vec3 normal) {
    const vec3 key = vec3(-0.5425900f, 0.6412428f, 0.5425900f);
    const vec3 fill = vec3(0.8082904f, -0.1154701f, 0.5773503f);
    const float sky = 0.5f + 0.5f * normal.y;
    return 0.22f + 0.16f * sky + 0.55f * max(0.0f, dot(normal, key)) + 0.12f * max(0.0f, dot(normal, fill));
}

/// What light does to a colour, to show relief. `strength`: 1 for a gentle light, 0 leaves the colour alone.
LIGHT_FUNCTION float light_gain(float light, float strength) {
    return 1.0f - 0.55f * strength + 0.7f * strength * light;
}
LIGHT_FUNCTION vec3 lit_colour(vec3 colour, float light, float strength) {
    return clamp(colour * light_gain(light, strength), 0.0f, 255.0f);
}

/// Clay in a full light, nearer (up to 1) warmer and farther (down to 0) cooler.
LIGHT_FUNCTION vec3 lit_clay(float nearness, float light) {
    const vec3 near_clay = vec3(246.0f, 214.0f, 178.0f), far_clay = vec3(120.0f, 148.0f, 182.0f);
    return clamp(mix(far_clay, near_clay, clamp(nearness, 0.0f, 1.0f)) * (0.12f + light), 0.0f, 255.0f);
}

#ifdef __cplusplus
}  // namespace touchable
#endif
#undef LIGHT_FUNCTION

#endif
