// Holes in the depth whose walls are as stiff as the scene says: where that stiffness is felt, when, and how
// a finger gets out of it again.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "haptics_cpu/force_guard.hpp"
#include "haptics_cpu/world_space.hpp"
#include "tests/haptics/force_path.hpp"

namespace touchable::test {
namespace {

using glm::dvec3;

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
constexpr double scene_k = 600, hole_k = 100;  // N/m

/// Flat ground at 100 of 600 N/m without friction.
class HoleyField : public SmallField {
public:
    HoleyField(int width, int height, std::optional<double> hole_stiffness = hole_k / 1000)
        : SmallField(width, height, 100.0, DepthSemantics::planar) {
        scene.default_properties = {scene_k, 0, 0};
        scene.hole_stiffness = hole_stiffness;
    }
};

TEST(HoleStiffness, IsThatOfCellsWithAnInvalidCornerAndFadesOverTheNext) {
    HoleyField small(20, 20);
    small.set(small.prev, 10, 10, nothing);
    const HeightField field = small.field();
    const auto k = [&](double x, double y) {
        const auto i = static_cast<int>(x), j = static_cast<int>(y);
        const double stiffness = field.properties(i, j, x - i, y - j).stiffness;
        EXPECT_EQ(stiffness, field.stiffness(i, j, x - i, y - j));
        return stiffness;
    };
    for (const auto& [x, y] : {std::pair{10.0, 10.0}, {9.0, 9.0}, {9.25, 10.5}, {10.75, 9.5}, {10.5, 9.125}})
        EXPECT_EQ(k(x, y), hole_k) << x << ' ' << y;
    EXPECT_EQ(k(8.5, 10), (scene_k + hole_k) / 2);
    EXPECT_EQ(k(10, 11.75), 0.25 * hole_k + 0.75 * scene_k);
    EXPECT_EQ(k(8.5, 8.5), 0.25 * hole_k + 0.75 * scene_k);
    for (const auto& [x, y] : {std::pair{8.0, 10.0}, {7.5, 9.5}, {12.0, 12.5}, {10.0, 12.0}})
        EXPECT_EQ(k(x, y), scene_k) << x << ' ' << y;
}

TEST(HoleStiffness, BeyondThePictureIsAHoleToo) {
    const HoleyField small(20, 20);
    EXPECT_EQ(small.field().stiffness(-1, 5, 0.5, 0), hole_k);
    EXPECT_EQ(small.field().stiffness(900, -7, 0.5, 0.5), hole_k);
    EXPECT_EQ(small.field().stiffness(18, 5, 0.5, 0), (scene_k + hole_k) / 2);
    EXPECT_EQ(small.field().stiffness(17, 5, 0.5, 0), scene_k);
}

TEST(HoleStiffness, TakesThePlaceOfTheHapticImages) {
    HoleyField small(20, 20);
    small.scene.haptic = {{2, 2}, {0, 0}, {0, 0}};
    small.prev.haptic.assign(3 * 400, 0);
    small.set(small.prev, 10, 10, nothing);
    EXPECT_EQ(small.field().stiffness(9, 9, 0.5, 0.5), hole_k);
    EXPECT_EQ(small.field().stiffness(5, 5, 0.5, 0.5), 2000);
    EXPECT_EQ(small.field().properties(8, 10, 0.5, 0).stiffness, 1050);
}

TEST(HoleStiffness, ComesOnBeforeTheHoleOpensAndEndsWhenItCloses) {
    HoleyField small(20, 20);
    small.set(small.next, 10, 10, nothing);
    EXPECT_EQ(small.field(0).stiffness(10, 10, 0, 0), scene_k);
    EXPECT_EQ(small.field(0.25).stiffness(10, 10, 0, 0), (scene_k + hole_k) / 2);
    EXPECT_EQ(small.field(0.5).stiffness(10, 10, 0, 0), hole_k);
    EXPECT_EQ(small.field(0.75).stiffness(9, 9, 0.5, 0.5), hole_k);
    std::swap(small.prev.vertices, small.next.vertices);
    EXPECT_EQ(small.field(0).stiffness(10, 10, 0, 0), hole_k);
    EXPECT_EQ(small.field(0.4375).stiffness(10, 10, 0, 0), hole_k);
    EXPECT_EQ(small.field(0.5).stiffness(10, 10, 0, 0), scene_k);
    small.scene.interpolation = FrameInterpolation::hold;
    EXPECT_EQ(small.field(0.75).stiffness(10, 10, 0, 0), hole_k);
}

TEST(HoleStiffness, OfASceneThatDoesNotSayIsThatOfThePixels) {
    HoleyField small(20, 20, std::nullopt);
    small.set(small.prev, 10, 10, nothing);
    EXPECT_EQ(small.field().stiffness(9, 9, 0.5, 0.5), scene_k);
    EXPECT_EQ(small.field().hole_share(9, 9, 0.5, 0.5), 0);
}

/// Ground at 100 on the left, and right of pixel 32 nothing down to 400: above row 32 because there is no
/// depth, below it because that is the depth. One wall, half of it a hole's.
class CliffAndHole : public HoleyField {
public:
    explicit CliffAndHole(std::optional<double> hole_stiffness, bool has_hole = true)
        : HoleyField(65, 65, hole_stiffness) {
        shape(prev, [=](int x, int y) { return x < 32 ? 100.0 : (has_hole && y < 32 ? nothing : 400.0); });
    }
};

class HoleWall : public testing::Test {
protected:
    /// 10 mm below the ground's level, 30 mm behind the wall, then along the wall: from its half at rows
    /// above 32 to the other, or back; then at rest.
    static std::vector<dvec3> along(double from_y, double to_y) {
        auto path = path_along({{2, from_y, -50}, {2, from_y, -110}, {-30, from_y, -110}}, 0.1);
        const auto slide = path_along({path.back(), {-30, to_y, -110}}, 0.02);
        path.insert(path.end(), slide.begin(), slide.end());
        path.insert(path.end(), 800, path.back());
        return path;
    }
    static double newtons(const GuardedForce& force) { return length(force.force); }
    /// How far a proxy is from its goal, metres.
    static double stretch(const Contact& contact) { return 0.001 * length(contact.proxy - contact.goal); }
};

TEST_F(HoleWall, OfAHoleIsSoftWhereverAFingerIsCaughtBehindIt) {
    const auto path = path_along({{2, 3.3, -50}, {2, 3.3, -101}, {-30, 3.3, -101}, {-30, 3.3, -180}}, 0.1);
    const CliffAndHole soft(hole_k / 1000), hard(std::nullopt);
    const PathResult felt = run_path(path, without_ramp(), soft), was = run_path(path, without_ramp(), hard);
    int caught = 0;
    for (std::size_t k = 0; k < path.size(); ++k) {
        const Contact& contact = felt.contacts[k];
        EXPECT_EQ(contact.proxy, was.contacts[k].proxy);
        EXPECT_EQ(contact.in_hole, was.contacts[k].in_hole);
        if (!contact.touching) continue;
        ++caught;
        ASSERT_TRUE(contact.in_hole);
        ASSERT_EQ(contact.properties.stiffness, hole_k);
        ASSERT_EQ(was.contacts[k].properties.stiffness, scene_k);
    }
    EXPECT_GT(caught, 300);
    EXPECT_NEAR(newtons(felt.forces.back()), hole_k * stretch(felt.contacts.back()), 1e-9);
    EXPECT_GT(stretch(felt.contacts.back()), 0.025);
    EXPECT_EQ(was.forces.back().reasons, guard_force);
}

TEST_F(HoleWall, OutOfAHoleTheForceRisesByNoMoreThanHalfANewtonIn10Ms) {
    const CliffAndHole field(hole_k / 1000);
    for (const double depth : {30.0, 5.0}) {
        auto path = along(3.3, -3.6);
        for (dvec3& goal : path) goal.x = std::max(goal.x, -depth);
        const PathResult result = run_path(path, without_ramp(), field);
        const std::size_t at_the_wall = 1000;
        EXPECT_NEAR(stretch(result.contacts[at_the_wall]), depth / 1000, 5e-4);
        EXPECT_NEAR(newtons(result.forces[at_the_wall]), hole_k * stretch(result.contacts[at_the_wall]),
                    1e-9);
        double fastest = 0;
        for (std::size_t k = at_the_wall; k < path.size(); ++k)
            fastest = std::max(fastest, length(result.forces[k].force - result.forces[k - 10].force));
        EXPECT_LE(fastest, 0.5) << depth;
        EXPECT_GT(fastest, 0.3) << depth;
        EXPECT_GT(result.ticks_with(guard_rise), 50);
        // In the end it is the wall that it always was.
        EXPECT_NEAR(newtons(result.forces.back()), std::min(10.0, scene_k * stretch(result.contacts.back())),
                    1e-9);
        EXPECT_EQ(result.forces.back().reasons & guard_rise, 0U);
    }
}

TEST_F(HoleWall, IntoAHoleTheForceFallsAtOnce) {
    const PathResult result = run_path(along(-3.6, 3.3), without_ramp(), CliffAndHole(hole_k / 1000));
    EXPECT_EQ(result.ticks_with(guard_rise), 0);
    EXPECT_NEAR(newtons(result.forces.back()), hole_k * stretch(result.contacts.back()), 1e-9);
}

TEST_F(HoleWall, ANewContactOutsideHasItsStiffnessAtOnce) {
    auto path = path_along({{2, 3.3, -50}, {2, 3.3, -110}, {-20, 3.3, -110}, {-2, 3.3, -110}}, 0.1);
    const auto away = path_along({{2, 3.3, -110}, {2, 3.3, -90}, {-2, 3.3, -90}, {-2, 3.3, -102}}, 0.1);
    path.insert(path.end(), away.begin(), away.end());
    const PathResult result = run_path(path, without_ramp(), CliffAndHole(hole_k / 1000));
    EXPECT_FALSE(result.contacts.back().in_hole);
    EXPECT_EQ(result.forces.back().reasons, guard_none);
    EXPECT_NEAR(newtons(result.forces.back()), scene_k * 0.002, 1e-9);
}

TEST_F(HoleWall, BetweenValidDepthsIsTheSameToTheBitWhateverHolesAre) {
    for (const bool has_haptic_image : {false, true}) {
        CliffAndHole with(hole_k / 1000, false), without(std::nullopt, false);
        for (CliffAndHole* field : {&with, &without})
            for (int y = 0; y < 65 && has_haptic_image; ++y)
                for (int x = 0; x < 65; ++x)
                    field->prev.haptic.insert(field->prev.haptic.end(),
                                              {static_cast<std::uint8_t>(y < 32 ? 5 : 200), 40, 20});
        const PathResult a = run_path(along(3.3, -3.6), without_ramp(), with),
                         b = run_path(along(3.3, -3.6), without_ramp(), without);
        EXPECT_GT(b.touching(), 1000);
        for (std::size_t k = 0; k < a.forces.size(); ++k) {
            ASSERT_EQ(a.forces[k].force, b.forces[k].force) << k;
            ASSERT_EQ(a.forces[k].reasons, b.forces[k].reasons) << k;
            ASSERT_FALSE(a.contacts[k].in_hole);
        }
    }
}

TEST_F(HoleWall, MayHaveNoStiffnessAtAll) {
    const PathResult result = run_path(along(3.3, 3.2), without_ramp(), CliffAndHole(0));
    EXPECT_TRUE(result.contacts.back().touching);
    EXPECT_EQ(newtons(result.forces.back()), 0);
}

/// A finger at rest 5 mm deep on the ground, a pixel beside a hole that opens or closes.
TEST(HoleStiffness, AHoleThatClosesBesideAFingerDoesNotKickIt) {
    HoleyField field(65, 65);
    field.set(field.prev, 34, 32, nothing);
    GuardSettings settings = without_ramp();
    FingerGuard guard(settings, 0.001);
    FingerState finger;
    guard.guard(field.touch(finger, {0.1, 0, -90}));
    const dvec3 goal{0.1, 0, -105};
    for (int tick = 0; tick < 200; ++tick) guard.guard(field.touch(finger, goal));
    double last = length(guard.guard(field.touch(finger, goal)).force);
    EXPECT_LT(last, 0.6 * scene_k * 0.005);
    field.set(field.prev, 34, 32, 100);
    double fastest = 0;
    for (int tick = 0; tick < 200; ++tick) {
        const double now = length(guard.guard(field.touch(finger, goal)).force);
        fastest = std::max(fastest, now - last);
        last = now;
    }
    EXPECT_NEAR(fastest, rise_from_hole, 1e-9);
    EXPECT_NEAR(last, scene_k * 0.005, 1e-9);
}

TEST_F(HoleWall, BecomesACliffBetweenTwoFramesWithoutAKick) {
    CliffAndHole field(hole_k / 1000);
    field.shape(field.next, [](int x, int) { return x < 32 ? 100.0 : 400.0; });
    FingerGuard guard(without_ramp(), 0.001);
    FingerState finger;
    std::vector<dvec3> forces;
    const auto touch = [&](const dvec3& goal, double blend) {
        forces.push_back(guard.guard(field.touch(finger, goal, blend)).force);
    };
    for (const dvec3& goal : path_along({{2, 3.3, -50}, {2, 3.3, -110}, {-30, 3.3, -110}}, 0.1))
        touch(goal, 0);
    const std::size_t caught = forces.size();
    for (int tick = 0; tick < 600; ++tick) touch({-30, 3.3, -110}, std::min(0.99, 0.03 * tick));
    double fastest = 0;
    for (std::size_t k = caught; k < forces.size(); ++k)
        fastest = std::max(fastest, length(forces[k] - forces[k - 10]));
    EXPECT_NEAR(length(forces[caught]), hole_k * 0.03, 0.1);
    EXPECT_NEAR(length(forces.back()), 10, 1e-9);
    EXPECT_NEAR(fastest, 10 * rise_from_hole, 1e-6);
}

/// A surface that jumps from 4 to 12 mm in front of a goal when its hole closes; a few ticks later the hole
/// opens again, and at last it is gone. The jump takes its 100 ms, and the stiffness its time.
TEST(HoleStiffness, AJumpAtAHoleComesOnAsEvenlyAsElsewhere) {
    FingerGuard guard(without_ramp(), 0.001);
    std::vector<double> forces;
    for (int tick = 0; tick < 1000; ++tick) {
        Contact contact;
        const bool jumped = tick >= 10;
        const double x = jumped ? 12 : 4;
        contact.touching = true;
        contact.proxy = contact.carried = {0, 0, x};
        contact.hole_share = !jumped ? 1.0 : std::clamp((tick - 20) / 16.0, 0.0, 1.0);
        if (tick >= 60) contact.hole_share = 0;
        const double k = scene_k + (hole_k - scene_k) * contact.hole_share;
        contact.properties.stiffness = k;
        contact.carried_stiffness = k;
        contact.force = {0, 0, 0.001 * k * x};
        contact.jumped = tick == 10;
        if (contact.jumped) contact.jumped_force = contact.force;
        forces.push_back(length(guard.guard(contact).force));
    }
    double fastest = 0;
    for (std::size_t k = 10; k < forces.size(); ++k) fastest = std::max(fastest, forces[k] - forces[k - 10]);
    EXPECT_NEAR(forces[9], 0.4, 1e-9);
    EXPECT_NEAR(forces[10], 0.4, 0.1);
    EXPECT_NEAR(forces.back(), 7.2, 1e-9);
    // The fade is at its steepest half-way, 1.5 of the jump in 100 ms: 8 mm at the stiffness of that moment.
    EXPECT_LT(fastest, 10 * rise_from_hole + 0.15 * 0.008 * 300);
    EXPECT_GT(fastest, 10 * rise_from_hole);
}

TEST(HoleStiffness, OnlyWhatRestsOnAnInvalidVertexIsInAHole) {
    SmallField small(20, 20, 100.0, DepthSemantics::planar);
    small.set(small.prev, 10, 10, nothing);
    const HeightField field = small.field();
    const WorldSpace space(field);
    const auto in_hole = [&](Feature feature, int i, int j) {
        Place place;
        place.feature = feature;
        place.i = i;
        place.j = j;
        return is_in_hole(space, place);
    };
    EXPECT_FALSE(in_hole(Feature::free, 10, 10));
    EXPECT_TRUE(in_hole(Feature::vertex, 10, 10));
    EXPECT_FALSE(in_hole(Feature::vertex, 9, 10));
    EXPECT_TRUE(in_hole(Feature::vertex, -1, 10));  // the ring
    EXPECT_TRUE(in_hole(Feature::edge_h, 9, 10));
    EXPECT_FALSE(in_hole(Feature::edge_h, 9, 11));
    EXPECT_TRUE(in_hole(Feature::edge_v, 10, 9));
    EXPECT_FALSE(in_hole(Feature::edge_v, 9, 9));
    EXPECT_TRUE(in_hole(Feature::edge_d, 9, 9));
    EXPECT_FALSE(in_hole(Feature::edge_d, 9, 10));
    // Of the eight triangles of the cells around it six have that vertex.
    EXPECT_TRUE(in_hole(Feature::face_lower, 9, 9));
    EXPECT_TRUE(in_hole(Feature::face_upper, 9, 9));
    EXPECT_TRUE(in_hole(Feature::face_lower, 10, 10));
    EXPECT_TRUE(in_hole(Feature::face_upper, 10, 10));
    EXPECT_TRUE(in_hole(Feature::face_lower, 9, 10));
    EXPECT_FALSE(in_hole(Feature::face_upper, 9, 10));
    EXPECT_FALSE(in_hole(Feature::face_lower, 10, 9));
    EXPECT_TRUE(in_hole(Feature::face_upper, 10, 9));
}

}  // namespace
}  // namespace touchable::test
