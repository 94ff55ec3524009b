// SPDX-License-Identifier: Apache-2.0
// The lower median of 9 codes, some of them invalid, without a branch; for GLSL.
//
// Invalid codes count as least and greatest alternately, so that the middle of all is the lower median of the
// valid ones (engine/surface/median.cpp). A column is sorted once, with its invalid codes above all others;
// its two forms, with the first invalid code as the least or as the greatest, follow by shifting. A window
// starts with the least, and each column continues the alternation.
#ifndef TOUCHABLE_SHADERS_MEDIAN3_H
#define TOUCHABLE_SHADERS_MEDIAN3_H

#include "shaders/median_network.h"

/// A column of three, ascending. `odd`: an odd number of invalid codes, which switches the alternation.
struct Ranked3 {
    uint least_first[3], greatest_first[3];
    bool odd;
};
/// Two neighbouring columns, the first beginning with the least.
struct Pair3 {
    uint v[4];
    bool odd;
};

uint[3] chosen(bool which, uint yes[3], uint no[3]) {
    return uint[3](which ? yes[0] : no[0], which ? yes[1] : no[1], which ? yes[2] : no[2]);
}

/// Adds a least code and drops the greatest.
uint[3] shifted(uint v[3]) {
    return uint[3](0u, v[0], v[1]);
}

Ranked3 balanced3(uint sorted[3], uint invalid) {
    Ranked3 ranked;
    ranked.odd = (invalid & 1u) != 0u;
    ranked.greatest_first = chosen(invalid >= 2u, shifted(sorted), sorted);
    ranked.least_first = chosen(ranked.odd, shifted(ranked.greatest_first), ranked.greatest_first);
    return ranked;
}

Pair3 paired3(Ranked3 first, Ranked3 second) {
    Pair3 pair;
    pair3(first.least_first, chosen(first.odd, second.greatest_first, second.least_first), pair.v);
    pair.odd = first.odd != second.odd;
    return pair;
}

uint median_of(Pair3 pair, Ranked3 third) {
    return median9(pair.v, chosen(pair.odd, third.greatest_first, third.least_first));
}

#endif
