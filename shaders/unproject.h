// What the kernel unproject.comp and its caller agree on. Compiled as GLSL and as C++.
//
// Filtered codes of a pair of frames become q = 1 / planar depth at a moment between them, height taken off;
// 0 stands for an invalid pixel. Each lane makes UNPROJECT_PIXELS of them, in the order they lie in memory.
//
// A code's length grows with its distance m from the end of its scale where the length is least (1 / length
// for inverse codings), so base + step m adds what is never negative, and a depth is good to four roundings.
#ifndef TOUCHABLE_SHADERS_UNPROJECT_H
#define TOUCHABLE_SHADERS_UNPROJECT_H

#ifdef __cplusplus
namespace touchable {
using uint = unsigned int;
#endif

#define UNPROJECT_LANES 32
#define UNPROJECT_PIXELS 8

#define UNPROJECT_CODES 0          // of the earlier frame, 16 bits each, 8 to a uvec4
#define UNPROJECT_VALIDITY 1       // a bit each, rows in whole words
#define UNPROJECT_HEIGHTS 2        // as codes
#define UNPROJECT_NEXT_CODES 3     // of the later frame; the earlier one's again where there is none
#define UNPROJECT_NEXT_VALIDITY 4
#define UNPROJECT_NEXT_HEIGHTS 5
#define UNPROJECT_Q 6              // floats

/// Specialisation constants, in order, each 0 or 1: what a pair of frames does not need is left out.
struct UnprojectConstants {
    uint is_pair;      // two frames are mixed
    uint has_heights;  // of either frame
    uint is_ragged;    // the width is no multiple of UNPROJECT_PIXELS
    uint is_range;     // a length is along the pixel's ray, and not along -Z
};

struct UnprojectPush {
    uint width, pixels, validity_words;  // words of a row
    uint top_code;                       // m = top_code - code; 0: m = code
    float base, step;                    // length = base + step m, scene units
    uint is_inverse;                     // 1 / length instead
    float cx, cy, per_fx, per_fy;        // pixels, 1 / pixels
    float height_per_code, next_height_per_code;  // scene units; 0: no heights
    float blend, rest;                            // weights of the later and the earlier frame, in all 1
};

#ifdef __cplusplus
}  // namespace touchable
#endif

#endif
