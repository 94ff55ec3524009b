// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "engine/scene/frames.hpp"
#include "engine/scene/plane_memory.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

/// A plane of known samples: `padding` bytes of junk after each row, and `skew` before the first (odd
/// addresses).
struct OwnedPlane {
    std::vector<std::uint8_t> bytes;
    PlaneView view;

    OwnedPlane(int width, int height, int bytes_per_sample, int channels, int padding, int skew) {
        const int stride = width * channels * bytes_per_sample + padding;
        bytes.assign(static_cast<std::size_t>(skew + stride * height), 0xEE);
        view = {bytes.data() + skew, stride, width, height, bytes_per_sample, channels};
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                for (int c = 0; c < channels; ++c)
                    store(skew + y * stride, x * channels + c, expected(x, y, c));
    }
    std::uint16_t expected(int x, int y, int channel) const {
        const int value = 40503 * (x + 131 * y + 7919 * channel + 1);
        return static_cast<std::uint16_t>(view.bytes_per_sample == 1 ? value & 0xFF : value & 0xFFFF);
    }

private:
    void store(int row, int sample, std::uint16_t value) {
        const auto at = static_cast<std::size_t>(row + sample * view.bytes_per_sample);
        if (view.bytes_per_sample == 2)
            std::memcpy(&bytes[at], &value, 2);
        else
            bytes[at] = static_cast<std::uint8_t>(value);
    }
};

TEST(PlaneView, SamplesEveryLayout) {
    for (int bytes : {1, 2})
        for (int channels : {1, 3})
            for (int padding : {0, 1, 64})
                for (int skew : {0, 1}) {
                    const OwnedPlane plane(7, 5, bytes, channels, padding, skew);
                    for (int y = 0; y < 5; ++y)
                        for (int x = 0; x < 7; ++x)
                            for (int c = 0; c < channels; ++c)
                                ASSERT_EQ(plane.view.sample(x, y, c), plane.expected(x, y, c));
                }
}

TEST(PlaneView, ReadsRowsBottomUp) {
    const OwnedPlane plane(4, 3, 2, 1, 6, 0);
    PlaneView flipped = plane.view;
    flipped.data = plane.view.row(2);
    flipped.stride = -plane.view.stride;
    for (int y = 0; y < 3; ++y)
        for (int x = 0; x < 4; ++x) EXPECT_EQ(flipped.sample(x, y), plane.view.sample(x, 2 - y));
}

TEST(PlaneView, WithoutDataIsEmpty) {
    EXPECT_TRUE(PlaneView{}.empty());
    EXPECT_FALSE(OwnedPlane(1, 1, 1, 1, 0, 0).view.empty());
}

void expect_touch_planes(const OwnedPlane& haptic, const OwnedPlane& height, const SurfaceFrame& frame) {
    const int w = frame.width, h = frame.height;
    ASSERT_EQ(frame.haptic.size(), static_cast<std::size_t>(3 * w * h));
    ASSERT_EQ(frame.heights.size(), static_cast<std::size_t>(w * h));
    for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x) {
            ASSERT_EQ(frame.heights[frame.index(x, y)], height.expected(x, y, 0));
            for (int c = 0; c < 3; ++c)
                ASSERT_EQ(frame.haptic[frame.index(x, y) * 3 + static_cast<std::size_t>(c)],
                          haptic.expected(x, y, c));
        }
}

TEST(TouchPlanes, AreCopiedIntoAnySlot) {
    SurfaceFrame frame;
    for (const auto& [w, h] : {std::pair{9, 4}, {1, 1}, {1, 7}, {33, 16}})
        for (int bytes : {1, 2})
            for (int padding : {0, 5}) {
                const OwnedPlane haptic(w, h, 1, 3, padding, 1), height(w, h, bytes, 1, padding, 1);
                RawFrame raw;
                raw.haptic = haptic.view;
                raw.height = height.view;
                frame.width = w;
                frame.height = h;
                copy_touch_planes(raw, frame);
                expect_touch_planes(haptic, height, frame);
            }
}

