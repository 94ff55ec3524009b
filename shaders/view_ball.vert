#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require

// A corner of the square that a ball is seen in: across the line to its centre, and as wide as the ball,
// enlarged by half a pixel, appears from the eye.

#include "shaders/view_marks.h"
#include "shaders/view_quad.h"

layout(set = 0, binding = 0, std430) readonly buffer Solids {
    SolidRecord solids[];
};

layout(location = 0) out vec3 place;             // from the centre
layout(location = 1) flat out vec4 to_eye;       // unit; w: distance
layout(location = 2) flat out vec4 centre;       // w: radius
layout(location = 3) flat out vec4 light;
layout(location = 4) flat out float per_length;  // pixels

void main() {
    const SolidRecord solid = solids[gl_InstanceIndex];
    const vec3 back = push.eye.xyz - solid.foot.xyz;
    const float distance_to_eye = length(back);
    per_length = push.eye.w / distance_to_eye;
    to_eye = vec4(back / distance_to_eye, distance_to_eye);
    centre = solid.foot;
    light = solid.light;

    const vec3 other = abs(to_eye.y) < 0.9f ? vec3(0.0f, 1.0f, 0.0f) : vec3(1.0f, 0.0f, 0.0f);
    const vec3 a = normalize(cross(to_eye.xyz, other)), b = cross(to_eye.xyz, a);
    // Half width: where sight grazes the ball, at the centre's distance. An eye within it sees nothing.
    const float radius = solid.foot.w + 0.5f / per_length;
    const float share = radius / distance_to_eye, slant = 1.0f - share * share;
    const float reach = slant > 0.0f ? radius / sqrt(slant) : 0.0f;
    const vec2 corner = mix(vec2(-1.0f), vec2(1.0f), quad_corner());
    place = reach * (corner.x * a + corner.y * b);
    gl_Position = push.clip_from_world * vec4(solid.foot.xyz + place, 1.0f);
}
