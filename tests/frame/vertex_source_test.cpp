#include "engine/scene/frames.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>
#include "tests/frame/random.hpp"

namespace touchable {
namespace {

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
                   test::Random& random) {
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

TEST(FilteredVertices, GiveTheDepthOfEachValidCodeAndHonestTiles) {
    test::Random random(2);
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

TEST(FilteredVertices, ValidityComesFromItsBitsNotFromTheCode) {
    test::Random random(3);
    SurfaceFrame frame;
    fill_randomly(frame, coding(DepthCodingKind::linear, true, 255), {5, 5}, 0, random);
    frame.validity[2] &= ~(1U << 3);
    const FilteredVertices vertices(frame);
    EXPECT_FALSE(vertices.at(3, 2).valid);
    EXPECT_TRUE(vertices.at(2, 3).valid);
}

TEST(FilteredVertices, FollowTheFrameTheyReadWhenItsSlotIsRefilled) {
    test::Random random(4);
    const DepthCoding depth = coding(DepthCodingKind::metric, false, 2400);
    SurfaceFrame frame;
    fill_randomly(frame, depth, {20, 20}, 0, random);
    const FilteredVertices vertices(frame);
    fill_randomly(frame, depth, {33, 16}, 5, random);
    expect_honest_tiles(vertices, {33, 16});
}

TEST(ExactVertices, GiveTheDepthsTheyWereMadeOfAndHonestTiles) {
    test::Random random(5);
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

TEST(ExactVertices, DepthsThatAreMissingAreNotValid) {
    const ExactVertices vertices(3, 2, {7, 8});
    EXPECT_TRUE(vertices.at(1, 0).valid);
    EXPECT_FALSE(vertices.at(2, 0).valid);
    EXPECT_FALSE(vertices.at(2, 1).valid);
    EXPECT_TRUE(vertices.tile(0, 0).any_invalid);
}

TEST(ExactVertices, DepthsThatAreNotFiniteAreInvalidAndBoundNothing) {
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
}  // namespace touchable