TEST(TouchPlanes, AreEmptiedWithoutRawPlanes) {
    const OwnedPlane haptic(3, 2, 1, 3, 0, 0), height(3, 2, 1, 1, 0, 0);
    SurfaceFrame frame;
    RawFrame raw;
    raw.haptic = haptic.view;
    raw.height = height.view;
    copy_touch_planes(raw, frame);
    raw.haptic = {};
    copy_touch_planes(raw, frame);
    EXPECT_TRUE(frame.haptic.empty());
    EXPECT_EQ(frame.heights.size(), 6U);
    raw.height = {};
    copy_touch_planes(raw, frame);
    EXPECT_TRUE(frame.heights.empty());
}

// Its vertices read it where it is.
static_assert(!std::is_copy_constructible_v<SurfaceFrame> && !std::is_move_constructible_v<SurfaceFrame> &&
              !std::is_copy_assignable_v<SurfaceFrame> && !std::is_move_assignable_v<SurfaceFrame>);

TEST(SurfaceFrame, PacksValidityIntoWords) {
    Random random(1);
    for (int width : {1, 31, 32, 33, 65}) {
        SurfaceFrame frame;
        frame.width = width;
        frame.height = 3;
        ASSERT_EQ(frame.validity_words_per_row(), width <= 32 ? 1 : (width <= 64 ? 2 : 3));
        for (int k = 0; k < 3 * frame.validity_words_per_row(); ++k)
            frame.validity.push_back(static_cast<std::uint32_t>(random.next()));
        for (int y = 0; y < 3; ++y)
            for (int x = 0; x < width; ++x) {
                const std::uint32_t word =
                    frame.validity[static_cast<std::size_t>(y * frame.validity_words_per_row() + x / 32)];
                EXPECT_EQ(frame.validity_row(y)[x / 32], word);
                EXPECT_EQ(frame.is_valid(x, y), (word & (1U << (x % 32))) != 0);
            }
    }
}

/// How far a cell lies from the cells of tile `t`, along one axis of a picture of `pixels`.
int cells_away(int cell, int t, int pixels) {
    const int first = t * 16, last = std::max(first, std::min(first + 15, pixels - 2));
    return cell < first ? first - cell : (cell > last ? cell - last : 0);
}

void expect_nearest_tile(int cell, int tile, int tiles, int pixels) {
    ASSERT_GE(tile, 0);
    ASSERT_LT(tile, tiles);
    for (int other = 0; other < tiles; ++other)
        EXPECT_LE(cells_away(cell, tile, pixels), cells_away(cell, other, pixels))
            << cell << " of " << pixels;
    for (int pixel : {cell, cell + 1})
        if (pixel >= 0 && pixel < pixels) {
            EXPECT_TRUE(pixel >= tile * 16 && pixel <= tile * 16 + 16) << cell << " of " << pixels;
        }
}

TEST(TileGrid, FindsNearestTileOfCell) {
    for (int pixels = 1; pixels <= 100; ++pixels) {
        const TileGrid across = TileGrid::of(pixels, 1), down = TileGrid::of(1, pixels);
        EXPECT_EQ(across.tiles_y, 1);
        EXPECT_EQ(down.tiles_x, 1);
        for (int cell = -3; cell <= pixels + 3; ++cell) {
            expect_nearest_tile(cell, across.column_of_cell(cell), across.tiles_x, pixels);
            expect_nearest_tile(cell, down.row_of_cell(cell), down.tiles_y, pixels);
        }
    }
}

TEST(TileGrid, GivesEachTileACell) {
    EXPECT_EQ(TileGrid::of(1, 1).tiles_x, 1);
    EXPECT_EQ(TileGrid::of(2, 1).tiles_x, 1);
    EXPECT_EQ(TileGrid::of(17, 1).tiles_x, 1);
    EXPECT_EQ(TileGrid::of(18, 1).tiles_x, 2);
    EXPECT_EQ(TileGrid::of(33, 16).tiles_x, 2);
    EXPECT_EQ(TileGrid::of(33, 16).tiles_y, 1);
    EXPECT_EQ(TileGrid::of(1920, 1080).tiles_x, 120);
    EXPECT_EQ(TileGrid::of(1920, 1080).tiles_y, 68);
}

