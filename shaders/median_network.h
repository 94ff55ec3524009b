// SPDX-License-Identifier: Apache-2.0
// Medians of 9 and 25 codes from minima and maxima alone, without a branch, for GLSL and for C++: both run
// the same text, which a test verifies. In C++ a Code is any type with `lesser` and `greater` declared before
// this is included, such as vectors of codes.
//
// A window is given as sorted columns, which neighbouring windows share, as they share merged pairs of
// columns: neighbouring pixels, x and x + 1, share the columns between x - 1 and x + 2.
// Threads: any; nothing here keeps state.
#ifndef TOUCHABLE_SHADERS_MEDIAN_NETWORK_H
#define TOUCHABLE_SHADERS_MEDIAN_NETWORK_H

#ifdef __cplusplus
namespace touchable {
// Inlined, so that a caller compiled for wider vectors gets them here too.
#define NETWORK template <class Code> [[gnu::always_inline]] inline
#define GIVEN(v, n) const Code (&v)[n]
#define CHANGED(v, n) Code (&v)[n]
#define ORDERED(v) Code& v
#define UNROLLED
#else
#define NETWORK
#define Code uint
#define GIVEN(v, n) const Code v[n]
#define CHANGED(v, n) inout Code v[n]
#define ORDERED(v) inout Code v
#define UNROLLED [[unroll]]
#define lesser min
#define greater max
#endif

NETWORK void order(ORDERED(a), ORDERED(b)) {
    const Code low = lesser(a, b);
    b = greater(a, b);
    a = low;
}

NETWORK Code middle_of(Code a, Code b, Code c) {
    return greater(lesser(a, b), lesser(greater(a, b), c));
}

NETWORK void sort4(ORDERED(a), ORDERED(b), ORDERED(c), ORDERED(d)) {
    order(a, b);
    order(c, d);
    order(a, c);
    order(b, d);
    order(b, c);
}

/// v[1] to v[n - 1] are sorted already.
NETWORK void insert3(CHANGED(v, 3)) {
    order(v[0], v[1]);
    order(v[1], v[2]);
}
NETWORK void insert5(CHANGED(v, 5)) {
    order(v[0], v[1]);
    order(v[1], v[2]);
    order(v[2], v[3]);
    order(v[3], v[4]);
}

NETWORK void sort3(CHANGED(v, 3)) {
    order(v[1], v[2]);
    insert3(v);
}
NETWORK void sort5(CHANGED(v, 5)) {
    order(v[0], v[1]);
    order(v[3], v[4]);
    order(v[2], v[4]);
    order(v[2], v[3]);
    order(v[0], v[3]);
    order(v[0], v[2]);
    order(v[1], v[4]);
    order(v[1], v[3]);
    order(v[1], v[2]);
}

/// Of a 3x3 window sorted along its columns, and then along its rows, only a diagonal can be the median: the
/// greatest of the columns' least, the middle one of their middle ones and the least of their greatest.
/// Computes these of two columns.
NETWORK void pair3(GIVEN(a, 3), GIVEN(b, 3), CHANGED(pair, 4)) {
    pair[0] = greater(a[0], b[0]);
    pair[1] = lesser(a[1], b[1]);
    pair[2] = greater(a[1], b[1]);
    pair[3] = lesser(a[2], b[2]);
}
/// The median with a third column.
NETWORK Code median9(GIVEN(pair, 4), GIVEN(c, 3)) {
    const Code middle = greater(pair[1], lesser(pair[2], c[1]));
    return middle_of(greater(pair[0], c[0]), middle, lesser(pair[3], c[2]));
}

/// Batcher's odd-even merge of two sorted columns.
NETWORK void pair5(GIVEN(first, 5), GIVEN(second, 5), CHANGED(pair, 10)) {
    Code a0 = first[0], a1 = first[1], a2 = first[2], a3 = first[3], a4 = first[4];
    Code b0 = second[0], b1 = second[1], b2 = second[2], b3 = second[3], b4 = second[4];
    order(a0, b0);
    order(a4, b4);
    order(a4, b0);
    order(a2, b2);
    order(a2, a4);
    order(b2, b0);
    order(a1, b1);
    order(a3, b3);
    order(a3, b1);
    order(a1, a2);
    order(a3, a4);
    order(b1, b2);
    order(b3, b0);
    pair[0] = a0;
    pair[1] = a1;
    pair[2] = a2;
    pair[3] = a3;
    pair[4] = a4;
    pair[5] = b1;
    pair[6] = b2;
    pair[7] = b3;
    pair[8] = b0;
    pair[9] = b4;
}

/// Ranks 7 to 12 of 0 to 19 of two pairs, four columns: those that can be the median of 25. By the last step of
/// their odd-even merge, ranks 2 k + 1 and 2 k + 2 are the k-th of the odd entries and the (k+1)-th of the even ones.
NETWORK void quad5(GIVEN(a, 10), GIVEN(b, 10), CHANGED(quad, 6)) {
    Code a_even[5], b_even[5], a_odd[5], b_odd[5], even[10], odd[10];
    UNROLLED for (int k = 0; k < 5; ++k) {
        a_even[k] = a[2 * k];
        b_even[k] = b[2 * k];
        a_odd[k] = a[2 * k + 1];
        b_odd[k] = b[2 * k + 1];
    }
    pair5(a_even, b_even, even);
    pair5(a_odd, b_odd, odd);
    UNROLLED for (int k = 0; k < 3; ++k) {
        quad[2 * k] = lesser(odd[k + 3], even[k + 4]);
        quad[2 * k + 1] = greater(odd[k + 3], even[k + 4]);
    }
}
/// Rank 12 of four columns and a fifth: least, over n, of the greatest of n codes of the four and 13 - n of
/// the fifth.
NETWORK Code median25(GIVEN(quad, 6), GIVEN(c, 5)) {
    Code median = quad[5];
    UNROLLED for (int k = 0; k < 5; ++k) median = lesser(median, greater(quad[k], c[4 - k]));
    return median;
}

#undef NETWORK
#undef GIVEN
#undef CHANGED
#undef ORDERED
#undef UNROLLED
#ifdef __cplusplus
}  // namespace touchable
#else
#undef Code
#undef lesser
#undef greater
#endif

#endif
