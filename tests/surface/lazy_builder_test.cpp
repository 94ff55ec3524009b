#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "engine/content/seeded_noise.hpp"
#include "engine/surface/surface_builder.hpp"
#include "tests/frame/allocations.hpp"
#include "tests/surface/pictures.hpp"

namespace touchable::test {
namespace {

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
