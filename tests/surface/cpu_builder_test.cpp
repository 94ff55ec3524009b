#include <gtest/gtest.h>

#include "engine/surface/surface_builder.hpp"
#include "tests/frame/allocations.hpp"
#include "tests/surface/pictures.hpp"

namespace touchable::test {
namespace {

StoredPlane plane_of(const Scene& scene, Fill fill, std::uint64_t seed, const Layout& layout = {}) {
    Random random(seed);
    return store_plane(scene.width, scene.height, fill_picture(scene, fill, random), layout);
}

TEST(CpuBuilder, GivesTheSameBitsWithAnyVectorsAndThreads) {
    for (const FilterSettings& filter :
         {FilterSettings{0, 0}, {0, 2}, {3, 0}, {3, 3}, {5, 0}, {5, 1}, {3, 1, TerraceRemoval::on}})
        for (const Fill fill : {Fill::random, Fill::few_holes, Fill::half_holes, Fill::single_invalid})
            for (const Marking marking : {Marking::zero, Marking::largest}) {
                const int bits = marking == Marking::zero ? 16 : 8;
                const Scene scene = depth_scene(139, 117, bits, marking, filter);
                const StoredPlane plane =
                    plane_of(scene, fill, 5, {.bytes_per_sample = bits / 8, .padding = 3});
                SurfaceFrame reference, slot;
                ASSERT_TRUE(make_reference_builder(scene)->build(plane.frame(), reference));
                for (const VectorUnit unit : usable_vector_units())
                    for (const int threads : {1, 2, 5}) {
                        const auto builder = make_cpu_builder(scene, {threads, unit});
                        for (int frame = 0; frame < 2; ++frame) {
                            ASSERT_TRUE(builder->build(plane.frame(), slot));
                            ASSERT_EQ(first_difference(reference, slot), "")
                                << threads << " threads, vectors " << static_cast<int>(unit) << ", median "
                                << filter.median << ", fill_holes " << filter.fill_holes << ", fill "
                                << static_cast<int>(fill) << ", " << bits << " bits";
                        }
                    }
            }
}

/// A line remembers whether the row before it in the same memory had holes.
TEST(CpuBuilder, ForgetsTheHolesOfTheFrameBefore) {
    const Scene scene = depth_scene(97, 61, 16, Marking::zero, {5, 0});
    const auto builder = make_cpu_builder(scene);
    SurfaceFrame slot;
    for (const Fill fill : {Fill::half_holes, Fill::all_greatest, Fill::invalid_border, Fill::ramp,
                            Fill::all_invalid, Fill::random}) {
        const StoredPlane plane = plane_of(scene, fill, 6);
        SurfaceFrame reference;
        ASSERT_TRUE(make_reference_builder(scene)->build(plane.frame(), reference));
        ASSERT_TRUE(builder->build(plane.frame(), slot));
        EXPECT_EQ(first_difference(reference, slot), "") << static_cast<int>(fill);
    }
}

/// What it remembers of a row another thread may have written.
TEST(CpuBuilder, RemembersTheFramesBeforeWithAnyVectorsAndThreads) {
    for (const TerraceRemoval terraces : {TerraceRemoval::off, TerraceRemoval::on}) {
        const Scene scene =
            depth_scene(139, 117, 8, Marking::zero,
                        {.median = 3, .terraces = terraces, .temporal = true, .temporal_noise = {1, 1e-5}});
        const auto reference = make_reference_builder(scene);
        std::vector<std::unique_ptr<SurfaceBuilder>> builders;
        for (const VectorUnit unit : usable_vector_units())
            for (const int threads : {1, 2, 5}) builders.push_back(make_cpu_builder(scene, {threads, unit}));
        SurfaceFrame expected, slot;
        for (int n = 0; n < 6; ++n) {
            const StoredPlane plane = plane_of(scene, n % 3 == 2 ? Fill::half_holes : Fill::few_values,
                                               static_cast<std::uint64_t>(n), {.bytes_per_sample = 1});
            RawFrame raw = plane.frame();
            raw.number = n;
            ASSERT_TRUE(reference->build(raw, expected));
            for (const auto& builder : builders) {
                ASSERT_TRUE(builder->build(raw, slot));
                ASSERT_EQ(first_difference(expected, slot), "") << n;
            }
        }
    }
}

TEST(CpuBuilder, AllocatesNothingForTheSecondFrame) {
    FilterSettings temporal{3, 0};
    temporal.temporal = true;
    for (const FilterSettings& filter :
         {FilterSettings{5, 2}, {3, 0}, {0, 0}, {0, 0, TerraceRemoval::on}, temporal})
        for (const int threads : {1, 3}) {
            const Scene scene = depth_scene(131, 167, 16, Marking::zero, filter);
            const StoredPlane first = plane_of(scene, Fill::few_holes, 1),
                              second = plane_of(scene, Fill::blob, 2);
            const auto builder = make_cpu_builder(scene, {threads});
            SurfaceFrame slot;
            const std::size_t before_first = allocations();
            ASSERT_TRUE(builder->build(first.frame(), slot));
            const std::size_t before = allocations();
            EXPECT_GT(before, before_first);  // or this counts nothing
            ASSERT_TRUE(builder->build(second.frame(), slot));
            EXPECT_EQ(allocations(), before) << threads << " threads, median " << filter.median;
        }
}

}  // namespace
}  // namespace touchable::test
