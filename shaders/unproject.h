// SPDX-License-Identifier: Apache-2.0
// Interface of the kernel unproject.comp and its caller. Compiled as GLSL and as C++.
//
// Converts filtered codes of a pair of frames to q = 1 / planar depth as drawn at a moment between them
// (blend_rule.h), less height; 0 stands for an invalid pixel and for those beyond the width. A lane has a word
// of validity: 32 pixels, 4 texels of codes, so that nothing is loaded twice and no row needs a special end.
// Rows of q are whole words, too.
//
// A code's length grows with its distance m from the scale's end of least length (1 / length for inverse
// codings), so base + step m never adds a negative number, and a depth has four roundings. A logarithmic
// code's length is base + from_shift (e^(step m) - 1), the step in two parts, with six roundings.
// Threads: any; nothing here keeps state.
#ifndef TOUCHABLE_SHADERS_UNPROJECT_H
#define TOUCHABLE_SHADERS_UNPROJECT_H

#ifdef __cplusplus
#include <bit>
#include <cmath>
namespace touchable {
using uint = unsigned int;
#define UNPROJECT_FUNCTION inline
#define UNPROJECT_FLOAT_OF std::bit_cast<float>
#define UNPROJECT_FLOOR std::floor
#else
#define UNPROJECT_FUNCTION
#define UNPROJECT_FLOAT_OF uintBitsToFloat
#define UNPROJECT_FLOOR floor
#endif

#define UNPROJECT_WORD 32  // pixels of a word of validity
#define UNPROJECT_LANES 64

#define UNPROJECT_CODES 0       // of the earlier frame: texels of 8 codes, rows in whole texels
#define UNPROJECT_VALIDITY 1    // a bit each, rows in whole words
#define UNPROJECT_HEIGHTS 2     // as codes
#define UNPROJECT_NEXT_CODES 3  // of the later frame; the earlier one's again if there is none
#define UNPROJECT_NEXT_VALIDITY 4
#define UNPROJECT_NEXT_HEIGHTS 5
#define UNPROJECT_Q 6  // floats, rows in whole words of UNPROJECT_WORD

/// Specialisation constants, in order, 0 or 1: what is not needed is left out.
struct UnprojectConstants {
    uint is_pair;      // two frames are mixed
    uint has_heights;  // of either frame
    uint is_range;     // a length is along the pixel's ray, and not along -Z
    uint is_inverse;   // base + step m is 1 / length
    uint is_from_top;  // m = code_max - code, and not the code itself
    uint is_log;       // base + from_shift (e^(step m + step_low m) - 1) is the length
};

struct UnprojectPush {
    uint height;  // pixels
    uint pitch;   // texels of a row of codes
    uint words;   // of a row of validity
    uint code_max;
    float base, step;                             // scene units, or 1 / scene units
    float shift;                                  // scene units, of inverse codings
    float cx, cy, per_fx, per_fy;                 // pixels, 1 / pixels
    float height_per_code, next_height_per_code;  // scene units; 0: no heights
    float blend, rest;                            // weights of the later and the earlier frame, in all 1
    float step_low, from_shift;  // log: the rest of the step; near plane + the coding's shift
    float reach;                 // scene units: of blend_rule.h
};

/// e^(t + low) - 1 for t from 0 to 87, |low| far less: exp would lose digits, and all of them near 0.
UNPROJECT_FUNCTION float grown(float t, float low) {
    const float powers = UNPROJECT_FLOOR(t * 1.44269504f + 0.5f);
    const float r = (t - powers * 0.693359375f) + (powers * 2.12194440e-4f + low);  // ln 2 in two parts
    const float upper = ((r / 5040.0f + 1.0f / 720.0f) * r + 1.0f / 120.0f) * r + 1.0f / 24.0f;
    const float series = (upper * r + 1.0f / 6.0f) * r + 0.5f;
    const float scale = UNPROJECT_FLOAT_OF(uint(int(powers) + 127) << 23);  // 2^powers
    return scale * (r + r * r * series) + (scale - 1.0f);
}

#ifdef __cplusplus
}  // namespace touchable
#endif
#undef UNPROJECT_FUNCTION
#undef UNPROJECT_FLOAT_OF
#undef UNPROJECT_FLOOR

#endif
