// SPDX-License-Identifier: Apache-2.0
// Where edges of colour are, against edges of depth that are known.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <random>
#include <vector>

#include "engine/authoring/recorded_clip.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/must.hpp"

namespace touchable::test {
namespace {

constexpr int width = 640, height = 480;

class FramesOf : public OwnClip {
public:
    FramesOf(const Scene& scene, std::vector<RawFrame> frames) : OwnClip(scene), frames_(std::move(frames)) {}
    Result<std::optional<RawFrame>> next() override {
        if (number_ == std::ssize(frames_)) return std::optional<RawFrame>();
        return std::optional(frames_[static_cast<std::size_t>(number_++)]);
    }

private:
    const std::vector<RawFrame> frames_;
};

ClipQuality quality_of(const Scene& scene, std::vector<RawFrame> frames) {
    FramesOf clip(scene, std::move(frames));
    return must(measure_quality(clip, scene, [](std::int64_t) {}));
}

/// Boxes before a wall. Their colour is moved, and smaller or larger than they are.
class ColourEdgeFit : public ::testing::Test {
protected:
    /// `x`, `y`: 0 or more. `uneven_`: each is at another place of its square of 80 pixels, of
    /// another size.
    bool in_box(int x, int y, int larger = 0) const {
        const int square = x / 80 + 10 * (y / 80);
        const int column = x % 80 - (uneven_ ? 31 * square % 29 - 10 : 0);
        const int row = y % 80 - (uneven_ ? 17 * square % 29 - 10 : 0);
        const int end = (uneven_ ? 44 + 13 * square % 17 : 50) + larger;
        return column >= 20 - larger && column < end && row >= 20 - larger && row < end;
    }
    ClipQuality::ColourFit fit(int right, int below, int colour_larger, bool with_shadow = false) {
        depth_.clear();
        colour_.clear();
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const bool shadow = with_shadow && !in_box(x + 80, y + 80) && in_box(x + 87, y + 80);
                depth_.push_back(shadow ? invalid : in_box(x + 80, y + 80) ? 200 : 60);
                const int larger = colour_larger + (x / 80 % 3 == 0 ? some_larger_ : 0);
                const bool is_red = in_box(x - right + 80, y - below + 80, larger);
                const int noise = (x * 7 + y * 13) % 11;
                for (const int channel : {is_red ? 190 : 40, 60, is_red ? 30 : 170})
                    colour_.push_back(static_cast<std::uint8_t>(channel + noise));
            }
        RawFrame frame;
        frame.depth = {depth_.data(), width, width, height, 1, 1};
        frame.colour = {colour_.data(), 3 * width, width, height, 1, 3};
        Scene scene = small_scene(width, height);
        scene.depth.invalid_codes[0] = invalid;
        scene.depth.invalid_code_count = 1;
        derive_valid_range(scene.depth);
        const ClipQuality found = quality_of(scene, {frame});
        where = found.where.colour_edges;
        EXPECT_TRUE(found.colour);
        return found.colour.value_or(ClipQuality::ColourFit{});
    }
    /// Of colour that is shifted alone.
    void expect_fit(int right, int below) {
        const auto fitted = fit(right, below, 0);
        EXPECT_NEAR(fitted.right.value_or(9), right, 0.01);
        EXPECT_NEAR(fitted.below.value_or(9), below, 0.01);
        EXPECT_NEAR(fitted.rim, 0, 0.51);
    }

