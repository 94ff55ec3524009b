#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "engine/content/random.hpp"
#include "engine/surface/vulkan_builder.hpp"
#include "player/view/gpu_lattice.hpp"
#include "tests/gpu/gpu_fixture.hpp"
#include "tests/view/shown.hpp"

namespace touchable::test {
namespace {

class Unproject : public GpuTest {
protected:
    void SetUp() override {
        GpuTest::SetUp();
        lattices.emplace(gpu);
    }
    void TearDown() override {
        lattices.reset();
        GpuTest::TearDown();
    }

    /// q of the kernel against its twin: the same pixels invalid, the others 1e-6 of the depth before height
    /// is taken off, plus what that is of the depth after it.
    void compare(const Scene& scene, const SurfaceFrame& prev, const SurfaceFrame& next, double blend) {
        FramePair pair;
        pair.prev = {0, 0, &prev};
        pair.next = {1, 1'000'000, &next};
        pair.blend = blend;
        const HeightField field(scene, pair);
        const ViewSurface surface = must(lattices->surface_of(field, pair, {}));
        const std::vector<float> twin = q_of(field), &made = surface.q;
        ASSERT_TRUE(surface.on_gpu);
        EXPECT_EQ(surface.tiles, classify_tiles(scene.width, scene.height, made));
        ASSERT_EQ(twin.size(), made.size());
        const double tallest = prev.heights.empty() ? 0 : largest_height(scene.height_coding, scene.depth);
        double worst = 0;
        for (std::size_t k = 0; k < twin.size(); ++k) {
            ASSERT_EQ(made[k] == 0.0F, twin[k] == 0.0F) << "pixel " << k;
            if (twin[k] == 0.0F) continue;
            const double q = static_cast<double>(twin[k]);
            const double bound = 1e-6 * (1 + 2 * tallest * q);
            worst = std::max(worst, std::fabs(static_cast<double>(made[k]) / q - 1) / bound);
        }
        EXPECT_LE(worst, 1.0);
    }

