// Maps of friction that differ within a facet: a slide ends at the first place that holds it, by that place's
// own mu.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "engine/content/seeded_noise.hpp"
#include "tests/haptics/small_field.hpp"
#include "tests/reference/surface.hpp"

namespace touchable::test {
namespace {

using glm::dvec3;
using reference::Real;
using reference::Vec;

/// A wall with cells of 25 x 25 at planar depth 100, friction painted on it; 1000 N/m.
class WideCells : public testing::Test {
protected:
    WideCells() : wall(9, 9, 100.0, DepthSemantics::planar) {
        wall.scene.camera = {4, 4, 4, 4};
        wall.scene.haptic = {{1, 1}, {0, 1}, {0, 1}};
        wall.prev.haptic.assign(3 * 81, 0);
    }
    /// By column, static and dynamic, 0 to 255.
    void paint(int column, int mu_s, int mu_d) {
        for (int y = 0; y < 9; ++y) {
            std::uint8_t* p = &wall.prev.haptic[3 * wall.prev.index(column, y)];
            p[1] = static_cast<std::uint8_t>(mu_s);
            p[2] = static_cast<std::uint8_t>(mu_d);
        }
    }
    /// Column 4 is at x = 0.
    Contact press(double x, double depth) { return wall.touch(finger, {x, 1, -100 - depth}); }
    void land(double x, double depth) {
        press(x, -10);
        press(x, depth);
    }

