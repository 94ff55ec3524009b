// The lower median of 9 codes, some of them invalid, from minima and maxima alone, without a branch; for GLSL.
//
// Invalid codes count as least and greatest in turn, so that the middle of all is the lower median of the valid
// ones (engine/surface/median.cpp). A column is sorted once, with its invalid codes above all others; both ways
// it can take part, with the first of them as the least or as the greatest, follow by shifting. A window starts
// with the least and goes on, column by column, with whatever is next in turn.
#ifndef TOUCHABLE_SHADERS_MEDIAN3_H
#define TOUCHABLE_SHADERS_MEDIAN3_H

/// A column of three, ascending. `odd`: of its invalid codes, whose turn changes after it.
struct Ranked3 {
    uvec3 least_first, greatest_first;
    bool odd;
};

/// What two neighbouring columns, the first in turn with the least, say of a window that has both.
struct Pair3 {
    uint low, middle_low, middle_high, high;
    bool odd;
};

/// v.y <= v.z; sorts the new v.x in.
uvec3 inserted3(uvec3 v) {
    const uint rest = max(v.x, v.y);
    return uvec3(min(v.x, v.y), min(rest, v.z), max(rest, v.z));
}

Ranked3 balanced3(uvec3 sorted, uint invalid) {
    Ranked3 ranked;
    ranked.odd = (invalid & 1u) != 0u;
    ranked.greatest_first = invalid >= 2u ? uvec3(0u, sorted.xy) : sorted;
    ranked.least_first = ranked.odd ? uvec3(0u, ranked.greatest_first.xy) : ranked.greatest_first;
    return ranked;
}

Pair3 paired3(Ranked3 first, Ranked3 second) {
    const uvec3 a = first.least_first, b = first.odd ? second.greatest_first : second.least_first;
    return Pair3(max(a.x, b.x), min(a.y, b.y), max(a.y, b.y), min(a.z, b.z), first.odd != second.odd);
}

uint middle_of(uint a, uint b, uint c) {
    return max(min(a, b), min(max(a, b), c));
}

uint median9(Pair3 pair, Ranked3 third) {
    const uvec3 c = pair.odd ? third.greatest_first : third.least_first;
    const uint middle = max(pair.middle_low, min(pair.middle_high, c.y));
    return middle_of(max(pair.low, c.x), middle, min(pair.high, c.z));
}

#endif
