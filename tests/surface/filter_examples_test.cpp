#include <gtest/gtest.h>

#include "engine/surface/surface_builder.hpp"
#include "tests/surface/pictures.hpp"

// Small pictures worked out by hand; in them 0 is an invalid pixel. Every builder must agree with the hand.
namespace touchable::test {
namespace {

using Codes = std::vector<std::uint16_t>;

void expect_filtered(int width, int height, const Codes& stored, FilterSettings filter,
                     const Codes& expected) {
    for (const int bytes : {1, 2}) {
        const Scene scene = depth_scene(width, height, 8 * bytes, Marking::zero, filter);
        const StoredPlane plane = store_plane(width, height, stored, {.bytes_per_sample = bytes});
        SurfaceFrame reference, cpu, lazy;
        ASSERT_TRUE(make_reference_builder(scene)->build(plane.frame(), reference));
        ASSERT_TRUE(make_cpu_builder(scene)->build(plane.frame(), cpu));
        ASSERT_TRUE(make_lazy_builder(scene)->build(plane.frame(), lazy));
        EXPECT_EQ(reference.codes, expected);
        EXPECT_EQ(cpu.codes, expected);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const std::uint16_t code = expected[reference.index(x, y)];
                EXPECT_EQ(reference.is_valid(x, y), code != 0) << x << ", " << y;
                EXPECT_EQ(cpu.is_valid(x, y), code != 0) << x << ", " << y;
                EXPECT_EQ(lazy.vertices->at(x, y).valid, code != 0) << x << ", " << y;
                if (code == 0) continue;
                EXPECT_EQ(lazy.vertices->at(x, y).depth, scene.depth.depth(code)) << x << ", " << y;
            }
    }
}

TEST(Median, OfAnEvenCountIsTheLowerOneAndAnInvalidCentreStaysInvalid) {
    // At (0, 0), for example: 10 10 20 / 10 10 20 / 40 40 -, sorted 10 10 10 10 20 20 40 40, element 7/2
    // is 10.
    expect_filtered(3, 3,
                    {10, 20, 30,  //
                     40, 0, 60,   //
                     70, 80, 90},
                    {.median = 3},
                    {10, 20, 30,  //
                     40, 0, 60,   //
                     70, 70, 80});
}

TEST(Median, ReplicatesTheBorderPixelsCodeAndValidity) {
    expect_filtered(5, 1, {9, 1, 8, 2, 7}, {.median = 5}, {9, 8, 7, 7, 7});
    expect_filtered(5, 1, {9, 1, 0, 2, 7}, {.median = 5}, {9, 2, 0, 2, 7});
    // At (1, 0): columns 0, 1 and 2, of which column 0 is an invalid border pixel three times over.
    expect_filtered(3, 1, {0, 4, 6}, {.median = 3}, {0, 4, 6});
}

TEST(Median, OfASinglePixelIsThatPixel) {
    expect_filtered(1, 1, {42}, {.median = 5}, {42});
    expect_filtered(1, 1, {0}, {.median = 5, .fill_holes = 16}, {0});
}

TEST(Median, RemovesASpikeAndKeepsAnEdge) {
    expect_filtered(5, 3,
                    {10, 10, 10, 50, 50,  //
                     10, 99, 10, 50, 50,  //
                     10, 10, 10, 50, 50},
                    {.median = 3},
                    {10, 10, 10, 50, 50,  //
                     10, 10, 10, 50, 50,  //
                     10, 10, 10, 50, 50});
}

// One rim at a time: a pixel is filled from what was valid before the pass, and neighbours beyond the edge do
// not count, so (1, 0) with two valid neighbours has to wait for (1, 1), whose neighbours 3 5 7 9 give 5.
TEST(HoleFilling, ReadsTheStateBeforeThePass) {
    const Codes stored = {5, 0, 0, 0,  //
                          9, 0, 0, 0,  //
                          7, 3, 0, 0};
    expect_filtered(4, 3, stored, {.fill_holes = 0}, stored);
    expect_filtered(4, 3, stored, {.fill_holes = 1},
                    {5, 0, 0, 0,  //
                     9, 5, 0, 0,  //
                     7, 3, 0, 0});
    expect_filtered(4, 3, stored, {.fill_holes = 2},
                    {5, 5, 0, 0,  //
                     9, 5, 0, 0,  //
                     7, 3, 0, 0});
    expect_filtered(4, 3, stored, {.fill_holes = 3},
                    {5, 5, 0, 0,  //
                     9, 5, 5, 0,  //
                     7, 3, 0, 0});
}

TEST(HoleFilling, ComesBeforeTheMedian) {
    // The centre becomes 2, from 1 1 2 2 2 2 9 9. Had the median come first, the upper row would be 1 1 1.
    expect_filtered(3, 3,
                    {1, 9, 1,  //
                     2, 0, 2,  //
                     2, 2, 9},
                    {.median = 3, .fill_holes = 1},
                    {2, 2, 2,  //
                     2, 2, 2,  //
                     2, 2, 2});
}

TEST(HoleFilling, LeavesAPixelWithTwoValidNeighboursAlone) {
    expect_filtered(3, 1, {4, 0, 6}, {.fill_holes = 16}, {4, 0, 6});
}

TEST(TileBounds, ShareTheVerticesBetweenTwoTiles) {
    // 18 columns: the first tile has the vertices 0 to 16, the second 16 and 17.
    Codes stored(36, 100);
    stored[16] = 200;     // (16, 0): in both
    stored[18 + 3] = 50;  // (3, 1): in the first
    stored[18 + 17] = 0;  // (17, 1): in the second
    const Scene scene = depth_scene(18, 2, 16, Marking::zero);
    const StoredPlane plane = store_plane(18, 2, stored, {});
    for (const auto& builder : {make_reference_builder(scene), make_cpu_builder(scene)}) {
        SurfaceFrame frame;
        ASSERT_TRUE(builder->build(plane.frame(), frame));
        const std::vector<TileBounds> expected = {{50, 200, false}, {100, 200, true}};
        EXPECT_EQ(frame.tiles, expected) << builder->name();
    }
}

TEST(TileBounds, OfNoValidPixelAreEmpty) {
    const Scene scene = depth_scene(3, 3, 16, Marking::zero);
    const StoredPlane plane = store_plane(3, 3, Codes(9, 0), {});
    for (const auto& builder : {make_reference_builder(scene), make_cpu_builder(scene)}) {
        SurfaceFrame frame;
        ASSERT_TRUE(builder->build(plane.frame(), frame));
        EXPECT_EQ(frame.tiles, (std::vector<TileBounds>{{65535, 0, true}})) << builder->name();
    }
}

TEST(Decode, KeepsValidCodesAndWritesZeroForInvalidOnes) {
    Scene scene =
        depth_scene(6, 1, 12, Marking::range_and_few);  // metric: 511 to 3840, but not 1365, 2047, 2048
    ASSERT_EQ(scene.depth.valid_min, 511);
    ASSERT_EQ(scene.depth.valid_max, 3840);
    const StoredPlane plane = store_plane(6, 1, {510, 511, 2047, 3840, 3841, 4096}, {});
    for (const auto& builder : {make_reference_builder(scene), make_cpu_builder(scene)}) {
        SurfaceFrame frame;
        ASSERT_TRUE(builder->build(plane.frame(), frame));
        EXPECT_EQ(frame.codes, (Codes{0, 511, 0, 3840, 0, 0})) << builder->name();
        EXPECT_EQ(frame.validity, (std::vector<std::uint32_t>{0b001010})) << builder->name();
    }
}

}  // namespace
}  // namespace touchable::test
