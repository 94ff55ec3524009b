// SPDX-License-Identifier: Apache-2.0
// Friction against closed forms, and friction at edges where only its promises are known.

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include <array>
#include <cmath>

#include "engine/base/same_bits.hpp"
#include "haptics_cpu/slide.hpp"
#include "tests/haptics/touch_rig.hpp"
#include "tests/reference/solver.hpp"

namespace touchable::test {
namespace {

/// A large flat wall at planar depth 100 and a finger that has landed 1 deep in it at the centre.
class FlatWall : public testing::Test {
protected:
    FlatWall() : wall(65, 65, 100.0, DepthSemantics::planar) {
        wall.scene.default_properties = {1000, 0.5, 0.3};
        goal_at(0, -1);
        goal_at(0, 1);
    }
    Contact goal_at(double x, double depth) { return wall.touch(finger, {x, 0.1, -100 - depth}); }

    SmallField wall;
    FingerState finger;
};

TEST_F(FlatWall, HoldsWithinStaticCone) {
    const Contact contact = goal_at(0.499, 1);
    EXPECT_NEAR(contact.proxy.x, 0, 1e-9);
    EXPECT_NEAR(contact.proxy.z, -100, 1e-9);
}

TEST_F(FlatWall, SlipsToDynamicCone) {
    const Contact contact = goal_at(0.501, 1);
    EXPECT_NEAR(contact.proxy.x, 0.501 - 0.3, 1e-9);
    // F_t = mu_d F_n while it slides.
    EXPECT_NEAR(-contact.force.x / contact.force.z, 0.3, 1e-9);
}

TEST_F(FlatWall, SticksAgainAtRest) {
    goal_at(0.6, 1);
    goal_at(0.6, 1);  // rests: from here on static friction holds
    EXPECT_NEAR(goal_at(0.75, 1).proxy.x, 0.3, 1e-9);
    EXPECT_NEAR(goal_at(0.81, 1).proxy.x, 0.51, 1e-9);
}

TEST(Friction, FrictionlessSceneNeedsNoFriction) {
    SmallField wall(9, 9, 100.0);
    EXPECT_FALSE(wall.field().has_friction());
    wall.scene.default_properties.static_friction = 0.1;
    EXPECT_TRUE(wall.field().has_friction());
}

// Coulomb friction on the analytic plane, held to closed forms as near as rounding allows; and the same cone
// where faces meet.

using glm::dot;
// Places near -1000 are known to 2e-13, forces are made of differences of a few of them over 2 units.
constexpr double plane_rounding = 5e-11;

/// The plane at a tilt: its normal, a direction along it, and its point on the optical axis.
class TiltedPlane {
public:
    TiltedPlane(double tilt, double direction)
        : rig("plane", options(tilt, direction), TouchRig::Depth::exact) {
        normal =
            ExactSurface("plane", options(tilt, direction)).closest({0, 0, -1010}, {0, 0, -1000}, 0)->normal;
        along = glm::normalize(glm::cross(normal, dvec3(0.36, 0.48, -0.8)));
    }
    /// Under the surface by `depth` (above it: negative), `way` along it from the axis.
    dvec3 goal(double way, double depth) const { return dvec3(0, 0, -1000) + way * along - depth * normal; }
    double normal_force(const Contact& contact) const { return dot(contact.force, normal); }
    dvec3 tangential_force(const Contact& contact) const {
        return contact.force - normal_force(contact) * normal;
    }

