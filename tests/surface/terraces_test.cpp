#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "engine/scene/filter_codes.hpp"
#include "engine/surface/surface_builder.hpp"
#include "tests/surface/pictures.hpp"
#include "tests/surface/test_gpu.hpp"

// Terrace removal on pictures of 8 bits: a level is 126 codes, the gate 157, no code moves by more than 126,
// and in the end codes are doubled. In what is worked out by hand, 0 is an invalid pixel.
namespace touchable::test {
namespace {

using Codes = std::vector<std::uint16_t>;
constexpr FilterSettings removal{.terraces = TerraceRemoval::on};

/// By every builder, which must agree.
std::unique_ptr<const SurfaceFrame> levelled(const Scene& scene, const Codes& stored) {
    const StoredPlane plane =
        store_plane(scene.width, scene.height, stored, {.bytes_per_sample = scene.depth_bits > 8 ? 2 : 1});
    auto made = std::make_unique<SurfaceFrame>();
    SurfaceFrame &reference = *made, cpu, lazy, vulkan;
    EXPECT_TRUE(make_reference_builder(scene)->build(plane.frame(), reference));
    EXPECT_TRUE(make_cpu_builder(scene)->build(plane.frame(), cpu));
    EXPECT_TRUE(make_lazy_builder(scene)->build(plane.frame(), lazy));
    EXPECT_EQ(first_difference(reference, cpu), "");
    EXPECT_EQ(first_vertex_difference(reference, *lazy.vertices), "");
    EXPECT_EQ(first_tile_not_enclosed(reference, *lazy.vertices), "");
    EXPECT_EQ(lazy.coding, reference.coding);
    for (const SurfacePlan& plan : all_plans) {
        auto builder = make_vulkan_builder(scene, test_kernels(), plan);
        EXPECT_TRUE(builder && (*builder)->build(plane.frame(), vulkan));
        EXPECT_EQ(first_difference(reference, vulkan), "") << plan_text(plan);
    }
    return made;
}

Scene scene_of(int width, int height) {
    return depth_scene(width, height, 8, Marking::zero, removal);
}

void expect_levelled(int width, int height, const Codes& stored, const Codes& expected) {
    EXPECT_EQ(levelled(scene_of(width, height), stored)->codes, expected);
}

Codes finer(Codes codes) {
    for (auto& code : codes) code = static_cast<std::uint16_t>(code * 252);
    return codes;
}

/// `level` of each pixel.
template <class Level>
Codes picture(int width, int height, Level&& level) {
    Codes codes;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) codes.push_back(static_cast<std::uint16_t>(level(x, y)));
    return codes;
}

TEST(Terraces, APlaneIsNotTouchedNotEvenAtTheBorder) {
    for (const auto& [a, b] : {std::pair{1, 2}, std::pair{0, 0}, std::pair{3, 0}, std::pair{-2, 4}}) {
        const Codes plane = picture(33, 29, [i = a, j = b](int x, int y) { return 100 + i * x + j * y; });
        expect_levelled(33, 29, plane, finer(plane));
    }
}

// Three pixels have pairs at distance 1 only, so two passes. The first: 10 + 11 levels - 2 x 10 = 126, within
// the gate: 2 x 126 + 8 over 16 is 16. The second: 1260 + 1386 - 2 x 1276 = 94: (2 x 94 + 4)/8 is 24, added
// to twice 1276.
TEST(Terraces, AStepOfOneLevelBecomesASlope) {
    expect_levelled(3, 1, {10, 10, 11}, {2520, 2 * 1276 + 24, 2772});
    expect_levelled(1, 3, {10, 10, 11}, {2520, 2 * 1276 + 24, 2772});
}

// 252 is between the gate and twice it: what counts is 2 x 157 - 252 = 62, and (124 + 8)/16 is 8 at the foot;
// at the head (-124 + 8)/16, downward: -8. Then 1260 + 1504 - 2 x 1268 = 228, of which 86 count: (172 + 4)/8
// is 22; at the head (-172 + 4)/8: -21.
TEST(Terraces, OfAStepOfTwoLevelsLittleIsTaken) {
    expect_levelled(4, 1, {10, 10, 12, 12}, {2520, 2 * 1268 + 22, 2 * 1504 - 21, 3024});
}

TEST(Terraces, AStepOfThreeLevelsStays) {
    const Codes step = picture(40, 36, [](int x, int) { return x < 17 ? 10 : 13; });
    expect_levelled(40, 36, step, finer(step));
}

// Around the centre each pair has 2 x 11 - 2 x 10 levels = 252, of which 62 count, with weights 2 + 2 + 1 +
// 1: 380/16 is 23. Then 2 x 1386 - 2 x 1283 = 206, of which 108 count: 652/8 is 81. On the rim only pairs
// along it are inside, and those are flat.
TEST(Terraces, AllFourDirectionsCountTheDiagonalsHalf) {
    const Codes dent = {11, 11, 11,  //
                        11, 10, 11,  //
                        11, 11, 11};
    Codes expected = finer(dent);
    expected[4] = 2 * 1283 + 81;
    expect_levelled(3, 3, dent, expected);
}

// One diagonal alone: 10 + 11 - 2 x 10 levels, weight 1: (126 + 8)/16 is 8; then 1260 + 1386 - 2 x 1268 =
// 110: 14.
TEST(Terraces, EachDiagonalCounts) {
    for (const bool rising : {false, true}) {
        Codes codes(9, 0);
        codes[4] = 10;
        codes[rising ? 2 : 0] = 10;
        codes[rising ? 6 : 8] = 11;
        Codes expected = finer(codes);
        expected[4] = 2 * 1268 + 14;
        expect_levelled(3, 3, codes, expected);
    }
}

TEST(Terraces, PairsWithAnInvalidPixelDoNotCount) {
    expect_levelled(3, 1, {0, 10, 11}, {0, 2520, 2772});
    expect_levelled(3, 1, {10, 0, 11}, {2520, 0, 2772});
    // At distance 2 the pair of the middle one is whole: 10 + 11 - 2 x 10 levels make 16 in its pass, the
    // last two find invalid neighbours.
    expect_levelled(5, 1, {10, 0, 10, 0, 11}, {2520, 0, 2 * 1276, 0, 2772});
}

TEST(Terraces, ASilhouetteDoesNotMoveAndNoBitOfItChanges) {
    const Codes slopes = picture(48, 40, [](int x, int y) { return x + y < 44 ? 60 + x : 200 - y; });
    expect_levelled(48, 40, slopes, finer(slopes));
}

TEST(Terraces, ASpikeStays) {
    Codes codes(25 * 25, 40);
    codes[25 * 12 + 12] = 44;
    expect_levelled(25, 25, codes, finer(codes));
}

/// Farthest of the inner pixels from the plane that was quantised, in levels, at most.
double farthest_from_plane(const SurfaceFrame& frame, double level, double a, double b) {
    double farthest = 0;
    for (int y = 24; y < frame.height - 24; ++y)
        for (int x = 24; x < frame.width - 24; ++x) {
            const double code = frame.codes[frame.index(x, y)] / level;
            farthest = std::max(farthest, std::fabs(code - (40 + a * x + b * y)));
        }
    return farthest;
}

TEST(Terraces, AQuantisedPlaneIsAPlaneAgain) {
    for (const auto& [a, b] : {std::pair{0.125, 0.0}, std::pair{0.0, 0.25}, std::pair{0.19, 0.11}}) {
        Scene scene = scene_of(96, 96);
        const Codes stored =
            picture(96, 96, [i = a, j = b](int x, int y) { return std::lround(40 + i * x + j * y); });
        const auto made = levelled(scene, stored);
        const SurfaceFrame& frame = *made;
        EXPECT_LT(farthest_from_plane(frame, 252, a, b), 0.15);
        scene.filter = {};
        EXPECT_GT(farthest_from_plane(*levelled(scene, stored), 1, a, b), 0.4);
    }
}

/// Mean over the rows of the jump from column 47 to 48, in levels, on a slope that has a step there.
double jump_of_step(int levels) {
    const Codes stored = picture(
        96, 128, [&](int x, int y) { return std::lround(60 + 0.13 * x + 0.07 * y + (x < 48 ? 0 : levels)); });
    const auto made = levelled(scene_of(96, 128), stored);
    const SurfaceFrame& frame = *made;
    double sum = 0;
    for (int y = 20; y < 108; ++y)
        sum += (frame.codes[frame.index(48, y)] - frame.codes[frame.index(47, y)]) / 252.0;
    return sum / 88;
}

TEST(Terraces, StepsOfThreeLevelsAndMoreStayStepsOnASlope) {
    EXPECT_GT(jump_of_step(3), 2.5);
    EXPECT_GT(jump_of_step(4), 3.8);
    for (const int levels : {6, 12, 100}) EXPECT_NEAR(jump_of_step(levels), levels + 0.13, 0.1) << levels;
}

// Second differences of these leave 16 bits.
TEST(Terraces, TheLargestStepsThereAreStay) {
    for (const int period : {1, 2, 3, 9}) {
        Scene scene = depth_scene(53, 41, 8, Marking::none, removal);
        const Codes stored =
            picture(53, 41, [&](int x, int y) { return (x / period + y / period) % 2 == 0 ? 0 : 255; });
        for (const double noise : {0.0, 4.0}) {
            scene.filter.terrace_noise = noise;
            EXPECT_EQ(levelled(scene, stored)->codes, finer(stored));
        }
    }
}

TEST(Terraces, NoCodeMovesByMoreThanItMay) {
    Random random(8);
    for (const double noise : {0.0, 1.0, 4.0}) {
        Scene scene = scene_of(61, 45);
        scene.filter.terrace_noise = noise;
        const int most = terrace_filter(scene)->most_at(0);
        const Codes stored = picture(61, 45, [&](int x, int) { return 60 + x / 9 + random.below(6); });
        const auto made = levelled(scene, stored);
        const SurfaceFrame& frame = *made;
        int farthest = 0;
        for (std::size_t k = 0; k < stored.size(); ++k)
            farthest = std::max(farthest, std::abs(frame.codes[k] - 252 * stored[k]));
        EXPECT_LE(farthest, 2 * most);
        EXPECT_GT(farthest, 200);
    }
}

TEST(Terraces, MillimetreCodesAreMadeFinerToo) {
    Scene scene = depth_scene(64, 40, 16, Marking::zero, removal);
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.scale = 1;
    scene.depth.near = 300;
    scene.depth.far = 4000;
    derive_valid_range(scene.depth);
    const Codes stored = picture(64, 40, [](int x, int y) { return 900 + (x + 2 * y) / 7; });
    const auto made = levelled(scene, stored);
    const SurfaceFrame& frame = *made;
    EXPECT_EQ(frame.coding.scale, 1.0 / 16);
    EXPECT_EQ(frame.codes[frame.index(0, 0)] >> 4, 900);
    EXPECT_NE(frame.codes[frame.index(32, 20)] & 15, 0);
}

TEST(Terraces, WhereCodesLeaveNoRoomNothingChanges) {
    for (const auto terraces : {TerraceRemoval::automatic, TerraceRemoval::off}) {
        const Scene scene = depth_scene(40, 30, 16, Marking::zero, {.terraces = terraces});
        const Codes stored = picture(40, 30, [](int x, int y) { return 900 + (x + 2 * y) / 7; });
        EXPECT_EQ(levelled(scene, stored)->codes, stored);
    }
}

}  // namespace
}  // namespace touchable::test
