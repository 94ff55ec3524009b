// SPDX-License-Identifier: Apache-2.0
// Interface of the kernel resolve.comp and its caller. Compiled as GLSL and as C++.
//
// Converts packed pixels (shaders/raster.h) to colours and z, as they are copied into images; empty pixels
// get the background's colour and 0. A lane has a step of eight pixels.
// Threads: any; nothing here keeps state.
#ifndef TOUCHABLE_SHADERS_RESOLVE_H
#define TOUCHABLE_SHADERS_RESOLVE_H

#ifdef __cplusplus
namespace touchable {
using uint = unsigned int;
#endif

#define RESOLVE_LANES 64
#define RESOLVE_STEP 8  // pixels; rows are whole steps

#define RESOLVE_PIXELS 0      // texels of two
#define RESOLVE_BACKGROUND 1  // PackedColour of each row
#define RESOLVE_COLOURS 2     // PackedColour
#define RESOLVE_Z 3           // floats

struct ResolvePush {
    uint steps;   // of a row in memory
    uint height;  // pixels
};

#ifdef __cplusplus
}  // namespace touchable
#endif

#endif
