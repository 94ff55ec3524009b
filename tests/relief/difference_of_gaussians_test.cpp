// The Laplacian of Gaussian, against sums that are written out.
#include "engine/authoring/relief_filter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

NumberField random_field(int width, int height, int largest, std::uint64_t seed) {
    Numbers numbers(seed);
    NumberField field(width, height);
    for (auto& number : field.numbers) number = numbers.below(largest + 1);
    return field;
}

/// One direction after the other, each rounded.
NumberField plain_box(const NumberField& field, int side, const SurfaceRuns& runs) {
    NumberField across(field.width, field.height), mean = across;
    const auto place = [&](int x, int y) { return static_cast<std::size_t>(y * field.width + x); };
    const auto rounded = [&](std::int64_t sum) { return static_cast<std::int32_t>((sum + side / 2) / side); };
    const auto is_of = [](const SurfaceRuns::Run& run, int k) { return run.first <= k && k <= run.last; };
    for (int y = 0; y < field.height; ++y)
        for (int x = 0; x < field.width; ++x) {
            std::int64_t sum = 0;
            for (int k = x - side / 2; k <= x + side / 2; ++k)
                if (is_of(runs.across[place(x, y)], k)) sum += field.row(y)[k];
            across.row(y)[x] = rounded(sum);
        }
    for (int y = 0; y < field.height; ++y)
        for (int x = 0; x < field.width; ++x) {
            std::int64_t sum = 0;
            for (int k = y - side / 2; k <= y + side / 2; ++k)
                if (is_of(runs.down[place(x, y)], k)) sum += across.row(k)[x];
            mean.row(y)[x] = rounded(sum);
        }
    return mean;
}

/// Runs that end at random.
SurfaceRuns random_runs(int width, int height, std::uint64_t seed) {
    Numbers numbers(seed);
    SurfaceRuns runs(width, height);
    const auto part = [&](std::vector<SurfaceRuns::Run>& all, int length, int step, std::size_t begin) {
        for (int first = 0, last = 0; first < length; first = last + 1) {
            last = std::min(length - 1, first + numbers.below(12));
            for (int k = first; k <= last; ++k)
                all[begin + static_cast<std::size_t>(k * step)] = {static_cast<std::int16_t>(first),
                                                                   static_cast<std::int16_t>(last)};
        }
    };
    for (int y = 0; y < height; ++y) part(runs.across, width, 1, static_cast<std::size_t>(y * width));
    for (int x = 0; x < width; ++x) part(runs.down, height, width, static_cast<std::size_t>(x));
    return runs;
}

TEST(BoxFilter, IsTheMeanOfASquareAsFarAsTheSurfaceGoes) {
    BoxFilter filter;
    for (const int largest : {1, 255, 1 << 24})
        for (const int side : {1, 3, 9, 23, 127})
            for (const auto& [width, height] : {std::pair{1, 1}, {5, 40}, {70, 3}, {33, 29}})
                for (const bool parted : {false, true}) {
                    const auto seed = static_cast<std::uint64_t>(side);
                    const SurfaceRuns runs =
                        parted ? random_runs(width, height, seed) : SurfaceRuns(width, height);
                    NumberField field = random_field(width, height, largest, seed);
                    const NumberField expected = plain_box(field, side, runs);
                    filter.apply(field, side, runs);
                    EXPECT_EQ(field.numbers, expected.numbers)
                        << side << " " << width << "x" << height << parted;
                }
    NumberField most(140, 140);
    most.numbers.assign(most.numbers.size(), 1 << 24);
    filter.apply(most, 127, SurfaceRuns(140, 140));
    EXPECT_EQ(most.row(70)[70], 1 << 24);
}

/// What a Gaussian of that width makes of a point, less what a wider one does, along the row through it.
double gaussian_difference(double distance, double narrow, double wide) {
    const auto bell = [&](double sigma) {
        return std::exp(-distance * distance / (2 * sigma * sigma)) / (2 * 3.141592653589793 * sigma * sigma);
    };
    return bell(narrow) - bell(wide);
}

TEST(DifferenceOfGaussians, IsThatOfAPoint) {
    constexpr int side = 129, middle = side / 2;
    NumberField values(side, side), weights(side, side);
    weights.numbers.assign(weights.numbers.size(), DifferenceOfGaussians::most_weight);
    values.row(middle)[middle] = DifferenceOfGaussians::most_value;
    DifferenceOfGaussians split;
    split.split(values, weights, SurfaceRuns(side, side));
    for (int k = 1; k < DifferenceOfGaussians::bands; ++k) {  // of the finest a pixel is no point
        const double narrow = DifferenceOfGaussians::sigma[static_cast<std::size_t>(k)],
                     wide = DifferenceOfGaussians::sigma[static_cast<std::size_t>(k) + 1];
        const double peak = gaussian_difference(0, narrow, wide);
        for (int x = 0; x < 3 * wide; ++x)
            EXPECT_NEAR(split.band(k).row(middle)[middle + x] / (4096 * peak),
                        gaussian_difference(x, narrow, wide) / peak, 0.2)
                << "band " << k << ", " << x << " pixels away";
    }
}

TEST(DifferenceOfGaussians, SeesNothingInWhatIsEvenOrALine) {
    constexpr int side = 96;
    NumberField values(side, side), weights(side, side);
    weights.numbers.assign(weights.numbers.size(), DifferenceOfGaussians::most_weight);
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) values.row(y)[x] = 1000 + 16 * x;
    DifferenceOfGaussians split;
    split.split(values, weights, SurfaceRuns(side, side));
    for (int k = 0; k < DifferenceOfGaussians::bands; ++k)
        for (int x = 36; x < side - 36; ++x)
            EXPECT_LE(std::abs(split.band(k).row(side / 2)[x]), 2) << k << " " << x;
}

/// Two halves, of which only one counts: the other might as well not be there.
TEST(DifferenceOfGaussians, DoesNotMixInWhatCountsForNothing) {
    NumberField left = random_field(80, 60, 4080, 7), other = left, weights(80, 60);
    for (int y = 0; y < 60; ++y)
        for (int x = 0; x < 80; ++x) {
            weights.row(y)[x] = x < 40 ? DifferenceOfGaussians::most_weight : 0;
            if (x >= 40) other.row(y)[x] = 4080 - other.row(y)[x];
        }
    DifferenceOfGaussians one, two;
    one.split(left, weights, SurfaceRuns(80, 60));
    two.split(other, weights, SurfaceRuns(80, 60));
    for (int k = 0; k < DifferenceOfGaussians::bands; ++k)
        EXPECT_EQ(one.band(k).numbers, two.band(k).numbers);
    EXPECT_EQ(one.confidence().row(30)[10], DifferenceOfGaussians::most_weight);
    EXPECT_EQ(one.confidence().row(30)[60], 0);
}

}  // namespace
}  // namespace touchable::test
