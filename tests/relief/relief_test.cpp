// SPDX-License-Identifier: Apache-2.0
// A clip with relief: its other planes as they were, heights that are the same bits everywhere.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <vector>

#include "engine/authoring/recorded_clip.hpp"
#include "engine/authoring/relief_filter.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/clip/clip.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/must.hpp"
#include "tests/video/remuxed_clip.hpp"

namespace touchable::test {
namespace {

Result<std::unique_ptr<ClipReader>> looked_at_and_with_relief(std::unique_ptr<ClipReader> clip,
                                                              const ReliefSettings& settings,
                                                              double max_height) {
    auto looked = look_at_relief(std::move(clip), settings);
    if (!looked) return looked.error();
    return with_relief(std::move(looked->clip), settings, looked->range, max_height);
}

constexpr int columns = 48, rows = 36, count = 20;

class ReliefClip : public ::testing::Test {
protected:
    ReliefClip() {
        scene_.rate = {30000, 1001};
        must(write_clip(folder_ / "clip.mkv", scene_, count, planes_, {Archive::fast, false}));
    }
    std::unique_ptr<ClipReader> open(const ReliefSettings& settings = {}) const {
        return must(looked_at_and_with_relief(must(open_clip(folder_ / "clip.mkv")), settings, 2));
    }
    static std::uint64_t hash_of(const std::vector<RawFrame>& frames) {
        ByteHash hash;
        for (const RawFrame& frame : frames)
            for (int y = 0; y < rows; ++y) hash.add(frame.height.row(y), columns);
        return hash.value();
    }