    SmallField wall;
    FingerState finger;
};

TEST_F(WideCells, ASlideIntoRougherGroundEndsByTheFrictionOfWhereItEnds) {
    paint(5, 255, 255);  // mu = x / 25 to the right of column 4
    land(2, 3);
    ASSERT_EQ(finger.proxy.feature, Feature::face_upper);
    const Contact contact = press(10, 3);
    // 10 - x = 3 x / 25
    EXPECT_NEAR(contact.proxy.x, 10 / (1 + 3 / 25.0), 1e-11);
    EXPECT_NEAR(-contact.force.x / contact.force.z, contact.properties.dynamic_friction, 1e-12);
    EXPECT_NEAR(contact.properties.dynamic_friction, contact.proxy.x / 25, 1e-13);
}

TEST_F(WideCells, ASlideIntoSmootherGroundRunsAwayWhereFrictionFallsFasterThanThePull) {
    paint(4, 255, 255);  // mu = 1 - x / 25
    land(2, 50);         // the load; mu h falls by 2 where the pull falls by 1
    const Contact held = press(2 + 0.9 * 50 * 23 / 25.0, 50);
    EXPECT_NEAR(held.proxy.x, 2, 1e-12);
    // Once it slips, nothing holds it until the way back from the goal: 60 - x = 50 (1 - x / 25) at -10.
    const Contact away = press(60, 50);
    EXPECT_GT(away.proxy.x, 25);
}

TEST_F(WideCells, ASlideEndsAtTheFirstOfSeveralPlacesThatHoldIt) {
    // Rough in a strip between two smooth columns: up to column 5 mu = x / 25, from there it falls again.
    paint(5, 255, 255);
    land(0.5, 30);
    const Contact contact = press(20, 30);
    EXPECT_NEAR(contact.proxy.x, 20 / (1 + 30 / 25.0), 1e-11);
}

TEST_F(WideCells, WhereDynamicIsPaintedAboveStaticTheLesserHolds) {
    // mu_s = x / 25 and mu_d = 1 - x / 25 meet at half-way.
    paint(4, 0, 255);
    paint(5, 255, 0);
    land(1, 8);
    const Contact below = press(10, 8);
    EXPECT_NEAR(below.proxy.x, 10 / (1 + 8 / 25.0), 1e-11) << "by mu_s";
    finger = {};
    land(1, 8);
    const Contact above = press(20, 8);
    EXPECT_NEAR(above.proxy.x, (20 - 8) / (1 - 8 / 25.0), 1e-11) << "by mu_d";
    EXPECT_LT(above.properties.dynamic_friction, above.properties.static_friction);
}

TEST_F(WideCells, FrictionThatBeginsWithinAFacetOfAHoleHolds) {
    wall.prev.haptic.clear();
    wall.scene.default_properties = {1000, 0.5, 0.5};
    // A hole at the far plane is a slope; one at the wall's own depth is a place without friction.
    wall.scene.depth.far = 100;
    wall.set(wall.prev, 4, 4, NAN);
    land(2, 3);
    ASSERT_EQ(finger.proxy.feature, Feature::face_upper);
    const Contact contact = press(10, 3);
    EXPECT_NEAR(-contact.force.x / contact.force.z, contact.properties.dynamic_friction, 1e-12);
    EXPECT_LT(contact.properties.dynamic_friction, 0.45);
}

TEST_F(WideCells, WhatBeganToSlideWithoutFrictionSlidesOnWhereThereIsSome) {
    // Smooth up to column 4; right of it mu_s = 1 at once (column 5) and mu_d far less.
    paint(4, 0, 0);
    paint(5, 255, 51);
    land(-10, 3);
    // It comes to x = 10 on the way; to rest by mu_d = 0.2 x / 25.
    const Contact slid = press(10, 3);
    EXPECT_NEAR(slid.proxy.x, 10 / (1 + 3 * 0.2 / 25), 1e-11);
    // A little further in the next tick: it has moved in the last one, so mu_s does not hold it.
    const Contact on = press(10.1, 3);
    EXPECT_NEAR(on.proxy.x, 10.1 / (1 + 3 * 0.2 / 25), 1e-11);
    // Once it has not moved, mu_s does.
    press(10.1, 3);
    EXPECT_EQ(press(10.2, 3).proxy.x, on.proxy.x);
}

TEST_F(WideCells, ASlideThatComesToTheFootWithoutFrictionIsStillOne) {
    paint(5, 255, 51);
    land(-10, 3);
    press(-0.1, 3);  // all the way: no friction to the left of column 4
    ASSERT_TRUE(finger.proxy.sliding);
    const Contact on = press(1, 3);
    EXPECT_NEAR(on.proxy.x, 1 / (1 + 3 * 0.2 / 25), 1e-11);
}

/// How a place inside a facet answers to friction: the rest of the way over the load, in long double.
struct Lean {
    Real tangential = 0, load = 0;
};
Lean lean(const reference::Surface& surface, const Proxy& proxy, const dvec3& goal) {
    const bool lower = proxy.feature == Feature::face_lower;
    const Vec a = surface.vertex({proxy.i, proxy.j}).point;
    const Vec b = surface.vertex({proxy.i + 1, proxy.j + 1}).point;
    const Vec c = surface.vertex({proxy.i + lower, proxy.j + !lower}).point;
    const Vec n = glm::normalize(glm::cross(b - a, c - a)), v = Vec(goal) - Vec(proxy.point);
    const Real along = glm::dot(v, n);
    return {reference::length(v - along * n), std::fabs(along)};
}

TEST(UnevenFriction, WhereverASlideEndsInsideAFacetTheForceLeansByMuDynamicOfThatPlace) {
    SplitMix64 random(77);
    int judged = 0, uneven = 0, lesser = 0;
    double worst = 0;
    for (int picture = 0; picture < 60; ++picture) {
        SmallField field(25, 25, 100.0, picture % 2 ? DepthSemantics::planar : DepthSemantics::range);
        field.scene.camera = {random.within(10, 400), random.within(10, 400), 12, 12};
        field.scene.haptic = {{1, 1}, {0, 1}, {0, picture % 3 ? 0.8 : 1.4}};
        const double tilt = random.within(-0.5, 0.5), rough = picture % 5 ? 0.1 : 0.0;
        const double pixel = 100 / field.scene.camera.fx;
        field.shape(field.prev, [&](int x, int y) {
            return 100 + pixel * (tilt * (x - 12) + 0.3 * tilt * (y - 12) + random.within(-rough, rough));
        });
        for (int k = 0; k < 3 * 25 * 25; ++k)
            field.prev.haptic.push_back(static_cast<std::uint8_t>(random.next() >> 56));
        field.next.haptic = field.prev.haptic;
        if (picture % 4 == 0)  // smooth maps as well
            for (std::size_t k = 0; k < field.prev.haptic.size(); ++k)
                field.prev.haptic[k] = static_cast<std::uint8_t>(field.prev.haptic[k] / 8 + 40 + k / 75 * 3);
        field.fill(field.next, 100);
        TouchSettings settings;
        settings.stribeck_speed = 0;
        FingerState finger;
        dvec3 goal{0, 0, -90};
        field.touch(finger, goal);
        const reference::Surface surface(field.scene, field.pair());
        double last_mu = 0;
        for (int tick = 0; tick < 400; ++tick) {
            goal.x += random.within(-0.3, 0.3) * pixel;
            goal.y += random.within(-0.3, 0.3) * pixel;
            const double reach = 5 * pixel;
            goal.x = std::clamp(goal.x, -reach, reach);
            goal.y = std::clamp(goal.y, -reach, reach);
            goal.z = -100 - pixel * (0.3 + 1.5 * random.unit());
            const Contact contact = field.touch(finger, goal);
            const double mu = contact.properties.dynamic_friction;
            const Proxy& proxy = finger.proxy;
            const bool on_face = proxy.feature == Feature::face_lower || proxy.feature == Feature::face_upper;
            if (on_face && proxy.sliding && !contact.counts.capped) {
                const Lean leans = lean(surface, proxy, contact.goal);
                if (leans.load < 0.01 * pixel) continue;
                const auto off = static_cast<double>(std::fabs(leans.tangential / leans.load - mu));
                worst = std::max(worst, off);
                ASSERT_LE(off, 1e-9) << "picture " << picture << " tick " << tick;
                ++judged;
                uneven += std::abs(mu - last_mu) > 0.05;
                lesser += mu == contact.properties.static_friction;
            }
            last_mu = mu;
        }
    }
    EXPECT_GT(judged, 3000);
    EXPECT_GT(uneven, 1000);
    EXPECT_GT(lesser, 300);
    std::cout << judged << " slides judged, worst " << worst << ", by mu_s " << lesser << '\n';
}

}  // namespace
}  // namespace touchable::test
