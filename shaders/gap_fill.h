// SPDX-License-Identifier: Apache-2.0
// Fills the gaps that a turned view uncovers, and the holes of the clip's own. Compiled as GLSL and as C++:
// every painter fills them alike.
//
// In the clip's own view a pixel's place does not depend on its depth, so where depth is missing colours are
// drawn all the same, behind all else (HOLE_Q).
//
// No camera saw what lies in a gap. A triangle that cut_rule.h leaves out, between vertices that are there,
// is drawn behind all else, in the mean colour of what is far around it: the background beside the gap goes
// on, softly. It is not felt and not measured. Views of values leave gaps empty, as there is no value.
// Threads: any; nothing here keeps state.
#ifndef TOUCHABLE_SHADERS_GAP_FILL_H
#define TOUCHABLE_SHADERS_GAP_FILL_H

#include "shaders/cut_rule.h"

#ifdef __cplusplus
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
namespace touchable {
using glm::ivec2;
using glm::vec3;
#define GAP_FUNCTION template <class Lattice>
#define GAP_OF(first) const Lattice &lattice, first
#define GAP_Q(at) gap_q(lattice, at)
#define GAP_COLOUR(at) gap_colour(lattice, at)
#else
#define GAP_FUNCTION
#define GAP_OF(first) first
#define GAP_Q(at) gap_q(at)
#define GAP_COLOUR(at) gap_colour(at)
#endif

/// Of a gap's z: behind any surface, which is nearer than 2^24 times the near plane.
#define GAP_Z 5.9604644775390625e-8f
#define HOLE_Q 1e-30f  // of a vertex without depth in the clip's own view
#define GAP_REACH 3  // vertices looked at to each side

#if defined(__cplusplus) || defined(GAP_LATTICE)
#ifndef __cplusplus
/// q of a vertex, 0 where there is no surface, negative where it is eroded (edge_rule.h); and its colour, RGB
/// of 0 to 255. (In C++ any lattice with these works.)
float gap_q(ivec2 at);
vec3 gap_colour(ivec2 at);
#endif

/// Whether a triangle with these corners is a gap to be filled.
GAP_FUNCTION bool is_gap(GAP_OF(ivec2 a), ivec2 b, ivec2 c) {
    const float q0 = GAP_Q(a), q1 = GAP_Q(b), q2 = GAP_Q(c);
    return q0 != 0.0f && q1 != 0.0f && q2 != 0.0f && triangle_is_cut(q0, q1, q2);
}

/// The colour in which a gap beside a vertex is filled. `size`: of the lattice.
GAP_FUNCTION vec3 gap_fill(GAP_OF(ivec2 at), ivec2 size) {
    float farthest = 0.0f;
    vec3 sum = vec3(0.0f, 0.0f, 0.0f);
    float count = 0.0f;
    for (int pass = 0; pass < 2; ++pass)
        for (int j = -GAP_REACH; j <= GAP_REACH; ++j)
            for (int i = -GAP_REACH; i <= GAP_REACH; ++i) {
                const ivec2 there = at + ivec2(i, j);
                if (there.x < 0 || there.y < 0 || there.x >= size.x || there.y >= size.y) continue;
                const float signed_q = GAP_Q(there), q = signed_q < 0.0f ? -signed_q : signed_q;
                if (!(q > 0.0f)) continue;
                if (pass == 0) {
                    farthest = farthest > 0.0f && farthest < q ? farthest : q;
                } else if (q <= CUT_RULE_RATIO * farthest) {
                    sum += GAP_COLOUR(there);
                    count += 1.0f;
                }
            }
    return sum / count;
}
#endif

#ifdef __cplusplus
}  // namespace touchable
#endif
#undef GAP_FUNCTION
#undef GAP_OF
#undef GAP_Q
#undef GAP_COLOUR

#endif