using Array = FrameArray<std::uint16_t>;

/// Memory of another owner, and whether it still lives.
struct Lent {
    std::shared_ptr<std::vector<std::uint16_t>> memory =
        std::make_shared<std::vector<std::uint16_t>>(std::vector<std::uint16_t>{7, 8, 9});
    std::weak_ptr<std::vector<std::uint16_t>> watched = memory;

    void give(Array& array) {
        array.adopt(*memory, memory);
        memory.reset();
    }
};

TEST(FrameArray, OwnsItsElements) {
    Array array;
    EXPECT_TRUE(array.empty());
    array.resize(3);
    EXPECT_EQ(array, (std::vector<std::uint16_t>{0, 0, 0}));
    array[1] = 5;
    array.resize(4);
    EXPECT_EQ(array, (std::vector<std::uint16_t>{0, 5, 0, 0}));
    array.assign(2, 6);
    array.push_back(1);
    EXPECT_EQ(array, (std::vector<std::uint16_t>{6, 6, 1}));
    EXPECT_FALSE(array.adopted());
    array.clear();
    EXPECT_EQ(array.size(), 0U);
}

TEST(FrameArray, UsesAdoptedMemoryInPlace) {
    Lent lent;
    const std::uint16_t* where = lent.memory->data();
    Array array;
    array.assign(9, 1);
    lent.give(array);
    EXPECT_EQ(array.data(), where);
    EXPECT_EQ(array, (std::vector<std::uint16_t>{7, 8, 9}));
    array[2] = 4;
    EXPECT_EQ((*lent.watched.lock())[2], 4);
    EXPECT_TRUE(array.adopted());
}

TEST(FrameArray, ReleasesAdoptedMemoryOnResize) {
    const auto changes = {+[](Array& a) { a.resize(3); }, +[](Array& a) { a.assign(3, 0); },
                          +[](Array& a) { a.clear(), a.resize(3); }};
    for (const auto change : changes) {
        Lent lent;
        Array array;
        lent.give(array);
        change(array);
        EXPECT_TRUE(lent.watched.expired());
        EXPECT_FALSE(array.adopted());
        EXPECT_EQ(array, (std::vector<std::uint16_t>{0, 0, 0}));
    }
}

TEST(FrameArray, CopiesAndMovesMemory) {
    Lent lent;
    Array array;
    lent.give(array);
    Array copy = array;
    EXPECT_FALSE(copy.adopted());
    EXPECT_NE(copy.data(), array.data());
    EXPECT_EQ(copy, array);
    const std::uint16_t* where = array.data();
    Array moved = std::move(array);
    EXPECT_TRUE(moved.adopted());
    EXPECT_EQ(moved.data(), where);
    moved = copy;
    EXPECT_TRUE(lent.watched.expired());
    EXPECT_EQ(moved, (std::vector<std::uint16_t>{7, 8, 9}));
}

/// The hue of HSV in turns, 0 to below 1, as textbooks have it.
double hue_of(int r, int g, int b) {
    const int most = std::max({r, g, b}), chroma = most - std::min({r, g, b});
    if (chroma == 0) return 0;
    double sixths = 0;
    if (most == r)
        sixths = static_cast<double>(g - b) / chroma;
    else if (most == g)
        sixths = 2 + static_cast<double>(b - r) / chroma;
    else
        sixths = 4 + static_cast<double>(r - g) / chroma;
    return (sixths < 0 ? sixths + 6 : sixths) / 6;
}

template <class Check>
void for_every_colour(Check&& check) {
    for (int r = 0; r < 256; ++r)
        for (int g = 0; g < 256; ++g)
            for (int b = 0; b < 256; ++b) check(r, g, b);
}

