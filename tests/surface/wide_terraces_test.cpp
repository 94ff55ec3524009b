// Terrace removal that reaches farther than 16 pixels: contours of large pictures of few levels.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "engine/scene/filter_codes.hpp"
#include "engine/surface/surface_builder.hpp"
#include "tests/surface/pictures.hpp"
#include "tests/surface/test_gpu.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

constexpr int reaches[] = {16, 32, 64, 128};

FilterSettings removal_within(int reach) {
    return {.terraces = TerraceRemoval::on, .terrace_reach = reach};
}

/// By hand: half of the reach, and halves of that.
TEST(WideTerraces, PassesHalveTheirTapsDownToOneTwice) {
    const std::vector<int> taps[] = {
        {8, 4, 2, 1, 1}, {16, 8, 4, 2, 1, 1}, {32, 16, 8, 4, 2, 1, 1}, {64, 32, 16, 8, 4, 2, 1, 1}};
    for (std::size_t n = 0; n < std::size(reaches); ++n) {
        const auto filter = terrace_filter(depth_scene(40, 30, 8, Marking::none, removal_within(reaches[n])));
        ASSERT_TRUE(filter);
        std::vector<int> passes;
        int sum = 0;
        for (int pass = 0; pass < filter->passes(); ++pass) {
            passes.push_back(filter->tap_of(pass));
            sum += passes.back();
        }
        EXPECT_EQ(passes, taps[n]);
        EXPECT_EQ(sum, reaches[n]);
        EXPECT_LE(filter->passes(), most_terrace_passes);
    }
}

/// All builders on one picture, at one reach.
void expect_same_bits(const Scene& scene, Fill fill, std::uint64_t seed) {
    Random random(seed);
    const StoredPlane plane = store_plane(scene.width, scene.height, fill_picture(scene, fill, random),
                                          {.bytes_per_sample = scene.depth_bits > 8 ? 2 : 1});
    SurfaceFrame reference, cpu, lazy, vulkan;
    ASSERT_TRUE(make_reference_builder(scene)->build(plane.frame(), reference));
    for (const VectorUnit unit : usable_vector_units())
        for (const int threads : {1, 3}) {
            ASSERT_TRUE(make_cpu_builder(scene, {threads, unit})->build(plane.frame(), cpu));
            ASSERT_EQ(first_difference(reference, cpu), "") << threads << " threads";
        }
    ASSERT_TRUE(make_lazy_builder(scene)->build(plane.frame(), lazy));
    ASSERT_EQ(first_vertex_difference(reference, *lazy.vertices), "");
    ASSERT_EQ(first_tile_not_enclosed(reference, *lazy.vertices), "");
    for (const SurfacePlan& plan : all_plans) {
        auto builder = make_vulkan_builder(scene, test_kernels(), plan);
        ASSERT_TRUE(builder && (*builder)->build(plane.frame(), vulkan));
        ASSERT_EQ(first_difference(reference, vulkan), "") << plan_text(plan);
    }
}

TEST(WideTerraces, AllBuildersGiveTheBitsOfTheReference) {
    constexpr std::pair<int, int> sizes[] = {{1, 1}, {7, 150}, {150, 7}, {129, 33}, {64, 64}, {203, 141}};
    constexpr Fill fills[] = {Fill::ramp,       Fill::random,   Fill::few_holes,   Fill::blob,
                              Fill::half_holes, Fill::extremes, Fill::silhouettes, Fill::slanted_edges};
    std::uint64_t seed = 1;
    for (const int reach : reaches)
        for (const auto& [width, height] : sizes)
            for (const Fill fill : fills) {
                if (++seed % std::min<std::size_t>(sweep_step(), 3) != 0) continue;
                FilterSettings filter = removal_within(reach);
                if (seed % 4 == 0) filter.levels = {seed % 8 == 0 ? 6.0 : 0.0, 3e-6};
                if (seed % 5 == 0) filter.terrace_noise = 1;
                if (seed % 6 == 0) filter.median = 3;
                SCOPED_TRACE(std::to_string(width) + "x" + std::to_string(height) + ", reach " +
                             std::to_string(reach) + ", seed " + std::to_string(seed));
                expect_same_bits(
                    depth_scene(width, height, seed % 3 == 0 ? 16 : 8, all_markings[seed % 4], filter), fill,
                    seed);
                if (HasFatalFailure()) return;
            }
}

/// A hill of hundreds of pixels, in levels.
double hill(double x, double y) {
    const double u = (x - 330) / 260, v = (y - 250) / 210;
    return 100 + 9 * std::exp(-u * u - v * v) + 0.004 * x;
}

