// Friction that falls with speed, against its formula and against plain Coulomb friction at both ends.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "haptics_cpu/slide.hpp"
#include "tests/haptics/small_field.hpp"

namespace touchable::test {
namespace {

constexpr double mu_s = 0.5, mu_d = 0.3;

/// A flat wall at 100, and strokes over it 1 mm deep.
class Stribeck : public testing::Test {
protected:
    Stribeck() : wall(129, 33, 100.0, DepthSemantics::planar) {
        wall.scene.default_properties = {1000, mu_s, mu_d};
    }
    /// Where the proxy is (mm), tick by tick, for a goal at x(0), x(1), ...
    std::vector<double> follow(const std::vector<double>& goals, double stribeck_speed) {
        TouchSettings settings;
        settings.stribeck_speed = stribeck_speed;
        FingerState finger;
        wall.touch(finger, {goals[0], 0.1, -99}, 0, settings);
        std::vector<double> places;
        for (const double x : goals)
            places.push_back(wall.touch(finger, {x, 0.1, -101}, 0, settings).proxy.x);
        return places;
    }
    /// To the right at a steady speed (m/s is mm per tick), from `from`.
    static std::vector<double> steady(double from, double speed, int ticks) {
        std::vector<double> goals;
        for (int k = 0; k < ticks; ++k) goals.push_back(from + speed * k);
        return goals;
    }

    SmallField wall;
};

TEST_F(Stribeck, AtASteadySpeedFrictionIsThatOfTheFormula) {
    for (const double speed : {0.05, 0.2, 0.4}) {
        const double v_s = 0.2, mu = mu_d + (mu_s - mu_d) / (1 + (speed / v_s) * (speed / v_s));
        const int ticks = static_cast<int>(20 / speed);
        const auto goals = steady(-10, speed, ticks);
        const auto places = follow(goals, v_s);
        const auto last = static_cast<std::size_t>(ticks - 1);
        EXPECT_NEAR(goals[last] - places[last], mu, 1e-6) << speed;
    }
}

/// docs/solver.md, Friction.
TEST_F(Stribeck, HalfOfStaticFrictionIsLeftAtItsSpeedAndSlowIsATenthOfIt) {
    for (const double v_s : {0.01, 0.2}) {
        EXPECT_NEAR(stribeck_slip(v_s, v_s).static_share, 0.5, 1e-15);
        EXPECT_NEAR(stribeck_slip(3 * v_s, v_s).static_share, 0.1, 1e-15);
        EXPECT_EQ(stribeck_slip(0, v_s).static_share, 1);
        EXPECT_TRUE(is_slow(0.099 * v_s, v_s));
        EXPECT_FALSE(is_slow(0.101 * v_s, v_s));
    }
}

TEST_F(Stribeck, ASmallSpeedMakesItCoulombsOneTickAfterTheSlip) {
    const auto goals = steady(-3, 0.02, 300);
    const auto places = follow(goals, 1e-9), coulomb = follow(goals, 0);
    std::size_t slip = 0;
    while (coulomb[slip] == coulomb[0]) ++slip;
    ASSERT_GT(slip, 20U);
    for (std::size_t k = 0; k < goals.size(); ++k) {
        if (k == slip) continue;  // it slips at no speed, and so with mu static
        EXPECT_NEAR(places[k], coulomb[k], 1e-9) << k;
    }
}

TEST_F(Stribeck, ALargeSpeedLeavesStaticFrictionAlone) {
    std::vector<double> goals = steady(-3, 0.02, 200);
    for (int k = 0; k < 200; ++k) goals.push_back(goals.back() - 0.03);
    const auto places = follow(goals, 1e9);
    wall.scene.default_properties.dynamic_friction = mu_s;
    EXPECT_EQ(places, follow(goals, 0));
}

TEST_F(Stribeck, SticksAgainOnlyOnceItIsSlow) {
    // Dragged at 0.2 m/s, then held still: friction grows as the filtered speed falls, and the proxy may
    // stay.
    std::vector<double> goals = steady(-3, 0.2, 20);
    const double still = goals.back();
    for (int k = 0; k < 100; ++k) goals.push_back(still);
    const auto rested = follow(goals, 0.05);
    EXPECT_EQ(rested.back(), rested[20]) << "nothing pulls it on";
    // From there to within the static cone at once: held if it has rested long enough, dragged on if not.
    for (const std::size_t rest : {std::size_t{1}, std::size_t{30}}) {
        std::vector<double> pulled(goals.begin(), goals.begin() + 20 + static_cast<std::ptrdiff_t>(rest));
        pulled.push_back(rested.back() + 0.49);
        const double moved = follow(pulled, 0.05).back() - rested.back();
        if (rest == 1)
            EXPECT_GT(moved, 0.01);
        else
            EXPECT_EQ(moved, 0);
    }
}

TEST_F(Stribeck, ASurfaceThatMovesDoesNotCountAsSlip) {
    wall.fill(wall.next, 90.0);
    TouchSettings settings;
    settings.stribeck_speed = 0.05;
    FingerState finger;
    wall.touch(finger, {2, 0.1, -99}, 0, settings);
    for (int k = 0; k < 50; ++k) {
        const double blend = 0.01 * k, depth = 100 - 10 * blend;
        // The goal goes along on the proxy's ray: the wall's motion is all there is.
        ASSERT_TRUE(
            wall.touch(finger, {2 * depth / 100, 0.1 * depth / 100, -depth - 1}, blend, settings).touching);
        EXPECT_LT(finger.slip_speed, 1e-9) << k;
    }
}

TEST_F(Stribeck, RefusesASpeedThatIsNone) {
    for (const double speed : {-1.0, std::nan(""), HUGE_VAL}) {
        TouchSettings settings;
        settings.stribeck_speed = speed;
        const auto made = TouchSolver::create(wall.scene, settings);
        ASSERT_FALSE(made);
        EXPECT_NE(made.error().message.find("Stribeck"), std::string::npos);
    }
}

}  // namespace
}  // namespace touchable::test
