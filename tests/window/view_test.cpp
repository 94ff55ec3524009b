#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "engine/content/scenes.hpp"
#include "player/window/pointer.hpp"

namespace touchable::test {
namespace {

Scene globe_scene() {
    return (*make_scene("globe", {}))->scene();
}

double largest_difference(const glm::dmat4& a, const glm::dmat4& b) {
    double largest = 0;
    for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 4; ++r) largest = std::max(largest, std::abs(a[c][r] - b[c][r]));
    return largest;
}

TEST(WindowView, IsTheClipsOwnUntilTurnedAndAgainAtHome) {
    const Scene scene = globe_scene();
    WindowView view(scene, {0, 0, -600});
    const ViewCamera own = view.camera(720, 480);
    EXPECT_EQ(largest_difference(own.clip_from_world, own_view(scene, 720, 480, 0.6).clip_from_world), 0);
    view.turn(30, 10);
    EXPECT_FALSE(view.own());
    view.near_by(2);
    view.pan(10, 10, 720, 480);
    view.go_home();
    EXPECT_EQ(largest_difference(own.clip_from_world, view.camera(720, 480).clip_from_world), 0);
}

TEST(WindowView, FirstTouchOfTheOrbitDoesNotJump) {
    Scene scene = globe_scene();
    scene.camera.cx -= 8;  // as of recordings, whose axis is not in the picture's middle
    scene.camera.cy += 6;
    WindowView view(scene, {3, -5, -600});
    const auto own = view.camera(720, 480).project({10, 20, -580});
    view.turn(0, 0);
    const auto orbit = view.camera(720, 480).project({10, 20, -580});
    ASSERT_TRUE(own && orbit);
    EXPECT_NEAR(own->x, orbit->x, 1e-6);
    EXPECT_NEAR(own->y, orbit->y, 1e-6);
}

TEST(WindowView, PanGoesWithThePointer) {
    const Scene scene = globe_scene();
    WindowView view(scene, {0, 0, -600});
    view.turn(20, 5);
    const auto before = view.camera(720, 480).project({0, 0, -600});
    view.pan(30, -12, 720, 480);
    const auto after = view.camera(720, 480).project({0, 0, -600});
    EXPECT_NEAR(after->x - before->x, 30, 0.5);
    EXPECT_NEAR(after->y - before->y, -12, 0.5);
}

TEST(WindowView, LookingAtAPlacePutsItInTheMiddleAndKeepsTheDistance) {
    const Scene scene = globe_scene();
    WindowView view(scene, {0, 0, -600});
    view.turn(15, 0);
    const double before = glm::length(view.camera(720, 480).eye - glm::dvec3(0, 0, -600));
    const glm::dvec3 place(40, 30, -550);
    view.look_at(place);
    const ViewCamera camera = view.camera(720, 480);
    const auto seen = camera.project(place);
    ASSERT_TRUE(seen);
    EXPECT_NEAR(seen->x, scene.camera.cx + 0.5, 1e-6);
    EXPECT_NEAR(seen->y, scene.camera.cy + 0.5, 1e-6);
    EXPECT_NEAR(glm::length(camera.eye - place), before, 1e-6);
}

/// What is seen and what is picked are those of a picture that has no more than the upper part.
TEST(WindowView, WhatIsLeftBelowIsBelowAllThatIsSeen) {
    const Scene scene = globe_scene();
    WindowView view(scene, {0, 0, -600}), upper(scene, {0, 0, -600});
    view.leave_below(0.125);
    const glm::dvec3 place(40, -130, -550);
    for (const bool is_turned : {false, true}) {
        if (is_turned) view.turn(20, 5);
        if (is_turned) upper.turn(20, 5);
        const ViewCamera camera = view.camera(720, 480), small = upper.camera(720, 420);
        EXPECT_EQ(camera.height, 480);
        const auto seen = camera.project(place), wanted = small.project(place);
        ASSERT_TRUE(seen && wanted);
        EXPECT_NEAR(glm::distance(*seen, *wanted), 0, 1e-9);
        EXPECT_LT(glm::distance(camera.unproject(seen->x, seen->y, seen->z), place), 1e-6);
    }
    view.go_home();
    const ViewCamera own = view.camera(720, 480);
    const glm::dvec4 corner = own.clip_from_lattice * glm::dvec4(0, scene.height - 0.5, 1, 1 / 600.0);
    EXPECT_NEAR((corner.y / corner.w + 1) * 240, 420, 1e-9) << "the clip's lowest row";
    view.leave_below(0);
    EXPECT_EQ(largest_difference(view.camera(720, 480).clip_from_world,
                                 own_view(scene, 720, 480, 0.6).clip_from_world),
              0);
}

TEST(WindowView, LooksAsAnotherClipIsLookedAt) {
    const Scene scene = globe_scene();
    WindowView before(scene, {0, 0, -600}), next(scene, {0, 0, -300});
    next.look_as(before);
    EXPECT_TRUE(next.own());
    before.turn(30, 10);
    before.near_by(2);
    next.look_as(before);
    EXPECT_FALSE(next.own());
    EXPECT_EQ(next.orbit().azimuth, 30);
    EXPECT_EQ(next.orbit().zoom, 2);
    next.go_home();
    EXPECT_TRUE(next.own());
}

}  // namespace
}  // namespace touchable::test
