#version 460
#extension GL_GOOGLE_include_directive : require

// Packed pixels, as raster.comp makes them -> colour and z, the background where they are empty.

#include "shaders/view_screen.h"

layout(push_constant, std430) uniform Push {
    ScreenPush push;
};
layout(set = 0, binding = SCREEN_BACKGROUND, std430) readonly buffer Background {
    uint background[];
};
layout(set = 0, binding = SCREEN_PIXELS, std430) readonly buffer Pixels {
    uvec2 pixels[];  // colour, then z: the words of 64 bits
};

layout(location = 0) out vec4 drawn;

void main() {
    const uvec2 at = uvec2(gl_FragCoord.xy);
    const uvec2 pixel = pixels[at.y * push.width + at.x];
    drawn = unpackUnorm4x8(pixel.y != 0u ? pixel.x : background[at.y]);
    gl_FragDepth = uintBitsToFloat(pixel.y);
}