    const Planes planes_{.colour = true, .haptic = true, .height = false, .noisy = false};
    Scene scene_ = small_scene(columns, rows, 12);
    TemporaryFolder folder_;
};

TEST_F(ReliefClip, AddsHeightsOnly) {
    auto plain = must(open_clip(folder_ / "clip.mkv"));
    const auto before = must(read_all(*plain));
    auto reader = open();
    const auto frames = must(read_all(*reader));
    ASSERT_EQ(frames.size(), before.size());
    for (std::size_t n = 0; n < frames.size(); ++n) {
        RawFrame without = frames[n];
        ASSERT_FALSE(without.height.empty());
        without.height = {};
        EXPECT_TRUE(same_frame(without, before[n])) << n;
    }
    EXPECT_EQ(reader->scene().height_coding.max_height, 2);
    EXPECT_EQ(reader->scene().height_coding.code_max, 255);
    EXPECT_EQ(reader->tracks().back().role, "height");
}

TEST_F(ReliefClip, IsSameWithoutColour) {
    auto reader = open();
    const auto once = must(read_all(*reader));
    must(reader->rewind());
    reader->leave_out_colour();
    EXPECT_EQ(hash_of(once), hash_of(must(read_all(*reader))));
}

TEST_F(ReliefClip, CopiesOtherTracksAsStored) {
    auto reader = open();
    SceneDescription described = reader->described();
    ClipStorage storage{Archive::fast, false};
    storage.copied =
        ClipStorage::Copied{folder_ / "clip.mkv", {PlaneRole::depth, PlaneRole::colour, PlaneRole::haptic}};
    auto writer = must(create_clip(folder_ / "relief.mkv", described, storage));
    const auto made = must(read_all(*reader));
    for (const RawFrame& frame : made) must(writer->write(frame));
    must(writer->finish());
    auto written = must(open_clip(folder_ / "relief.mkv"));
    EXPECT_EQ(written->frame_count(), count);
    const auto read = must(read_all(*written));
    for (std::size_t n = 0; n < made.size(); ++n) EXPECT_TRUE(same_frame(read[n], made[n])) << n;
    // Lossy colour would be another after it was encoded once more.
    auto kept = packets(folder_ / "relief.mkv"), before = packets(folder_ / "clip.mkv");
    for (const std::string& packet : before)
        EXPECT_NE(std::find(kept.begin(), kept.end(), packet), kept.end());
    // Any frame can be sought, as in any clip.
    for (const std::int64_t frame : {15, 7, 19}) {
        must(written->seek(frame));
        const auto there = must(written->next());
        EXPECT_TRUE(same_frame(*there, made[static_cast<std::size_t>(frame)])) << frame;
    }
}

TEST_F(ReliefClip, NeedsColour) {
    must(write_clip(folder_ / "grey.mkv", scene_, 2, {}));
    expect_error(looked_at_and_with_relief(must(open_clip(folder_ / "grey.mkv")), {}, 2), ErrorKind::input,
                 "has no colour");
}

TEST_F(ReliefClip, LeavesRoomBeforeCamera) {
    const auto relief = must(looked_at_and_with_relief(must(open_clip(folder_ / "clip.mkv")), {}, 50));
    EXPECT_NEAR(relief->scene().height_coding.max_height, 5, 0.1);  // the nearest depth is 10
}

/// Noise that is another in each frame, and an even colour.
TEST_F(ReliefClip, ReportsNoiseAndEvenness) {
    const auto note_of = [&](const std::string& name, const std::function<int(int, int, int)>& grey) {
        auto writer = must(create_clip(folder_ / name, small_scene(columns, rows), exact_clip));
        for (int n = 0; n < 5; ++n) {
            RawFrame frame = test_frame(small_scene(columns, rows), n, {.noisy = false});
            Image colour{columns, rows, 1, 3, {}};
            for (int y = 0; y < rows; ++y)
                for (int x = 0; x < columns; ++x)
                    colour.samples.insert(colour.samples.end(), 3, static_cast<std::uint8_t>(grey(n, x, y)));
            add_plane(frame, PlaneRole::colour, plane_from(std::move(colour)));
            must(writer->write(frame));
        }
        must(writer->finish());
        return must(looked_at_and_with_relief(must(open_clip(folder_ / name)), {}, 2))->notes().back();
    };
    Random numbers(3);
    const auto noise = [&] { return static_cast<int>(numbers.next() % 9); };
    const std::string noisy = note_of("noise.mkv", [&](int, int, int) { return 100 + noise(); });
    EXPECT_TRUE(has_words(noisy, "most of what is felt is noise"));
    const std::string clear =
        note_of("clear.mkv", [&](int, int x, int y) { return 100 + noise() + (x % 8 < 4 ? 60 : 0) + y; });
    EXPECT_TRUE(has_words(clear, "noise from frame to frame is"));
    EXPECT_EQ(clear.find("most of what is felt"), std::string::npos) << clear;
    const std::string even = note_of("even.mkv", [](int, int, int) { return 100; });
    EXPECT_TRUE(has_words(even, "nothing of it can be felt"));
}

/// By GCC and Clang, with and without optimisation.
TEST_F(ReliefClip, HasSameBitsEverywhere) {
    Scene scene = small_scene(columns, rows);
    auto writer = must(create_clip(folder_ / "exact.mkv", scene, exact_clip));
    for (int n = 0; n < 5; ++n) {
        // Noise over a slope, which surfaces of random depths would cut to single pixels.
        RawFrame frame = test_frame(scene, n, {.noisy = false});
        const RawFrame noise = test_frame(scene, n, {.colour = true});
        frame.colour = noise.colour;
        must(writer->write(frame));
    }
    must(writer->finish());
    auto relief = must(looked_at_and_with_relief(must(open_clip(folder_ / "exact.mkv")), {}, 2));
    const auto frames = must(read_all(*relief));
    const auto least = std::minmax_element(frames[2].height.row(20), frames[2].height.row(20) + columns);
    EXPECT_GT(*least.second - *least.first, 60);
    EXPECT_EQ(hash_of(frames), 15312345440906504892U);
}

// The Laplacian of Gaussian, against sums that are written out.

NumberField random_field(int width, int height, int largest, std::uint64_t seed) {
    Random numbers(seed);
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
    Random numbers(seed);
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

TEST(BoxFilter, AveragesWithinSurface) {
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

/// A point blurred by a Gaussian, less the same by a wider one, along the row through it.
double gaussian_difference(double distance, double narrow, double wide) {
    const auto bell = [&](double sigma) {
        return std::exp(-distance * distance / (2 * sigma * sigma)) / (2 * 3.141592653589793 * sigma * sigma);
    };
    return bell(narrow) - bell(wide);
}

TEST(DifferenceOfGaussians, MatchesPointResponse) {
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

TEST(DifferenceOfGaussians, IgnoresEvenSlopes) {
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
TEST(DifferenceOfGaussians, IgnoresWeightlessPixels) {
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

// The parts of a picture that become relief, and those that do not.

constexpr int width = 96, height = 64;

/// A grey picture over depths, both by column and row.
class ReliefFilterTest : public ::testing::Test {
protected:
    template <class Grey, class Code>
    const NumberField& relief(Grey&& grey, Code&& code, const ReliefSettings& settings = {}) {
        colour_.clear();
        depth_.clear();
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                for (int channel = 0; channel < 3; ++channel)
                    colour_.push_back(static_cast<std::uint8_t>(grey(x, y)));
                depth_.push_back(static_cast<std::uint8_t>(code(x, y)));
            }
        return relief_with(coding_, settings);
    }
    /// The relief of the same picture in another coding.
    const NumberField& relief_with(const DepthCoding& coding, const ReliefSettings& settings = {}) {
        RawFrame frame;
        frame.depth = {depth_.data(), width, width, height, 1, 1};
        frame.colour = {colour_.data(), 3 * width, width, height, 1, 3};
        filter_ = std::make_unique<ReliefFilter>(settings, coding);
        return filter_->apply(frame);
    }
    static void expect_level(const NumberField& relief) {
        for (const std::int32_t number : relief.numbers) EXPECT_EQ(number, 0);
    }
    static int even(int, int) { return 120; }
    static int spot(int x, int y) { return std::abs(x - 48) <= 2 && std::abs(y - 32) <= 2 ? 160 : 110; }

    const DepthCoding coding_ = small_scene(width, height).depth;
    std::vector<std::uint8_t> colour_, depth_;
    std::unique_ptr<ReliefFilter> filter_;
};

TEST_F(ReliefFilterTest, RaisesBrightSpots) {
    expect_level(relief(even, even));
    const NumberField& raised = relief(spot, even);
    EXPECT_GT(raised.row(32)[48], 16 * 20);
    EXPECT_LT(raised.row(32)[54], 0);
    ReliefSettings inverted;
    inverted.invert = true;
    const std::int32_t before = raised.row(32)[48];
    EXPECT_EQ(relief(spot, even, inverted).row(32)[48], -before);
}

TEST_F(ReliefFilterTest, AddsBandsByShares) {
    std::int32_t sum = 0;
    for (int band = 0; band < DifferenceOfGaussians::bands; ++band) {
        ReliefSettings one{{0, 0, 0}};
        one.bands[static_cast<std::size_t>(band)] = 100;
        sum += relief(spot, even, one).row(32)[48];
    }
    EXPECT_EQ(relief(spot, even, {{100, 100, 100}}).row(32)[48], sum);
    EXPECT_NEAR(relief(spot, even, {{200, 200, 200}}).row(32)[48], 2 * sum, 2);
}

TEST_F(ReliefFilterTest, IgnoresColourAtSurfaceEdges) {
    const auto half = [](int x, int) { return x < 48 ? 90 : 180; };
    const auto step = [](int x, int) { return x < 48 ? 128 : 60; };
    const NumberField& one_surface = relief(half, even);
    EXPECT_GT(one_surface.row(32)[48], 16 * 10);
    for (const std::int32_t number : relief(half, step).numbers) EXPECT_LE(std::abs(number), 1);
}

/// Grey of 128 stands for it; any other grey is a colour.
TEST_F(ReliefFilterTest, IgnoresUnseenGrey) {
    const auto half_seen = [](int x, int) { return x < 48 ? 128 : 90; };
    const auto half_grey = [](int x, int) { return x < 48 ? 127 : 90; };
    expect_level(relief(half_seen, even));
    EXPECT_GT(relief(half_grey, even).row(32)[47], 16 * 3);
}

TEST_F(ReliefFilterTest, IgnoresShadowsHighlightsAndHoles) {
    const auto in_the_dark = [](int x, int y) { return spot(x, y) == 160 ? 5 : 0; };
    const auto overexposed = [](int x, int y) { return spot(x, y) == 160 ? 255 : 253; };
    expect_level(relief(in_the_dark, even));
    expect_level(relief(overexposed, even));
    DepthCoding coding = coding_;
    coding.invalid_codes[0] = 0;
    coding.invalid_code_count = 1;
    const auto with_hole = [](int x, int y) { return x > 30 && x < 66 && y > 14 && y < 50 ? 0 : 128; };
    relief(spot, with_hole);
    EXPECT_EQ(relief_with(coding).row(32)[48], 0);
    EXPECT_EQ(filter_->confidence().row(32)[48], 0);
}

// Heights of a clip, frame after frame: steady where nothing moves, and quick where something does.

constexpr int pixels = 400;

/// About normal: a sum of four even ones, each of that width.
std::int32_t noise(Random& numbers, int deviation) {
    std::int32_t sum = 0;
    for (int k = 0; k < 4; ++k) sum += numbers.below(2 * deviation + 1) - deviation;
    return sum * 87 / 100;  // 4 (2d)^2/12 is 1.33 d^2
}

TEST(ReliefHeights, SpanTheirRange) {
    NumberField relief(3, 1);
    relief.numbers = {0, 500, -500};
    EXPECT_EQ(ReliefHeights({500, 0}, 100).next(relief), (std::vector<std::uint8_t>{128, 255, 1}));
    EXPECT_EQ(ReliefHeights({1000, 0}, 100).next(relief), (std::vector<std::uint8_t>{128, 192, 65}));
    EXPECT_EQ(ReliefHeights({1000, 0}, 400).next(relief), (std::vector<std::uint8_t>{128, 255, 0}));
    EXPECT_EQ(ReliefHeights({500, 0}, 0).next(relief), (std::vector<std::uint8_t>{128, 128, 128}));
}

/// A still point of a still camera flickers by a level at most.
TEST(ReliefHeights, FlickerLittleOnStillPoints) {
    constexpr int deviation = 16, full = 16 * 36;  // a level of brightness, as much detail as castel's
    Random numbers(5);
    NumberField truth(pixels, 1), seen = truth;
    for (auto& number : truth.numbers) number = numbers.below(2 * full + 1) - full;
    ReliefHeights heights({full, deviation}, 100);
    std::vector<std::uint8_t> least(pixels, 255), most(pixels, 0), plain_least = least, plain_most = most;
    ReliefHeights unsteady({full, 0}, 100);
    for (int frame = 0; frame < 90; ++frame) {
        for (std::size_t k = 0; k < pixels; ++k)
            seen.numbers[k] = truth.numbers[k] + noise(numbers, deviation);
        const auto steady = heights.next(seen), plain = unsteady.next(seen);
        if (frame < 30) continue;  // the first frame is noise too
        for (std::size_t k = 0; k < pixels; ++k) {
            least[k] = std::min(least[k], steady[k]);
            most[k] = std::max(most[k], steady[k]);
            plain_least[k] = std::min(plain_least[k], plain[k]);
            plain_most[k] = std::max(plain_most[k], plain[k]);
        }
    }
    int flicker = 0, plain_flicker = 0;
    double error = 0;
    for (std::size_t k = 0; k < pixels; ++k) {
        flicker += most[k] - least[k];
        plain_flicker += plain_most[k] - plain_least[k];
        error += std::abs((most[k] + least[k]) / 2.0 - (128 + 127.0 * truth.numbers[k] / full));
    }
    EXPECT_GT(plain_flicker, 10 * pixels);
    EXPECT_LE(flicker, 4 * pixels) << "mean range over 60 frames";
    EXPECT_LT(error / pixels, 1.5);
    // As the clip's note says it, of all frames.
    const auto told = heights.flicker();
    ASSERT_TRUE(told);
    EXPECT_LT(told->mean, 0.25);
    EXPECT_LT(told->more_than_one, 0.01);
}

TEST(ReliefHeights, NeedTwoFramesForFlicker) {
    ReliefHeights heights({16, 4}, 100);
    heights.next(NumberField(8, 1));
    EXPECT_FALSE(heights.flicker());
    heights.next(NumberField(8, 1));
    ASSERT_TRUE(heights.flicker());
    EXPECT_EQ(heights.flicker()->mean, 0);
}

TEST(ReliefHeights, FollowMotionAtOnce) {
    NumberField relief(1, 1);
    ReliefHeights heights({1000, 10}, 100);
    EXPECT_EQ(heights.next(relief)[0], 128);
    relief.numbers[0] = 500;
    EXPECT_EQ(heights.next(relief)[0], 192);
    relief.numbers[0] = 480;  // twice the noise
    EXPECT_GT(heights.next(relief)[0], 189);
    for (int frame = 0; frame < 30; ++frame) heights.next(relief);
    EXPECT_NEAR(heights.next(relief)[0], 189, 1);
    heights.forget();
    relief.numbers[0] = 470;
    EXPECT_EQ(heights.next(relief)[0], 188);
}

TEST(ReliefEstimator, TakesPercentilesOfAllFrames) {
    NumberField weights(pixels, 1), relief = weights;
    weights.numbers.assign(pixels, DifferenceOfGaussians::most_weight);
    Random numbers(9);
    ReliefEstimator estimator;
    EXPECT_EQ(estimator.range().full, 1);
    for (int frame = 0; frame < 40; ++frame) {
        for (std::size_t k = 0; k < pixels; ++k)
            relief.numbers[k] = static_cast<std::int32_t>(k) + noise(numbers, 8);
        weights.numbers[399] = 0;  // does not count
        relief.numbers[399] = 30000;
        estimator.add(relief, weights, frame > 0);
    }
    EXPECT_NEAR(estimator.range().full, 396, 8);
    EXPECT_NEAR(estimator.range().noise.value_or(-1), 8, 2);
}

}  // namespace
}  // namespace touchable::test
