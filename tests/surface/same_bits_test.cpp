// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "engine/picture/image.hpp"
#include "engine/scene/filter_codes.hpp"
#include "engine/surface/surface_builder.hpp"
#include "tests/must.hpp"
#include "tests/real_data.hpp"
#include "tests/stand_ins.hpp"
#include "tests/surface/pictures.hpp"
#include "tests/surface/test_gpu.hpp"
#include "tests/sweep.hpp"
#include "tests/temporary_files.hpp"

// Every builder gives the bits of the obvious one, for any picture.
namespace touchable::test {
namespace {

constexpr int medians[] = {0, 3, 5};
constexpr int fill_passes[] = {0, 1, 2, 5};
constexpr int bit_depths[] = {8, 10, 12, 16};

/// Counts of what the cases of a test have met: a count of 0 means that nothing was proved about it.
struct Coverage {
    long pictures = 0, valid = 0, invalid = 0, non_zero = 0, zero_but_valid = 0;
    long filled = 0, smoothed = 0, tiles_with_holes = 0, tiles_without = 0, narrow_tiles = 0;
    long finer = 0;
};

struct Case {
    int width, height, bits;
    Marking marking;
    Fill fill;
    Layout layout;
    FilterSettings filter;
    std::uint64_t seed;
};

std::string text(const Case& c) {
    return std::to_string(c.width) + "x" + std::to_string(c.height) + ", " + std::to_string(c.bits) +
           " bits, marking " + std::to_string(static_cast<int>(c.marking)) + ", fill " +
           std::to_string(static_cast<int>(c.fill)) + ", padding " + std::to_string(c.layout.padding) +
           (c.layout.bottom_up ? " bottom up" : "") + ", median " + std::to_string(c.filter.median) +
           ", fill_holes " + std::to_string(c.filter.fill_holes) +
           (c.filter.terraces == TerraceRemoval::on ? ", terraces removed" : "") + ", seed " +
           std::to_string(c.seed);
}

class AllBuilders : public testing::Test {
protected:
    void compare(const Case& c) {
        SCOPED_TRACE(text(c));
        const Scene scene = depth_scene(c.width, c.height, c.bits, c.marking, c.filter);
        Random random(c.seed);
        const std::vector<std::uint16_t> stored = fill_picture(scene, c.fill, random);
        const StoredPlane plane = store_plane(c.width, c.height, stored, c.layout);
        SurfaceFrame reference;
        ASSERT_TRUE(make_reference_builder(scene)->build(plane.frame(), reference));
        ASSERT_EQ(builders_.difference(scene, plane.frame(), reference), "");
        count(scene, stored, reference);
    }

    void count(const Scene& scene, const std::vector<std::uint16_t>& stored, const SurfaceFrame& frame) {
        ++seen_.pictures;
        const auto terraces = terrace_filter(scene);
        const auto unchanged = [&](std::uint16_t code) {
            return terraces ? 2 * terraces->working.of(code) : int{code};
        };
        seen_.finer += terraces.has_value();
        for (int y = 0; y < frame.height; ++y)
            for (int x = 0; x < frame.width; ++x) {
                const std::uint16_t before = stored[frame.index(x, y)],
                                    after = frame.codes[frame.index(x, y)];
                const bool was_valid = scene.depth.is_valid(before), is_valid = frame.is_valid(x, y);
                ++(is_valid ? seen_.valid : seen_.invalid);
                seen_.non_zero += after != 0;
                seen_.zero_but_valid += is_valid && after == 0;
                seen_.filled += is_valid && !was_valid;
                seen_.smoothed += is_valid && was_valid && unchanged(before) != after;
            }
        const TileGrid grid = TileGrid::of(frame.width, frame.height);
        for (std::size_t n = 0; n < frame.tiles.size(); ++n) {
            ++(frame.tiles[n].any_invalid ? seen_.tiles_with_holes : seen_.tiles_without);
            const int tx = static_cast<int>(n) % grid.tiles_x, ty = static_cast<int>(n) / grid.tiles_x;
            const TileDepths exact = depths_of(frame.tiles[n], frame.coding),
                             lazy = builders_.lazy_vertices().tile(tx, ty);
            const bool same = exact.nearest == lazy.nearest && exact.farthest == lazy.farthest;
            const double within = frame.coding.far - frame.coding.near;
            seen_.narrow_tiles += exact.nearest < exact.farthest &&
                                  (terraces ? lazy.farthest - lazy.nearest < 0.9 * within : same);
        }
    }

