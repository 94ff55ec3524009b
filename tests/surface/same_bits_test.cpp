#include <gtest/gtest.h>

#include "engine/scene/filter_codes.hpp"
#include "engine/surface/surface_builder.hpp"
#include "tests/surface/pictures.hpp"
#include "tests/surface/test_gpu.hpp"
#include "tests/sweep.hpp"

// Every builder gives the bits of the obvious one, whatever the picture.
namespace touchable::test {
namespace {

constexpr int medians[] = {0, 3, 5};
constexpr int fill_passes[] = {0, 1, 2, 5};
constexpr int bit_depths[] = {8, 10, 12, 16};

/// What the cases of a test have met; a test that met none of something has proved nothing about it.
struct Coverage {
    long pictures = 0, valid = 0, invalid = 0, non_zero = 0, zero_but_valid = 0;
    long filled = 0, smoothed = 0, tiles_with_holes = 0, tiles_without = 0, narrow_tiles = 0;
    long finer = 0;
};

struct Case {
    int width, height, bits;
    Marking marking;
    Fill fill;
    Layout layout;
    FilterSettings filter;
    std::uint64_t seed;
};

std::string text(const Case& c) {
    return std::to_string(c.width) + "x" + std::to_string(c.height) + ", " + std::to_string(c.bits) +
           " bits, marking " + std::to_string(static_cast<int>(c.marking)) + ", fill " +
           std::to_string(static_cast<int>(c.fill)) + ", padding " + std::to_string(c.layout.padding) +
           (c.layout.bottom_up ? " bottom up" : "") + ", median " + std::to_string(c.filter.median) +
           ", fill_holes " + std::to_string(c.filter.fill_holes) +
           (c.filter.terraces == TerraceRemoval::on ? ", terraces removed" : "") + ", seed " +
           std::to_string(c.seed);
}

class SameBits : public testing::Test {
protected:
    void compare(const Case& c) {
        SCOPED_TRACE(text(c));
        const Scene scene = depth_scene(c.width, c.height, c.bits, c.marking, c.filter);
        Random random(c.seed);
        const std::vector<std::uint16_t> stored = fill_picture(scene, c.fill, random);
        const StoredPlane plane = store_plane(c.width, c.height, stored, c.layout);
        SurfaceFrame reference;
        ASSERT_TRUE(make_reference_builder(scene)->build(plane.frame(), reference));
        ASSERT_TRUE(make_cpu_builder(scene)->build(plane.frame(), cpu_));
        ASSERT_TRUE(make_lazy_builder(scene)->build(plane.frame(), lazy_));
        ASSERT_EQ(first_difference(reference, cpu_), "");
        for (const VectorUnit unit : usable_vector_units()) {
            ASSERT_TRUE(make_cpu_builder(scene, {1, unit})->build(plane.frame(), cpu_));
            ASSERT_EQ(first_difference(reference, cpu_), "") << "vectors " << static_cast<int>(unit);
        }
        for (const SurfacePlan& plan : all_plans) {
            auto vulkan = make_vulkan_builder(scene, test_kernels(), plan);
            ASSERT_TRUE(vulkan) << vulkan.error().message;
            const auto built = (*vulkan)->build(plane.frame(), vulkan_);
            ASSERT_TRUE(built) << built.error().message;
            ASSERT_EQ(first_difference(reference, vulkan_), "") << "vulkan, " << plan_text(plan);
        }
        ASSERT_EQ(first_vertex_difference(reference, *vulkan_.vertices), "") << "vulkan";
        ASSERT_EQ(first_vertex_difference(reference, *cpu_.vertices), "") << "cpu";
        ASSERT_EQ(first_vertex_difference(reference, *lazy_.vertices), "") << "lazy";
        ASSERT_EQ(first_tile_not_enclosed(reference, *cpu_.vertices), "") << "cpu";
        ASSERT_EQ(first_tile_not_enclosed(reference, *lazy_.vertices), "") << "lazy";
        count(scene, stored, reference);
    }

