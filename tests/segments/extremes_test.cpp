// Segments of pictures of any size, without colour, without depth, and with holes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <set>

#include "engine/authoring/segmentation.hpp"
#include "tests/segments/generated_table.hpp"

namespace touchable::test {
namespace {

/// A frame by functions of column and row.
class SegmentsOf : public ::testing::Test {
protected:
    template <class Code>
    RawFrame depth_of(int width, int height, Code&& code) {
        depth_.clear();
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) depth_.push_back(static_cast<std::uint16_t>(code(x, y)));
        RawFrame frame;
        frame.depth = {reinterpret_cast<const std::uint8_t*>(depth_.data()), 2 * width, width, height, 2, 1};
        return frame;
    }
    template <class Grey>
    void paint(RawFrame& frame, int width, int height, Grey&& grey) {
        colour_.clear();
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                for (int k = 0; k < 3; ++k) colour_.push_back(static_cast<std::uint8_t>(grey(x, y)));
        frame.colour = {colour_.data(), 3 * width, width, height, 1, 3};
    }
    static Scene scene_of(int width, int height) {
        GeneratedTable table;
        table.width = width;
        table.height = height;
        return table.scene();
    }
    /// Its figures agree with its labels.
    static void check(const Segmentation& found) {
        std::map<std::uint16_t, std::int32_t> pixels;
        for (const std::uint16_t label : found.labels) ++pixels[label];
        pixels.erase(0);
        ASSERT_EQ(pixels.size(), found.segments.size());
        std::uint16_t before = 0;
        for (const Segment& segment : found.segments) {
            EXPECT_GT(segment.label, before);
            before = segment.label;
            EXPECT_EQ(segment.pixels, pixels[segment.label]);
            EXPECT_EQ(found.labels[static_cast<std::size_t>(segment.y * found.width + segment.x)],
                      segment.label);
        }
    }