/// So saturated hues, a little more than a code apart, differ, and sectors meet at multiples of 256.
TEST(HueCode, RoundsEveryColoursHue) {
    double worst = 0;
    std::vector<bool> met(1536);
    for_every_colour([&](int r, int g, int b) {
        const uint code = hue_code(static_cast<uint>(r), static_cast<uint>(g), static_cast<uint>(b));
        met.at(code) = true;
        worst = std::max(worst, std::fabs(hue_of(r, g, b) * 1536 - code));
    });
    EXPECT_LE(worst, 0.5);
    EXPECT_GT(worst, 0.49);  // or the formula above says nothing
    EXPECT_EQ(std::count(met.begin(), met.end(), true), 1536);
}

TEST(HueCode, RejectsDarkAndGreyColours) {
    for (const int least_sum : {0, 1, 77, 400, 765})
        for_every_colour([&](int r, int g, int b) {
            if ((r + 3 * g + 7 * b) % 5 != 0 && r + g + b != least_sum) return;  // a fifth, and the limit
            const bool grey = r == g && g == b;
            ASSERT_EQ(hue_is_valid(static_cast<uint>(r), static_cast<uint>(g), static_cast<uint>(b),
                                   static_cast<uint>(least_sum)),
                      r + g + b >= least_sum && !grey)
                << r << " " << g << " " << b;
        });
}

TEST(StoredCode, IsHueOrStoredValue) {
    const std::vector<std::uint8_t> samples{9, 9, 9, 0, 255, 0, 25, 26, 25, 26, 26, 25, 0xEE, 0xEE};
    const PlaneView rgb{samples.data(), 14, 4, 1, 1, 3};
    DepthCoding coding;
    coding.kind = DepthCodingKind::hue;
    coding.near = 1;
    coding.far = 2;
    coding.near_is_high = false;
    coding.code_max = DepthCoding::hue_circle;
    coding.least_sum = 77;
    derive_valid_range(coding);
    EXPECT_EQ(stored_code(rgb, coding, 0, 0), no_hue);  // grey
    EXPECT_EQ(stored_code(rgb, coding, 1, 0), 512);
    EXPECT_EQ(stored_code(rgb, coding, 2, 0), no_hue);  // 76: too dark
    EXPECT_EQ(stored_code(rgb, coding, 3, 0), 256);     // 77
    EXPECT_FALSE(coding.is_valid(no_hue));
    EXPECT_DOUBLE_EQ(coding.depth(512), 1 + 1 / 3.0);
    coding.kind = DepthCodingKind::linear;
    const PlaneView wide{samples.data(), 14, 2, 1, 2, 1};
    EXPECT_EQ(stored_code(wide, coding, 1, 0), wide.sample(1, 0));
}

TEST(RawFrame, IsKeptByCopy) {
    std::vector<std::uint8_t> height{1, 2, 3, 0, 4, 5, 6, 0};  // rows of three, and a gap
    std::vector<std::uint16_t> depth{10, 20, 30, 40, 50, 60};
    RawFrame given;
    given.number = 7;
    given.height = {height.data(), 4, 3, 2, 1, 1};
    given.depth = {reinterpret_cast<const std::uint8_t*>(depth.data()), 6, 3, 2, 2, 1};
    const std::vector<std::uint8_t> height_then = height;
    const std::vector<std::uint16_t> depth_then = depth;
    RawFrame then = given;
    then.height.data = height_then.data();
    then.depth.data = reinterpret_cast<const std::uint8_t*>(depth_then.data());
    const RawFrame kept = kept_frame(given);
    height.assign(height.size(), 99);
    depth.assign(depth.size(), 99);
    EXPECT_TRUE(same_touch_planes(kept, then));
    EXPECT_FALSE(same_touch_planes(given, then));
    EXPECT_EQ(kept.number, 7);
    EXPECT_TRUE(kept.colour.empty());
    for (const PlaneView& plane : {kept.depth, kept.height}) {
        EXPECT_NE(plane_block_of(plane.data, static_cast<std::size_t>(plane.stride * 2)), nullptr);
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(plane.data) % plane_alignment, 0U);
        EXPECT_EQ(static_cast<std::size_t>(plane.stride) % plane_row_alignment, 0U);
    }
    EXPECT_EQ(kept_frame(kept).depth.data, kept.depth.data) << "copied once more";
}

