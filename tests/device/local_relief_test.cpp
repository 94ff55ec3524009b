// What a gliding finger takes its ground for, by the limits of docs/touch.md ("Cliffs, holes and rough
// ground"), on surfaces whose steps, slopes and bends are given.
#include "device/hand_parts.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/device/fake_probe.hpp"

namespace touchable {
namespace {

using Kind = LocalRelief::Kind;

constexpr double usual_reach = 0.0006;        // metres: that of a hand that moves slowly
constexpr double mm_per_pixel = 800 / 500.0;  // of the views below, at their middle

double tangent(double degrees) {
    return std::tan(degrees * std::acos(-1.0) / 180);
}

/// A millimetre of the scene is one of the device. `rise` of a place so many millimetres right of the middle:
/// millimetres towards the camera.
LocalRelief in_the_middle(double reach, const std::function<std::optional<double>(double)>& rise) {
    const FakeProbe probe = camera_view([&rise](double x, double) -> std::optional<double> {
        const auto here = rise((x - 320) * mm_per_pixel);
        return here ? std::optional(800 - *here) : std::nullopt;
    });
    return LocalReliefSearch(reach, 0.001, middle_of(probe, 1)).about({320, 240}, 800, probe);
}

/// A quarter of a millimetre from the finger.
LocalRelief beside_step(double up_mm) {
    return in_the_middle(usual_reach, [up_mm](double right) { return right > 0.25 ? up_mm : 0; });
}

TEST(LocalRelief, AStepOfMoreThanSixMillimetresIsACliff) {
    EXPECT_EQ(beside_step(6.1).kind, Kind::broken);
    EXPECT_EQ(beside_step(-6.1).kind, Kind::broken);
    EXPECT_EQ(beside_step(5.9).kind, Kind::rough);
    EXPECT_EQ(beside_step(-5.9).kind, Kind::rough);
}

TEST(LocalRelief, KnowsTheHighestWithinReach) {
    EXPECT_DOUBLE_EQ(beside_step(6.5).highest, 800 - 6.5);
    EXPECT_DOUBLE_EQ(beside_step(2).highest, 800 - 2);
    EXPECT_EQ(beside_step(-6.5).highest, 800);
}

TEST(LocalRelief, WhatIsBeyondReachIsNotMinded) {
    const auto wall = [](double right) { return right > 0.65 ? 50.0 : 0.0; };
    EXPECT_EQ(in_the_middle(usual_reach, wall).kind, Kind::smooth);
    EXPECT_EQ(in_the_middle(0.0007, wall).kind, Kind::broken);
}

TEST(LocalRelief, AHoleWithinReachIsACliff) {
    const auto hole = [](double right) { return right > 0.25 ? std::nullopt : std::optional(0.0); };
    const LocalRelief local_relief = in_the_middle(usual_reach, hole);
    EXPECT_EQ(local_relief.kind, Kind::broken);
    EXPECT_EQ(local_relief.highest, 800);
}

/// A hand so fast that it looks 8 mm far rises by more than 6 mm on a slope that it may well follow.
TEST(LocalRelief, ASlopeIsACliffFrom65Degrees) {
    for (const double side : {-1.0, 1.0}) {
        const auto slope = [side](double degrees) {
            return [slope = side * tangent(degrees)](double right) { return slope * right; };
        };
        EXPECT_EQ(in_the_middle(0.008, slope(64)).kind, Kind::smooth);
        EXPECT_EQ(in_the_middle(0.008, slope(66)).kind, Kind::broken);
        EXPECT_EQ(in_the_middle(usual_reach, slope(80)).kind, Kind::smooth) << "3.4 mm within reach";
    }
}

/// A fold straight under the finger: what it leaves of the straight line through its sides.
TEST(LocalRelief, AFoldOfATenthOfAMillimetreIsRough) {
    for (const double side : {-1.0, 1.0}) {
        const auto fold = [side](double mm) {
            return [=](double right) { return side * 0.5 * mm * std::fabs(right) / 0.6; };
        };
        EXPECT_EQ(in_the_middle(usual_reach, fold(0.095)).kind, Kind::smooth);
        EXPECT_EQ(in_the_middle(usual_reach, fold(0.105)).kind, Kind::rough);
    }
}

TEST(LocalRelief, ARidgeIsSmoothBelowATenthOfAMillimetreHoweverSharp) {
    const auto ridge = [](double mm) {
        return [=](double right) { return std::fabs(right) > 0.1 ? 0 : 0.5 * mm; };
    };
    EXPECT_EQ(in_the_middle(usual_reach, ridge(0.095)).kind, Kind::smooth);
    EXPECT_EQ(in_the_middle(usual_reach, ridge(0.105)).kind, Kind::rough);
}

TEST(LocalRelief, FartherOffAFoldIsRoughFromTenDegrees) {
    for (const double side : {-1.0, 1.0}) {
        const auto fold = [side](double degrees) {
            return [slope = side * tangent(degrees / 2)](double right) { return slope * std::fabs(right); };
        };
        EXPECT_EQ(in_the_middle(0.0024, fold(9)).kind, Kind::smooth) << "0.38 mm within reach";
        EXPECT_EQ(in_the_middle(0.0024, fold(10)).kind, Kind::rough);
    }
}

TEST(LocalRelief, WhereNoFingerGoesNothingIsMinded) {
    const FakeProbe probe = camera_view([](double x, double) { return x > 320 ? 400.0 : 800.0; });
    const LocalReliefSearch search(usual_reach, 0.001, {{0, 0}, {320, 479}});
    EXPECT_EQ(search.about({320, 240}, 800, probe).kind, Kind::smooth);
}

}  // namespace
}  // namespace touchable
