#pragma once

/// Medians of 9 and 25 values from minima and maxima alone, without a branch, so that many are found at once.
/// The window comes as columns that are each sorted; neighbouring windows share those. T is a vector of
/// values side by side (an extension of GCC and Clang), or anything else with `lesser` and `greater`.
/// Everything is inlined, so that a caller compiled for wider vectors gets them here too.
namespace touchable {

template <class T>
[[gnu::always_inline]] inline T lesser(const T& a, const T& b) {
    return a < b ? a : b;
}
template <class T>
[[gnu::always_inline]] inline T greater(const T& a, const T& b) {
    return a < b ? b : a;
}

template <class T>
[[gnu::always_inline]] inline void order(T& a, T& b) {
    const T low = lesser(a, b);
    b = greater(a, b);
    a = low;
}

template <class T>
[[gnu::always_inline]] inline T middle_of(const T& a, const T& b, const T& c) {
    return greater(lesser(a, b), lesser(greater(a, b), c));
}

template <class T>
[[gnu::always_inline]] inline void sort_column(T (&v)[3]) {
    order(v[0], v[1]);
    order(v[1], v[2]);
    order(v[0], v[1]);
}

template <class T>
[[gnu::always_inline]] inline void sort_column(T (&v)[5]) {
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

/// ranks[k] holds the k-th least of each column. Sorted along the rows too, a window's entries grow to the
/// right and downward; all but the rising diagonals in the middle have too many entries above or below them
/// to be the median. Of 3x3 that leaves one diagonal.
template <class T>
[[gnu::always_inline]] inline T median_of_sorted_columns(T (&ranks)[3][3]) {
    const T low = greater(ranks[0][0], greater(ranks[0][1], ranks[0][2]));
    const T high = lesser(ranks[2][0], lesser(ranks[2][1], ranks[2][2]));
    return middle_of(low, middle_of(ranks[1][0], ranks[1][1], ranks[1][2]), high);
}

/// Of 5x5 it leaves three diagonals: only the greatest of the upper one, the median of the middle one and the
/// least of the lower one can be the median of all, and it is the middle of these three.
template <class T>
[[gnu::always_inline]] inline T median_of_sorted_columns(T (&ranks)[5][5]) {
    for (auto& row : ranks) sort_column(row);
    const T low = greater(greater(ranks[0][3], ranks[1][2]), greater(ranks[2][1], ranks[3][0]));
    const T high = lesser(lesser(ranks[1][4], ranks[2][3]), lesser(ranks[3][2], ranks[4][1]));
    T diagonal[5] = {ranks[0][4], ranks[1][3], ranks[2][2], ranks[3][1], ranks[4][0]};
    sort_column(diagonal);
    return middle_of(low, diagonal[2], high);
}

}  // namespace touchable
