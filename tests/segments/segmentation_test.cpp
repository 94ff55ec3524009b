// Segments of generated clips, of which it is known what every pixel shows.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <map>
#include <set>

#include "engine/authoring/segmentation.hpp"
#include "engine/base/same_bits.hpp"
#include "tests/segments/generated_table.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

const bool short_sweeps = sweep_step() > 1;

TEST(Segmenter, FindsThingsOnATable) {
    double sum = 0, least = 1;
    constexpr int scenes = 8;
    std::size_t most_segments = 0;
    for (int seed = 0; seed < scenes; ++seed) {
        const GeneratedTable table = random_table(static_cast<std::uint64_t>(seed));
        Segmenter segmenter(table.scene());
        const GeneratedFrame frame = generate(table, 0);
        const Segmentation& found = segmenter.next(frame.raw(), false);
        const double iou = mean_iou(frame.truth, found.labels);
        std::printf("scene %d: mean IoU %.3f, %zu segments\n", seed, iou, found.segments.size());
        sum += iou;
        least = std::min(least, iou);
        most_segments = std::max(most_segments, found.segments.size());
    }
    std::printf("mean of %d scenes: %.3f\n", scenes, sum / scenes);
    EXPECT_GE(sum / scenes, 0.8);
    EXPECT_GE(least, 0.7);
    EXPECT_LE(most_segments, 40U);
}

/// As good at the sizes of other cameras. What a frame takes is printed: 640x480 has to be 5 a second.
TEST(Segmenter, FindsThemInPicturesOfAnySize) {
    for (const auto& [width, height] : {std::pair{640, 480}, {1920, 1080}}) {
        if (short_sweeps && width > 640) continue;
        const GeneratedTable table = random_table(3, width, height);
        Segmenter segmenter(table.scene());
        const GeneratedFrame first = generate(table, 0), second = generate(table, 1);
        double iou = mean_iou(first.truth, segmenter.next(first.raw(0), false).labels);
        const auto wall = std::chrono::steady_clock::now();
        const std::clock_t cpu = std::clock();
        iou = std::min(iou, mean_iou(second.truth, segmenter.next(second.raw(1), true).labels));
        const double all_ms = 1000.0 * static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
        const double ms =
            std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - wall).count();
        std::printf("%dx%d: mean IoU %.3f, a frame takes %.0f ms, %.0f ms of CPU\n", width, height, iou, ms,
                    all_ms);
        EXPECT_GE(iou, 0.8);
    }
}

/// Per cent of the pixels seen in both frames whose label is another than it was, in the mean and at most.
struct Changes {
    double mean = 0, most = 0;
};
Changes changes_of(const GeneratedTable& table, int frames, int from) {
    Segmenter segmenter(table.scene());
    GeneratedFrame before;
    std::vector<std::uint16_t> labels;
    Changes changes;
    std::set<std::uint16_t> all;
    for (int n = 0; n < frames; ++n) {
        GeneratedFrame now = generate(table, n);
        const Segmentation& found = segmenter.next(now.raw(n), n > 0);
        for (const Segment& segment : found.segments) all.insert(segment.label);
        if (n >= from) {
            double seen = 0, changed = 0;
            for (std::size_t k = 0; k < now.truth.size(); ++k) {
                const auto there = place_before(table, now, before, n, k);
                if (!there) continue;
                ++seen;
                changed += labels[*there] != found.labels[k] ? 1 : 0;
            }
            const double share = 100 * changed / seen;
            changes.mean += share / (frames - from);
            changes.most = std::max(changes.most, share);
        }
        labels = found.labels;
        before = std::move(now);
    }
    std::printf("%zu labels in %d frames; %.3f %% change, at most %.3f %%\n", all.size(), frames,
                changes.mean, changes.most);
    return changes;
}

TEST(Segmenter, IsSteadyBeforeAStillCamera) {
    for (const int seed : short_sweeps ? std::vector{0, 2} : std::vector{0, 1, 2}) {
        GeneratedTable table = random_table(static_cast<std::uint64_t>(seed));
        table.colour_noise = 5;
        const Changes changes = changes_of(table, short_sweeps ? 8 : 16, 1);
        EXPECT_LE(changes.mean, 0.5);
    }
}

