// SPDX-License-Identifier: Apache-2.0
#pragma once

// Medians of windows by networks of `lesser` and `greater` (shaders/median_network.h), for single codes and
// for vectors of codes (engine/base/vectors.hpp).

#include <algorithm>
#include <vector>

#include "engine/base/vectors.hpp"
#include "engine/surface/code_rows.hpp"
#include "shaders/median_network.h"

namespace touchable {

/// Element (count - 1)/2 of the sorted codes; reorders them. count >= 1.
inline std::uint16_t lower_median(std::uint16_t* codes, int count) {
    std::uint16_t* middle = codes + (count - 1) / 2;
    std::nth_element(codes, middle, codes + count);
    return *middle;
}

template <class Code>
[[gnu::always_inline]] inline void sort_column(Code (&column)[3]) {
    sort3(column);
}
template <class Code>
[[gnu::always_inline]] inline void sort_column(Code (&column)[5]) {
    sort5(column);
}

/// Median of a window whose columns are sorted.
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

/// The lower median, in code order, of the valid codes in a window of 3x3 or 5x5 pixels; positions outside
/// the picture replicate the border pixel, and an invalid centre stays invalid.
class MedianFilter final : public BandSource {
public:
    /// `side`: 3 or 5.
    MedianFilter(std::unique_ptr<LineSource> lines, int side, VectorUnit unit)
        : lines_(std::move(lines)), side_(side), unit_(unit) {}
    void begin(const RawFrame& raw, RowBands& bands) override;
    void make(const RowBand& band, SurfaceFrame& out) override;

private:
    const std::unique_ptr<LineSource> lines_;
    const int side_;
    const VectorUnit unit_;
    std::vector<std::vector<CodeLine>> rings_;  // per thread: row y in [y % side]
};

}  // namespace touchable
