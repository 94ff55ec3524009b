// What view_resolve.frag and its caller agree on. Compiled as GLSL and as C++.
//
// Packed pixels (shaders/raster.h) become colours and z of images; where nothing is drawn, the background's
// colour and 0.
#ifndef TOUCHABLE_SHADERS_VIEW_RESOLVE_H
#define TOUCHABLE_SHADERS_VIEW_RESOLVE_H

#ifdef __cplusplus
namespace touchable {
using uint = unsigned int;
#endif

#define RESOLVE_PIXELS 0      // texels of RESOLVE_STEP
#define RESOLVE_BACKGROUND 1  // PackedColour of each row, texels of 4
#define RESOLVE_STEP 2        // pixels; rows are whole texels

struct ResolvePush {
    uint pitch;  // texels from one row of packed pixels to the next
};

#ifdef __cplusplus
}  // namespace touchable
#endif

#endif
