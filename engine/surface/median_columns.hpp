#pragma once

// `lesser` and `greater`, before the networks that use them.
#include "engine/base/vectors.hpp"
#include "shaders/median_network.h"

namespace touchable {

template <class Code>
[[gnu::always_inline]] inline void sort_column(Code (&column)[3]) {
    sort3(column);
}
template <class Code>
[[gnu::always_inline]] inline void sort_column(Code (&column)[5]) {
    sort5(column);
}

/// Of a window whose columns are sorted.
template <class Code>
[[gnu::always_inline]] inline Code median_of_columns(const Code (&columns)[3][3]) {
    Code pair[4];
    pair3(columns[0], columns[1], pair);
    return median9(pair, columns[2]);
}
template <class Code>
[[gnu::always_inline]] inline Code median_of_columns(const Code (&columns)[5][5]) {
    Code first[10], second[10], quad[6];
    pair5(columns[0], columns[1], first);
    pair5(columns[2], columns[3], second);
    quad5(first, second, quad);
    return median25(quad, columns[4]);
}

}  // namespace touchable