struct Size {
    int width, height;
};
constexpr Size sizes[] = {{1, 1}, {1, 40}, {40, 1}, {16, 16}, {17, 17}, {18, 17}, {33, 16}, {50, 70}};

DepthCoding coding(DepthCodingKind kind, bool near_is_high, std::uint16_t code_max) {
    DepthCoding c;
    c.kind = kind;
    c.near_is_high = near_is_high;
    c.near = kind == DepthCodingKind::metric ? 0 : 500;
    c.far = 3000.25;
    c.scale = 1.25;
    c.code_max = code_max;
    derive_valid_range(c);
    return c;
}

std::vector<DepthCoding> codings() {
    std::vector<DepthCoding> all{coding(DepthCodingKind::metric, false, 2400)};
    for (bool near_is_high : {true, false})
        for (std::uint16_t code_max : {std::uint16_t{255}, std::uint16_t{1023}, std::uint16_t{65535}}) {
            all.push_back(coding(DepthCodingKind::linear, near_is_high, code_max));
            all.push_back(coding(DepthCodingKind::inverse, near_is_high, code_max));
        }
    return all;
}

/// Calls visit(x, y) for the vertices of a tile that lie in the picture.
void for_each_vertex(int tx, int ty, Size size, const std::function<void(int, int)>& visit) {
    for (int y = 16 * ty; y <= 16 * ty + 16 && y < size.height; ++y)
        for (int x = 16 * tx; x <= 16 * tx + 16 && x < size.width; ++x) visit(x, y);
}

/// Random valid codes; about one pixel in `one_invalid_in` is invalid (0: none), and then its code is too.
void fill_randomly(SurfaceFrame& frame, const DepthCoding& depth, Size size, int one_invalid_in,
                   Random& random) {
    frame.width = size.width;
    frame.height = size.height;
    frame.coding = depth;
    frame.codes.assign(static_cast<std::size_t>(size.width * size.height), 0);
    frame.validity.assign(static_cast<std::size_t>(frame.validity_words_per_row() * size.height), 0);
    frame.tiles.clear();
    for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x) {
            if (one_invalid_in > 0 && random.below(one_invalid_in) == 0) continue;
            const int code = depth.valid_min + random.below(depth.valid_max - depth.valid_min + 1);
            frame.codes[frame.index(x, y)] = static_cast<std::uint16_t>(code);
            frame.validity_row(y)[x / 32] |= 1U << (x % 32);
        }
    const TileGrid grid = TileGrid::of(size.width, size.height);
    for (int ty = 0; ty < grid.tiles_y; ++ty)
        for (int tx = 0; tx < grid.tiles_x; ++tx) {
            TileBounds bounds;
            for_each_vertex(tx, ty, size, [&](int x, int y) {
                if (!frame.is_valid(x, y)) {
                    bounds.any_invalid = true;
                    return;
                }
                bounds.least = std::min(bounds.least, frame.codes[frame.index(x, y)]);
                bounds.greatest = std::max(bounds.greatest, frame.codes[frame.index(x, y)]);
            });
            frame.tiles.push_back(bounds);
        }
}

/// The tile encloses every valid vertex, touches its extremes, and tells of invalid ones.
void expect_honest_tiles(const VertexSource& vertices, Size size) {
    const TileGrid grid = TileGrid::of(size.width, size.height);
    for (int ty = 0; ty < grid.tiles_y; ++ty)
        for (int tx = 0; tx < grid.tiles_x; ++tx) {
            std::vector<double> depths;
            bool any_invalid = false;
            for_each_vertex(tx, ty, size, [&](int x, int y) {
                const DepthSample sample = vertices.at(x, y);
                if (sample.valid)
                    depths.push_back(sample.depth);
                else
                    any_invalid = true;
            });
            const TileDepths tile = vertices.tile(tx, ty);
            EXPECT_EQ(tile.any_invalid, any_invalid);
            if (depths.empty()) {
                EXPECT_GT(tile.nearest, tile.farthest);
                continue;
            }
            EXPECT_EQ(tile.nearest, *std::min_element(depths.begin(), depths.end()));
            EXPECT_EQ(tile.farthest, *std::max_element(depths.begin(), depths.end()));
        }
}

