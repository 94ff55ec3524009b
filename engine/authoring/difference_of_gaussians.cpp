#include "engine/authoring/difference_of_gaussians.hpp"

#include <algorithm>
#include <utility>

namespace touchable {
namespace {

/// Each blur goes on from the one before: variances, (side^2 - 1) / 12 of a box, add up.
constexpr std::array<std::array<int, 2>, DifferenceOfGaussians::bands + 1> box_sides{
    {{3, 1}, {5, 3}, {11, 9}, {23, 23}}};

/// A sum over `side` numbers of 24 bits, divided by `side` as a product: exact, since what rounding this
/// reciprocal up adds is less than sum / 2^38, and that less than 1 / side.
constexpr int reciprocal_bits = 38;
constexpr std::uint64_t reciprocal_of(int side) {
    return ((std::uint64_t{1} << reciprocal_bits) + static_cast<std::uint64_t>(side) - 1) /
           static_cast<std::uint64_t>(side);
}
inline std::int32_t rounded_share(std::uint32_t sum, std::uint32_t half, std::uint64_t reciprocal) {
    return static_cast<std::int32_t>(((sum + half) * reciprocal) >> reciprocal_bits);
}

}  // namespace

SurfaceRuns::SurfaceRuns(int columns, int rows) : width(columns), height(rows) {
    const auto pixels = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
    across.assign(pixels, {0, static_cast<std::int16_t>(columns - 1)});
    down.assign(pixels, {0, static_cast<std::int16_t>(rows - 1)});
}

void BoxFilter::apply(NumberField& field, int side, const SurfaceRuns& runs) {
    if (side == 1) return;
    const int reach = side / 2, width = field.width, height = field.height;
    const auto half = static_cast<std::uint32_t>(reach);
    const std::uint64_t reciprocal = reciprocal_of(side);
    const auto columns = static_cast<std::size_t>(width);
    row_sums_.resize(columns + 1);
    column_sums_.resize(columns * (static_cast<std::size_t>(height) + 1));
    std::fill_n(column_sums_.begin(), columns, 0U);
    for (int y = 0; y < height; ++y) {
        const std::int32_t* from = field.row(y);
        for (std::size_t x = 0; x < columns; ++x)
            row_sums_[x + 1] = row_sums_[x] + static_cast<std::uint32_t>(from[x]);
        const SurfaceRuns::Run* run = runs.across.data() + static_cast<std::size_t>(y) * columns;
        const std::uint32_t* above = column_sums_.data() + static_cast<std::size_t>(y) * columns;
        std::uint32_t* below = column_sums_.data() + (static_cast<std::size_t>(y) + 1) * columns;
        for (int x = 0; x < width; ++x) {
            const int first = std::max(x - reach, static_cast<int>(run[x].first)),
                      last = std::min(x + reach, static_cast<int>(run[x].last));
            const std::uint32_t sum =
                row_sums_[static_cast<std::size_t>(last) + 1] - row_sums_[static_cast<std::size_t>(first)];
            below[x] = above[x] + static_cast<std::uint32_t>(rounded_share(sum, half, reciprocal));
        }
    }
    for (int y = 0; y < height; ++y) {
        const SurfaceRuns::Run* run = runs.down.data() + static_cast<std::size_t>(y) * columns;
        std::int32_t* to = field.row(y);
        for (int x = 0; x < width; ++x) {
            const int first = std::max(y - reach, static_cast<int>(run[x].first)),
                      last = std::min(y + reach, static_cast<int>(run[x].last));
            const std::uint32_t sum =
                column_sums_[(static_cast<std::size_t>(last) + 1) * columns + static_cast<std::size_t>(x)] -
                column_sums_[static_cast<std::size_t>(first) * columns + static_cast<std::size_t>(x)];
            to[x] = rounded_share(sum, half, reciprocal);
        }
    }
}

void DifferenceOfGaussians::blur(std::size_t step, const SurfaceRuns& runs) {
    for (const int side : box_sides[step]) {
        box_.apply(weighted_, side, runs);
        box_.apply(weights_, side, runs);
    }
    if (wider_.width != weights_.width || wider_.height != weights_.height)
        wider_ = NumberField(weights_.width, weights_.height);
    // Of next to no weight the mean would be all rounding.
    constexpr std::int32_t least_weight = most_weight / 64;
    for (std::size_t k = 0; k < wider_.numbers.size(); ++k) {
        const std::int32_t weight = weights_.numbers[k];
        wider_.numbers[k] = weight < least_weight ? -1 : (weighted_.numbers[k] + weight / 2) / weight;
    }
}

void DifferenceOfGaussians::split(const NumberField& values, const NumberField& weights,
                                  const SurfaceRuns& runs) {
    weights_ = weights;
    weighted_ = values;
    for (std::size_t k = 0; k < weighted_.numbers.size(); ++k) weighted_.numbers[k] *= weights.numbers[k];
    blur(0, runs);
    std::swap(mean_, wider_);
    for (std::size_t step = 1; step < box_sides.size(); ++step) {
        blur(step, runs);
        if (step == 1) confidence_ = weights_;
        NumberField& band = bands_[step - 1];
        if (band.width != values.width || band.height != values.height)
            band = NumberField(values.width, values.height);
        for (std::size_t k = 0; k < band.numbers.size(); ++k) {
            const std::int32_t narrow = mean_.numbers[k], wide = wider_.numbers[k];
            band.numbers[k] = narrow < 0 || wide < 0 ? 0 : narrow - wide;
        }
        std::swap(mean_, wider_);
    }
}

}  // namespace touchable