    static constexpr std::uint8_t invalid = 0;
    bool uneven_ = false;
    int some_larger_ = 0;  ///< the colour of three boxes in eight, than that of the others
    std::vector<std::uint8_t> depth_, colour_, where;
};

TEST_F(ColourEdgeFit, IsZeroForRegisteredPictures) {
    expect_fit(0, 0);
    EXPECT_EQ(std::count(where.begin(), where.end(), 1), 0);
}

TEST_F(ColourEdgeFit, MeasuresShift) {
    expect_fit(3, -2);
    EXPECT_GT(std::count(where.begin(), where.end(), 1), 500);
}

TEST_F(ColourEdgeFit, TellsRimFromShift) {
    const auto narrow = fit(-2, 0, -3);
    EXPECT_NEAR(narrow.right.value_or(9), -2, 0.01);
    EXPECT_NEAR(narrow.rim, 3, 0.51);
}

TEST_F(ColourEdgeFit, RimIsNegativeBeyondSurface) {
    const auto fitted = fit(0, 1, 2);
    EXPECT_NEAR(fitted.below.value_or(9), 1, 0.01);
    EXPECT_NEAR(fitted.rim, -2, 0.51);
}

TEST_F(ColourEdgeFit, DisagreesForDistantColour) {
    uneven_ = true;
    EXPECT_TRUE(fit(3, -2, 0).agrees());
    for (const auto& [right, below] : {std::pair{30, 0}, {-30, 0}, {0, -30}}) {
        const auto fitted = fit(right, below, 0);
        EXPECT_FALSE(fitted.agrees()) << right << ' ' << below << ": " << fitted.agreement;
    }
}

TEST_F(ColourEdgeFit, AgreesWithinTwoPixels) {
    for (const int larger : {-3, -2, 2, 3}) {
        some_larger_ = larger;
        const double lines = 30 + 2 * std::min(larger, 0);  // that meet both edges of a box and of its colour
        const double agreement = std::abs(larger) <= 2 ? 1 : 5 * 30 / (5 * 30 + 3 * lines);
        EXPECT_DOUBLE_EQ(fit(0, 0, 0).agreement, agreement) << larger;
    }
}

TEST_F(ColourEdgeFit, IgnoresShadowWithoutDepth) {
    const auto fitted = fit(2, 0, 0, true);
    EXPECT_NEAR(fitted.right.value_or(9), 2, 0.01);
}

TEST_F(ColourEdgeFit, IsEmptyWithoutEdges) {
    const std::vector<std::uint8_t> depth(width * height, 100), colour(3 * width * height, 100);
    RawFrame frame;
    frame.depth = {depth.data(), width, width, height, 1, 1};
    frame.colour = {colour.data(), 3 * width, width, height, 1, 3};
    RawFrame pixel = frame;
    pixel.depth.width = pixel.depth.height = pixel.colour.width = pixel.colour.height = 1;
    EXPECT_FALSE(quality_of(small_scene(width, height), {frame, pixel}).colour);
}

// How frames follow each other.

/// A frame of one pixel of depth and one of colour.
RawFrame frame_at(std::int64_t number, std::int64_t ms, int depth, int colour = 0) {
    const auto d = static_cast<std::uint8_t>(depth), c = static_cast<std::uint8_t>(colour);
    auto bytes = std::make_shared<std::array<std::uint8_t, 4>>(std::array{d, c, c, c});
    RawFrame frame;
    frame.number = number;
    frame.time_ns = ms * 1000000;
    frame.depth = {bytes->data(), 1, 1, 1, 1, 1};
    frame.colour = {bytes->data() + 1, 3, 1, 1, 1, 3};
    frame.storage = bytes;
    return frame;
}

/// Of frames 33 ms apart.
ClipQuality::FrameTimes times_of(
    int frames, const std::function<int(int)>& depth,
    const std::function<int(int)>& colour = [](int) { return 0; }) {
    std::vector<RawFrame> all;
    for (int k = 0; k < frames; ++k) all.push_back(frame_at(k, 33 * k, depth(k), colour(k)));
    return quality_of(small_scene(1, 1), all).times;
}

TEST(FrameTimes, HaveNoFaultWhenEven) {
    const ClipQuality::FrameTimes times = times_of(20, [](int k) { return k; });
    EXPECT_EQ(times.frames, 20);
    EXPECT_EQ(times.repeated, 0);
    EXPECT_EQ(times.missing, 0);
    EXPECT_EQ(times.jumps, 0);
    EXPECT_EQ(times.usual_ms, 33);
}

TEST(FrameTimes, CountRepeatedDepth) {
    const auto twice = [](int k) { return k / 2; };
    const auto slow = times_of(20, twice, [](int k) { return k / 4; });
    EXPECT_EQ(slow.repeated, 8);       // not the first and the last, which are not between changes
    EXPECT_EQ(slow.of_new_colour, 0);  // colour changes with every fourth, when depth does
    EXPECT_EQ(times_of(20, twice, [](int k) { return k; }).of_new_colour, 8);
}

TEST(FrameTimes, LongStillnessIsNotRepetition) {
    // Moves, stands still for ten frames, moves on.
    const auto times = times_of(30, [](int k) { return k < 10 || k >= 20 ? k : 10; });
    EXPECT_EQ(times.repeated, 0);
    EXPECT_EQ(times.changed, 20);
    EXPECT_EQ(times_of(30, [](int) { return 7; }).repeated, 0);
}

TEST(FrameTimes, CountGapsAndJumps) {
    std::vector<RawFrame> frames;
    std::int64_t ms = 0;
    for (int k = 0; k < 20; ++k) {
        ms += k == 5 ? 132 : k == 9 ? 0 : k == 12 ? 66 : 33;
        frames.push_back(frame_at(k, ms, k));
    }
    const ClipQuality::FrameTimes times = quality_of(small_scene(1, 1), frames).times;
    EXPECT_EQ(times.missing, 3 + 1);
    EXPECT_EQ(times.jumps, 1);
    EXPECT_EQ(times.longest_ms, 132);
    EXPECT_EQ(times.longest_at, 5);
}

TEST(FrameTimes, AreZeroForOneFrame) {
    EXPECT_EQ(quality_of(small_scene(1, 1), {}).times.frames, 0);
    EXPECT_EQ(quality_of(small_scene(1, 1), {frame_at(0, 0, 1)}).times.usual_ms, 0);
}

// What haptic pictures need of a device.

constexpr int columns = 100, rows = 10;

class HapticPictureValues : public ::testing::Test {
protected:
    ClipQuality::HapticValues values(const std::function<std::array<int, 3>(int, int)>& rgb) {
        Scene scene = small_scene(columns, rows);
        scene.haptic = {{0, 10}, {0, 1}, {0, 1}};
        std::vector<std::uint8_t> depth(columns * rows, 100), haptic;
        for (int y = 0; y < rows; ++y)
            for (int x = 0; x < columns; ++x)
                for (const int value : rgb(x, y)) haptic.push_back(static_cast<std::uint8_t>(value));
        RawFrame frame;
        frame.depth = {depth.data(), columns, columns, rows, 1, 1};
        frame.haptic = {haptic.data(), 3 * columns, columns, rows, 1, 3};
        const ClipQuality found = quality_of(scene, {frame});
        where = found.where.haptic;
        return found.haptic.value();
    }
    static std::int64_t marked(const std::vector<std::uint8_t>& marks) {
        return std::count(marks.begin(), marks.end(), 1);
    }