    std::vector<std::uint16_t> depth_;
    std::vector<std::uint8_t> colour_;
};

TEST_F(SegmentsOf, TheSmallestPictures) {
    for (const auto& [width, height] : {std::pair{1, 1}, {2, 2}, {1, 50}, {50, 1}, {5, 3}}) {
        Segmenter segmenter(scene_of(width, height));
        RawFrame frame = depth_of(width, height, [](int, int) { return 1000; });
        for (int n = 0; n < 3; ++n) {
            const Segmentation& found = segmenter.next(frame, n > 0);
            check(found);
            EXPECT_EQ(found.labels, std::vector<std::uint16_t>(depth_.size(), 1)) << width << "x" << height;
        }
        frame = depth_of(width, height, [](int, int) { return 0; });
        EXPECT_TRUE(segmenter.next(frame, true).segments.empty());
    }
}

TEST_F(SegmentsOf, NothingButHolesAreNone) {
    Segmenter segmenter(scene_of(64, 48));
    RawFrame frame = depth_of(64, 48, [](int, int) { return 0; });
    paint(frame, 64, 48, [](int x, int) { return x; });
    for (int n = 0; n < 2; ++n) {
        const Segmentation& found = segmenter.next(frame, n > 0);
        EXPECT_TRUE(found.segments.empty());
        EXPECT_EQ(*std::max_element(found.labels.begin(), found.labels.end()), 0);
    }
    // And where surfaces come and go again, they have the label that they had.
    const auto surface = [](int x, int) { return x < 32 ? 1000 : 2000; };
    RawFrame seen = depth_of(64, 48, surface);
    const std::vector<std::uint16_t> labels = segmenter.next(seen, true).labels;
    segmenter.next(depth_of(64, 48, [](int, int) { return 0; }), true);
    EXPECT_EQ(segmenter.next(depth_of(64, 48, surface), true).labels, labels);
}

TEST_F(SegmentsOf, WithoutColourAStepOfDepthTellsThemApart) {
    for (const bool with_colour : {false, true}) {
        Segmenter segmenter(scene_of(160, 120));
        const auto is_near = [](int x, int y) { return x > 50 && x < 110 && y > 30 && y < 90; };
        RawFrame frame = depth_of(160, 120, [&](int x, int y) { return is_near(x, y) ? 1000 : 1200; });
        if (with_colour) paint(frame, 160, 120, [](int, int) { return 90; });  // one colour
        const Segmentation& found = segmenter.next(frame, false);
        check(found);
        ASSERT_EQ(found.segments.size(), 2U);
        int wrong = 0;
        for (int y = 0; y < 120; ++y)
            for (int x = 0; x < 160; ++x)
                wrong +=
                    (found.labels[static_cast<std::size_t>(y * 160 + x)] == found.labels[0]) == is_near(x, y);
        EXPECT_EQ(wrong, 0);
        for (const Segment& segment : found.segments) {
            EXPECT_EQ(segment.contrast, 0);
            EXPECT_EQ(segment.colour[1], with_colour ? 90 : 0);
        }
    }
}

/// What a slanted floor has of depth is no step, and neither is a gap in it.
TEST_F(SegmentsOf, AFloorWithAGapIsOneSegment) {
    Segmenter segmenter(scene_of(160, 120));
    const RawFrame frame = depth_of(160, 120, [](int x, int y) {
        const double down = 0.2 + y / 120.0;  // of a floor depth is 1 over it
        return x == 80 || x == 81 ? 0 : static_cast<int>(1000 / down);
    });
    const Segmentation& found = segmenter.next(frame, false);
    check(found);
    EXPECT_EQ(found.segments.size(), 1U);
}

TEST_F(SegmentsOf, ColourOfAnotherSizeIsTakenWhereItLies) {
    const auto found_with = [&](int times) {
        Segmenter segmenter(scene_of(160, 120));
        RawFrame frame = depth_of(160, 120, [](int, int) { return 1000; });
        paint(frame, 160 * times, 120 * times, [&](int x, int) { return x < 80 * times ? 40 : 220; });
        const Segmentation& found = segmenter.next(frame, false);
        check(found);
        return found;
    };
    const Segmentation plain = found_with(1), larger = found_with(3);
    ASSERT_EQ(plain.segments.size(), 2U);
    EXPECT_EQ(plain.segments[0].colour[0], 40);
    EXPECT_EQ(plain.segments[1].colour[0], 220);
    EXPECT_EQ(larger.labels, plain.labels);
    EXPECT_EQ(larger.segments, plain.segments);
}

/// Every coding of depth, and depth along the ray.
TEST_F(SegmentsOf, AnyCodingOfDepthIsReadAsADepth) {
    for (const DepthCodingKind kind : {DepthCodingKind::linear, DepthCodingKind::inverse})
        for (const DepthSemantics semantics : {DepthSemantics::range, DepthSemantics::planar}) {
            Scene scene = small_scene(160, 120, 16);
            scene.camera = {130, 130, 79.5, 59.5};
            scene.depth.kind = kind;
            scene.depth.semantics = semantics;
            derive_valid_range(scene.depth);
            const RawFrame frame = depth_of(160, 120, [&](int x, int y) {
                const double ray = semantics == DepthSemantics::range ? scene.camera.ray_length(x, y) : 1.0;
                return scene.depth.code((x < 80 ? 60 : 70) * ray);
            });
            Segmenter segmenter(scene);
            const Segmentation& found = segmenter.next(frame, false);
            EXPECT_EQ(found.segments.size(), 2U);
            EXPECT_NE(found.labels[79], found.labels[80]);
        }
}

TEST_F(SegmentsOf, TextureIsMeasured) {
    const auto contrast_of = [&](auto&& grey) {
        Segmenter segmenter(scene_of(160, 120));
        RawFrame frame = depth_of(160, 120, [](int, int) { return 1000; });
        paint(frame, 160, 120, grey);
        const Segmentation& found = segmenter.next(frame, false);
        EXPECT_EQ(found.segments.size(), 1U);
        return found.segments[0].contrast;
    };
    EXPECT_EQ(contrast_of([](int, int) { return 100; }), 0);
    EXPECT_LE(contrast_of([](int x, int) { return 80 + x / 8; }), 8);  // light that falls off
    EXPECT_NEAR(contrast_of([](int x, int y) { return (x + y) % 2 ? 110 : 90; }), 160, 4);  // 10 levels
}

/// Depth of 8 bits is a staircase: its steps are no edges.
TEST_F(SegmentsOf, DepthOfEightBitsHasNoSegmentsOfItsOwn) {
    double sum = 0;
    for (std::uint64_t seed = 0; seed < 4; ++seed) {
        GeneratedTable table = random_table(seed);
        table.depth_noise = 0;
        Scene scene = table.scene();
        scene.depth.kind = DepthCodingKind::inverse;
        scene.depth.near = 0.4;
        scene.depth.far = 8;
        scene.depth.code_max = 255;
        scene.depth.invalid_code_count = 0;
        derive_valid_range(scene.depth);
        GeneratedFrame frame = generate(table, 0);
        for (std::uint16_t& code : frame.depth) code = scene.depth.code(code * 0.001);
        Segmenter segmenter(scene);
        const Segmentation& found = segmenter.next(frame.raw(), false);
        check(found);
        std::printf("8 bits, scene %d: %zu segments, mean IoU %.3f\n", static_cast<int>(seed),
                    found.segments.size(), mean_iou(frame.truth, found.labels));
        sum += mean_iou(frame.truth, found.labels);
        EXPECT_LE(found.segments.size(), 20U);
    }
    EXPECT_GE(sum / 4, 0.92);
}

}  // namespace
}  // namespace touchable::test
