// What haptic pictures ask of a device.
#include "engine/authoring/quality_estimators.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <random>

#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

constexpr int columns = 100, rows = 10;

class HapticValuesOf : public ::testing::Test {
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
        HapticValuesEstimator estimator(scene);
        estimator.add(frame, &where);
        return estimator.values();
    }
    static std::int64_t marked(const std::vector<std::uint8_t>& marks) {
        return std::count(marks.begin(), marks.end(), 1);
    }

    ClipQuality::Where::Haptic where;
};

TEST_F(HapticValuesOf, SharesAreThoseOfThePicture) {
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

TEST_F(HapticValuesOf, AreasAndSmoothChangesAreNotMixed) {
    EXPECT_EQ(values([](int x, int) { return std::array{x, 255 - x, 30}; }).mixed, 0);
    EXPECT_EQ(values([](int x, int) { return std::array{x / 10 * 20, 100, 30}; }).mixed, 0);
}

TEST_F(HapticValuesOf, NoiseOfACodecIsMixed) {
    std::minstd_rand random(3);
    const ClipQuality::HapticValues found = values([&](int, int) {
        const int noise = static_cast<int>(random() / 16 % 5);
        return std::array{100 + noise, 120 - noise, 60};
    });
    EXPECT_GT(found.mixed, 0.1);  // five times what is told of
    EXPECT_EQ(marked(where.mixed), static_cast<std::int64_t>(found.mixed * columns * rows + 0.5));
}

}  // namespace
}  // namespace touchable::test
