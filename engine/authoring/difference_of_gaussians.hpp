#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace touchable {

/// A picture of whole numbers, row by row.
struct NumberField {
    int width = 0, height = 0;
    std::vector<std::int32_t> numbers;

    NumberField() = default;
    NumberField(int columns, int rows)
        : width(columns),
          height(rows),
          numbers(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows)) {}
    std::int32_t* row(int y) {
        return numbers.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
    }
    const std::int32_t* row(int y) const {
        return numbers.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
    }
};

/// Where surfaces end: of each pixel the first and the last column, and the first and the last row, of the
/// run of pixels around it that belong together.
struct SurfaceRuns {
    struct Run {
        std::int16_t first, last;
    };
    SurfaceRuns() = default;
    /// All pixels belong together.
    SurfaceRuns(int width, int height);

    int width = 0, height = 0;
    std::vector<Run> across, down;
};

/// Sum over a square of `side` (odd) pixels around each, as far as they are of its surface, over that many
/// pixels; in place. Along rows first, then along columns, each rounded to the nearest, halves up. Numbers
/// are 0 to 2^24, sides at most 127.
class BoxFilter {
public:
    void apply(NumberField& field, int side, const SurfaceRuns& runs);

private:
    std::vector<std::uint32_t> row_sums_,
        column_sums_;  // of all before; they may wrap, their differences do not
};

/// Details of a picture by their size: what a Gaussian blur leaves less what a wider one leaves. This is the
/// Laplacian of Gaussian that the paper takes for roughness (section 3.1.2), at three widths. Pixels have
/// weights, and surfaces end: neither what counts for nothing nor another surface blurs into what is beside
/// it (normalised convolution).
class DifferenceOfGaussians {
public:
    static constexpr int bands = 3;
    /// Standard deviations of the blurs between which the bands lie, in pixels. A Gaussian is boxes, one
    /// after the other: sides of squares.
    static constexpr std::array<double, bands + 1> sigma{0.82, 1.83, 4.47, 10.39};

    static constexpr std::int32_t most_weight = 4096, most_value = 4096;

    /// `values` 0 to most_value, `weights` 0 to most_weight, all of one size.
    void split(const NumberField& values, const NumberField& weights, const SurfaceRuns& runs);
    /// Band k of the last picture, from fine to coarse: 0 where nothing near counts.
    const NumberField& band(int k) const { return bands_[static_cast<std::size_t>(k)]; }
    /// How much what is around each pixel counts, 0 to most_weight: weights after the second blur.
    const NumberField& confidence() const { return confidence_; }

private:
    void blur(std::size_t step, const SurfaceRuns& runs);

    BoxFilter box_;
    NumberField weighted_, weights_, mean_, wider_, confidence_;
    std::array<NumberField, bands> bands_;
};

}  // namespace touchable
