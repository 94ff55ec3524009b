// SPDX-License-Identifier: Apache-2.0
// The lower median of 25 codes, some of them invalid, without a branch; for GLSL. Invalid codes take part as in
// median3.h.
#ifndef TOUCHABLE_SHADERS_MEDIAN5_H
#define TOUCHABLE_SHADERS_MEDIAN5_H

#include "shaders/median_network.h"

/// A column of five, ascending. `odd`: an odd number of invalid codes, which switches the alternation.
struct Ranked5 {
    uint least_first[5], greatest_first[5];
    bool odd;
};
/// Two columns merged.
struct Pair5 {
    uint least_first[10], greatest_first[10];
    bool odd;
};
/// The codes of four columns that can be the median with a fifth.
struct Quad5 {
    uint v[6];
    bool odd;
};

uint[5] chosen(bool which, uint yes[5], uint no[5]) {
    uint v[5];
    [[unroll]] for (int k = 0; k < 5; ++k) v[k] = which ? yes[k] : no[k];
    return v;
}
uint[10] chosen(bool which, uint yes[10], uint no[10]) {
    uint v[10];
    [[unroll]] for (int k = 0; k < 10; ++k) v[k] = which ? yes[k] : no[k];
    return v;
}

/// Shifts a 0 in at the low end; the greatest code drops out.
uint[5] shifted(uint v[5]) {
    return uint[5](0u, v[0], v[1], v[2], v[3]);
}

Ranked5 balanced5(uint sorted[5], uint invalid) {
    Ranked5 ranked;
    ranked.odd = (invalid & 1u) != 0u;
    sorted = chosen(invalid >= 2u, shifted(sorted), sorted);
    ranked.greatest_first = chosen(invalid >= 4u, shifted(sorted), sorted);
    ranked.least_first = chosen(ranked.odd, shifted(ranked.greatest_first), ranked.greatest_first);
    return ranked;
}

Pair5 paired5(Ranked5 first, Ranked5 second) {
    Pair5 pair;
    pair5(first.least_first, chosen(first.odd, second.greatest_first, second.least_first), pair.least_first);
    pair5(first.greatest_first, chosen(first.odd, second.least_first, second.greatest_first), pair.greatest_first);
    pair.odd = first.odd != second.odd;
    return pair;
}

Quad5 joined5(Pair5 first, Pair5 second) {
    Quad5 quad;
    quad5(first.least_first, chosen(first.odd, second.greatest_first, second.least_first), quad.v);
    quad.odd = first.odd != second.odd;
    return quad;
}

uint median_of(Quad5 quad, Ranked5 fifth) {
    return median25(quad.v, chosen(quad.odd, fifth.greatest_first, fifth.least_first));
}

#endif