    TouchRig rig;
    dvec3 normal, along;

private:
    static SceneOptions options(double tilt, double direction) {
        SceneOptions options = sized(320, 240);
        options.tilt_degrees = tilt;
        options.tilt_direction_degrees = direction;
        return options;
    }
};

class PlaneFriction : public testing::TestWithParam<std::pair<double, double>> {
protected:
    PlaneFriction() : plane(GetParam().first, GetParam().second) {}
    TiltedPlane plane;
};

TEST_P(PlaneFriction, SlipsExactlyAboveFrictionAngle) {
    const double tilt = GetParam().first * pi / 180, steepness = sine(tilt) / cosine(tilt);
    for (const double share : {1.5, 1 + 1e-6, 1 - 1e-6, 0.5}) {
        const double mu = steepness * share;
        plane.rig.scene().default_properties = {1000, mu, mu};
        plane.rig.lift_fingers();
        plane.rig.tick({0, 0, -995});
        const Contact landed = plane.rig.tick({0, 0, -1002});
        ASSERT_TRUE(landed.touching);
        const double slid = length(landed.proxy - dvec3(0, 0, -1000));
        // The part of the 2 sin a along the plane that mu does not hold.
        const double expected = share > 1 ? 0 : 2 * cosine(tilt) * (steepness - mu);
        EXPECT_NEAR(slid, expected, plane_rounding) << "mu " << share << " of tan a";
    }
}

TEST_P(PlaneFriction, SlidingDragIsProportional) {
    plane.rig.scene().default_properties = {1000, 0.5, 0.3};
    plane.rig.tick(plane.goal(0, -1));
    for (int k = 0; k <= 300; ++k) {
        const double depth = 2 + 0.002 * k;
        const Contact contact = plane.rig.tick(plane.goal(0.02 * k, depth));
        const double load = plane.normal_force(contact);
        EXPECT_NEAR(load, depth, plane_rounding);  // 1000 N/m
        const dvec3 drag = plane.tangential_force(contact);
        if (k > 80) {
            EXPECT_NEAR(length(drag), 0.3 * load, plane_rounding * load) << k;
            EXPECT_NEAR(dot(drag, plane.along), -length(drag), plane_rounding);
        } else if (k < 50) {
            EXPECT_NEAR(length(drag), 0.02 * k, plane_rounding) << "sticks, and pulls like the spring " << k;
        }
    }
}

TEST_P(PlaneFriction, StrokeLosesHysteresisArea) {
    const double load = 2, mu_s = 0.5, mu_d = 0.3, half_stroke = 3, step = 0.001;
    plane.rig.scene().default_properties = {1000, mu_s, mu_d};
    plane.rig.tick(plane.goal(-half_stroke, -1));
    plane.rig.tick(plane.goal(-half_stroke, load));
    double lost = 0, last_drag = 0;
    auto stroke = [&](int sign) {
        const int steps = static_cast<int>(2 * half_stroke / step + 0.5);
        for (int k = 1; k <= steps; ++k) {
            const Contact contact = plane.rig.tick(plane.goal(sign * (k * step - half_stroke), load));
            const double drag = dot(contact.force, plane.along);
            lost -= 0.5 * (drag + last_drag) * sign * step;  // N mm
            last_drag = drag;
        }
    };
    stroke(1);
    lost = 0;
    stroke(-1);
    stroke(1);
    // After a turn the spring goes from mu_d load one way to mu_s load the other way while the proxy sticks;
    // then it slips and slides on at mu_d.
    const double stuck = (mu_s + mu_d) * load;
    const double area = 2 * (0.5 * (mu_s - mu_d) * load * stuck + mu_d * load * (2 * half_stroke - stuck));
    // The slip falls somewhere within a step.
    EXPECT_NEAR(lost, area, 2 * (mu_s - mu_d) * load * step);
}

INSTANTIATE_TEST_SUITE_P(, PlaneFriction,
                         testing::Values(std::pair{5.0, 0.0}, std::pair{20.0, 37.0}, std::pair{33.0, 90.0},
                                         std::pair{45.0, 211.0}),
                         [](const auto& tilt) {
                             return "Tilt" + std::to_string(static_cast<int>(tilt.param.first));
                         });

TEST(Friction, FingersSlideIndependently) {
    TiltedPlane plane(20, 37);
    plane.rig.scene().default_properties = {1000, 0.5, 0.3};
    const auto solver = TouchSolver::create(plane.rig.scene(), plane.rig.settings).value();
    // Finger 1 is dragged, finger 0 leans within its cone, finger 2 does as 1 a little later.
    auto goals = [&](int k) {
        auto dragged = [&](int n) { return plane.goal(0.02 * std::max(0, n), n < 0 ? -1 : 2); };
        return std::array{plane.goal(k < 10 ? 0 : 0.9, k == 0 ? -1 : 2), dragged(k - 1), dragged(k - 100)};
    };
    std::array<FingerState, 3> fingers, alone;
    for (int k = 0; k < 300; ++k) {
        std::array<Contact, 3> contacts;
        const auto now = goals(k);
        solver.tick(plane.rig.field(), now, fingers, contacts);
        for (std::size_t n = 0; n < 3; ++n) {
            const Contact contact = tick_one(solver, plane.rig.field(), alone[n], now[n]);
            ASSERT_EQ(contacts[n].force, contact.force) << "tick " << k << " finger " << n;
        }
        if (k < 12) continue;
        EXPECT_FALSE(fingers[0].proxy.sliding);
        EXPECT_EQ(fingers[1].proxy.sliding, k > 51) << k;
        EXPECT_EQ(fingers[2].proxy.sliding, k > 150) << k;
    }
}

/// Walls of two slopes that meet in column 16; depth of a column from `depth(columns right of it)`.
struct FoldedField : SmallField {
    template <class Depth>
    explicit FoldedField(Depth depth) : SmallField(33, 65, 0, DepthSemantics::planar) {
        scene.camera.cx = 16;
        shape(prev, [&](int x, int) { return depth(x - 16); });
    }
};
/// Unit normal of the strip between column 16 and one of its neighbours.
dvec3 normal_beside(const SmallField& field, int side) {
    const double d0 = field.field().vertex(16, 32).depth, d1 = field.field().vertex(16 + side, 32).depth;
    const dvec3 across{side * d1 / field.scene.camera.fx, 0, d0 - d1};
    return glm::normalize(dvec3(-across.z, 0, across.x) * double(side));
}

TEST(Friction, ValleyLoadSumsBothWalls) {
    FoldedField valley([](int x) { return 100.0 - (x < 0 ? -0.25 * x : 0.1 * x); });
    const dvec3 left = normal_beside(valley, -1), right = normal_beside(valley, 1);
    // G - C = -(l0 n0 + l1 n1) for a goal 2 under the bottom.
    const double determinant = left.x * right.z - left.z * right.x;
    const double l0 = -2 * right.x / determinant, l1 = 2 * left.x / determinant;
    ASSERT_NEAR(l0 * left.x + l1 * right.x, 0, 1e-12);
    ASSERT_NEAR(l0 * left.z + l1 * right.z, 2, 1e-12);
    valley.scene.default_properties = {1000, 0.4, 0.25};
    FingerState finger;
    valley.touch(finger, {0, 0, -95});
    const Contact bottom = valley.touch(finger, {0, 0, -102});
    EXPECT_NEAR(length(bottom.proxy - dvec3(0, 0, -100)), 0, 1e-9);
    valley.touch(finger, {0, 0, -102});  // sticks
    const double holds = 0.4 * (l0 + l1), slides = 0.25 * (l0 + l1);
    EXPECT_NEAR(valley.touch(finger, {0, holds - 1e-6, -102}).proxy.y, 0, 1e-9);
    EXPECT_NEAR(valley.touch(finger, {0, holds + 1e-6, -102}).proxy.y, holds + 1e-6 - slides, 1e-9);
    EXPECT_NEAR(valley.touch(finger, {0, 2, -102}).proxy.y, 2 - slides, 1e-9);
    EXPECT_NEAR(valley.touch(finger, {0, 3, -102}).proxy.x, 0, 1e-9);
}

TEST(Friction, RidgeUsesConeOfFace) {
    FoldedField ridge([](int x) { return 100.0 + 0.1 * std::abs(x); });
    const dvec3 n = normal_beside(ridge, 1);
    const double slope = n.x / n.z;
    // A goal 2 under the crest: 2 n.z presses on the face, 2 n.x pulls down it, y pulls along the crest.
    for (const double mu : {slope * 1.001, slope * 0.999, 0.8}) {
        ridge.scene.default_properties = {1000, mu, mu};
        FingerState finger;
        ridge.touch(finger, {0, 0, -95});
        const Contact on_crest = ridge.touch(finger, {0, 0, -102});
        EXPECT_EQ(std::abs(on_crest.proxy.x) < 1e-9, mu > slope) << mu;
        if (mu < 0.8) continue;
        const double holds = 2 * std::sqrt(mu * mu * n.z * n.z - n.x * n.x);
        EXPECT_NEAR(ridge.touch(finger, {0, holds - 1e-6, -102}).proxy.y, 0, 1e-9);
        EXPECT_GT(ridge.touch(finger, {0, holds + 1e-6, -102}).proxy.y, 1e-8);
    }
}

// Friction that falls with speed, against its formula and against plain Coulomb friction at both ends.

constexpr double mu_s = 0.5, mu_d = 0.3;

/// A flat wall at 100, and strokes over it 1 mm deep.
class Stribeck : public testing::Test {
protected:
    Stribeck() : wall(129, 33, 100.0, DepthSemantics::planar) {
        wall.scene.default_properties = {1000, mu_s, mu_d};
    }
    /// Where the proxy is (mm), tick by tick, for a goal at x(0), x(1), ...
    std::vector<double> follow(const std::vector<double>& goals, double stribeck_speed) {
        TouchSettings settings{.stribeck_speed = stribeck_speed};
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

TEST_F(Stribeck, SteadySpeedFollowsFormula) {
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
TEST_F(Stribeck, HalvesStaticShareAtSpeed) {
    for (const double v_s : {0.01, 0.2}) {
        EXPECT_NEAR(stribeck_slip(v_s, v_s).static_share, 0.5, 1e-15);
        EXPECT_NEAR(stribeck_slip(3 * v_s, v_s).static_share, 0.1, 1e-15);
        EXPECT_EQ(stribeck_slip(0, v_s).static_share, 1);
        EXPECT_TRUE(is_slow(0.099 * v_s, v_s));
        EXPECT_FALSE(is_slow(0.101 * v_s, v_s));
    }
}

TEST_F(Stribeck, SmallSpeedIsCoulombFriction) {
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

TEST_F(Stribeck, LargeSpeedKeepsStaticFriction) {
    std::vector<double> goals = steady(-3, 0.02, 200);
    for (int k = 0; k < 200; ++k) goals.push_back(goals.back() - 0.03);
    const auto places = follow(goals, 1e9);
    wall.scene.default_properties.dynamic_friction = mu_s;
    EXPECT_EQ(places, follow(goals, 0));
}

TEST_F(Stribeck, SticksAgainOnceSlow) {
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

TEST_F(Stribeck, SurfaceMotionIsNoSlip) {
    wall.fill(wall.next, 90.0);
    TouchSettings settings{.stribeck_speed = 0.05};
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

TEST_F(Stribeck, RejectsInvalidSpeed) {
    for (const double speed : {-1.0, std::nan(""), HUGE_VAL}) {
        const auto made = TouchSolver::create(wall.scene, {.stribeck_speed = speed});
        ASSERT_FALSE(made);
        EXPECT_NE(made.error().message.find("Stribeck"), std::string::npos);
    }
}

// Maps of friction that differ within a facet: a slide ends at the first place that holds it, by that place's
// own mu.

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
    void paint(int column, int static_level, int dynamic_level) {
        for (int y = 0; y < 9; ++y) {
            std::uint8_t* p = &wall.prev.haptic[3 * wall.prev.index(column, y)];
            p[1] = static_cast<std::uint8_t>(static_level);
            p[2] = static_cast<std::uint8_t>(dynamic_level);
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

TEST_F(WideCells, SmootherGroundLetsSlideRun) {
    paint(4, 255, 255);  // mu = 1 - x / 25
    land(2, 50);         // the load; mu h falls by 2 where the pull falls by 1
    const Contact held = press(2 + 0.9 * 50 * 23 / 25.0, 50);
    EXPECT_NEAR(held.proxy.x, 2, 1e-12);
    // Once it slips, nothing holds it until the way back from the goal: 60 - x = 50 (1 - x / 25) at -10.
    const Contact away = press(60, 50);
    EXPECT_GT(away.proxy.x, 25);
}

TEST_F(WideCells, SlideEndsAtFirstHold) {
    // Rough in a strip between two smooth columns: up to column 5 mu = x / 25, from there it falls again.
    paint(5, 255, 255);
    land(0.5, 30);
    const Contact contact = press(20, 30);
    EXPECT_NEAR(contact.proxy.x, 20 / (1 + 30 / 25.0), 1e-11);
}

TEST_F(WideCells, LesserOfTwoFrictionsHolds) {
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

TEST_F(WideCells, HoleFacetFrictionHolds) {
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

TEST_F(WideCells, SlideContinuesOntoRoughGround) {
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

TEST_F(WideCells, FrictionlessArrivalStillSlides) {
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

TEST(UnevenFriction, SlidesEndByLocalFriction) {
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

/// By how much friction fails to hold a proxy after `length` image steps, in lengths of its way: the rest of
/// the way less mu times the load, by the lesser mu.
Real missing(const FrictionCone& cone, const Motion& motion, const ImageStep& step, const CellPoint& from,
             Real length) {
    const Real a = from.a + length * step.dx, b = from.b + length * step.dy;
    const auto mu = [&](const std::array<double, 4>& at) {
        return (1 - b) * ((1 - a) * at[0] + a * at[1]) + b * ((1 - a) * at[2] + a * at[3]);
    };
    const Real rest = 1 - length / (1 - length * step.stretch);
    return rest - std::min(mu(cone.sliding), mu(cone.most)) *
                      std::sqrt(Real(motion.load2) / glm::dot(motion.way, motion.way));
}

// On steep ground the rest of a way is no straight line over the image. There, and between smooth and rough
// corners, friction may hold in the middle of a way alone.
TEST(StoppingLength, IsFirstSampleThatHolds) {
    SplitMix64 random(19);
    int stopped = 0, passed = 0;
    for (int k = 0; k < 20000; ++k) {
        const bool steep = k % 2;
        CornerProperties corners{};
        for (HapticProperties& corner : corners) {
            corner.static_friction = steep ? std::round(random.unit()) : random.unit();
            corner.dynamic_friction = steep ? corner.static_friction : random.unit();
        }
        const CellPoint from{random.unit(), random.unit()};
        const FrictionCone cone = cone_over(corners, from, true, {});
        Motion motion;
        motion.way = {1, 0, 0};
        motion.load2 = std::pow(10.0, random.within(-0.6, 1.4));
        const double far = steep ? 0.3 : 2;
        const ImageStep step{random.within(-far, far), random.within(-far, far),
                             steep ? random.within(-0.99, -0.5) : random.within(-0.95, 4)};
        const auto to_rim = [](double at, double speed) {
            return speed > 0 ? (1 - at) / speed : -at / speed;
        };
        const double reach = std::min(to_rim(from.a, step.dx), to_rim(from.b, step.dy));
        const double length = stopping_length(cone, motion, step, from, reach);
        const double end = std::min({length, reach, step.length_at(1)});
        const int samples = 200;
        for (int n = 0; n < samples && end > 0; ++n) {
            const Real at = Real(end) * n / samples;
            ASSERT_GT(missing(cone, motion, step, from, at), -1e-9L) << k << " at " << n;
        }
        if (length <= reach) {
            ASSERT_LE(missing(cone, motion, step, from, length), 1e-9L) << k;
            stopped += length > 0 && length < step.length_at(1);
        } else {
            ++passed;
        }
    }
    EXPECT_GT(stopped, 3000);
    EXPECT_GT(passed, 1000);
}

}  // namespace
}  // namespace touchable::test
