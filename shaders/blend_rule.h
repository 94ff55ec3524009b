// Where the eye is shown the mix of two frames' depths. Compiled as GLSL and as C++.
//
// Where an edge has travelled over a pixel, one frame has what is before it there, and the other what is
// behind it. Half-way between them there is nothing: seen from aside, a mix would be a second silhouette in
// the air. A surface that has come nearer or gone away is shown on its way. Both are told apart by how far.
// Two depths of a pixel are mixed where they differ by no more than
// - what a hand moves between the frames (`reach`: 2 m/s, for 1/24 s at most), or a sixteenth of the nearer
//   one where that is more: by so much neighbours of one surface may differ as well (cut_rule.h);
// - in no case more than a quarter of the nearer one: closer than 0.27 m, where hardly a camera sees, a hand
//   at 30 frames a second is slower than that, and models of a few centimetres have edges too.
#ifndef TOUCHABLE_SHADERS_BLEND_RULE_H
#define TOUCHABLE_SHADERS_BLEND_RULE_H

#ifdef __cplusplus
namespace touchable {
#define BLEND_RULE_FUNCTION constexpr
#else
#define BLEND_RULE_FUNCTION
#endif

#define BLEND_RULE_SPEED 2.0f              // m/s
#define BLEND_RULE_SECONDS (1.0f / 24.0f)  // slower clips show no more of a movement for that
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