TEST(Segmenter, FollowsWhatMoves) {
    for (const int seed : short_sweeps ? std::vector{0, 2} : std::vector{0, 1, 2}) {
        GeneratedTable table = random_table(static_cast<std::uint64_t>(seed));
        if (seed != 1) table.things[3].speed = {0.008, 0, 0};
        if (seed != 1) table.things[5].speed = {-0.004, 0, 0.003};
        if (seed != 0) table.camera_speed = {0.01, 0, -0.003};
        const Changes changes = changes_of(table, short_sweeps ? 8 : 20, 1);
        EXPECT_LE(changes.mean, 3);
    }
}

/// All that is found of some frames of a clip that moves, of which some are left out.
class HashedClip {
public:
    HashedClip() {
        table_.things[3].speed = {0.01, 0, 0};
        table_.camera_speed = {-0.006, 0, 0};
        for (const int n : {0, 1, 2, 3, 9, 10}) frames_.push_back(generate(table_, n));
    }
    std::uint64_t hash(int threads) const {
        Segmenter segmenter(table_.scene(), threads);
        ByteHash hash;
        for (std::size_t n = 0; n < frames_.size(); ++n) {
            const bool follows = n != 0 && n != 4;
            const Segmentation& found = segmenter.next(frames_[n].raw(), follows);
            hash.add(found.labels.data(), 2 * found.labels.size());
            for (const Segment& segment : found.segments) {
                const std::array<std::int32_t, 8> figures{
                    segment.label,    segment.pixels,    segment.x,         segment.y,
                    segment.contrast, segment.colour[0], segment.colour[1], segment.colour[2]};
                hash.add(figures.data(), sizeof figures);
            }
        }
        return hash.value();
    }

private:
    GeneratedTable table_ = random_table(11);
    std::vector<GeneratedFrame> frames_;
};

/// Of GCC, Clang, with and without optimisation, and with any number of threads.
TEST(Segmenter, HasTheSameBitsEverywhere) {
    const HashedClip clip;
    for (const int threads : {1, 2, 4}) EXPECT_EQ(clip.hash(threads), 14712688257145656365U) << threads;
}

/// After a cut things that are where they were, and look as they did, have the labels that they had.
TEST(Segmenter, KnowsThingsAgainAfterACut) {
    GeneratedTable table = random_table(3), other = random_table(4);
    Segmenter segmenter(table.scene());
    const GeneratedFrame frame = generate(table, 0), later = generate(table, 1), cut = generate(other, 0);
    const std::vector<std::uint16_t> before = segmenter.next(frame.raw(), false).labels;
    segmenter.next(cut.raw(), false);
    const std::vector<std::uint16_t>& after = segmenter.next(later.raw(), false).labels;
    std::size_t same = 0;
    for (std::size_t k = 0; k < before.size(); ++k) same += before[k] == after[k] ? 1U : 0U;
    EXPECT_GE(same * 100, before.size() * 97);
}

/// Somebody draws the curtains: things do not look as they did, but are where they were.
TEST(Segmenter, KeepsLabelsWhereTheLightChanges) {
    const GeneratedTable table = random_table(3);
    Segmenter segmenter(table.scene());
    GeneratedFrame frame = generate(table, 0);
    const std::vector<std::uint16_t> before = segmenter.next(frame.raw(0), false).labels;
    for (std::uint8_t& sample : frame.colour) sample = static_cast<std::uint8_t>(sample / 2);
    const std::vector<std::uint16_t>& after = segmenter.next(frame.raw(1), true).labels;
    std::size_t same = 0;
    for (std::size_t k = 0; k < before.size(); ++k) same += before[k] == after[k] ? 1U : 0U;
    EXPECT_GE(same * 100, before.size() * 97);
}

// Segments of pictures of any size, without colour, without depth, and with holes.

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
