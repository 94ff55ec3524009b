#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require

// The factor of a surface's light in a ball's soft shadow.

#include "shaders/solid_light.h"
#include "shaders/view_marks.h"

layout(set = 0, binding = 0, std430) readonly buffer Shadows {
    ShadowRecord shadows[];
};
layout(set = 0, binding = 1) uniform texture2D z_image;

layout(location = 0) flat in uint shadow;
layout(location = 0) out vec4 drawn;

void main() {
    const float z = texelFetch(z_image, ivec2(gl_FragCoord.xy), 0).x;
    const vec4 at = shadows[shadow].share_from_pixel * vec4(gl_FragCoord.xy, z, 1.0f);
    const vec3 share = at.xyz / at.w;
    const float squared = dot(share, share);
    if (!(z > 0.0f) || squared >= 1.0f) discard;
    drawn = vec4(vec3(shadow_light(squared, shadows[shadow].darkness.x)), 1.0f);
}
