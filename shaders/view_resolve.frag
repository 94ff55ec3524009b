#version 460
#extension GL_GOOGLE_include_directive : require

// Packed pixels -> colours and z.

#include "shaders/view_resolve.h"

layout(push_constant, std430) uniform Push {
    ResolvePush push;
};
layout(set = 0, binding = RESOLVE_PIXELS) uniform utextureBuffer pixels;
layout(set = 0, binding = RESOLVE_BACKGROUND) uniform utextureBuffer background;

layout(location = 0) out vec4 drawn;

void main() {
    const uvec2 at = uvec2(gl_FragCoord.xy);
    const uvec4 two = texelFetch(pixels, int(at.y * push.pitch + at.x / 2u));
    const uvec2 pixel = (at.x & 1u) == 0u ? two.xy : two.zw;
    const uint empty = texelFetch(background, int(at.y / 4u))[at.y & 3u];
    drawn = unpackUnorm4x8(pixel.y != 0u ? pixel.x : empty);
    gl_FragDepth = uintBitsToFloat(pixel.y);
}
