#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "engine/content/scenes.hpp"
#include "player/control/window_view.hpp"

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

}  // namespace
}  // namespace touchable::test
