#include "device/hand.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "tests/device/fake_probe.hpp"

namespace touchable {
namespace {

/// Of a plane at 800 mm; a millimetre of the scene is one of the device.
class WatchedGoals : public ::testing::Test {
protected:
    void look(int times, const glm::dvec3& goal) {
        for (int time = 0; time < times; ++time) {
            glm::dvec3 looked_at = goal;
            watch.look(probe, std::span(&looked_at, 1));
            EXPECT_TRUE(looked_at == goal || goal != goal) << "it stays";
        }
    }
    glm::dvec3 below(double millimetres) const { return probe.unproject(320, 240, 800 + millimetres); }
    glm::dvec3 at(double x, double y) const { return probe.unproject(x, y, 800); }

    const FakeProbe probe = flat_view(800);
    GoalWatch watch{0.001, std::nullopt};
    const std::vector<std::string> far_below{
        "1.0 % of the goals lie more than 10 mm below the surface; depth=MM among the hand's keys raises "
        "them"};
    const std::vector<std::string> outside{
        "1.0 % of the goals lie outside the picture, where there is only the wall around it"};
};

TEST_F(WatchedGoals, FarBelowIsMoreThanTenMillimetres) {
    look(100, below(9.9));
    EXPECT_TRUE(watch.remarks().empty());
    look(1, below(10.1));
    EXPECT_TRUE(watch.remarks().empty()) << "one of 101 is less than 1 %";
    look(1, below(10.1));
    look(98, below(-50));
    EXPECT_EQ(watch.remarks(), far_below) << "two of 200";
}

TEST_F(WatchedGoals, ThePicturesEdgeIsInIt) {
    look(96, at(320, 240));
    for (const auto& [x, y] : {std::pair{0, 0}, {639, 0}, {0, 479}, {639, 479}}) look(25, at(x, y));
    EXPECT_TRUE(watch.remarks().empty());
}

TEST_F(WatchedGoals, WhatIsBesideThePictureOrBehindTheCameraOrNowhereIsOutside) {
    constexpr double nowhere = std::numeric_limits<double>::quiet_NaN();
    for (const glm::dvec3& goal : {at(-0.5, 240), at(639.5, 240), at(320, -0.5), at(320, 479.5),
                                   glm::dvec3(0, 0, 5), glm::dvec3(0, 0, 0), glm::dvec3(nowhere)}) {
        watch = GoalWatch(0.001, std::nullopt);
        look(99, at(320, 240));
        look(1, goal);
        EXPECT_EQ(watch.remarks(), outside) << goal.x << ' ' << goal.y << ' ' << goal.z;
    }
}

}  // namespace
}  // namespace touchable