TEST(FilteredVertices, GiveDepthsAndExactTiles) {
    Random random(2);
    for (const DepthCoding& depth : codings())
        for (Size size : sizes)
            for (int one_invalid_in : {0, 1, 3, 300}) {
                SCOPED_TRACE(std::to_string(size.width) + "x" + std::to_string(size.height));
                SurfaceFrame frame;
                fill_randomly(frame, depth, size, one_invalid_in, random);
                const FilteredVertices vertices(frame);
                for (int y = 0; y < size.height; ++y)
                    for (int x = 0; x < size.width; ++x) {
                        const DepthSample sample = vertices.at(x, y);
                        ASSERT_EQ(sample.valid, frame.is_valid(x, y));
                        if (!sample.valid) continue;
                        ASSERT_EQ(sample.depth, depth.depth(frame.codes[frame.index(x, y)]));
                    }
                expect_honest_tiles(vertices, size);
            }
}

TEST(FilteredVertices, FollowTheirFrame) {
    Random random(4);
    const DepthCoding depth = coding(DepthCodingKind::metric, false, 2400);
    SurfaceFrame frame;
    fill_randomly(frame, depth, {20, 20}, 0, random);
    const FilteredVertices vertices(frame);
    fill_randomly(frame, depth, {33, 16}, 5, random);
    expect_honest_tiles(vertices, {33, 16});
}

TEST(ExactVertices, GiveDepthsAndExactTiles) {
    Random random(5);
    for (Size size : sizes) {
        SCOPED_TRACE(std::to_string(size.width) + "x" + std::to_string(size.height));
        std::vector<double> depths;
        for (int k = 0; k < size.width * size.height; ++k)
            depths.push_back(500 + static_cast<double>(random.next() >> 11) * 0x1p-43);
        const ExactVertices vertices(size.width, size.height, depths);
        for (int y = 0; y < size.height; ++y)
            for (int x = 0; x < size.width; ++x) {
                ASSERT_TRUE(vertices.at(x, y).valid);
                ASSERT_EQ(vertices.at(x, y).depth, depths[static_cast<std::size_t>(y * size.width + x)]);
            }
        expect_honest_tiles(vertices, size);
    }
}

TEST(ExactVertices, AreInvalidWithoutDepth) {
    const ExactVertices vertices(3, 2, {7, 8});
    EXPECT_TRUE(vertices.at(1, 0).valid);
    EXPECT_FALSE(vertices.at(2, 0).valid);
    EXPECT_FALSE(vertices.at(2, 1).valid);
    EXPECT_TRUE(vertices.tile(0, 0).any_invalid);
}

TEST(ExactVertices, IgnoreInfiniteDepths) {
    const double infinity = std::numeric_limits<double>::infinity();
    std::vector<double> depths(33 * 16, 7.5);
    depths[0] = std::nan("");
    depths[16] = infinity;
    depths[15 * 33 + 32] = -infinity;
    const ExactVertices vertices(33, 16, depths);
    EXPECT_FALSE(vertices.at(0, 0).valid);
    EXPECT_FALSE(vertices.at(16, 0).valid);
    EXPECT_FALSE(vertices.at(32, 15).valid);
    EXPECT_TRUE(vertices.at(1, 0).valid);
    for (int tx : {0, 1}) {
        EXPECT_TRUE(vertices.tile(tx, 0).any_invalid);
        EXPECT_EQ(vertices.tile(tx, 0).nearest, 7.5);
        EXPECT_EQ(vertices.tile(tx, 0).farthest, 7.5);
    }
    const ExactVertices nothing(1, 1, {infinity});
    EXPECT_TRUE(nothing.tile(0, 0).any_invalid);
    EXPECT_GT(nothing.tile(0, 0).nearest, nothing.tile(0, 0).farthest);
}

}  // namespace
}  // namespace touchable::test
