#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>

#include "player/draw/finger_marks.hpp"
#include "player/draw/light_picture.hpp"
#include "player/draw/pictures.hpp"
#include "tests/view/shown.hpp"

namespace touchable::test {
namespace {

Result<Image> picture(const Shown& shown, const SurfacePainter::Settings& settings,
                      std::span<const FingerMark> fingers) {
    const HeightField field = shown.field();
    const auto painter = make_cpu_painter();
    return make_picture(settings, shown.scene, make_view_surface(field, shown.raw_prev.colour),
                        subject_of(field), fingers, {2, 6}, *painter);
}

TEST(ScenePicture, HasTheSizeAskedFor) {
    const auto shown = shown_scene("globe", 96, 64);
    const int sizes[][2] = {{1, 1}, {2, 2}, {5, 300}, {160, 90}};
    for (const auto& [width, height] : sizes) {
        const auto image = picture(*shown, {{}, width, height}, {});
        ASSERT_TRUE(image);
        EXPECT_EQ(image->width, width);
        EXPECT_EQ(image->height, height);
        EXPECT_EQ(image->channels, 3);
        EXPECT_EQ(image->samples.size(), static_cast<std::size_t>(3 * width * height));
    }
}

TEST(ScenePicture, IsTheSameEveryTime) {
    const auto shown = shown_scene("globe", 96, 64);
    const FingerMark finger{{0, 0, -80}, {0, 0, -70}, {0, 0, 2}, true, {{-5, 0, -70}, {0, 0, -70}}};
    const auto first = picture(*shown, {{}, 160, 90}, {&finger, 1});
    const auto again = picture(*shown, {{}, 160, 90}, {&finger, 1});
    EXPECT_EQ(first->samples, again->samples);
}

TEST(ScenePicture, OfNothingIsBackground) {
    auto shown = shown_scene("globe", 96, 64);
    shown->prev.vertices = std::make_unique<ExactVertices>(96, 64, std::vector<double>(96 * 64, NAN));
    const auto image = picture(*shown, {{}, 20, 10}, {});
    ASSERT_TRUE(image);
    for (int y = 0; y < 10; ++y)
        for (int x = 1; x < 20; ++x)
            for (int channel = 0; channel < 3; ++channel)
                EXPECT_EQ(image->view().sample(x, y, channel), image->view().sample(0, y, channel));
}

int pixels_that_differ(const Image& a, const Image& b) {
    int count = 0;
    for (std::size_t k = 0; k < a.samples.size(); k += 3)
        count += a.samples[k] != b.samples[k] || a.samples[k + 1] != b.samples[k + 1] ||
                 a.samples[k + 2] != b.samples[k + 2];
    return count;
}

TEST(ScenePicture, ShowsAFingerWhereItIs) {
    const auto shown = shown_scene("plane", 96, 64);
    Viewpoint own;
    own.own = true;
    const auto bare = picture(*shown, {own, 192, 128}, {});
    // Half a finger before the surface, over the pixel (60, 20).
    const HeightField field = shown->field();
    const Camera& camera = shown->scene.camera;
    const double depth =
        planar_depth(camera, shown->scene.depth.semantics, 60, 20, field.vertex(60, 20).depth);
    FingerMark finger;
    finger.proxy = finger.goal = unproject(camera, 60, 20, depth);
    const auto marked = picture(*shown, {own, 192, 128}, {&finger, 1});
    EXPECT_GT(pixels_that_differ(*bare, *marked), 10);
    const auto ball = marked->view(), before = bare->view();
    EXPECT_NE(ball.sample(121, 41, 0), before.sample(121, 41, 0));
    // Away from the finger and its shadow nothing changes.
    const double reach = 6.0 * camera.fx * 2 / depth + 3;
    for (int y = 0; y < 128; ++y)
        for (int x = 0; x < 192; ++x) {
            if (std::hypot(x - 121.0, y - 41.0) <= reach) continue;
            for (int channel = 0; channel < 3; ++channel)
                ASSERT_EQ(ball.sample(x, y, channel), before.sample(x, y, channel)) << x << ", " << y;
        }
}

TEST(ScenePicture, HidesWhatIsBehindTheSurface) {
    const auto shown = shown_scene("plane", 96, 64);
    Viewpoint own;
    own.own = true;
    const auto bare = picture(*shown, {own, 96, 64}, {});
    FingerMark hidden;
    hidden.proxy = hidden.goal = {0, 0, -2 * shown->scene.depth.far};
    const auto marked = picture(*shown, {own, 96, 64}, {&hidden, 1});
    EXPECT_EQ(pixels_that_differ(*bare, *marked), 0);
}

TEST(ScenePicture, AFingerThatTouchesShowsItsGoalThroughTheSurface) {
    const auto shown = shown_scene("plane", 96, 64);
    Viewpoint own;
    own.own = true;
    FingerMark hidden;
    hidden.touching = true;
    hidden.proxy = {0, 0, -2 * shown->scene.depth.far};
    hidden.goal = hidden.proxy - glm::dvec3(0, 0, 1);
    const auto bare = picture(*shown, {own, 192, 128}, {});
    const auto marked = picture(*shown, {own, 192, 128}, {&hidden, 1});
    EXPECT_GT(pixels_that_differ(*bare, *marked), 0);
}

/// docs/window.md: the arrow is the force on the finger.
TEST(FingerMarks, TheArrowPointsWhereTheFingerIsPushed) {
    FingerMark finger;
    finger.goal = {1, 2, -80};
    finger.proxy = {1, 2, -70};
    finger.force = {0, 3, 4};
    finger.touching = true;
    FingerShapes shapes;
    shape_fingers({&finger, 1}, {2, 6}, {0, 0, 0}, shapes);
    double farthest = 0;
    int parts = 0;
    for (const Solid& solid : shapes.solids) {
        if (solid.is_ball) continue;
        ++parts;
        EXPECT_NEAR(solid.along.y, 0.6, 1e-12);
        EXPECT_NEAR(solid.along.z, 0.8, 1e-12);
        const glm::dvec3 tip = solid.foot + solid.to.height * solid.along;
        farthest = std::max(farthest, glm::dot(tip - finger.proxy, glm::dvec3(0, 0.6, 0.8)));
    }
    EXPECT_GT(parts, 0);
    EXPECT_NEAR(farthest, 5 * 6 + 2, 0.2) << "5 N, 6 units each, from the rim of the finger";
}

/// Of 1 N and of 9 N that come at the eye, and of 9 N aside.
TEST(FingerMarks, AnArrowAtTheEyeLeavesTheFingerFree) {
    const auto widest = [](const glm::dvec3& force) {
        FingerMark finger;
        finger.goal = {0, 0, -102};
        finger.proxy = {0, 0, -100};
        finger.force = force;
        finger.touching = true;
        FingerShapes shapes;
        shape_fingers({&finger, 1}, {2, 6}, {0, 0, 0}, shapes);
        double radii = 0;  // as they are seen, at the ball's distance
        for (const Solid& solid : shapes.solids)
            if (!solid.is_ball)
                for (const Ring& ring : {solid.from, solid.to}) {
                    const glm::dvec3 at = solid.foot + ring.height * solid.along;
                    radii = std::max(radii, ring.radius / 2 * 100 / -at.z);
                }
        return radii;
    };
    EXPECT_LT(widest({0, 0, 1}), 0.6);
    EXPECT_LT(widest({0, 0, 9}), 0.6);
    EXPECT_LT(widest({0, 0, 15}), 0.6) << "nearly at the eye";
    EXPECT_NEAR(widest({0, 9, 0}), 0.884, 1e-3);
}

/// In every finger's colour, so that it is seen on dark ground.
TEST(FingerMarks, TheArrowIsBrighterThanTheFinger) {
    for (std::size_t k = 0; k < 5; ++k) {
        std::vector<FingerMark> fingers(5);
        for (FingerMark& finger : fingers) finger.shown = false;
        fingers[k].shown = fingers[k].touching = true;
        fingers[k].force = {0, 3, 4};
        FingerShapes shapes;
        shape_fingers(fingers, {2, 6}, {0, 0, 0}, shapes);
        const auto most = [](const Solid& solid) {
            const glm::vec3& light = solid.material.light;
            return std::max({light.x, light.y, light.z});
        };
        for (const Solid& solid : shapes.solids) {
            if (solid.is_ball) continue;
            EXPECT_NEAR(most(solid), 1, 1e-6) << k;
            EXPECT_GT(most(solid), most(shapes.solids.front())) << k;
        }
    }
}

TEST(LightPicture, DevelopsEveryByteToItself) {
    LightPicture picture{256, 1, {}, {}};
    for (unsigned k = 0; k < 256; ++k) picture.light.push_back(light_of(pack_colour(k, k, k)));
    const Image image = developed(picture, 1);
    for (std::size_t k = 0; k < 256; ++k) EXPECT_EQ(image.samples[3 * k], k);
}

TEST(LightPicture, AveragesLightAndNotBrightness) {
    LightPicture picture{2, 2, {}, {glm::vec3(0), glm::vec3(1), glm::vec3(1), glm::vec3(0)}};
    EXPECT_EQ(developed(picture, 2).samples[0], 188);  // sRGB of half the light; brightness would be 128
}

}  // namespace
}  // namespace touchable::test
