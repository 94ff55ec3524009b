// The lower median of 25 codes, some of them invalid, from minima and maxima alone, without a branch; for GLSL.
// Invalid codes take part as in median3.h. Two neighbouring columns are merged once for the windows they share,
// and of two such pairs only the ranks that can be the median of 25 are looked for.
#ifndef TOUCHABLE_SHADERS_MEDIAN5_H
#define TOUCHABLE_SHADERS_MEDIAN5_H

/// Ascending.
struct Five {
    uint v[5];
};
struct Ten {
    uint v[10];
};

/// A column of five. `odd`: of its invalid codes, whose turn changes after it.
struct Ranked5 {
    Five least_first, greatest_first;
    bool odd;
};
/// Two columns merged.
struct Pair5 {
    Ten least_first, greatest_first;
    bool odd;
};
/// Ranks 7 to 12 of 0 to 19, of four columns.
struct Quad5 {
    uint v[6];
    bool odd;
};

void order(inout uint a, inout uint b) {
    const uint low = min(a, b);
    b = max(a, b);
    a = low;
}

void sort4(inout uint a, inout uint b, inout uint c, inout uint d) {
    order(a, b);
    order(c, d);
    order(a, c);
    order(b, d);
    order(b, c);
}

/// a <= b <= c <= d, and one more.
Five inserted5(uint a, uint b, uint c, uint d, uint more) {
    Five sorted;
    sorted.v[0] = min(a, more);
    more = max(a, more);
    sorted.v[1] = min(b, more);
    more = max(b, more);
    sorted.v[2] = min(c, more);
    more = max(c, more);
    sorted.v[3] = min(d, more);
    sorted.v[4] = max(d, more);
    return sorted;
}

Five chosen5(bool which, Five yes, Five no) {
    Five five;
    [[unroll]] for (int k = 0; k < 5; ++k) five.v[k] = which ? yes.v[k] : no.v[k];
    return five;
}

Ten chosen10(bool which, Ten yes, Ten no) {
    Ten ten;
    [[unroll]] for (int k = 0; k < 10; ++k) ten.v[k] = which ? yes.v[k] : no.v[k];
    return ten;
}

/// One more least, and the greatest left out.
Five shifted5(Five five) {
    return Five(uint[5](0u, five.v[0], five.v[1], five.v[2], five.v[3]));
}

Ranked5 balanced5(Five sorted, uint invalid) {
    Ranked5 ranked;
    ranked.odd = (invalid & 1u) != 0u;
    sorted = chosen5(invalid >= 2u, shifted5(sorted), sorted);
    ranked.greatest_first = chosen5(invalid >= 4u, shifted5(sorted), sorted);
    ranked.least_first = chosen5(ranked.odd, shifted5(ranked.greatest_first), ranked.greatest_first);
    return ranked;
}

/// Batcher's odd-even merge.
Ten merged10(Five a, Five b) {
    order(a.v[0], b.v[0]);
    order(a.v[4], b.v[4]);
    order(a.v[4], b.v[0]);
    order(a.v[2], b.v[2]);
    order(a.v[2], a.v[4]);
    order(b.v[2], b.v[0]);
    order(a.v[1], b.v[1]);
    order(a.v[3], b.v[3]);
    order(a.v[3], b.v[1]);
    order(a.v[1], a.v[2]);
    order(a.v[3], a.v[4]);
    order(b.v[1], b.v[2]);
    order(b.v[3], b.v[0]);
    return Ten(uint[10](a.v[0], a.v[1], a.v[2], a.v[3], a.v[4], b.v[1], b.v[2], b.v[3], b.v[0], b.v[4]));
}

Pair5 paired5(Ranked5 first, Ranked5 second) {
    Pair5 pair;
    pair.least_first = merged10(first.least_first,
                                chosen5(first.odd, second.greatest_first, second.least_first));
    pair.greatest_first = merged10(first.greatest_first,
                                   chosen5(first.odd, second.least_first, second.greatest_first));
    pair.odd = first.odd != second.odd;
    return pair;
}

/// The last step of an odd-even merge of ten and ten, where it matters: ranks 2 k + 1 and 2 k + 2 are the k-th
/// of the odd entries and the (k+1)-th of the even ones.
Quad5 joined5(Pair5 first, Pair5 second) {
    const Ten a = first.least_first;
    const Ten b = chosen10(first.odd, second.greatest_first, second.least_first);
    const Ten even = merged10(Five(uint[5](a.v[0], a.v[2], a.v[4], a.v[6], a.v[8])),
                              Five(uint[5](b.v[0], b.v[2], b.v[4], b.v[6], b.v[8])));
    const Ten odd = merged10(Five(uint[5](a.v[1], a.v[3], a.v[5], a.v[7], a.v[9])),
                             Five(uint[5](b.v[1], b.v[3], b.v[5], b.v[7], b.v[9])));
    Quad5 quad;
    [[unroll]] for (int k = 0; k < 3; ++k) {
        quad.v[2 * k] = min(odd.v[k + 3], even.v[k + 4]);
        quad.v[2 * k + 1] = max(odd.v[k + 3], even.v[k + 4]);
    }
    quad.odd = first.odd != second.odd;
    return quad;
}

/// Rank 12 of four columns and a fifth: of n codes of the four and 13 - n of the fifth, the greatest; least
/// over n.
uint median25(Quad5 quad, Ranked5 fifth) {
    const Five c = chosen5(quad.odd, fifth.greatest_first, fifth.least_first);
    uint median = quad.v[5];
    [[unroll]] for (int k = 0; k < 5; ++k) median = min(median, max(quad.v[k], c.v[4 - k]));
    return median;
}

#endif
