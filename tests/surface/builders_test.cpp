#include <gtest/gtest.h>

#include "engine/content/seeded_noise.hpp"
#include "engine/surface/surface_builder.hpp"
#include "tests/frame/allocations.hpp"
#include "tests/surface/pictures.hpp"
#include "tests/surface/test_gpu.hpp"

namespace touchable::test {
namespace {

std::vector<std::unique_ptr<SurfaceBuilder>> all_builders(const Scene& scene) {
    std::vector<std::unique_ptr<SurfaceBuilder>> builders;
    builders.push_back(make_reference_builder(scene));
    builders.push_back(make_cpu_builder(scene));
    builders.push_back(make_lazy_builder(scene));
    builders.push_back(test_vulkan_builder(scene));
    return builders;
}

/// A frame with all planes of width x height.
struct FullFrame {
    std::vector<std::uint8_t> colour, haptic;
    std::vector<std::uint8_t> depth, height;
    RawFrame raw;

    FullFrame(int width, int rows) {
        const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(rows);
        colour.assign(3 * pixels, 1);
        haptic.resize(3 * pixels);
        for (std::size_t n = 0; n < haptic.size(); ++n) haptic[n] = static_cast<std::uint8_t>(7 * n);
        depth.assign(2 * pixels, 3);
        height.resize(pixels);
        for (std::size_t n = 0; n < pixels; ++n) height[n] = static_cast<std::uint8_t>(5 * n);
        raw.number = 12;
        raw.depth = {depth.data(), 2 * width, width, rows, 2, 1};
        raw.colour = {colour.data(), 3 * width, width, rows, 1, 3};
        raw.haptic = {haptic.data(), 3 * width, width, rows, 1, 3};
        raw.height = {height.data(), width, width, rows, 1, 1};
    }
};

TEST(Builders, CopyHapticAndHeightPlanesUnfiltered) {
    const Scene scene = depth_scene(19, 7, 16, Marking::zero, {5, 2});
    FullFrame full(19, 7);
    for (const auto& builder : all_builders(scene)) {
        SurfaceFrame frame;
        ASSERT_TRUE(builder->build(full.raw, frame)) << builder->name();
        EXPECT_EQ(frame.haptic, full.haptic) << builder->name();
        EXPECT_EQ(frame.heights, std::vector<std::uint16_t>(full.height.begin(), full.height.end()));
        full.raw.haptic = full.raw.height = {};
        ASSERT_TRUE(builder->build(full.raw, frame));
        EXPECT_TRUE(frame.haptic.empty() && frame.heights.empty()) << builder->name();
        full = FullFrame(19, 7);
    }
}

TEST(Builders, RefusePlanesThatAreNotTheScenes) {
    const Scene scene = depth_scene(19, 7, 16, Marking::zero);
    const auto expect_refused = [&](const char* what, auto&& spoil) {
        for (const auto& builder : all_builders(scene)) {
            FullFrame full(19, 7);
            SurfaceFrame frame;
            ASSERT_TRUE(builder->build(full.raw, frame));
            const FrameArray<std::uint16_t> codes = frame.codes;
            spoil(full.raw);
            const Result<void> refused = builder->build(full.raw, frame);
            ASSERT_FALSE(refused) << what << ", " << builder->name();
            EXPECT_EQ(refused.error().kind, ErrorKind::input);
            EXPECT_NE(refused.error().message.find("frame 12"), std::string::npos) << refused.error().message;
            EXPECT_NE(refused.error().message.find(what), std::string::npos) << refused.error().message;
            EXPECT_EQ(frame.codes, codes) << "the slot was touched";
            EXPECT_EQ(frame.width, 19);
        }
    };
    expect_refused("no depth plane", [](RawFrame& raw) { raw.depth = {}; });
    expect_refused("depth plane is 18x7, the scene says 19x7", [](RawFrame& raw) { raw.depth.width = 18; });
    expect_refused("depth plane is 19x8", [](RawFrame& raw) { raw.depth.height = 8; });
    expect_refused("depth plane has 3 channels", [](RawFrame& raw) { raw.depth.channels = 3; });
    expect_refused("depth plane has samples of 8 bits",
                   [](RawFrame& raw) { raw.depth.bytes_per_sample = 1; });
    expect_refused("depth plane has rows of 38 bytes", [](RawFrame& raw) { raw.depth.stride = 37; });
    expect_refused("colour plane is 19x6", [](RawFrame& raw) { raw.colour.height = 6; });
    expect_refused("haptic plane is 20x7", [](RawFrame& raw) { raw.haptic.width = 20; });
    expect_refused("haptic plane has 1 channels", [](RawFrame& raw) { raw.haptic.channels = 1; });
    expect_refused("haptic plane has samples of 16 bits",
                   [](RawFrame& raw) { raw.haptic.bytes_per_sample = 2; });
    expect_refused("height plane is 1x7", [](RawFrame& raw) { raw.height.width = 1; });
}

TEST(Builders, ReuseASlotOfAnyBuilderAndSize) {
    Random random(3);
    SurfaceFrame slot;
    std::string last;
    for (int round = 0; round < 60; ++round) {
        const Scene scene = depth_scene(1 + random.below(70), 1 + random.below(50), 16, Marking::zero,
                                        {random.below(2) * 3, random.below(3)});
        const StoredPlane plane = noisy_plane(scene, Fill::few_holes, random.next());
        SurfaceFrame reference;
        ASSERT_TRUE(make_reference_builder(scene)->build(plane.frame(), reference));
        const auto builder = std::move(all_builders(scene)[static_cast<std::size_t>(random.below(4))]);
        ASSERT_TRUE(builder->build(plane.frame(), slot));
        last = std::string(builder->name());
        EXPECT_EQ(first_vertex_difference(reference, *slot.vertices), "") << round << ": " << last;
        EXPECT_EQ(first_tile_not_enclosed(reference, *slot.vertices), "") << round << ": " << last;
        if (last != "lazy") {
            EXPECT_EQ(first_difference(reference, slot), "") << round << ": " << last;
            EXPECT_TRUE(slot.raw.depth.empty()) << "a filtered frame must not hold on to the raw one";
        } else {
            EXPECT_TRUE(slot.codes.empty() && slot.validity.empty() && slot.tiles.empty());
        }
    }
}

}  // namespace
}  // namespace touchable::test