    void expect_everything_met(const FilterSettings& filter) const {
        SCOPED_TRACE("median " + std::to_string(filter.median) + ", fill_holes " +
                     std::to_string(filter.fill_holes));
        EXPECT_GT(seen_.valid, seen_.pictures);
        EXPECT_GT(seen_.invalid, seen_.pictures);
        EXPECT_GT(seen_.non_zero, seen_.pictures);
        EXPECT_GT(seen_.zero_but_valid, 0);
        EXPECT_GT(seen_.tiles_with_holes, 0);
        EXPECT_GT(seen_.tiles_without, 0);
        EXPECT_GT(seen_.narrow_tiles, 0);  // a lazy tile that just answers "anything" would enclose too
        EXPECT_EQ(seen_.filled > 0, filter.fill_holes > 0);
        EXPECT_EQ(seen_.smoothed > 0, filter.median > 0 || filter.terraces == TerraceRemoval::on ||
                                          filter.flying_pixels != DepthLength{});
        EXPECT_EQ(seen_.finer > 0, filter.terraces == TerraceRemoval::on);
    }

    Coverage seen_;
    BuilderComparison builders_;
};

class FilteredBuilders : public AllBuilders, public testing::WithParamInterface<FilterSettings> {
protected:
    /// Whether the n-th case is for this filter. In a short run each filter takes a seventh of them, and
    /// all filters together take every one.
    bool is_taken(std::size_t n) const {
        const std::size_t step = sweep_step();
        return n % step == static_cast<std::size_t>(GetParam().median + GetParam().fill_holes) % step;
    }
};

TEST_P(FilteredBuilders, AgreeOnEveryPicture) {
    std::uint64_t seed = 1;
    for (const int bits : bit_depths)
        for (const Marking marking : all_markings)
            for (int fill = 0; fill < fill_count; ++fill, ++seed) {
                if (!is_taken(seed)) continue;
                const Layout layout{bits > 8 ? 2 : 1, static_cast<int>(seed % 5), seed % 6 == 0};
                compare({37, 19, bits, marking, static_cast<Fill>(fill), layout, GetParam(), seed});
                if (HasFatalFailure()) return;
            }
    expect_everything_met(GetParam());
}

TEST_P(FilteredBuilders, AgreeAtEverySize) {
    std::vector<std::pair<int, int>> sizes;
    for (int height = 1; height <= 10; ++height)
        for (int width = 1; width <= 10; ++width) sizes.emplace_back(width, height);
    for (const int height : {1, 2, 3, 5, 15, 16, 17, 18, 24})
        for (const int width : {15, 16, 17, 18, 31, 32, 33, 34, 35, 40, 65})
            sizes.emplace_back(width, height), sizes.emplace_back(height, width);
    Random random(2024);
    // Terraces are five kernels more.
    const int repeats = GetParam().terraces == TerraceRemoval::on || sweep_step() > 1 ? 1 : 3;
    for (std::size_t n = 0; n < sizes.size(); ++n)
        for (int repeat = 0; repeat < repeats && is_taken(n); ++repeat) {
            const auto [width, height] = sizes[n];
            const int bits = bit_depths[random.below(4)];
            const Layout layout{bits > 8 ? 2 : 1, random.below(8), random.below(4) == 0};
            compare({width, height, bits, all_markings[random.below(4)],
                     static_cast<Fill>(random.below(fill_count)), layout, GetParam(), random.next()});
            if (HasFatalFailure()) return;
        }
    expect_everything_met(GetParam());
}

TEST_P(FilteredBuilders, AgreeOnBigPictures) {
    std::uint64_t seed = 77;
    for (const auto& [width, height] : {std::pair{331, 97}, std::pair{97, 203}})
        for (const Fill fill : {Fill::few_holes, Fill::blob})
            for (const Marking marking : {Marking::zero, Marking::largest}) {
                const Layout layout{.padding = 6};
                compare({width, height, 16, marking, fill, layout, GetParam(), seed++});
                if (HasFatalFailure()) return;
            }
    EXPECT_EQ(seen_.pictures, 8);
    EXPECT_GT(seen_.invalid, 0);
    EXPECT_GT(seen_.valid, 100000);
}

std::vector<FilterSettings> all_filters() {
    std::vector<FilterSettings> filters;
    for (const int median : medians)
        for (const int passes : fill_passes) filters.push_back({median, passes});
    filters.push_back({0, 0, TerraceRemoval::on});
    filters.push_back({3, 1, TerraceRemoval::on, 0.5});
    filters.push_back({0, 2, TerraceRemoval::on, 4});
    filters.push_back({0, 0, TerraceRemoval::on, 0, {0, 4e-6}});
    filters.push_back({3, 3, TerraceRemoval::on, 0.25, {20, 1e-5}});
    filters.push_back({.flying_pixels = {0, 2e-6}});
    filters.push_back({.median = 3, .fill_holes = 2, .flying_pixels = {3, 1e-6}});
    filters.push_back({.median = 3, .terraces = TerraceRemoval::on, .flying_pixels = {0.5, 0}});
    return filters;
}

INSTANTIATE_TEST_SUITE_P(Filters, FilteredBuilders, testing::ValuesIn(all_filters()), [](const auto& test) {
    return "Median" + std::to_string(test.param.median) + "Fill" + std::to_string(test.param.fill_holes) +
           (test.param.terraces == TerraceRemoval::on ? "Terraces" : "") +
           (test.param.levels != DepthLength{} ? "Levels" : "") +
           (test.param.flying_pixels != DepthLength{} ? "Flying" : "");
});

TEST_F(AllBuilders, AgreeAfterMostFillPasses) {
    for (const int median : medians) {
        compare({64, 48, 16, Marking::zero, Fill::blob, {}, {median, 16}, 5});
        compare(
            {64, 48, 8, Marking::range_and_few, Fill::many_holes, {.bytes_per_sample = 1}, {median, 16}, 6});
        if (HasFatalFailure()) return;
    }
    EXPECT_GT(seen_.filled, 1000);
    EXPECT_GT(seen_.invalid, 0);  // the blob is larger than 16 passes reach
}

TEST_F(AllBuilders, AgreeWithNothingToFill) {
    for (int passes = 1; passes <= 7; ++passes)
        for (const Marking marking : {Marking::zero, Marking::range_and_few})
            for (const int bytes : {1, 2}) {
                const Layout layout{.bytes_per_sample = bytes};
                const auto seed = static_cast<std::uint64_t>(passes);
                compare({37, 41, 8, marking, Fill::few_holes, layout, {3, passes}, seed});
                if (HasFatalFailure()) return;
            }
    EXPECT_GT(seen_.filled, 0);
}

TEST_F(AllBuilders, AgreeOnWideSamples) {
    for (int fill = 0; fill < fill_count; ++fill)
        compare({33, 21, 8, Marking::zero, static_cast<Fill>(fill), {.bytes_per_sample = 2}, {5, 1}, 9});
    EXPECT_GT(seen_.smoothed, 0);
}

// Depth cameras and scanners as they are: the fast and the lazy builder against the reference.

struct RealFrame {
    const char* name;
    const char* file;
    int far_code;  // deeper codes become invalid
};

std::ostream& operator<<(std::ostream& out, const RealFrame& frame) {
    return out << frame.file;
}

/// Codes deeper than `far_code` become invalid.
void expect_the_same_bits_of_a_picture(const std::filesystem::path& file, int far_code) {
    const auto image = must(read_image(file));
    ASSERT_EQ(image.channels, 1);

    Scene scene = depth_scene(image.width, image.height, 8 * image.bytes_per_sample, Marking::none);
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.semantics = DepthSemantics::planar;
    scene.depth.scale = 1;
    scene.depth.near = 0;
    scene.depth.far = far_code;
    derive_valid_range(scene.depth);
    ASSERT_FALSE(scene.depth.is_valid(0));
    RawFrame raw;
    raw.depth = image.view();

    BuilderComparison builders;
    SurfaceFrame unfiltered, reference;
    ASSERT_TRUE(make_reference_builder(scene)->build(raw, unfiltered));
    for (const FilterSettings& filter : {FilterSettings{0, 0}, {3, 0}, {5, 2}}) {
        SCOPED_TRACE("median " + std::to_string(filter.median) + ", fill_holes " +
                     std::to_string(filter.fill_holes));
        scene.filter = filter;
        ASSERT_TRUE(make_reference_builder(scene)->build(raw, reference));
        ASSERT_EQ(builders.difference(scene, raw, reference, std::span(all_plans, 1)), "");
        EXPECT_EQ(reference.codes == unfiltered.codes, filter == FilterSettings{})
            << "did the filter do anything?";
        long valid = 0;
        for (int y = 0; y < reference.height; ++y)
            for (int x = 0; x < reference.width; ++x) valid += reference.is_valid(x, y);
        EXPECT_GT(valid, scene.width * scene.height / 10);
    }
}

class RealFrames : public testing::TestWithParam<RealFrame> {};

TEST_P(RealFrames, AgreeAcrossBuilders) {
    const std::filesystem::path file = real_data(GetParam().file);
    TOUCHABLE_NEEDS_DATA(file);
    expect_the_same_bits_of_a_picture(file, GetParam().far_code);
}

TEST(StandInFrames, AgreeAcrossBuilders) {
    const std::pair<const char*, int> frames[] = {{"castel_sr300/depth_0000.png", 20000},
                                                  {"visp_cube_realsense/depth_0000.png", 60000},
                                                  {"redwood5/depth_00000.png", 60000},
                                                  {"icl_nuim5/depth_1.png", 65535}};
    const TemporaryFolder folder;
    for (const auto& [file, far_code] : frames) {
        SCOPED_TRACE(file);
        const std::filesystem::path path = folder / file;
        StandIn what = stand_in(path.parent_path().filename());
        what.frames = 1;
        write_stand_in(path.parent_path(), what);
        expect_the_same_bits_of_a_picture(path, far_code);
        if (HasFailure()) return;
    }
}

INSTANTIATE_TEST_SUITE_P(Data, RealFrames,
                         testing::Values(RealFrame{"Castel", "castel_sr300/depth_0010.png", 20000},
                                         RealFrame{"Cube", "visp_cube_realsense/depth_0003.png", 60000},
                                         RealFrame{"Redwood", "stills/redwood5/depth_00002.png", 60000},
                                         RealFrame{"Icl", "stills/icl_nuim5/depth_1.png", 65535}),
                         [](const auto& test) { return test.param.name; });

// The temporal filter, frame after frame. In what is worked out by hand codes have 16 bits, so that they stay
// as coarse as they are, and 0 is an invalid pixel.

using Codes = std::vector<std::uint16_t>;

/// A gate of so many codes where there is no median.
Scene scene_of(int width, int height, double gate, int bits = 16) {
    Scene scene = depth_scene(width, height, bits, Marking::zero, {.temporal = true});
    const double code = (scene.depth.far - scene.depth.near) / scene.depth.code_max;
    scene.filter.temporal_noise = {gate * code / 2, 0};
    return scene;
}

StoredPlane plane_of(const Scene& scene, const Codes& codes) {
    return store_plane(scene.width, scene.height, codes,
                       {.bytes_per_sample = scene.depth_bits > 8 ? 2 : 1, .padding = 1});
}

/// Builders of every kind, side by side; they must agree on every frame.
class Sequence {
public:
    explicit Sequence(const Scene& scene) : scene_(scene), reference_(make_reference_builder(scene)) {
        others_.push_back(make_cpu_builder(scene));
        for (const VectorUnit unit : usable_vector_units())
            for (const int threads : {1, 3}) others_.push_back(make_cpu_builder(scene, {threads, unit}));
        for (const SurfacePlan& plan : all_plans) {
            auto vulkan = make_vulkan_builder(scene, test_kernels(), plan);
            EXPECT_TRUE(vulkan);
            if (vulkan) others_.push_back(std::move(*vulkan));
        }
        frames_ = std::vector<SurfaceFrame>(others_.size());
    }
    /// The frame after the last one, or of another number.
    const SurfaceFrame& show(const Codes& codes) { return show(codes, number_ + 1); }
    const SurfaceFrame& show(const Codes& codes, std::int64_t number) {
        number_ = number;
        const StoredPlane plane = plane_of(scene_, codes);
        RawFrame raw = plane.frame();
        raw.number = number;
        EXPECT_TRUE(reference_->build(raw, frame_));
        for (std::size_t k = 0; k < others_.size(); ++k) {
            EXPECT_TRUE(others_[k]->build(raw, frames_[k]));
            EXPECT_EQ(first_difference(frame_, frames_[k]), "") << "frame " << number << ", builder " << k;
            EXPECT_EQ(first_vertex_difference(frame_, *frames_[k].vertices), "");
        }
        return frame_;
    }
    /// The code shown for a picture of one pixel.
    int shown(int code) { return show({static_cast<std::uint16_t>(code)}).codes[0]; }

private:
    Scene scene_;
    std::unique_ptr<SurfaceBuilder> reference_;
    std::vector<std::unique_ptr<SurfaceBuilder>> others_;
    std::vector<SurfaceFrame> frames_;
    SurfaceFrame frame_;
    std::int64_t number_ = -1;
};

TEST(TemporalFilter, AveragesNoiseWithinGate) {
    const Scene scene = scene_of(1, 1, 100);
    ASSERT_EQ(temporal_filter(scene)->gate.at(1000), 100);
    for (const auto& [from, to] :
         {std::pair{1000, 1000 + 25}, std::pair{900, 1000 - 75}, std::pair{1100, 1000 + 75}}) {
        Sequence sequence(scene);
        EXPECT_EQ(sequence.shown(from), from) << "the first frame is as it is";
        EXPECT_EQ(sequence.shown(from == 1000 ? 1100 : 1000), from == 1000 ? 1025 : to);
    }
}

// Beyond the gate what is kept falls from 75 to 0; from twice the gate on there is no lag.
TEST(TemporalFilter, FollowsMotionBeyondTwiceGate) {
    const Scene scene = scene_of(1, 1, 100);
    for (const int distance : {101, 120, 160, 199, 200, 201, 5000}) {
        const int tent = std::max(200 - distance, 0);
        for (const int sign : {1, -1}) {
            Sequence sequence(scene);
            sequence.shown(10000);
            EXPECT_EQ(sequence.shown(10000 + sign * distance), 10000 + sign * (distance - tent * 3 / 4));
        }
    }
}

TEST(TemporalFilter, ConvergesFromBothSides) {
    for (const int start : {1, 2, 3, 4, 7, 50, 99}) {
        Sequence up(scene_of(1, 1, 100)), down(scene_of(1, 1, 100));
        up.shown(5000 - start);
        down.shown(5000 + start);
        int above = 0, below = 0;
        for (int n = 0; n < 20; ++n) {
            below = up.shown(5000);
            above = down.shown(5000);
            EXPECT_EQ(5000 - below, above - 5000) << "no side is favoured";
        }
        EXPECT_EQ(below, 5000) << start;
    }
}

// A level is 126 codes: noise of half a level is averaged below what 8 bits can say.
TEST(TemporalFilter, RefinesEightBitCodes) {
    Sequence sequence(scene_of(1, 1, 3, 8));
    sequence.shown(100);
    EXPECT_EQ(sequence.shown(101), 101 * 126 - 94);
    EXPECT_EQ(sequence.shown(100), 100 * 126 + 24);
    int sum = 0;
    for (int n = 0; n < 40; ++n) {
        const int code = sequence.shown(100 + n % 2);
        EXPECT_LT(std::abs(code - 100 * 126 - 63), 12 + 64 / (n + 1)) << n;
        sum += code;
    }
    EXPECT_NEAR(sum / 40.0, 100.5 * 126, 4);
}

TEST(TemporalFilter, BridgesThreeFrameDropouts) {
    Sequence sequence(scene_of(1, 1, 100));
    EXPECT_FALSE(sequence.show({0}).is_valid(0, 0));
    EXPECT_EQ(sequence.shown(1000), 1000);
    for (int n = 0; n < 3; ++n) EXPECT_EQ(sequence.shown(0), 1000) << n;
    EXPECT_EQ(sequence.shown(1040), 1010) << "what was held counts as the frame before";
    EXPECT_EQ(sequence.shown(0), 1010);
    EXPECT_EQ(sequence.shown(1010), 1010) << "and may be held as long again";
    for (int n = 0; n < 3; ++n) EXPECT_TRUE(sequence.show({0}).is_valid(0, 0)) << n;
    for (int n = 0; n < 5; ++n) {
        const SurfaceFrame& gone = sequence.show({0});
        EXPECT_FALSE(gone.is_valid(0, 0)) << n;
        EXPECT_EQ(gone.codes[0], 0) << n;
    }
    EXPECT_EQ(sequence.shown(1040), 1040) << "as if it were new";
}

TEST(TemporalFilter, SpansSkippedFrames) {
    Sequence sequence(scene_of(2, 1, 100)), without_gap(scene_of(2, 1, 100));
    for (const std::int64_t number : {4, 5, 9, 24}) {
        const auto value = static_cast<std::uint16_t>(1000 + number);
        EXPECT_EQ(sequence.show({value, 2000}, number).codes, without_gap.show({value, 2000}).codes)
            << number;
    }
}

TEST(TemporalFilter, RestartsAtEarlierFrame) {
    const Scene scene = scene_of(2, 1, 100);
    for (const std::int64_t number : {5, 4, 0, -1}) {
        Sequence sequence(scene);
        sequence.show({1000, 2000}, 4);
        EXPECT_EQ(sequence.show({1000, 0}, 5).codes, (Codes{1000, 2000}));
        EXPECT_EQ(sequence.show({1040, 0}, number).codes, (Codes{1040, 0})) << number;
        EXPECT_EQ(sequence.show({1080, 2000}).codes, (Codes{1050, 2000})) << number;
    }
}

TEST(TemporalFilter, ScalesGateWithDepth) {
    for (const bool near_is_high : {true, false}) {
        Scene scene = scene_of(2, 1, 0);
        scene.depth.near = 500;
        scene.depth.far = 4500;
        scene.depth.near_is_high = near_is_high;
        scene.filter.temporal_noise = {0, 1e-6};
        derive_valid_range(scene.depth);
        const CodeCurve gate = temporal_filter(scene)->gate;
        const int near = near_is_high ? 60000 : 5535, far = near_is_high ? 600 : 64935;
        const int near_gate = gate.at(static_cast<std::uint16_t>(near)),
                  far_gate = gate.at(static_cast<std::uint16_t>(far));
        EXPECT_LT(10 * near_gate, far_gate);
        const auto codes = [](int a, int b) {
            return Codes{static_cast<std::uint16_t>(a), static_cast<std::uint16_t>(b)};
        };
        Sequence sequence(scene);
        sequence.show(codes(near, far));
        const int moved = near + 2 * near_gate + 9;
        EXPECT_EQ(sequence.show(codes(moved, far + 200)).codes, codes(moved, far + 50));
    }
}

TEST(TemporalFilter, StaysBetweenItsInputs) {
    for (const double gate : {1.0, 40.0, 3000.0, 32000.0}) {
        Sequence sequence(scene_of(40, 9, gate));
        Random random(3);
        Codes before;
        for (int n = 0; n < 12; ++n) {
            Codes codes(40 * 9);
            for (auto& code : codes)
                code = static_cast<std::uint16_t>(1 + random.below(n % 3 == 0 ? 65535 : 90));
            const SurfaceFrame& frame = sequence.show(codes);
            const Codes after(frame.codes.begin(), frame.codes.end());
            for (std::size_t k = 0; n > 0 && k < codes.size(); ++k) {
                ASSERT_GE(after[k], std::min(codes[k], before[k]));
                ASSERT_LE(after[k], std::max(codes[k], before[k]));
            }
            before = after;
        }
    }
}

class TemporalBuilders : public testing::TestWithParam<FilterSettings> {};

TEST_P(TemporalBuilders, AgreeOnEveryFrame) {
    std::vector<std::pair<int, Marking>> kinds{{8, Marking::none}, {16, Marking::zero}};
    if (GetParam().median == 0) kinds.insert(kinds.end(), {{16, Marking::largest}, {16, Marking::none}});
    for (const auto& [bits, marking] : kinds) {
        FilterSettings filter = GetParam();
        if (bits == 16) filter.terraces = TerraceRemoval::off;
        const Scene scene = depth_scene(77, 37, bits, marking, filter);
        Sequence sequence(scene);
        Random random(static_cast<std::uint64_t>(bits));
        for (int n = 0; n < 11; ++n) {
            const Fill fill = n % 2 == 0 ? Fill::blob : static_cast<Fill>(random.below(fill_count));
            sequence.show(fill_picture(scene, fill, random), n + (n > 7 ? 21 : 0));
            if (HasFailure()) FAIL() << bits << " bits, marking " << static_cast<int>(marking) << ", " << n;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(
    , TemporalBuilders,
    testing::Values(
        FilterSettings{.temporal = true, .temporal_noise = {2, 0}},
        FilterSettings{.median = 3, .fill_holes = 1, .temporal = true, .temporal_noise = {0, 2e-4}},
        FilterSettings{.median = 5, .temporal = true, .temporal_noise = {40, 0.01}},
        FilterSettings{.terraces = TerraceRemoval::on, .temporal = true, .temporal_noise = {1, 1e-5}},
        FilterSettings{.median = 5,
                       .fill_holes = 2,
                       .terraces = TerraceRemoval::on,
                       .terrace_noise = 1,
                       .temporal = true,
                       .temporal_noise = {0, 1e-4}}));

TEST(TemporalFilter, RestartsAfterFallback) {
    const Scene scene = scene_of(1, 1, 100);
    const auto builder =
        make_fallback_builder(std::make_unique<FailingBuilder>(scene, 2, Error{ErrorKind::gpu, "gone"}),
                              make_cpu_builder(scene), [](const std::string&) {});
    SurfaceFrame frame;
    Codes shown;
    for (const int code : {1000, 1040, 1080, 1120}) {
        const StoredPlane plane = plane_of(scene, {static_cast<std::uint16_t>(code)});
        RawFrame raw = plane.frame();
        raw.number = static_cast<std::int64_t>(shown.size());
        ASSERT_TRUE(builder->build(raw, frame));
        shown.push_back(frame.codes[0]);
    }
    EXPECT_EQ(shown, (Codes{1000, 1010, 1080, 1090}));
}

// Codes in between mark what is invalid by a code that no pixel has.
TEST(TemporalFilter, NeedsSpareCodeOnVulkan) {
    Scene scene = depth_scene(4, 4, 16, Marking::none, {.temporal = true, .temporal_noise = {1, 0}});
    EXPECT_TRUE(make_vulkan_builder(scene, test_kernels(), all_plans[0])) << "all pixels are valid";
    scene.depth.invalid_codes[0] = 700;
    scene.depth.invalid_code_count = 1;
    expect_error(make_vulkan_builder(scene, test_kernels(), all_plans[0]), "cpu builder");
    scene.filter.temporal = false;
    EXPECT_TRUE(make_vulkan_builder(scene, test_kernels(), all_plans[0]));
}

TEST(TemporalFilter, IsRefusedByLazyBuilder) {
    const Scene scene = scene_of(1, 1, 100);
    SurfaceFrame frame;
    const StoredPlane plane = plane_of(scene, {7});
    expect_error(make_lazy_builder(scene)->build(plane.frame(), frame), "filter.temporal");
}

}  // namespace
}  // namespace touchable::test
