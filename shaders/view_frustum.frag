#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require

// Light of a frustum, fading at its silhouette.

#include "shaders/solid_light.h"
#include "shaders/view_marks.h"

layout(location = 0) in vec3 normal;
layout(location = 1) flat in vec3 to_eye;
layout(location = 2) flat in vec4 light;
layout(location = 0) out vec4 drawn;

void main() {
    const vec3 unit = normalize(normal);
    const float facing = dot(unit, to_eye);
    // Near a silhouette the square of this grows evenly on the screen.
    const float squared = facing * facing;
    const float slope = max(length(vec2(dFdx(squared), dFdy(squared))), 1e-6f);
    const float edge = clamp(squared / slope, 0.0f, 1.0f);
    const bool is_veil = push.is_veil != 0u;
    if (is_veil && facing <= 0.0f) discard;
    const float opacity = is_veil ? veil(light.w, facing, push.is_behind != 0u) : 1.0f;
    drawn = vec4(solid_light(light.rgb, unit, to_eye), opacity * edge);
}
