// Coulomb friction on the analytic plane, held to closed forms as near as rounding allows; and the same cone
// where faces meet.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "engine/base/same_bits.hpp"
#include "tests/haptics/small_field.hpp"
#include "tests/haptics/touch_rig.hpp"

namespace touchable::test {
namespace {

using glm::dot;
using glm::dvec3;

// Places near -1000 are known to 2e-13, forces are made of differences of a few of them over 2 units.
constexpr double plane_rounding = 5e-11;

/// The plane at a tilt: its normal, a direction along it, and its point on the optical axis.
class TiltedPlane {
public:
    TiltedPlane(double tilt, double direction)
        : rig("plane", options(tilt, direction), TouchRig::Depth::exact) {
        normal = rig.content().closest({0, 0, -1010}, {0, 0, -1000}, 0)->normal;
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
        SceneOptions options;
        options.width = 320;
        options.height = 240;
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

TEST_P(PlaneFriction, ALoadStraightDownSlipsExactlyAboveTheAngleOfFriction) {
    const double tilt = GetParam().first * pi / 180, steepness = sine(tilt) / cosine(tilt);
    for (const double share : {1 + 1e-6, 1 - 1e-6}) {
        const double mu = steepness * share;
        plane.rig.scene().default_properties = {1000, mu, mu};
        plane.rig.lift_fingers();
        plane.rig.tick({0, 0, -995});
        const Contact landed = plane.rig.tick({0, 0, -1002});
        ASSERT_TRUE(landed.touching);
        const double slid = length(landed.proxy - dvec3(0, 0, -1000));
        // What mu does not hold of the 2 sin a along the plane.
        const double expected = share > 1 ? 0 : 2 * cosine(tilt) * (steepness - mu);
        EXPECT_NEAR(slid, expected, plane_rounding) << "mu " << share << " of tan a";
    }
}

TEST_P(PlaneFriction, SlidingPullsBackByMuDynamicTimesTheLoad) {
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

TEST_P(PlaneFriction, AStrokeToAndFroLosesTheAreaOfItsHysteresis) {
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

TEST(Friction, EachFingerSticksAndSlidesByItself) {
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
            Contact contact;
            solver.tick(plane.rig.field(), {&now[n], 1}, {&alone[n], 1}, {&contact, 1});
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

TEST(Friction, InAValleyTheLoadIsTheSumOfBothWallsShares) {
    const FoldedField base([](int x) { return 100.0 - (x < 0 ? -0.25 * x : 0.1 * x); });
    const dvec3 left = normal_beside(base, -1), right = normal_beside(base, 1);
    // G - C = -(l0 n0 + l1 n1) for a goal 2 under the bottom.
    const double determinant = left.x * right.z - left.z * right.x;
    const double l0 = -2 * right.x / determinant, l1 = 2 * left.x / determinant;
    ASSERT_NEAR(l0 * left.x + l1 * right.x, 0, 1e-12);
    ASSERT_NEAR(l0 * left.z + l1 * right.z, 2, 1e-12);
    FoldedField valley([](int x) { return 100.0 - (x < 0 ? -0.25 * x : 0.1 * x); });
    valley.scene.default_properties = {1000, 0.4, 0.25};
    FingerState finger;
    valley.touch(finger, {0, 0, -95});
    for (int k = 0; k < 2; ++k) valley.touch(finger, {0, 0, -102});  // arrives, and sticks
    const double holds = 0.4 * (l0 + l1), slides = 0.25 * (l0 + l1);
    EXPECT_NEAR(valley.touch(finger, {0, holds - 1e-6, -102}).proxy.y, 0, 1e-9);
    EXPECT_NEAR(valley.touch(finger, {0, holds + 1e-6, -102}).proxy.y, holds + 1e-6 - slides, 1e-9);
    EXPECT_NEAR(valley.touch(finger, {0, 2, -102}).proxy.y, 2 - slides, 1e-9);
    EXPECT_NEAR(valley.touch(finger, {0, 3, -102}).proxy.x, 0, 1e-9);
}

TEST(Friction, OnARidgeTheConeIsThatOfTheFaceItWouldSlideDown) {
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

}  // namespace
}  // namespace touchable::test
