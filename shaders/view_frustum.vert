#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require

// A vertex of a frustum.

#include "shaders/view_marks.h"

layout(set = 0, binding = 0, std430) readonly buffer Solids {
    SolidRecord solids[];
};

layout(location = 0) out vec3 normal;
layout(location = 1) flat out vec3 to_eye;
layout(location = 2) flat out vec4 light;

const float pi = 3.14159265f;

void main() {
    const SolidRecord solid = solids[gl_InstanceIndex];
    const uint ring = uint(gl_VertexIndex) / MARKS_RING_CORNERS, side = uint(gl_VertexIndex) % MARKS_RING_CORNERS;
    to_eye = normalize(push.eye.xyz - solid.foot.xyz);
    light = solid.light;

    const vec3 along = solid.along.xyz;
    const vec3 other = abs(along.y) < 0.9f ? vec3(0.0f, 1.0f, 0.0f) : vec3(1.0f, 0.0f, 0.0f);
    const vec3 a = normalize(cross(along, other)), b = cross(along, a);
    const float turn = 2.0f * pi * float(side % MARKS_SIDES) / float(MARKS_SIDES);
    const vec3 away = cos(turn) * a + sin(turn) * b;

    normal = normalize(solid.ends.z * along + solid.ends.w * away);
    const float height = ring == 0u ? solid.ends.x : solid.ends.y;
    const vec3 middle = solid.foot.xyz + height * along;
    const float half_pixel = 0.5f * length(push.eye.xyz - middle) / push.eye.w;
    const float radius = (ring == 0u ? solid.foot.w : solid.along.w) + half_pixel * solid.ends.w;
    gl_Position = push.clip_from_world * vec4(middle + radius * away, 1.0f);
}
