// SPDX-License-Identifier: Apache-2.0
// The hue of a colour as a whole number, for depth that is stored as hue. Compiled as GLSL and as C++.
//
// With M the greatest and m the least of the three bytes, and s their middle one, the position inside a
// sector is f = 256 (s - m) / (M - m), rounded to the nearest whole number, halves up: 0 to 256, and at least
// 1 where s > m. The code goes round the colour circle in six sectors of 256:
//
//   red -> yellow      R >= G >= B         f        green -> cyan      G >= B >= R   512 + f
//   yellow -> green    G >= R >= B   512 - f        cyan -> blue       B >= G >= R  1024 - f
//   blue -> magenta    B >= R >= G  1024 + f        magenta -> red     R >= B >  G  1536 - f
//
// Sectors agree where they meet, except at red, where the circle is closed: there the code is 0. So codes are
// 0 to 1535, and code / 1536 is the hue of HSV from 0 to 1 to within half a code. Neighbouring hues of full
// saturation are 1530 of those codes: finer steps would hold no more than 8 bits can express.
// Threads: any; nothing here keeps state.
#ifndef TOUCHABLE_SHADERS_HUE_CODE_H
#define TOUCHABLE_SHADERS_HUE_CODE_H

#ifdef __cplusplus
namespace touchable {
using uint = unsigned int;
#define HUE_CODE_FUNCTION constexpr
#else
#define HUE_CODE_FUNCTION
#endif

/// The code's largest value plus one: the whole circle.
#define HUE_CODE_CIRCLE 1536u

/// Bytes r, g, b (0 to 255). False for grey, which has no hue, and for colours too dark to tell one:
/// r + g + b < min_sum.
HUE_CODE_FUNCTION bool hue_is_valid(uint r, uint g, uint b, uint min_sum) {
    return r + g + b >= min_sum && !(r == g && g == b);
}

/// f of the text above, of sorted bytes; 0 for grey.
HUE_CODE_FUNCTION uint hue_sector_position(uint least, uint middle, uint greatest) {
    uint chroma = greatest - least;
    return chroma == 0u ? 0u : (512u * (middle - least) + chroma) / (2u * chroma);
}

/// The code of bytes r, g, b; 0 for grey.
HUE_CODE_FUNCTION uint hue_code(uint r, uint g, uint b) {
    if (r >= g && g >= b) return hue_sector_position(b, g, r);
    if (g >= r && r >= b) return 512u - hue_sector_position(b, r, g);
    if (g >= b && b >= r) return 512u + hue_sector_position(r, b, g);
    if (b >= g && g >= r) return 1024u - hue_sector_position(r, g, b);
    if (b >= r && r >= g) return 1024u + hue_sector_position(g, r, b);
    return 1536u - hue_sector_position(g, b, r);
}

#ifdef __cplusplus
}  // namespace touchable
#endif
#undef HUE_CODE_FUNCTION

#endif
