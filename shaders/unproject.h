// What the kernel unproject.comp and its caller agree on. Compiled as GLSL and as C++.
//
// Filtered codes of a pair of frames become q = 1 / planar depth at a moment between them, height taken off;
// 0 stands for an invalid pixel and for what lies beyond the width. A lane marches along a row, or a part of
// it, by words of validity: 32 pixels, 4 texels of codes, so that nothing is loaded twice and no row needs a
// special end. Rows of q are whole words too.
//
// A code's length grows with its distance m from the end of its scale where the length is least (1 / length
// for inverse codings), so base + step m adds what is never negative, and a depth is good to four roundings.
#ifndef TOUCHABLE_SHADERS_UNPROJECT_H
#define TOUCHABLE_SHADERS_UNPROJECT_H

#ifdef __cplusplus
namespace touchable {
using uint = unsigned int;
#endif

#define UNPROJECT_WORD 32  // pixels of a word of validity

#define UNPROJECT_CODES 0     // of the earlier frame: texels of 8 codes, rows in whole texels
#define UNPROJECT_VALIDITY 1  // a bit each, rows in whole words
#define UNPROJECT_HEIGHTS 2   // as codes
#define UNPROJECT_NEXT_CODES 3  // of the later frame; the earlier one's again where there is none
#define UNPROJECT_NEXT_VALIDITY 4
#define UNPROJECT_NEXT_HEIGHTS 5
#define UNPROJECT_Q 6  // floats, rows in whole words of UNPROJECT_WORD

/// Specialisation constants, in order. All but the first are 0 or 1: what is not needed is left out.
struct UnprojectConstants {
    uint group_size;   // lanes of a workgroup
    uint is_pair;      // two frames are mixed
    uint has_heights;  // of either frame
    uint is_range;     // a length is along the pixel's ray, and not along -Z
    uint is_inverse;   // base + step m is 1 / length
    uint is_from_top;  // m = code_max - code, and not the code itself
};

struct UnprojectPush {
    uint height;           // pixels
    uint pitch;            // texels of a row of codes
    uint words;            // of a row of validity
    uint segments;         // parts of a row, for a lane each
    uint segment_words;    // words of a part
    uint code_max;
    float base, step;                             // scene units, or 1 / scene units
    float shift;                                  // scene units, of inverse codings
    float cx, cy, per_fx, per_fy;                 // pixels, 1 / pixels
    float height_per_code, next_height_per_code;  // scene units; 0: no heights
    float blend, rest;                            // weights of the later and the earlier frame, in all 1
};

#ifdef __cplusplus
}  // namespace touchable
#endif

#endif