constexpr int hill_width = 640, hill_height = 480;

int at(const std::vector<std::uint16_t>& codes, int x, int y) {
    return codes[static_cast<std::size_t>(y * hill_width + x)];
}

/// A picture's codes with terraces removed, by the CPU builder.
std::vector<std::uint16_t> levelled(const FilterSettings& filter,
                                    const std::function<double(int, int)>& stored) {
    const Scene scene = depth_scene(hill_width, hill_height, 8, Marking::none, filter);
    std::vector<std::uint16_t> codes;
    for (int y = 0; y < hill_height; ++y)
        for (int x = 0; x < hill_width; ++x)
            codes.push_back(static_cast<std::uint16_t>(std::lround(stored(x, y))));
    SurfaceFrame frame;
    EXPECT_TRUE(make_cpu_builder(scene)->build(
        store_plane(hill_width, hill_height, codes, {.bytes_per_sample = 1}).frame(), frame));
    return {frame.codes.begin(), frame.codes.end()};
}

/// RMS, degrees, of faces against those of the hill, where a level is `kappa` pixels' widths deep;
/// `per_level`: the frame's codes.
double faces_off_deg(const std::vector<std::uint16_t>& codes, double per_level, double kappa) {
    const auto code = [&](int x, int y) { return at(codes, x, y) / per_level; };
    double sum = 0;
    int faces = 0;
    for (int y = 0; y + 1 < hill_height; y += 3)
        for (int x = 0; x + 1 < hill_width; x += 3) {
            const double ax = kappa * (code(x + 1, y) - code(x, y)),
                         ay = kappa * (code(x, y + 1) - code(x, y));
            const double bx = kappa * (hill(x + 1, y) - hill(x, y)),
                         by = kappa * (hill(x, y + 1) - hill(x, y));
            const double cosine =
                (ax * bx + ay * by + 1) / std::sqrt((ax * ax + ay * ay + 1) * (bx * bx + by * by + 1));
            const double angle = std::acos(std::min(cosine, 1.0)) * 57.29577951308232;
            sum += angle * angle;
            ++faces;
        }
    return std::sqrt(sum / faces);
}

TEST(WideTerraces, OfAHillWithContoursOf60PixelsTheNormalIsTheHillsAgain) {
    const auto off = [](int reach) { return faces_off_deg(levelled(removal_within(reach), hill), 252, 6); };
    EXPECT_GT(off(16), 6);
    EXPECT_LT(off(64), 2.5);
    EXPECT_LT(off(128), 2.3);
}

/// Mean over the rows of the jump from column 319 to 320, in levels, on a slope with contours of 77 pixels.
double jump_of_step(int levels, int reach) {
    const std::vector<std::uint16_t> made = levelled(removal_within(reach), [&](int x, int y) {
        return 60 + 0.013 * x + 0.007 * y + (x < 320 ? 0 : levels);
    });
    double sum = 0;
    for (int y = 130; y < hill_height - 130; ++y) sum += (at(made, 320, y) - at(made, 319, y)) / 252.0;
    return sum / (hill_height - 260);
}

TEST(WideTerraces, StepsOfThreeLevelsAndMoreStay) {
    for (const int reach : reaches) {
        EXPECT_GT(jump_of_step(3, reach), 2.6) << reach;
        EXPECT_GT(jump_of_step(4, reach), 3.8) << reach;
        for (const int levels : {6, 12}) EXPECT_NEAR(jump_of_step(levels, reach), levels, 0.1) << reach;
    }
}

/// Levels of four codes, and between them ramps of three pixels, as phones enlarge their depth.
double enlarged(int x, int y) {
    double sum = 0;
    for (int dx = -1; dx <= 1; ++dx) sum += std::round(hill(x + dx, y) / 4) * 4;
    return sum / 3;
}

TEST(WideTerraces, OfLevelsOfFourCodesWithRampsBetweenThemToo) {
    FilterSettings filter = removal_within(128);
    const Scene scene = depth_scene(hill_width, hill_height, 8, Marking::none, {});
    const auto off = [&] {
        const Scene filtered = depth_scene(hill_width, hill_height, 8, Marking::none, filter);
        return faces_off_deg(levelled(filter, enlarged), 2.0 * terrace_filter(filtered)->working.factor, 6);
    };
    const double as_codes = off();
    filter.levels = code_step(scene.depth).times(4);
    const double as_levels = off();
    EXPECT_GT(as_codes, 13);
    EXPECT_LT(as_levels, 6);
}

}  // namespace
}  // namespace touchable::test