    ClipQuality::Where::Haptic where;
};

TEST_F(HapticPictureValues, AreSharesOfPicture) {
    const ClipQuality::HapticValues found = values([](int x, int) {
        return std::array{x < 25 ? 255 : 51, 100, x < 10 ? 200 : 50};
    });
    EXPECT_DOUBLE_EQ(found.stiffest, 10);
    EXPECT_DOUBLE_EQ(found.too_stiff, 0.25);
    EXPECT_DOUBLE_EQ(found.more_dynamic, 0.1);
    EXPECT_DOUBLE_EQ(found.mixed, 0);
    EXPECT_EQ(marked(where.too_stiff), 25 * rows);
    EXPECT_EQ(marked(where.more_dynamic), 10 * rows);
}

TEST_F(HapticPictureValues, GradientsAreNotMixed) {
    EXPECT_EQ(values([](int x, int) { return std::array{x, 255 - x, 30}; }).mixed, 0);
    EXPECT_EQ(values([](int x, int) { return std::array{x / 10 * 20, 100, 30}; }).mixed, 0);
}

TEST_F(HapticPictureValues, CodecNoiseIsMixed) {
    std::minstd_rand random(3);
    const ClipQuality::HapticValues found = values([&](int, int) {
        const int noise = static_cast<int>(random() / 16 % 5);
        return std::array{100 + noise, 120 - noise, 60};
    });
    EXPECT_GT(found.mixed, 0.1);  // five times what is reported
    EXPECT_EQ(marked(where.mixed), static_cast<std::int64_t>(found.mixed * columns * rows + 0.5));
}

// Depth that goes to and fro as a whole.

/// Of a slope whose depth is `scale(k)` times itself in frame k, under an even colour where one is given.
std::optional<double> pumping_of(int frames, const std::function<double(int)>& scale,
                                 const std::function<int(int)>& brightness = {}) {
    constexpr int wide = 64, high = 48;
    Scene scene = small_scene(wide, high);
    DepthCoding& coding = scene.depth = {};
    coding.kind = DepthCodingKind::metric;
    coding.scale = 0.1;
    coding.far = 6000;
    coding.code_max = 65535;
    derive_valid_range(coding);
    struct Planes {
        std::vector<std::uint16_t> codes;
        std::vector<std::uint8_t> colour;
    };
    std::vector<RawFrame> all;
    for (int k = 0; k < frames; ++k) {
        const auto planes = std::make_shared<Planes>();
        for (int pixel = 0; pixel < wide * high; ++pixel)
            planes->codes.push_back(coding.code(scale(k) * (1000 + pixel % wide)));
        RawFrame frame;
        frame.number = k;
        frame.depth = plane_of_codes(planes->codes.data(), wide, high);
        if (brightness) {
            planes->colour.assign(3 * wide * high, static_cast<std::uint8_t>(brightness(k)));
            frame.colour = packed_plane(planes->colour.data(), wide, high, 1, 3);
        }
        frame.storage = planes;
        all.push_back(frame);
    }
    return quality_of(scene, all).pumping;
}

TEST(Pumping, MeasuresRandomScales) {
    std::mt19937 random(7);
    std::vector<double> scales;
    for (int k = 0; k < 400; ++k)
        scales.push_back(1 + 0.01 * (static_cast<double>(random() % 2001) / 1000 - 1));
    const auto share = pumping_of(400, [&](int k) { return scales[static_cast<std::size_t>(k)]; });
    ASSERT_TRUE(share);
    EXPECT_NEAR(*share, 0.01 / std::sqrt(3.0), 0.0006);  // of an even distribution
}

TEST(Pumping, IgnoresStillAndSteadyMotion) {
    EXPECT_LT(pumping_of(30, [](int) { return 1.0; }).value_or(9), 1e-9);
    EXPECT_LT(pumping_of(30, [](int k) { return 1 - 0.01 * k; }).value_or(9), 1e-9);
}

/// A shot of one frame between two of another place.
TEST(Pumping, IgnoresCuts) {
    const auto scale = [](int k) { return k % 6 == 3 ? 1.4 : 1.0; };
    EXPECT_LT(pumping_of(30, scale, [](int k) { return k % 6 == 3 ? 200 : 60; }).value_or(9), 1e-9);
    EXPECT_GT(pumping_of(30, scale, [](int k) { return k % 6 == 3 ? 70 : 60; }).value_or(0), 0.05);
}

TEST(Pumping, NeedsMoreThanThreeFrames) {
    EXPECT_FALSE(pumping_of(1, [](int) { return 1.0; }));
    EXPECT_FALSE(pumping_of(3, [](int k) { return 1.0 + 0.1 * (k % 2); }));
}

}  // namespace
}  // namespace touchable::test
