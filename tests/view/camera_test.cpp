#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "player/draw/view.hpp"

namespace touchable {
namespace {

Scene any_scene() {
    Scene scene;
    scene.width = 640;
    scene.height = 480;
    scene.camera = {600, 590, 311.5, 243.25};
    scene.depth.near = 50;
    scene.depth.far = 900;
    return scene;
}

void expect_near(const glm::dvec3& a, const glm::dvec3& b, double tolerance) {
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(a[axis], b[axis], tolerance);
}

TEST(ViewCamera, OwnViewShowsEachVertexAtTheCentreOfItsPixel) {
    const Scene scene = any_scene();
    const ViewCamera view = own_view(scene, scene.width, scene.height, 1.0);
    for (const double x : {0.0, 17.0, 311.0, 639.0})
        for (const double y : {0.0, 100.0, 479.0})
            for (const double depth : {50.0, 333.3, 900.0}) {
                const auto screen = view.project(unproject(scene.camera, x, y, depth));
                ASSERT_TRUE(screen);
                expect_near(*screen, {x + 0.5, y + 0.5, 1.0 / depth}, 1e-9);
            }
}

TEST(ViewCamera, OwnViewOfAnotherShapeIsAsLargeAsFitsAndCentred) {
    const Scene scene = any_scene();
    const ViewCamera view = own_view(scene, 1280, 720, 1.0);
    const auto corner = view.project(unproject(scene.camera, -0.5, -0.5, 100));
    const auto other = view.project(unproject(scene.camera, 639.5, 479.5, 100));
    ASSERT_TRUE(corner && other);
    expect_near(*corner, {160, 0, 0.01}, 1e-9);
    expect_near(*other, {1120, 720, 0.01}, 1e-9);
}

TEST(ViewCamera, WhatIsNearIsNotCutOffAsSoonAsAViewIsTurned) {
    const Scene scene = any_scene();
    for (const double depth : {2.0, 4.0, 50.0, 900.0, 1e5})
        for (const double turned : {0.0, 0.05, -0.1}) {
            Viewpoint viewpoint;
            viewpoint.own = turned == 0.0;
            viewpoint.azimuth = turned;
            const auto seen = make_view(viewpoint, scene, {0, 0, -400}, 800, 600)
                                  .project(unproject(scene.camera, 311.5, 243.25, depth));
            ASSERT_TRUE(seen) << depth << ", turned by " << turned;
            EXPECT_GT(seen->z, 0);
        }
}

TEST(ViewCamera, TheLatticeAndTheWorldAreSeenAtTheSamePlace) {
    const Scene scene = any_scene();
    Viewpoint viewpoint;
    viewpoint.azimuth = 31;
    viewpoint.elevation = -12;
    viewpoint.zoom = 1.4;
    const ViewCamera view = make_view(viewpoint, scene, {12, -7, -400}, 800, 600);
    for (const double x : {3.0, 300.0, 600.0})
        for (const double depth : {200.0, 500.0}) {
            const glm::dvec4 lattice = view.clip_from_lattice * glm::dvec4(x, 77, 1, 1 / depth);
            const auto world = view.project(unproject(scene.camera, x, 77, depth));
            ASSERT_TRUE(world);
            expect_near(
                {(lattice.x / lattice.w + 1) * 400, (lattice.y / lattice.w + 1) * 300, lattice.z / lattice.w},
                *world, 1e-8);
        }
}

TEST(ViewCamera, OrbitKeepsItsCentreInTheMiddleAndItsDistance) {
    const Scene scene = any_scene();
    const glm::dvec3 centre(40, 25, -300);
    for (const double azimuth : {-120.0, 0.0, 45.0})
        for (const double elevation : {-80.0, 0.0, 30.0}) {
            Viewpoint viewpoint{false, azimuth, elevation, 2, std::nullopt};
            const ViewCamera view = make_view(viewpoint, scene, centre, 640, 480);
            const auto screen = view.project(centre);
            ASSERT_TRUE(screen);
            EXPECT_NEAR(screen->x, 320, 1e-6);
            EXPECT_NEAR(screen->y, 240, 1e-6);
            EXPECT_NEAR(view.near / screen->z, 150, 1e-6);
        }
}

TEST(ViewCamera, OrbitGoesToTheRightAndUp) {
    const Scene scene = any_scene();
    const ViewCamera right = make_view({false, 30, 0, 1, std::nullopt}, scene, {0, 0, -300}, 640, 480);
    EXPECT_GT(right.eye.x, 0);
    EXPECT_NEAR(right.eye.y, 0, 1e-9);
    const ViewCamera above = make_view({false, 0, 30, 1, std::nullopt}, scene, {0, 0, -300}, 640, 480);
    EXPECT_GT(above.eye.y, 0);
    // Up is up, and right is right.
    const auto higher = above.project({0, 10, -300}), rightmost = above.project({10, 0, -300});
    EXPECT_LT(higher->y, 240);
    EXPECT_GT(rightmost->x, 320);
}

TEST(ViewCamera, FieldOfViewIsThatOfThePicturesHeight) {
    const Scene scene = any_scene();
    const ViewCamera view = make_view({false, 0, 0, 1, 90.0}, scene, {0, 0, -300}, 640, 480);
    EXPECT_NEAR(view.project({0, 300, -300})->y, 0, 1e-6);
}

TEST(ViewCamera, TheWholeZoomShowsEveryPointAndNoMoreThanItHasTo) {
    const Scene scene = any_scene();
    const glm::dvec3 centre(0, 0, -300);
    std::vector<glm::dvec3> ball;
    for (int k = 0; k < 100; ++k)
        for (int j = 0; j < 50; ++j) {
            const double longitude = 0.0628 * k, latitude = 0.0628 * (j - 25);
            ball.push_back(centre + 190.0 * glm::dvec3(std::cos(longitude) * std::cos(latitude),
                                                       std::sin(latitude),
                                                       std::sin(longitude) * std::cos(latitude)));
        }
    for (const auto& [width, height] : {std::pair(640, 480), std::pair(300, 900), std::pair(900, 200)})
        for (const std::optional<double> fov : {std::optional<double>(), std::optional(30.0)}) {
            Viewpoint viewpoint{false, 20, 15, std::nullopt, fov};
            viewpoint.zoom = whole_zoom(viewpoint, scene, centre, ball, width, height);
            ASSERT_LT(*viewpoint.zoom, 1);
            ASSERT_GT(*viewpoint.zoom, 0.1);
            const ViewCamera view = make_view(viewpoint, scene, centre, width, height);
            double farthest = 0;  // from the middle, in halves of the picture
            for (const glm::dvec3& point : ball) {
                const auto screen = view.project(point);
                ASSERT_TRUE(screen);
                farthest = std::max(
                    {farthest, std::abs(2 * screen->x / width - 1), std::abs(2 * screen->y / height - 1)});
            }
            EXPECT_LT(farthest, 1.0);
            EXPECT_GT(farthest, 0.88);
        }
}

TEST(ViewCamera, TheWholeZoomOfWhatIsSmallOrNothingIsOne) {
    const glm::dvec3 centre(0, 0, -300);
    const std::vector<glm::dvec3> points{{10, 0, -300}, {0, 10, -290}};
    EXPECT_EQ(whole_zoom({}, any_scene(), centre, points, 640, 480), 1);
    EXPECT_EQ(whole_zoom({}, any_scene(), centre, {}, 640, 480), 1);
}

TEST(ViewCamera, UnprojectIsTheInverseOfProject) {
    const Scene scene = any_scene();
    const ViewCamera view = make_view({false, -50, 20, 1.5, std::nullopt}, scene, {5, 6, -250}, 300, 200);
    const glm::dvec3 point(31, -14, -222);
    const auto screen = view.project(point);
    ASSERT_TRUE(screen);
    expect_near(view.unproject(screen->x, screen->y, screen->z), point, 1e-8);
}

TEST(ViewCamera, NothingBehindTheNearPlaneIsProjected) {
    const ViewCamera view = own_view(any_scene(), 640, 480, 10);
    EXPECT_TRUE(view.project({0, 0, -10.001}));
    EXPECT_FALSE(view.project({0, 0, -9.999}));
    EXPECT_FALSE(view.project({0, 0, 5}));
}

TEST(Viewpoint, IsReadFromWords) {
    EXPECT_TRUE(parse_viewpoint("own")->own);
    EXPECT_FALSE(parse_viewpoint("orbit")->own);
    const auto orbit = parse_viewpoint("orbit:az=-20.5,el=10,zoom=1.25,fov=40");
    ASSERT_TRUE(orbit);
    EXPECT_EQ(orbit->azimuth, -20.5);
    EXPECT_EQ(orbit->elevation, 10);
    EXPECT_EQ(orbit->zoom, 1.25);
    EXPECT_EQ(orbit->fov, 40);
}

TEST(Viewpoint, RefusesWhatItDoesNotKnowAndSaysWhatWouldBeRight) {
    for (const char* words :
         {"", "front", "orbits", "orbit:az", "orbit:az=", "orbit:az=1x", "orbit:az=nan", "orbit:roll=3",
          "orbit:el=90", "orbit:az=1,az=1", "orbit:zoom=0", "orbit:fov=180", "orbit:az=181"}) {
        const auto refused = parse_viewpoint(words);
        ASSERT_FALSE(refused) << words;
        EXPECT_EQ(refused.error().kind, ErrorKind::usage);
        EXPECT_TRUE(refused.error().message.starts_with("view ")) << refused.error().message;
        EXPECT_EQ(refused.error().hints.at(0).setting, Setting::view);
    }
    EXPECT_NE(parse_viewpoint("orbit:zoom=0").error().message.find("0.1 to 20"), std::string::npos);
}

}  // namespace
}  // namespace touchable
