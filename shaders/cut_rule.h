// SPDX-License-Identifier: Apache-2.0
// Decides which triangles are not drawn. Compiled as GLSL and as C++: every painter cuts alike.
//
// q is 1 / planar depth of a corner, scene units; 0 stands for an invalid pixel, and a triangle with one is
// never drawn (but see gap_fill.h). A triangle between corners whose depths differ by more than 6 % is not a
// surface but the gap between two: in a turned view it would be a false curtain. In the clip's own view it
// covers only the space between two pixels. It is drawn there, or a dark line would run along every edge: the
// picture is the clip's own. A pixel is about 1/500 of its depth wide (480 to 1000 pixels to 60 degrees), so
// 6 % in one pixel is a slope of 30: surfaces seen at more than 88 degrees from their normal, which no depth
// camera measures.
// Threads: any; nothing here keeps state.
#ifndef TOUCHABLE_SHADERS_CUT_RULE_H
#define TOUCHABLE_SHADERS_CUT_RULE_H

#ifdef __cplusplus
namespace touchable {
#define CUT_RULE_FUNCTION constexpr
#else
#define CUT_RULE_FUNCTION
#endif

/// Depths of a triangle's corners differ by at most this factor.
#define CUT_RULE_RATIO 1.06f

CUT_RULE_FUNCTION bool triangle_has_hole(float q0, float q1, float q2) {
    return !(q0 > 0.0f && q1 > 0.0f && q2 > 0.0f);
}

/// For turned views; in the clip's own, triangle_has_hole decides.
CUT_RULE_FUNCTION bool triangle_is_cut(float q0, float q1, float q2) {
    float least = q0 < q1 ? q0 : q1, greatest = q0 < q1 ? q1 : q0;
    least = q2 < least ? q2 : least;
    greatest = q2 > greatest ? q2 : greatest;
    return !(least > 0.0f) || greatest > CUT_RULE_RATIO * least;
}

#ifdef __cplusplus
}  // namespace touchable
#endif
#undef CUT_RULE_FUNCTION

#endif
