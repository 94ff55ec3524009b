#include <gtest/gtest.h>

#include <thread>

#include "engine/content/random.hpp"
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
            ASSERT_FALSE(refused.ok()) << what << ", " << builder->name();
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

TEST(LazyBuilder, AllocatesNothingForTheSecondFrameNorForAnyVertexOrTile) {
    const Scene scene = depth_scene(53, 38, 16, Marking::zero, {5, 16});
    const StoredPlane first = noisy_plane(scene, Fill::few_holes, 1),
                      second = noisy_plane(scene, Fill::blob, 2);
    const auto builder = make_lazy_builder(scene);
    SurfaceFrame slot;
    ASSERT_TRUE(builder->build(first.frame(), slot));
    const std::size_t before = allocations();
    ASSERT_TRUE(builder->build(second.frame(), slot));
    int valid = 0;
    for (int y = 0; y < scene.height; ++y)
        for (int x = 0; x < scene.width; ++x) valid += slot.vertices->at(x, y).valid;
    for (int ty = 0; ty < 3; ++ty)
        for (int tx = 0; tx < 4; ++tx) valid += slot.vertices->tile(tx, ty).nearest > 0;
    EXPECT_EQ(allocations(), before);
    EXPECT_GT(valid, 1000);
}

TEST(LazyBuilder, KeepsTheRawFrameAliveUntilTheSlotIsReused) {
    const Scene scene = depth_scene(20, 20, 16, Marking::zero, {3, 0});
    auto plane = std::make_shared<StoredPlane>(noisy_plane(scene, Fill::random, 8));
    SurfaceFrame reference, slot;
    RawFrame raw = plane->frame();
    raw.storage = plane;
    ASSERT_TRUE(make_reference_builder(scene)->build(raw, reference));
    ASSERT_TRUE(make_lazy_builder(scene)->build(raw, slot));
    const std::weak_ptr<StoredPlane> watched = plane;
    raw = {};
    plane.reset();
    ASSERT_FALSE(watched.expired());
    EXPECT_EQ(first_vertex_difference(reference, *slot.vertices), "");
    const StoredPlane other = noisy_plane(scene, Fill::random, 9);
    ASSERT_TRUE(make_cpu_builder(scene)->build(other.frame(), slot));
    EXPECT_TRUE(watched.expired());
}

TEST(LazyVertices, AnswerInAnyOrderAgainAndAgainAndOfTheNextFrame) {
    const Scene scene = depth_scene(150, 70, 16, Marking::zero, {5, 1});
    const auto reference_builder = make_reference_builder(scene), lazy_builder = make_lazy_builder(scene);
    SurfaceFrame reference, lazy;
    SplitMix64 random(12);
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
        const StoredPlane plane = noisy_plane(scene, Fill::few_holes, seed);
        ASSERT_TRUE(reference_builder->build(plane.frame(), reference));
        ASSERT_TRUE(lazy_builder->build(plane.frame(), lazy));
        for (int n = 0; n < 20000; ++n) {
            // Every second one within a few pixels, as under a finger.
            const int x = static_cast<int>(n % 2 == 0 ? random.within(60, 70) : random.within(0, 150));
            const int y = static_cast<int>(n % 2 == 0 ? random.within(30, 40) : random.within(0, 70));
            const DepthSample expected = reference.vertices->at(x, y), asked = lazy.vertices->at(x, y);
            ASSERT_TRUE(asked.valid == expected.valid && (!asked.valid || asked.depth == expected.depth))
                << x << ", " << y << " of frame " << seed;
        }
    }
}

void expect_right_answers_to_several_readers(const FilterSettings& filter) {
    const Scene scene = depth_scene(150, 70, 8, Marking::zero, filter);
    const StoredPlane plane = noisy_plane(scene, Fill::blob, 4);
    SurfaceFrame reference, lazy;
    ASSERT_TRUE(make_reference_builder(scene)->build(plane.frame(), reference));
    const auto builder = make_lazy_builder(scene);
    for (int round = 0; round < 10; ++round) {
        ASSERT_TRUE(builder->build(plane.frame(), lazy));
        std::string differences[3];
        std::vector<std::thread> readers;
        for (auto& difference : differences)
            readers.emplace_back([&] {
                difference = first_tile_not_enclosed(reference, *lazy.vertices) +
                             first_vertex_difference(reference, *lazy.vertices);
            });
        for (auto& reader : readers) reader.join();
        for (const auto& difference : differences) ASSERT_EQ(difference, "");
    }
}

TEST(LazyVertices, AnswerSeveralReadersAtOnce) {
    expect_right_answers_to_several_readers({3, 1});
}
TEST(LazyVertices, AnswerSeveralReadersOfBlocksWithoutTerracesAtOnce) {
    expect_right_answers_to_several_readers({3, 1, TerraceRemoval::on});
}

}  // namespace
}  // namespace touchable::test
