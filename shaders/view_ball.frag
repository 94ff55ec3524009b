#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require

// Light and z of a ball where the line of sight meets it, fading at its silhouette.

#include "shaders/solid_light.h"
#include "shaders/view_marks.h"

layout(location = 0) in vec3 place;
layout(location = 1) flat in vec4 to_eye;
layout(location = 2) flat in vec4 centre;
layout(location = 3) flat in vec4 light;
layout(location = 4) flat in float per_length;
layout(location = 0) out vec4 drawn;

void main() {
    // Everything relative to the centre: rounded world positions would be coarse for a small ball.
    const float beside = dot(place, place), slant = beside + to_eye.w * to_eye.w;
    const float squared = beside * (1.0f - beside / slant);  // distance of the line of sight from the centre
    const float radius = centre.w, edge = min(per_length * (radius - sqrt(squared)) + 0.5f, 1.0f);
    if (edge <= 0.0f) discard;
    const vec3 back = (to_eye.xyz * to_eye.w - place) * inversesqrt(slant);
    const vec3 met = place + back * (beside * inversesqrt(slant) + sqrt(max(radius * radius - squared, 0.0f)));
    const vec3 unit = normalize(met);
    const vec4 clip = push.clip_from_world * vec4(centre.xyz + met, 1.0f);
    gl_FragDepth = clip.z / clip.w;
    const float opacity =
        push.is_veil != 0u ? veil(light.w, max(dot(unit, to_eye.xyz), 0.0f), push.is_behind != 0u) : 1.0f;
    drawn = vec4(solid_light(light.rgb, unit, to_eye.xyz), opacity * edge);
}
