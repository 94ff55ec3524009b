// What the front view tells of a finger: how near the surface is, how hard it is pressed, how the surface
// gives way. By the figures of docs/drawing.md, on pictures of the window, whose plane is seen from the
// front: there the force's arrow is a point.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "engine/picture/image.hpp"
#include "tests/player/program.hpp"
#include "tests/window/scripted_window.hpp"

namespace touchable::test {
namespace {

constexpr int width = 1280, height = 720, middle_x = 640, middle_y = 360;
/// Of a finger, pixels: 2 % of the 1080 pixels that the plane is wide there; on this plane 4 mm of the hand.
constexpr double radius = 21.6;

/// What the window shows, once a finger has come there from the camera, with it over the middle of a plane of
/// 0.6 N/mm, `deeper` mm from where it rests at first, 4 mm before it.
Image picture_of(const std::string& deeper, const std::vector<std::string>& more = {}) {
    static const TemporaryFolder folder;
    const std::string clip = (folder / "plane.mkv").string();
    if (!std::filesystem::exists(clip)) {
        const auto made = run_touchable({"make", "plane", clip, "--tilt", "0", "--frames", "1"});
        EXPECT_EQ(made.code, 0) << made.err;
    }
    std::vector<std::string> words{clip, "--painter", "raster"};
    words.insert(words.end(), more.begin(), more.end());
    return played_by(words, "0 move 640 360\n0.1 deeper " + deeper + "\n", "3.6", "1280x720").image;
}

/// Of a place beside the finger's middle, y downward.
int channel_at(const Image& image, double x, double y, int channel) {
    const int i = middle_x + static_cast<int>(std::lround(x)),
              j = middle_y + static_cast<int>(std::lround(y));
    return image.samples[static_cast<std::size_t>((j * image.width + i) * 3 + channel)];
}

/// What is left there of the plane's light, 1: all of it.
double light_left(const Image& image, double x, double y) {
    const auto light = [](int byte) {
        const double share = byte / 255.0;
        return share <= 0.04045 ? share / 12.92 : std::pow((share + 0.055) / 1.055, 2.4);
    };
    // As far from the middle on the other side of the picture's middle line, for the clay's own shade.
    return light(channel_at(image, x, y, 1)) / light(channel_at(image, 300, y, 1));
}
/// Of the brightness, once the gloss of what is lighter is taken away: 0.2 (left - 1) of 255.
double brightness_left(const Image& image, double x, double y) {
    const double flat = channel_at(image, 300, y, 1), left = channel_at(image, x, y, 1) / flat;
    const double gloss = 0.2 * 255 / flat;
    return left > 1 ? (left + gloss) / (1 + gloss) : left;
}

/// Clay is never that blue: that is the ring.
bool is_ring(const Image& image, double angle, double distance) {
    return channel_at(image, distance * std::sin(angle), -distance * std::cos(angle), 2) > 215;
}

/// Of the ring, 12 degrees to the right of straight up, pixels; 0: there is none.
double ring_of(const Image& image) {
    constexpr double angle = 0.21;
    const auto blue_at = [&](double distance) {
        return channel_at(image, distance * std::sin(angle), -distance * std::cos(angle), 2);
    };
    int most = channel_at(image, 300, 0, 2) + 30;
    for (double distance = radius + 2; distance < 60; distance += 0.25)
        most = std::max(most, blue_at(distance));
    double sum = 0;
    int count = 0;
    for (double distance = radius + 2; distance < 60; distance += 0.25) {
        if (blue_at(distance) < most - 10) continue;
        sum += distance;
        ++count;
    }
    return count > 0 ? sum / count : 0;
}

/// How much of a turn is drawn strongly, clockwise from straight up.
double strong_share(const Image& image) {
    const double ring = ring_of(image);
    int strong = 0;
    constexpr int steps = 360;
    for (int k = 0; k < steps; ++k) strong += is_ring(image, 2 * std::numbers::pi * (k + 0.5) / steps, ring);
    return strong / static_cast<double>(steps);
}

TEST(FrontView, HalfAMillimetreAndFourAboveTheSurfaceDiffer) {
    const Image far = picture_of("0"), near = picture_of("3.5");
    EXPECT_NEAR(ring_of(far), 1.95 * radius, 1.5);
    EXPECT_NEAR(ring_of(near), 1.6 * radius, 1.5);
    // The shadow: to the lower right, wide and faint; then below the finger, and dark.
    EXPECT_NEAR(light_left(far, 20, 23), 0.66, 0.03);
    EXPECT_NEAR(light_left(far, 45, 50), 0.94, 0.03);
    EXPECT_NEAR(light_left(far, -20, -20), 1.00, 0.03);
    EXPECT_NEAR(light_left(near, 20, 23), 0.90, 0.03);
    EXPECT_NEAR(light_left(near, 45, 50), 1.00, 0.02);
    EXPECT_NEAR(light_left(near, -20, -20), 0.98, 0.03);
}

TEST(FrontView, OneNewtonAndThreeDiffer) {
    // 1.667 and 5 mm into 0.6 N/mm.
    const Image one = picture_of("5.667"), three = picture_of("9");
    EXPECT_NEAR(ring_of(one), 1.46 * radius, 1.5);
    EXPECT_NEAR(ring_of(three), 1.28 * radius, 1.5);
    // Of a limit of 10 N.
    EXPECT_NEAR(strong_share(one), 0.1, 0.02);
    EXPECT_NEAR(strong_share(three), 0.3, 0.02);
    // The dent, three quarters of its reach above the middle and below: 1.667 mm deep, and as deep as is
    // drawn.
    EXPECT_NEAR(brightness_left(one, 0, -42), 0.817, 0.03);
    EXPECT_NEAR(brightness_left(one, 0, 42), 1.157, 0.03);
    EXPECT_NEAR(brightness_left(three, 0, -42), 0.532, 0.03);
    EXPECT_NEAR(brightness_left(three, 0, 42), 1.299, 0.03);
}

/// From aside the arrow crosses it. At its limit all of the ring is white.
TEST(FrontView, TheRingIsWholeOverTheArrow) {
    const Image turned = picture_of("9\n0.2 max-force 1\n0.3 turn -70");
    const auto least_at = [&](double x, double y) {
        int least = 255;
        for (int channel = 0; channel < 3; ++channel)
            least = std::min(least, channel_at(turned, x, y, channel));
        return least;
    };
    // Friction holds the finger beside the middle.
    int left = 60, right = -60;
    for (int x = -60; x <= 60; ++x) {
        if (least_at(x, 0) < 225) continue;
        left = std::min(left, x);
        right = std::max(right, x);
    }
    const double ring = (right - left) / 2.0, middle = (right + left) / 2.0;
    ASSERT_NEAR(ring, 1.1 * radius, 3);
    const double beyond = middle + ring + 8;
    EXPECT_GT(channel_at(turned, beyond, 0, 2) - channel_at(turned, beyond, 0, 0), 100) << "no arrow";
    for (int degrees = 0; degrees < 360; degrees += 5) {
        const double angle = degrees * std::numbers::pi / 180;
        int most = 0;
        for (double distance = ring - 3; distance <= ring + 3; distance += 0.5)
            most = std::max(most, least_at(middle + distance * std::sin(angle), -distance * std::cos(angle)));
        EXPECT_GT(most, 200) << degrees;
    }
}

TEST(FrontView, DentIsSwitchedOffByOptionAndByCommand) {
    const Image off = picture_of("9", {"--dent", "off"}), told = picture_of("9\n0.2 dent off"),
                again = picture_of("9\n0.2 dent off\n0.3 dent on");
    for (const Image* flat : {&off, &told}) {
        EXPECT_NEAR(brightness_left(*flat, 0, -42), 1, 0.01);
        EXPECT_NEAR(brightness_left(*flat, 0, 42), 1, 0.01);
        EXPECT_NEAR(ring_of(*flat), 1.28 * radius, 1.5) << "the ring has nothing to do with it";
    }
    EXPECT_NEAR(brightness_left(again, 0, -42), 0.532, 0.03);
}

TEST(FrontView, AnOverlayKeepsItsColoursUnderAFinger) {
    const Image depth = picture_of("9\n0.2 overlay stiffness");
    EXPECT_NEAR(brightness_left(depth, 0, -42), 1, 0.01);
    EXPECT_NEAR(brightness_left(depth, 0, 42), 1, 0.01);
}

}  // namespace
}  // namespace touchable::test
