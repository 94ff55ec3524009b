#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require

// Light of a thread.

#include "shaders/solid_light.h"

layout(location = 0) in float across;
layout(location = 1) in vec3 sideways;
layout(location = 2) in vec3 front;
layout(location = 3) in vec3 to_eye;
layout(location = 4) flat in vec3 light;
layout(location = 5) in float pixels;
layout(location = 0) out vec4 drawn;

void main() {
    const vec3 normal = normalize(across * sideways + sqrt(max(0.0f, 1.0f - across * across)) * front);
    drawn = vec4(solid_light(light, normal, normalize(to_eye)), clamp(pixels * (1.0f - abs(across)), 0.0f, 1.0f));
}
