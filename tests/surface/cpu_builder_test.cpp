// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "engine/base/same_bits.hpp"
#include "engine/surface/frame_changes.hpp"
#include "engine/surface/patches.hpp"
#include "engine/surface/surface_builder.hpp"
#include "shaders/median_network.h"
#include "tests/limits.hpp"
#include "tests/surface/pictures.hpp"

#ifdef TOUCHABLE_HAS_OPENCV
#include <opencv2/imgproc.hpp>
#endif

namespace touchable::test {
namespace {

StoredPlane plane_of(const Scene& scene, Fill fill, std::uint64_t seed, const Layout& layout = {}) {
    Random random(seed);
    return store_plane(scene.width, scene.height, fill_picture(scene, fill, random), layout);
}

TEST(CpuBuilder, EqualsReferenceWithAnyPlan) {
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
TEST(CpuBuilder, ForgetsHolesOfPreviousFrame) {
    const Scene scene = depth_scene(97, 61, 16, Marking::zero, {5, 0});
    const auto builder = make_cpu_builder(scene);
    SurfaceFrame slot;
    for (const Fill fill : {Fill::half_holes, Fill::all_greatest, Fill::invalid_border, Fill::ramp,
                            Fill::all_invalid, Fill::random}) {
        const StoredPlane plane = plane_of(scene, fill, 6);
        ASSERT_TRUE(builder->build(plane.frame(), slot));
        EXPECT_EQ(reference_difference(scene, plane.frame(), slot), "") << static_cast<int>(fill);
    }
}

/// The remembered rows may have been written by another thread.
TEST(CpuBuilder, RemembersFramesWithAnyPlan) {
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

TEST(CpuBuilder, AllocatesOnlyForFirstFrame) {
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

// Changed pixels, and the blocks that have to be built again because of them.

constexpr std::pair<int, int> sizes[] = {{1, 1},   {31, 15}, {32, 16},  {33, 17}, {34, 33},
                                         {97, 48}, {7, 130}, {203, 81}, {64, 64}};

/// Around the samples of a block that differ, by looking at each; nothing where none does.
std::optional<PixelBox> obvious_box(const PlaneView& a, const PlaneView& b, int column, int row) {
    std::optional<PixelBox> box;
    for (int y = row * 16; y < std::min(row * 16 + 16, a.height); ++y)
        for (int x = column * 32; x < std::min(column * 32 + 32, a.width); ++x)
            for (int c = 0; c < a.channels; ++c)
                if (a.sample(x, y, c) != b.sample(x, y, c)) {
                    const PixelBox one = box.value_or(PixelBox{x, y, x + 1, y + 1});
                    box = PixelBox{std::min(one.left, x), std::min(one.top, y), std::max(one.right, x + 1),
                                   std::max(one.bottom, y + 1)};
                }
    return box;
}

/// Which blocks have a pixel within reach of such a box, pixel by pixel; nothing where more than half have
/// one of their own.
std::optional<std::vector<bool>> obviously_stale(const PlaneView& a, const PlaneView& b, int reach) {
    const BlockGrid grid = BlockGrid::of(a.width, a.height);
    std::vector<bool> stale(grid.count());
    std::size_t changed = 0;
    for (int row = 0; row < grid.rows; ++row)
        for (int column = 0; column < grid.columns; ++column) {
            const auto box = obvious_box(a, b, column, row);
            if (!box) continue;
            ++changed;
            for (int y = std::max(box->top - reach, 0); y < std::min(box->bottom + reach, a.height); ++y)
                for (int x = std::max(box->left - reach, 0); x < std::min(box->right + reach, a.width); ++x)
                    stale[grid.index(x / 32, y / 16)] = true;
        }
    if (2 * changed > grid.count()) return std::nullopt;
    return stale;
}

void expect_found(const RawFrame& a, const RawFrame& b, int reach, VectorUnit unit) {
    FrameChanges changes(a.depth.width, a.depth.height, reach, unit);
    RowBands bands(2);
    const BuildNumber before = changes.advance(a, bands);
    changes.advance(b, bands);
    const auto found = changes.stale_blocks(before);
    const auto expected = obviously_stale(a.depth, b.depth, reach);
    ASSERT_EQ(found.has_value(), expected.has_value());
    if (!found) return;
    int count = 0;
    for (int y = 0; y < found->grid().rows; ++y)
        for (int x = 0; x < found->grid().columns; ++x) {
            const bool stale = (*expected)[found->grid().index(x, y)];
            ASSERT_EQ(found->contains(x, y), stale)
                << a.depth.width << "x" << a.depth.height << ", " << a.depth.channels << " of "
                << a.depth.bytes_per_sample << " bytes, reach " << reach << ", block " << x << ", " << y;
            count += stale;
        }
    EXPECT_EQ(found->count(), count);
}

TEST(ChangedPixels, MakeBlocksInReachStale) {
    Random random(3);
    for (const auto& [width, height] : sizes)
        for (const auto& [channels, bytes] : {std::pair{1, 1}, {1, 2}, {3, 1}})
            for (int n = 0; n < 8; ++n) {
                const int samples = width * channels;
                std::vector<std::uint16_t> before(static_cast<std::size_t>(samples * height), 7);
                std::vector<std::uint16_t> after = before;
                const int changes = n == 0 ? 0 : n == 1 ? samples * height * 4 : random.below(6) + 1;
                for (int k = 0; k < changes; ++k)
                    after[static_cast<std::size_t>(random.below(samples * height))] = 8;
                RawFrame frames[2];
                const bool upward[] = {n % 2 == 0, n % 3 == 0};
                for (int k = 0; k < 2; ++k) {
                    const auto memory = std::make_shared<StoredPlane>(store_plane(
                        samples, height, k == 0 ? before : after, {bytes, random.below(4), upward[k]}));
                    frames[k] = memory->frame();
                    frames[k].depth.width = width;
                    frames[k].depth.channels = channels;
                    frames[k].storage = memory;
                }
                for (const int reach : {0, 1, 2, 17})
                    for (const VectorUnit unit : usable_vector_units())
                        expect_found(frames[0], frames[1], reach, unit);
            }
}

/// Every stale block is in one patch, no pixel in two; what a patch has around it is all that its pixels
/// depend on; and every tile with a vertex in a stale block is there, once.
TEST(Patches, CoverEveryStaleBlockOnce) {
    Random random(4);
    Patches patches;
    for (const auto& [width, height] : sizes)
        for (const int reach : {0, 1, 2, 5, 17, 34})
            for (int n = 0; n < 6; ++n) {
                const BlockGrid grid_of_blocks = BlockGrid::of(width, height);
                std::vector<std::uint64_t> changed(grid_of_blocks.count());
                for (std::uint64_t& frame : changed) frame = static_cast<std::uint64_t>(random.below(4));
                const FrameChanges::StaleBlocks map(grid_of_blocks, changed,
                                                    static_cast<std::uint64_t>(random.below(4)));
                patches.cover(map, width, height, reach);
                std::vector<int> covered(static_cast<std::size_t>(width * height));
                for (const auto& [inner, outer] : patches.patches) {
                    for (int y = inner.top; y < inner.bottom; ++y)
                        for (int x = inner.left; x < inner.right; ++x)
                            ++covered[static_cast<std::size_t>(y * width + x)];
                    EXPECT_EQ(outer.left, std::max(inner.left - reach, 0));
                    EXPECT_EQ(outer.top, std::max(inner.top - reach, 0));
                    EXPECT_EQ(outer.right, std::min(inner.right + reach, width));
                    EXPECT_EQ(outer.bottom, std::min(inner.bottom + reach, height));
                    EXPECT_EQ(inner.left % 32, 0);
                    EXPECT_TRUE(inner.right % 32 == 0 || inner.right == width);
                }
                EXPECT_EQ(patches.cost > 0, !patches.patches.empty());
                for (int y = 0; y < height; ++y)
                    for (int x = 0; x < width; ++x) {
                        const int times = covered[static_cast<std::size_t>(y * width + x)];
                        ASSERT_LE(times, 1);
                        ASSERT_TRUE(times == 1 || !map.contains(x / 32, y / 16));
                    }
                const TileGrid grid = TileGrid::of(width, height);
                std::vector<int> tiles(static_cast<std::size_t>(grid.tiles_x * grid.tiles_y));
                for (const auto& [row, run] : patches.tile_runs)
                    for (int tx = run.first; tx < run.last; ++tx)
                        ++tiles[static_cast<std::size_t>(row * grid.tiles_x + tx)];
                EXPECT_EQ(patches.tiles, std::count(tiles.begin(), tiles.end(), 1));
                for (int ty = 0; ty < grid.tiles_y; ++ty)
                    for (int tx = 0; tx < grid.tiles_x; ++tx) {
                        bool stale = false;
                        for (int y = ty * 16; y <= std::min(ty * 16 + 16, height - 1); ++y)
                            for (int x = tx * 16; x <= std::min(tx * 16 + 16, width - 1); ++x)
                                stale = stale || map.contains(x / 32, y / 16);
                        const int times = tiles[static_cast<std::size_t>(ty * grid.tiles_x + tx)];
                        ASSERT_LE(times, 1);
                        ASSERT_TRUE(times == 1 || !stale) << tx << ", " << ty;
                    }
            }
}

/// Frames of 128x64 codes that keep their planes.
RawFrame kept_frame(const std::vector<std::uint16_t>& codes, int bytes_per_sample = 2) {
    auto memory = std::make_shared<const StoredPlane>(store_plane(128, 64, codes, {bytes_per_sample}));
    RawFrame raw = memory->frame();
    raw.storage = memory;
    return raw;
}

class Changes : public testing::Test {
protected:
    /// The next frame, with another code at (x, y).
    BuildNumber change(int x, int y) {
        ++codes_[static_cast<std::size_t>(y * 128 + x)];
        return changes_.advance(kept_frame(codes_), bands_);
    }
    BuildNumber repeat() { return changes_.advance(kept_frame(codes_), bands_); }
    std::string stale(BuildNumber held) {
        const auto map = changes_.stale_blocks(held);
        if (!map) return "all";
        std::string text;
        for (int y = 0; y < 4; ++y)
            for (int x = 0; x < 4; ++x)
                if (map->contains(x, y)) text += std::to_string(x) + std::to_string(y) + " ";
        return text;
    }

    std::vector<std::uint16_t> codes_ = std::vector<std::uint16_t>(128 * 64, 100);
    RowBands bands_{2};
    FrameChanges changes_{128, 64, 1, usable_vector_units().front()};
};

TEST_F(Changes, ReachAsFarAsFilters) {
    repeat();
    EXPECT_EQ(stale(change(40, 20)), "");  // of the build itself
    for (const auto& [x, y, expected] : {std::tuple{40, 20, "11 "},
                                         {32, 20, "01 11 "},
                                         {63, 20, "11 21 "},
                                         {40, 16, "10 11 "},
                                         {40, 31, "11 12 "},
                                         {32, 16, "00 10 01 11 "},
                                         {0, 0, "00 "},
                                         {127, 63, "33 "}}) {
        const BuildNumber before = repeat();
        change(x, y);
        EXPECT_EQ(stale(before), expected) << x << ", " << y;
    }
}

TEST_F(Changes, AccumulateSinceSlotsBuild) {
    const BuildNumber first = repeat(), second = change(8, 8), third = change(40, 8), fourth = change(8, 8);
    EXPECT_EQ(stale(first), "00 10 ");  // changed back or not
    EXPECT_EQ(stale(second), "00 10 ");
    EXPECT_EQ(stale(third), "00 ");
    EXPECT_EQ(stale(fourth), "");
}

TEST_F(Changes, AreUnknownOfOtherBuilders) {
    FrameChanges others(128, 64, 1, VectorUnit::baseline);
    const BuildNumber other = others.advance(kept_frame(codes_), bands_), first = repeat();
    EXPECT_EQ(stale({}), "all");
    EXPECT_EQ(stale(other), "all");
    EXPECT_FALSE(other.is_since(changes_.touch_planes()));
    for (int n = 0; n < 100; ++n) {
        EXPECT_EQ(stale(first), n == 0 ? "" : "00 ") << n;
        change(8, 8);
    }
    EXPECT_EQ(stale(other), "all");
}

TEST_F(Changes, AreUnknownOfUnkeptPlanes) {
    const BuildNumber first = repeat();
    RawFrame brief = kept_frame(codes_);
    brief.storage = nullptr;  // though it lives until the end of this test
    const auto owner = kept_frame(codes_);
    brief.depth = owner.depth;
    const BuildNumber second = changes_.advance(brief, bands_);
    EXPECT_EQ(stale(first), "");  // it can be compared with the one before
    const BuildNumber third = repeat();
    EXPECT_EQ(stale(second), "all");
    EXPECT_EQ(stale(third), "");
    changes_.advance(kept_frame(codes_, 1), bands_);
    EXPECT_EQ(stale(third), "all");
}

/// For a while, after which they are.
TEST_F(Changes, AreSkippedWhileAllMoves) {
    repeat();
    for (std::uint16_t& code : codes_) ++code;
    for (int n = 0; n < 9; ++n) {
        const BuildNumber before = repeat();
        change(8, 8);
        EXPECT_EQ(stale(before), n < 4 ? "all" : "00 ") << n;
    }
    changes_.comparing_was_in_vain();
    const BuildNumber before = repeat();
    EXPECT_EQ(stale(before), "");
    change(8, 8);
    EXPECT_EQ(stale(before), "all");
}

TEST_F(Changes, CoverTouchPlanes) {
    const auto planes = std::make_shared<const std::vector<std::uint8_t>>(128 * 64 * 3, std::uint8_t{5});
    auto other = std::make_shared<std::vector<std::uint8_t>>(*planes);
    other->back() = 6;
    const auto advance = [&](const std::uint8_t* haptic, const std::uint8_t* height) {
        RawFrame raw = kept_frame(codes_);
        raw.storage =
            std::make_shared<std::tuple<std::shared_ptr<const void>, decltype(planes), decltype(other)>>(
                raw.storage, planes, other);
        if (haptic) raw.haptic = {haptic, 128 * 3, 128, 64, 1, 3};
        if (height) raw.height = {height, 128, 128, 64, 1, 1};
        return changes_.advance(raw, bands_);
    };
    const BuildNumber none = advance(nullptr, nullptr);
    const BuildNumber both = advance(planes->data(), planes->data());
    EXPECT_FALSE(none.is_since(changes_.touch_planes()));
    const BuildNumber again = advance(planes->data(), planes->data());
    EXPECT_TRUE(both.is_since(changes_.touch_planes()));
    const BuildNumber rougher = advance(other->data(), planes->data());
    EXPECT_FALSE(both.is_since(changes_.touch_planes()));
    EXPECT_FALSE(again.is_since(changes_.touch_planes()));
    EXPECT_TRUE(rougher.is_since(changes_.touch_planes()));
    advance(other->data(), nullptr);
    EXPECT_FALSE(rougher.is_since(changes_.touch_planes()));
    EXPECT_FALSE(BuildNumber{}.is_since(changes_.touch_planes()));
    EXPECT_EQ(stale(none), "");
}

TEST(LazyBuilder, AllocatesOnlyForFirstFrame) {
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

TEST(LazyBuilder, KeepsRawFrameUntilReuse) {
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

TEST(LazyVertices, AnswerInAnyOrder) {
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

TEST(LazyVertices, AnswerSeveralReadersAtOnce) {
    for (const FilterSettings& filter : {FilterSettings{3, 1}, {3, 1, TerraceRemoval::on}}) {
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
}

/// 64 inputs of zeros and ones at once: the lesser of two bits is their and, the greater their or.
struct Bits {
    std::uint64_t word = 0;
};
Bits lesser(Bits a, Bits b) {
    return {a.word & b.word};
}
Bits greater(Bits a, Bits b) {
    return {a.word | b.word};
}

/// Bit k of the number 64 n + lane, for all lanes.
Bits bit_of_numbers(std::uint64_t n, int k) {
    static constexpr std::uint64_t lanes[6] = {0xAAAAAAAAAAAAAAAA, 0xCCCCCCCCCCCCCCCC, 0xF0F0F0F0F0F0F0F0,
                                               0xFF00FF00FF00FF00, 0xFFFF0000FFFF0000, 0xFFFFFFFF00000000};
    if (k < 6) return {lanes[k]};
    return {(n >> (k - 6)) & 1 ? ~std::uint64_t{0} : 0};
}

Bits median_of_numbers3(std::uint64_t n) {
    Bits columns[3][3], pair[4];
    for (int k = 0; k < 9; ++k) columns[k / 3][k % 3] = bit_of_numbers(n, k);
    for (auto& column : columns) sort3(column);
    pair3(columns[0], columns[1], pair);
    return median9(pair, columns[2]);
}

Bits median_of_numbers5(std::uint64_t n) {
    Bits columns[5][5], first[10], second[10], quad[6];
    for (int k = 0; k < 25; ++k) columns[k / 5][k % 5] = bit_of_numbers(n, k);
    for (auto& column : columns) sort5(column);
    pair5(columns[0], columns[1], first);
    pair5(columns[2], columns[3], second);
    quad5(first, second, quad);
    return median25(quad, columns[4]);
}

/// A network of minima and maxima is right for all inputs where it is right for all inputs of zeros and ones.
template <class Median>
void expect_median_of_all_zeros_and_ones(int values, Median&& median_of_numbers) {
    for (std::uint64_t n = 0; n < (std::uint64_t{1} << values) / 64; ++n) {
        std::uint64_t expected = 0;
        for (std::uint64_t lane = 0; lane < 64; ++lane)
            if (std::popcount(64 * n + lane) > values / 2) expected |= std::uint64_t{1} << lane;
        ASSERT_EQ(median_of_numbers(n).word, expected) << "inputs from " << 64 * n;
    }
}

TEST(MedianNetwork, SelectsMedianOfEveryWindow) {
    expect_median_of_all_zeros_and_ones(9, median_of_numbers3);
    expect_median_of_all_zeros_and_ones(25, median_of_numbers5);
}

/// A window that a row shares with the one above it, as kernels sort their columns.
template <int Side>
void expect_inserting_sorts() {
    for (std::uint64_t n = 0; n < 32; ++n) {
        Bits sorted[Side], inserted[Side];
        for (int k = 0; k < Side; ++k) sorted[k] = inserted[k] = {n >> k & 1};
        if constexpr (Side == 3) {
            sort3(sorted);
            order(inserted[1], inserted[2]);
            insert3(inserted);
        } else {
            sort5(sorted);
            sort4(inserted[1], inserted[2], inserted[3], inserted[4]);
            insert5(inserted);
        }
        for (int k = 0; k < Side; ++k) {
            ASSERT_EQ(sorted[k].word, inserted[k].word);
            ASSERT_LE(sorted[std::max(k - 1, 0)].word, sorted[k].word);
        }
    }
}

TEST(MedianNetwork, SortsColumnsByInsertion) {
    expect_inserting_sorts<3>();
    expect_inserting_sorts<5>();
}

#ifdef TOUCHABLE_HAS_OPENCV

/// The first difference of two pictures, or nothing.
std::string first_difference_of(const cv::Mat& expected, const SurfaceFrame& frame, int bits) {
    for (int y = 0; y < frame.height; ++y)
        for (int x = 0; x < frame.width; ++x) {
            const int value = bits == 8 ? expected.at<std::uint8_t>(y, x) : expected.at<std::uint16_t>(y, x);
            const int code = frame.codes[frame.index(x, y)];
            if (value != code)
                return "pixel " + std::to_string(x) + ", " + std::to_string(y) + ": " + std::to_string(code) +
                       ", OpenCV's " + std::to_string(value);
        }
    return {};
}

/// OpenCV repeats the border as we do; of holes it knows nothing.
TEST(MedianFilter, MatchesOpenCvIncludingBorders) {
    Random random(11);
    int pictures = 0, changed = 0;
    for (const auto& [width, height] :
         {std::pair{5, 5}, {31, 7}, {32, 32}, {33, 18}, {64, 3}, {97, 61}, {640, 80}})
        for (const int bits : {8, 16})
            for (const int side : {3, 5})
                for (const Fill fill : {Fill::random, Fill::extremes, Fill::few_values, Fill::ramp}) {
                    const Scene scene = depth_scene(width, height, bits, Marking::none, {side, 0});
                    const StoredPlane plane = store_plane(width, height, fill_picture(scene, fill, random),
                                                          {.bytes_per_sample = bits / 8});
                    SurfaceFrame frame;
                    ASSERT_TRUE(make_cpu_builder(scene)->build(plane.frame(), frame));
                    const cv::Mat stored(height, width, bits == 8 ? CV_8UC1 : CV_16UC1,
                                         const_cast<std::uint8_t*>(plane.view.data),
                                         static_cast<std::size_t>(plane.view.stride));
                    cv::Mat filtered;
                    cv::medianBlur(stored, filtered, side);
                    ASSERT_EQ(first_difference_of(filtered, frame, bits), "")
                        << width << "x" << height << ", " << bits << " bits, median " << side << ", fill "
                        << static_cast<int>(fill);
                    ++pictures;
                    changed += cv::norm(stored, filtered, cv::NORM_INF) > 0 ? 1 : 0;
                }
    EXPECT_GT(changed, pictures / 2);
}

#else

TEST(MedianFilter, MatchesOpenCvIncludingBorders) {
    GTEST_SKIP() << "built without OpenCV (Debian: libopencv-imgproc-dev)";
}

#endif

}  // namespace
}  // namespace touchable::test
