#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require

// A corner of a stretch of thread.

#include "shaders/view_marks.h"
#include "shaders/view_quad.h"

layout(set = 0, binding = 0, std430) readonly buffer Threads {
    ThreadRecord points[];
};

layout(location = 0) out float across;  // -1 to 1
layout(location = 1) out vec3 sideways;
layout(location = 2) out vec3 front;  // where the thread faces the eye
layout(location = 3) out vec3 to_eye;
layout(location = 4) flat out vec3 light;
layout(location = 5) out float pixels;  // radius

bool is_joined(uint at) {
    return points[at].light.w != 0.0f;
}

void main() {
    const uint from = uint(gl_InstanceIndex), to = from + 1u;
    const bvec2 corner = quad_corner();
    across = corner.y ? 1.0f : -1.0f;
    const uint at = corner.x ? to : from;
    light = points[to].light.rgb;
    // Stretches that meet agree on a direction. The first point is joined to none, and an extra point after
    // the last one is not joined, either.
    const uint before = is_joined(at) ? at - 1u : at, after = is_joined(at + 1u) ? at + 1u : at;
    const vec3 point = points[at].at.xyz;
    const vec3 back = push.eye.xyz - point;
    const float distance_to_eye = length(back);
    to_eye = back / distance_to_eye;
    // By the stretch, so that both its ends agree on whether it is drawn.
    const vec3 stretch = points[to].at.xyz - points[from].at.xyz;
    const bool is_drawn = is_joined(to) && dot(stretch, stretch) > 0.0f;
    // A thread that folds back has no direction where it turns.
    const vec3 through = points[after].at.xyz - points[before].at.xyz;
    const vec3 onward = dot(through, through) > 0.0f ? through : stretch;
    const vec3 turned = cross(onward, to_eye);
    const bool has_side = is_drawn && dot(turned, turned) > 0.0f;
    sideways = has_side ? normalize(turned) : vec3(1.0f, 0.0f, 0.0f);
    front = has_side ? normalize(cross(sideways, onward)) : to_eye;

    const float pixel = distance_to_eye / push.eye.w;
    const float radius = points[at].at.w + 0.5f * pixel;
    pixels = radius / pixel;
    vec4 clip = push.clip_from_world * vec4(point + across * radius * sideways, 1.0f);
    // At the depth of the round thread's front.
    clip.z *= clip.w / max(clip.w - points[at].at.w, 1e-3f * clip.w);
    gl_Position = is_drawn ? clip : vec4(2.0f, 2.0f, 0.0f, 1.0f);
}
