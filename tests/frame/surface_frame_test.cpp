#include "engine/scene/frames.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <type_traits>
#include <utility>
#include <vector>

#include "tests/frame/random.hpp"

namespace touchable {
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

TEST(PlaneView, SamplesEveryDepthChannelStrideAndAlignment) {
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

TEST(PlaneView, NegativeStrideReadsRowsBottomUp) {
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

TEST(TouchPlanes, AreCopiedWholeWhateverTheStrideIntoARecycledSlotOfAnySize) {
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

TEST(TouchPlanes, AreEmptiedWhereTheRawFrameHasNone) {
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

TEST(SurfaceFrame, ValidityIsOneBitPerPixelLowBitFirstInRowsOfWholeWords) {
    test::Random random(1);
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

TEST(TileGrid, EveryCellLiesInItsTileOrTheNearestOneAndSoDoItsVertices) {
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

TEST(TileGrid, HasNoTileWithoutACell) {
    EXPECT_EQ(TileGrid::of(1, 1).tiles_x, 1);
    EXPECT_EQ(TileGrid::of(2, 1).tiles_x, 1);
    EXPECT_EQ(TileGrid::of(17, 1).tiles_x, 1);
    EXPECT_EQ(TileGrid::of(18, 1).tiles_x, 2);
    EXPECT_EQ(TileGrid::of(33, 16).tiles_x, 2);
    EXPECT_EQ(TileGrid::of(33, 16).tiles_y, 1);
    EXPECT_EQ(TileGrid::of(1920, 1080).tiles_x, 120);
    EXPECT_EQ(TileGrid::of(1920, 1080).tiles_y, 68);
}

}  // namespace
}  // namespace touchable