    void count(const Scene& scene, const std::vector<std::uint16_t>& stored, const SurfaceFrame& frame) {
        ++seen_.pictures;
        const auto terraces = terrace_filter(scene);
        const auto unchanged = [&](std::uint16_t code) {
            return terraces ? 2 * terraces->working.of(code) : int{code};
        };
        seen_.finer += terraces.has_value();
        for (int y = 0; y < frame.height; ++y)
            for (int x = 0; x < frame.width; ++x) {
                const std::uint16_t before = stored[frame.index(x, y)],
                                    after = frame.codes[frame.index(x, y)];
                const bool was_valid = scene.depth.is_valid(before), is_valid = frame.is_valid(x, y);
                ++(is_valid ? seen_.valid : seen_.invalid);
                seen_.non_zero += after != 0;
                seen_.zero_but_valid += is_valid && after == 0;
                seen_.filled += is_valid && !was_valid;
                seen_.smoothed += is_valid && was_valid && unchanged(before) != after;
            }
        const TileGrid grid = TileGrid::of(frame.width, frame.height);
        for (std::size_t n = 0; n < frame.tiles.size(); ++n) {
            ++(frame.tiles[n].any_invalid ? seen_.tiles_with_holes : seen_.tiles_without);
            const int tx = static_cast<int>(n) % grid.tiles_x, ty = static_cast<int>(n) / grid.tiles_x;
            const TileDepths exact = depths_of(frame.tiles[n], frame.coding),
                             lazy = lazy_.vertices->tile(tx, ty);
            const bool same = exact.nearest == lazy.nearest && exact.farthest == lazy.farthest;
            const double within = frame.coding.far - frame.coding.near;
            seen_.narrow_tiles += exact.nearest < exact.farthest &&
                                  (terraces ? lazy.farthest - lazy.nearest < 0.9 * within : same);
        }
    }

    void expect_everything_met(const FilterSettings& filter) const {
        SCOPED_TRACE("median " + std::to_string(filter.median) + ", fill_holes " +
                     std::to_string(filter.fill_holes));
        EXPECT_GT(seen_.valid, seen_.pictures);
        EXPECT_GT(seen_.invalid, seen_.pictures);
        EXPECT_GT(seen_.non_zero, seen_.pictures);
        EXPECT_GT(seen_.zero_but_valid, 0);
        EXPECT_GT(seen_.tiles_with_holes, 0);
        EXPECT_GT(seen_.tiles_without, 0);
        EXPECT_GT(seen_.narrow_tiles, 0);  // a lazy tile that just answers "anything" would enclose too
        EXPECT_EQ(seen_.filled > 0, filter.fill_holes > 0);
        EXPECT_EQ(seen_.smoothed > 0, filter.median > 0 || filter.terraces == TerraceRemoval::on ||
                                          filter.flying_pixels != DepthLength{});
        EXPECT_EQ(seen_.finer > 0, filter.terraces == TerraceRemoval::on);
    }