    std::optional<GpuLattices> lattices;
};

/// Two frames of every code there is, or nearly so, some pixels invalid.
struct Codes {
    Codes(const DepthCoding& coding, int width, int height, bool heights) {
        scene.width = width;
        scene.height = height;
        scene.camera = {0.9 * width, 1.1 * width, 0.4 * width, 0.7 * height};
        scene.depth = coding;
        derive_valid_range(scene.depth);
        scene.height_coding = {0.3 * coding.near, HeightUnits::world, 255};
        SplitMix64 random(3);
        for (SurfaceFrame* frame : {&prev, &next}) {
            frame->width = width;
            frame->height = height;
            frame->coding = scene.depth;
            frame->codes.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
            frame->validity.resize(static_cast<std::size_t>(frame->validity_words_per_row()) *
                                   static_cast<std::size_t>(height));
            frame->tiles.resize(static_cast<std::size_t>(TileGrid::of(width, height).tiles_x) *
                                static_cast<std::size_t>(TileGrid::of(width, height).tiles_y));
            if (heights) frame->heights.resize(frame->codes.size());
            for (int y = 0; y < height; ++y)
                for (int x = 0; x < width; ++x) set(*frame, x, y, random);
            frame->vertices = std::make_unique<FilteredVertices>(*frame);
        }
    }
    void set(SurfaceFrame& frame, int x, int y, SplitMix64& random) {
        const DepthCoding& coding = scene.depth;
        const auto code = static_cast<std::uint16_t>(random.within(coding.valid_min, coding.valid_max + 1.0));
        if (!frame.heights.empty())
            frame.heights[frame.index(x, y)] = static_cast<std::uint8_t>(random.next());
        if (!coding.is_valid(code) || random.unit() < 0.1) return;
        frame.codes[frame.index(x, y)] = code;
        frame.validity[static_cast<std::size_t>(y * frame.validity_words_per_row() + x / 32)] |= 1U
                                                                                                 << (x % 32);
    }
    Scene scene;
    SurfaceFrame prev, next;
};

DepthCoding coding_of(DepthCodingKind kind, DepthSemantics semantics, bool near_is_high) {
    DepthCoding coding;
    coding.kind = kind;
    coding.semantics = semantics;
    coding.near_is_high = near_is_high;
    coding.near = 0.3;
    coding.far = 70;
    coding.scale = 0.001;
    coding.code_max = kind == DepthCodingKind::hue ? 1535 : 65535;
    return coding;
}

TEST_F(Unproject, AgreesWithItsTwinForEveryCoding) {
    for (const DepthCodingKind kind :
         {DepthCodingKind::linear, DepthCodingKind::inverse, DepthCodingKind::metric, DepthCodingKind::hue})
        for (const DepthSemantics semantics : {DepthSemantics::range, DepthSemantics::planar})
            for (const bool near_is_high : {true, false})
                for (const bool heights : {false, true}) {
                    const Codes codes(coding_of(kind, semantics, near_is_high), 171, 93, heights);
                    for (const double blend : {0.0, 0.25, 0.5, 0.9})
                        compare(codes.scene, codes.prev, codes.next, blend);
                }
}

TEST_F(Unproject, AgreesForPicturesOfAnySize) {
    const DepthCoding coding = coding_of(DepthCodingKind::linear, DepthSemantics::range, true);
    for (const int width : {1, 2, 7, 8, 9, 31, 32, 33, 260})
        for (const int height : {1, 2, 5}) {
            const Codes codes(coding, width, height, false);
            compare(codes.scene, codes.prev, codes.next, 0.6);
        }
}

TEST_F(Unproject, AgreesOnTheGlobeAndOnARecording) {
    const auto globe = shown_scene("globe", 360, 240);
    for (const double blend : {0.0, 0.37}) compare(globe->scene, globe->prev, globe->next, blend);
    if (const auto castel = shown_recording("castel_sr300", "castel_sr300"))
        compare(castel->scene, castel->prev, castel->next, 0.6);
}

TEST_F(Unproject, HoldsTheEarlierFrameWhereTheSceneDoes) {
    Codes codes(coding_of(DepthCodingKind::linear, DepthSemantics::planar, true), 64, 20, false);
    codes.scene.interpolation = FrameInterpolation::hold;
    compare(codes.scene, codes.prev, codes.next, 0.9);
}

TEST_F(Unproject, AsksTheVerticesWhereThereAreNoCodes) {
    const auto globe = shown_scene("globe", 96, 64);
    SurfaceFrame lazy;
    ASSERT_TRUE(make_lazy_builder(globe->scene)->build(globe->raw_prev, lazy).ok());
    FramePair pair;
    pair.prev = pair.next = {0, 0, &lazy};
    const HeightField field(globe->scene, pair);
    const ViewSurface surface = must(lattices->surface_of(field, pair, {}));
    EXPECT_FALSE(surface.on_gpu);
    EXPECT_EQ(surface.q, q_of(globe->field()));
    EXPECT_EQ(surface.tiles, classify_tiles(96, 64, surface.q));
}

TEST_F(Unproject, ReadsFramesOfTheVulkanBuilderWhereTheyAre) {
    const auto globe = shown_scene("globe", 171, 93);
    for (const bool copies : {false, true}) {
        auto builder = must(make_vulkan_builder(globe->scene, std::make_shared<SurfaceKernels>(gpu),
                                                SurfacePlan{8, 0, false, copies}));
        SurfaceFrame prev, next;
        must(builder->build(globe->raw_prev, prev));
        must(builder->build(globe->raw_next, next));
        compare(globe->scene, prev, next, 0.4);
        if (!copies) continue;
        // What the CPU has read back of them is another matter.
        const FramePair pair{{0, 0, &prev}, {1, 1, &next}, 0.4};
        const HeightField field(globe->scene, pair);
        const std::vector<float> q = must(lattices->surface_of(field, pair, {})).q;
        prev.codes.assign(prev.codes.size(), 0);
        prev.validity.assign(prev.validity.size(), 0);
        EXPECT_EQ(must(lattices->surface_of(field, pair, {})).q, q);
    }
}

TEST_F(Unproject, UploadsFramesOfAnotherDevice) {
    const auto globe = shown_scene("globe", 70, 45);
    const auto other = must(GpuDevice::open());
    auto builder = must(make_vulkan_builder(globe->scene, other));
    SurfaceFrame prev, next;
    must(builder->build(globe->raw_prev, prev));
    must(builder->build(globe->raw_next, next));
    compare(globe->scene, prev, next, 0.4);
}

}  // namespace
}  // namespace touchable::test
