// SPDX-License-Identifier: Apache-2.0
// Decides where the mix of two frames' depths is drawn. Compiled as GLSL and as C++.
//
// If an edge has moved over a pixel, one frame has the foreground there, and the other the background.
// Half-way between them there is nothing: from the side, a mix would be a second silhouette in the air. A
// surface that has come nearer or gone away is drawn on its way. The distance tells both apart: two depths of
// a pixel are mixed if they differ by no more than
// - a hand's motion between the frames (`reach`: 2 m/s, for 1/24 s at most), or a sixteenth of the nearer
//   depth if that is more: neighbours of one surface may differ by as much (cut_rule.h);
// - and a quarter of the nearer depth: that limits a hand at 30 frames a second only closer than 0.27 m,
//   where hardly a camera sees, and models of a few centimetres have edges, too.
// Threads: any; nothing here keeps state.
#ifndef TOUCHABLE_SHADERS_BLEND_RULE_H
#define TOUCHABLE_SHADERS_BLEND_RULE_H

#ifdef __cplusplus
namespace touchable {
#define BLEND_RULE_FUNCTION constexpr
#else
#define BLEND_RULE_FUNCTION
#endif

#define BLEND_RULE_SPEED 2.0f              // m/s
#define BLEND_RULE_SECONDS (1.0f / 24.0f)  // slower clips get no larger reach
#define BLEND_RULE_LEAST 0.0625f           // of the nearer depth
#define BLEND_RULE_MOST 0.25f              // of the nearer depth, too

/// `reach` in the depths' unit.
BLEND_RULE_FUNCTION bool depths_mix(float one, float other, float reach) {
    const float nearer = one < other ? one : other, apart = one < other ? other - one : one - other;
    const float least = BLEND_RULE_LEAST * nearer, most = BLEND_RULE_MOST * nearer;
    const float wanted = reach < least ? least : reach;
    return apart <= (wanted < most ? wanted : most);
}

#ifdef __cplusplus
}  // namespace touchable
#endif
#undef BLEND_RULE_FUNCTION

#endif
