#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "engine/scene/filter_codes.hpp"
#include "engine/surface/surface_builder.hpp"
#include "tests/surface/pictures.hpp"
#include "tests/surface/test_gpu.hpp"

// The temporal filter, frame after frame. In what is worked out by hand codes have 16 bits, so that they stay
// as coarse as they are, and 0 is an invalid pixel.
namespace touchable::test {
namespace {

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
    /// Of a picture of one pixel.
    int shown(int code) { return show({static_cast<std::uint16_t>(code)}).codes[0]; }

private:
    Scene scene_;
    std::unique_ptr<SurfaceBuilder> reference_;
    std::vector<std::unique_ptr<SurfaceBuilder>> others_;
    std::vector<SurfaceFrame> frames_;
    SurfaceFrame frame_;
    std::int64_t number_ = -1;
};

TEST(TemporalFilter, ThreeQuartersOfNoiseAreKeptUpToTheGate) {
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
TEST(TemporalFilter, WhatMovesByTwiceTheGateIsNotHeldBack) {
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

TEST(TemporalFilter, EndsAtTheVeryCodeItIsShownFromBothSides) {
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
TEST(TemporalFilter, CodesOfEightBitsAreMadeFiner) {
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

TEST(TemporalFilter, ADropoutOfThreeFramesIsBridgedALongerOneIsNot) {
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

TEST(TemporalFilter, GoesOnOverFramesThatWereLeftOut) {
    Sequence sequence(scene_of(2, 1, 100)), without_gap(scene_of(2, 1, 100));
    for (const std::int64_t number : {4, 5, 9, 24}) {
        const auto value = static_cast<std::uint16_t>(1000 + number);
        EXPECT_EQ(sequence.show({value, 2000}, number).codes, without_gap.show({value, 2000}).codes)
            << number;
    }
}

TEST(TemporalFilter, BeginsAnewWithAFrameThatIsNotLater) {
    const Scene scene = scene_of(2, 1, 100);
    for (const std::int64_t number : {5, 4, 0, -1}) {
        Sequence sequence(scene);
        sequence.show({1000, 2000}, 4);
        EXPECT_EQ(sequence.show({1000, 0}, 5).codes, (Codes{1000, 2000}));
        EXPECT_EQ(sequence.show({1040, 0}, number).codes, (Codes{1040, 0})) << number;
        EXPECT_EQ(sequence.show({1080, 2000}).codes, (Codes{1050, 2000})) << number;
    }
}

TEST(TemporalFilter, TheGateIsThatOfTheDepthSeen) {
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

TEST(TemporalFilter, NeverLeavesTheCodesItComesFrom) {
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

class TemporalSameBits : public testing::TestWithParam<FilterSettings> {};

TEST_P(TemporalSameBits, OverFramesOfEveryKind) {
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
    , TemporalSameBits,
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

TEST(TemporalFilter, OfTheFallbackBuilderBeginsAnew) {
    const Scene scene = scene_of(1, 1, 100);
    class Failing final : public SurfaceBuilder {
    public:
        explicit Failing(const Scene& scene) : builder_(make_cpu_builder(scene)) {}
        std::string_view name() const override { return "failing"; }
        Result<void> build(const RawFrame& raw, SurfaceFrame& out) override {
            if (raw.number == 2) return Error{ErrorKind::gpu, "gone"};
            return builder_->build(raw, out);
        }

    private:
        std::unique_ptr<SurfaceBuilder> builder_;
    };
    const auto builder = make_fallback_builder(std::make_unique<Failing>(scene), make_cpu_builder(scene),
                                               [](const std::string&) {});
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
TEST(TemporalFilter, TheVulkanBuilderNeedsACodeToSpare) {
    Scene scene = depth_scene(4, 4, 16, Marking::none, {.temporal = true, .temporal_noise = {1, 0}});
    EXPECT_TRUE(make_vulkan_builder(scene, test_kernels(), all_plans[0])) << "all pixels are valid";
    scene.depth.invalid_codes[0] = 700;
    scene.depth.invalid_code_count = 1;
    const auto refused = make_vulkan_builder(scene, test_kernels(), all_plans[0]);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("cpu builder"), std::string::npos);
    scene.filter.temporal = false;
    EXPECT_TRUE(make_vulkan_builder(scene, test_kernels(), all_plans[0]));
}

TEST(TemporalFilter, TheLazyBuilderHasNoHistory) {
    const Scene scene = scene_of(1, 1, 100);
    SurfaceFrame frame;
    const StoredPlane plane = plane_of(scene, {7});
    const auto built = make_lazy_builder(scene)->build(plane.frame(), frame);
    ASSERT_FALSE(built);
    EXPECT_NE(built.error().message.find("filter.temporal"), std::string::npos);
}

}  // namespace
}  // namespace touchable::test
