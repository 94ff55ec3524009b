#include "bench/loop/stability.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace touchable {
namespace {

constexpr double period = ClosedLoop::period_s;

class Stability : public testing::Test {
protected:
    Stability() {
        loop.touch.scene = "plane";
        loop.touch.width = 96;
        loop.touch.height = 64;
        loop.touch.bits = TouchCase::exact;
    }
    double boundary() {
        auto made = TouchSurface::make(loop.touch);
        EXPECT_TRUE(made);
        const TouchSurface& surface = **made;
        const auto found = stability_boundary(surface, loop, pressed_place(surface, 51, 30));
        EXPECT_TRUE(found) << (found ? "" : found.error().message);
        return found ? *found : 0;
    }
    LoopCase loop;
};

/// Of a mass with viscous loss before a sampled and held spring: the stiffness at which the determinant of
/// its step becomes 1 (Jury's criterion; the others do not bind here).
double jury_boundary(double mass, double damping) {
    const double tau = mass / damping, a = std::exp(-period / tau);
    const double place_gain = tau / mass * (period - tau * (1 - a)), speed_gain = tau / mass * (1 - a);
    return (1 - a) / (speed_gain * tau * (1 - a) - place_gain * a);
}

TEST_F(Stability, OfAFlatWallEndsWhereJuryAndColgateSay) {
    for (const double damping : {1.0, 5.0, 20.0})
        for (const double mass : {0.2, 0.5}) {
            loop.handle.damping = damping;
            loop.handle.mass = mass;
            const double found = boundary(), exact = jury_boundary(mass, damping);
            EXPECT_NEAR(found / exact, 1, 0.03) << damping << " N s/m, " << mass << " kg";
            EXPECT_NEAR(exact / colgate_schenkel_bound(loop.handle), 1, 0.05);
        }
}

TEST_F(Stability, ShrinksWithDelayAsGilSays) {
    loop.handle.damping = 5;
    for (const int delay : {0, 1, 2, 4}) {
        loop.delay_ticks = delay;
        EXPECT_NEAR(boundary() / gil_bound(loop.handle, delay), 1, 0.05) << delay << " ticks";
    }
}

TEST_F(Stability, NeedsFrictionWhereReadingsAreQuantised) {
    loop.handle.damping = 5;
    loop.handle.quantum = 60e-6;
    const double without = boundary();
    EXPECT_LT(without, 0.5 * colgate_schenkel_bound(loop.handle)) << "it shakes by a quantum for ever";
    for (const double friction : {0.1, 0.3}) {
        loop.handle.friction = friction;
        EXPECT_GE(boundary(), abbott_okamura_bound(loop.handle)) << friction << " N";
    }
}

TEST_F(Stability, IsFoundOnASurfaceThatMoves) {
    loop.touch.scene = "moving";
    loop.touch.width = 80;
    loop.touch.height = 60;
    loop.handle.damping = 5;
    EXPECT_NEAR(boundary() / colgate_schenkel_bound(loop.handle), 1, 0.2);
}

TEST_F(Stability, FatesAreToldApart) {
    auto made = TouchSurface::make(loop.touch);
    ASSERT_TRUE(made);
    const PressedPlace place = pressed_place(**made, 51, 30);
    const double wall = colgate_schenkel_bound(loop.handle);
    EXPECT_EQ(fate_of(**made, loop, place, 0.8 * wall).value(), LoopFate::rests);
    EXPECT_EQ(fate_of(**made, loop, place, 1.2 * wall).value(), LoopFate::shakes);
    loop.handle.quantum = 0.01;  // read as 0 or 10 mm: it rests between, above the surface
    loop.handle.friction = 5;
    EXPECT_EQ(fate_of(**made, loop, place, 10'000).value(), LoopFate::leaves);
}

TEST(StabilityTheory, Bounds) {
    HandleDynamics handle;
    handle.damping = 5;
    EXPECT_DOUBLE_EQ(colgate_schenkel_bound(handle), 10'000);
    EXPECT_DOUBLE_EQ(gil_bound(handle, 0), 10'000);
    EXPECT_DOUBLE_EQ(gil_bound(handle, 1), 5 / 0.0015);
    EXPECT_DOUBLE_EQ(abbott_okamura_bound(handle), 10'000);
    handle.quantum = 60e-6;
    handle.friction = 0.3;
    EXPECT_DOUBLE_EQ(abbott_okamura_bound(handle), 10'000);
    handle.friction = 0.15;
    EXPECT_DOUBLE_EQ(abbott_okamura_bound(handle), 5'000);
}

}  // namespace
}  // namespace touchable