    Coverage seen_;
    SurfaceFrame cpu_, lazy_, vulkan_;  // recycled from picture to picture, of whatever size
};

class SameBitsWithFilter : public SameBits, public testing::WithParamInterface<FilterSettings> {
protected:
    /// Whether the n-th case is for this filter. In a short run each filter takes a seventh of them, and
    /// all filters together take every one.
    bool is_taken(std::size_t n) const {
        const std::size_t step = sweep_step();
        return n % step == static_cast<std::size_t>(GetParam().median + GetParam().fill_holes) % step;
    }
};

TEST_P(SameBitsWithFilter, AtEveryKindOfPicture) {
    std::uint64_t seed = 1;
    for (const int bits : bit_depths)
        for (const Marking marking : all_markings)
            for (int fill = 0; fill < fill_count; ++fill, ++seed) {
                if (!is_taken(seed)) continue;
                const Layout layout{.bytes_per_sample = bits > 8 ? 2 : 1,
                                    .padding = static_cast<int>(seed % 5),
                                    .bottom_up = seed % 6 == 0};
                compare({37, 19, bits, marking, static_cast<Fill>(fill), layout, GetParam(), seed});
                if (HasFatalFailure()) return;
            }
    expect_everything_met(GetParam());
}

TEST_P(SameBitsWithFilter, AtEverySize) {
    std::vector<std::pair<int, int>> sizes;
    for (int height = 1; height <= 10; ++height)
        for (int width = 1; width <= 10; ++width) sizes.emplace_back(width, height);
    for (const int height : {1, 2, 3, 5, 15, 16, 17, 18, 24})
        for (const int width : {15, 16, 17, 18, 31, 32, 33, 34, 35, 40, 65})
            sizes.emplace_back(width, height), sizes.emplace_back(height, width);
    Random random(2024);
    // Terraces are five kernels more.
    const int repeats = GetParam().terraces == TerraceRemoval::on || sweep_step() > 1 ? 1 : 3;
    for (std::size_t n = 0; n < sizes.size(); ++n)
        for (int repeat = 0; repeat < repeats && is_taken(n); ++repeat) {
            const auto [width, height] = sizes[n];
            const int bits = bit_depths[random.below(4)];
            const Layout layout{.bytes_per_sample = bits > 8 ? 2 : 1,
                                .padding = random.below(8),
                                .bottom_up = random.below(4) == 0};
            compare({width, height, bits, all_markings[random.below(4)],
                     static_cast<Fill>(random.below(fill_count)), layout, GetParam(), random.next()});
            if (HasFatalFailure()) return;
        }
    expect_everything_met(GetParam());
}

TEST_P(SameBitsWithFilter, InBigPictures) {
    std::uint64_t seed = 77;
    for (const auto& [width, height] : {std::pair{331, 97}, std::pair{97, 203}})
        for (const Fill fill : {Fill::few_holes, Fill::blob})
            for (const Marking marking : {Marking::zero, Marking::largest}) {
                const Layout layout{.padding = 6};
                compare({width, height, 16, marking, fill, layout, GetParam(), seed++});
                if (HasFatalFailure()) return;
            }
    EXPECT_EQ(seen_.pictures, 8);
    EXPECT_GT(seen_.invalid, 0);
    EXPECT_GT(seen_.valid, 100000);
}

std::vector<FilterSettings> all_filters() {
    std::vector<FilterSettings> filters;
    for (const int median : medians)
        for (const int passes : fill_passes) filters.push_back({median, passes});
    filters.push_back({0, 0, TerraceRemoval::on});
    filters.push_back({3, 1, TerraceRemoval::on, 0.5});
    filters.push_back({0, 2, TerraceRemoval::on, 4});
    filters.push_back({0, 0, TerraceRemoval::on, 0, {0, 4e-6}});
    filters.push_back({3, 3, TerraceRemoval::on, 0.25, {20, 1e-5}});
    filters.push_back({.flying_pixels = {0, 2e-6}});
    filters.push_back({.median = 3, .fill_holes = 2, .flying_pixels = {3, 1e-6}});
    filters.push_back({.median = 3, .terraces = TerraceRemoval::on, .flying_pixels = {0.5, 0}});
    return filters;
}

INSTANTIATE_TEST_SUITE_P(Filters, SameBitsWithFilter, testing::ValuesIn(all_filters()), [](const auto& test) {
    return "Median" + std::to_string(test.param.median) + "Fill" + std::to_string(test.param.fill_holes) +
           (test.param.terraces == TerraceRemoval::on ? "Terraces" : "") +
           (test.param.levels != DepthLength{} ? "Levels" : "") +
           (test.param.flying_pixels != DepthLength{} ? "Flying" : "");
});

TEST_F(SameBits, WithTheMostPassesOfHoleFilling) {
    for (const int median : medians) {
        compare({64, 48, 16, Marking::zero, Fill::blob, {}, {median, 16}, 5});
        compare(
            {64, 48, 8, Marking::range_and_few, Fill::many_holes, {.bytes_per_sample = 1}, {median, 16}, 6});
        if (HasFatalFailure()) return;
    }
    EXPECT_GT(seen_.filled, 1000);
    EXPECT_GT(seen_.invalid, 0);  // the blob is larger than 16 passes reach
}

TEST_F(SameBits, WhereLaterPassesFindNothingToFill) {
    for (int passes = 1; passes <= 7; ++passes)
        for (const Marking marking : {Marking::zero, Marking::range_and_few})
            for (const int bytes : {1, 2}) {
                const Layout layout{.bytes_per_sample = bytes};
                const auto seed = static_cast<std::uint64_t>(passes);
                compare({37, 41, 8, marking, Fill::few_holes, layout, {3, passes}, seed});
                if (HasFatalFailure()) return;
            }
    EXPECT_GT(seen_.filled, 0);
}

TEST_F(SameBits, OfEightBitsInSixteen) {
    for (int fill = 0; fill < fill_count; ++fill)
        compare({33, 21, 8, Marking::zero, static_cast<Fill>(fill), {.bytes_per_sample = 2}, {5, 1}, 9});
    EXPECT_GT(seen_.smoothed, 0);
}

}  // namespace
}  // namespace touchable::test
