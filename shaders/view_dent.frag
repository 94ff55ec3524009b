#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require

// Draws a pixel of a surface that gives way under fingers, from the picture without dents. Every pixel sums
// all dents, so that overlapping ones are one, whichever draws it.

#include "shaders/cut_rule.h"
#include "shaders/dents.h"

layout(set = 0, binding = 1) uniform texture2D z_image;
layout(set = 0, binding = 2) uniform texture2D picture;

layout(location = 0) out vec4 drawn;

vec3 colour_at(vec2 place) {
    const vec2 from = place - 0.5f, corner = floor(from), into = from - corner;
    const ivec2 last = textureSize(picture, 0) - 1;
    const ivec2 a = clamp(ivec2(corner), ivec2(0), last), b = clamp(ivec2(corner) + 1, ivec2(0), last);
    const vec3 above = mix(texelFetch(picture, a, 0).rgb, texelFetch(picture, ivec2(b.x, a.y), 0).rgb, into.x);
    const vec3 below = mix(texelFetch(picture, ivec2(a.x, b.y), 0).rgb, texelFetch(picture, b, 0).rgb, into.x);
    return mix(above, below, into.y);
}

void main() {
    const vec2 pixel = gl_FragCoord.xy;
    const float z = texelFetch(z_image, ivec2(pixel), 0).x;
    if (!(z > 0.0f)) discard;
    const vec4 at = header.world_from_pixel * vec4(pixel, z, 1.0f);
    const vec3 place = at.xyz / at.w;
    vec3 moved = vec3(0.0f), normals = vec3(0.0f), slope = vec3(0.0f);
    for (uint k = 0; k < header.count; ++k) {
        const DentRecord dent = dents[k];
        const vec3 share = (place - dent.centre.xyz) * dent.centre.w;
        const float along = dent_share(share);
        if (!(along > 0.0f)) continue;
        moved += along * dent.moved.xyz;
        normals += along * dent.normal.xyz;
        slope += dent_slope(share, dent.normal.xyz, dent.moved.xyz * dent.centre.w);
    }
    if (!(dot(normals, normals) > 0.0f)) discard;
    const vec4 there = header.pixel_from_world * vec4(place + moved, 1.0f);
    if (!(there.z <= there.w)) discard;  // before the near plane
    vec2 source = pixel - (there.xy / there.w - pixel);
    // Do not show what stands before the surface.
    const ivec2 last = textureSize(z_image, 0) - 1;
    const float source_z = texelFetch(z_image, clamp(ivec2(source), ivec2(0), last), 0).x;
    if (source_z > z * CUT_RULE_RATIO) source = pixel;
    const vec3 normal = normalize(normals);
    const DentLight light = dent_light(normal, normalize(normal + slope));
    drawn = vec4(colour_at(source) * light.factor + light.gloss, 1.0f);
}
