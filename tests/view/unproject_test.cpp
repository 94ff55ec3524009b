#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "engine/content/seeded_noise.hpp"
#include "engine/gpu/surface_kernels.hpp"
#include "engine/gpu/vulkan_builder.hpp"
#include "player/draw/gpu_painting.hpp"
#include "tests/gpu/gpu_fixture.hpp"
#include "tests/view/coded_frames.hpp"
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

    /// q and tiles of the kernels against their twins.
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
        expect_close(field, prev, twin, made);
    }

    std::optional<GpuLattices> lattices;
};

TEST_F(Unproject, AgreesWithItsTwinForEveryCoding) {
    for (const DepthCodingKind kind : {DepthCodingKind::linear, DepthCodingKind::inverse,
                                       DepthCodingKind::metric, DepthCodingKind::hue, DepthCodingKind::log})
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

TEST_F(Unproject, AgreesOnTheGlobe) {
    const auto globe = shown_scene("globe", 360, 240);
    for (const double blend : {0.0, 0.37}) compare(globe->scene, globe->prev, globe->next, blend);
}

TEST_F(Unproject, AgreesOnWhatACameraStores) {
    const auto castel = shown_stand_in("castel_sr300");
    ASSERT_TRUE(castel);
    compare(castel->scene, castel->prev, castel->next, 0.6);
}

TEST_F(Unproject, AgreesOnARecording) {
    TOUCHABLE_NEEDS_DATA(real_data("castel_sr300"));
    const auto castel = shown_recording("castel_sr300", "castel_sr300");
    ASSERT_TRUE(castel);
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
    ASSERT_TRUE(make_lazy_builder(globe->scene)->build(globe->raw_prev, lazy));
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

TEST_F(Unproject, FramesLargerThanTheDeviceReadsAreItsFaultSoThatAnotherPainterMayDraw) {
    const auto globe = shown_scene("globe", 96, 64);
    SurfaceFrame frame;
    must(make_cpu_builder(globe->scene)->build(globe->raw_prev, frame));
    const FramePair still{{0, 0, &frame}, {0, 0, &frame}, 0};
    gpu->vulkan()->facts.limits.max_texel_buffer_elements = 96 / 8 * 64 - 1;
    const auto surface = lattices->surface_of(HeightField(globe->scene, still), still, {});
    ASSERT_FALSE(surface);
    EXPECT_EQ(surface.error().kind, ErrorKind::gpu);
    EXPECT_NE(surface.error().message.find("kernel unproject"), std::string::npos) << surface.error().message;
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
