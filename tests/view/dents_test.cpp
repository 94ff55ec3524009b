// A surface that gives way under fingers, as pictures show it: the plain twin. (The GPU's is compared with it
// in drawing_test.cpp.)
#include "player/draw/finger_marks.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <memory>
#include <utility>
#include <vector>

#include "player/draw/light_picture.hpp"
#include "player/draw/pictures.hpp"
#include "tests/view/shown.hpp"

namespace touchable::test {
namespace {

TEST(GivenWay, IsForceByStiffnessInTheHandsScale) {
    // 3 N on 1.5 N/mm are 2 mm of the hand; at 0.5 m of the hand for a unit of the scene 0.004 units.
    const glm::dvec3 way = given_way({0, 0, 3}, 1500, 0.5);
    EXPECT_NEAR(way.z, -0.004, 1e-15);
    EXPECT_EQ(glm::length(given_way({1, 2, 3}, 0, 0.5)), 0) << "no spring";
    EXPECT_EQ(glm::length(given_way({NAN, 2, 3}, 1500, 0.5)), 0);
}

TEST(UnderFinger, FindsFootNormalAndHeight) {
    const auto shown = shown_scene("plane", 96, 64);  // 20 degrees about the picture's vertical
    const HeightField field = shown->field();
    const Camera& camera = shown->scene.camera;
    // Three places of the plane, by its depth alone.
    const auto point = [&](int x, int y) {
        return unproject(camera, x, y,
                         planar_depth(camera, shown->scene.depth.semantics, x, y, field.vertex(x, y).depth));
    };
    const glm::dvec3 at = point(40, 30);
    const glm::dvec3 normal = glm::normalize(glm::cross(point(60, 30) - at, point(40, 10) - at));
    const double high = 0.01 * -at.z;
    const auto under = under_finger(field, at + high * normal, 0.05 * -at.z);
    ASSERT_TRUE(under);
    EXPECT_GT(glm::dot(under->normal, normal), 0.9999);
    EXPECT_NEAR(under->height, high, 0.02 * high);
    EXPECT_LT(glm::distance(under->foot, at), 0.03 * high);
    EXPECT_EQ(under_finger(field, at - high * normal, 0.05 * -at.z)->height, 0) << "behind it";
    EXPECT_FALSE(under_finger(field, {0, 0, 1}, 1)) << "behind the camera";
    EXPECT_FALSE(under_finger(field, unproject(camera, -5, 30, -at.z), 1)) << "beside the picture";
}

/// A plane that faces the camera, seen by it, in colours that tell where they come from: two columns of it
/// differ, and no light is on it.
class DentedPlane : public ::testing::Test {
protected:
    DentedPlane() {
        SceneOptions options;
        options.width = width;
        options.height = height;
        options.tilt_degrees = 0;
        shown_ = std::make_unique<Shown>();
        auto made = make_scene("plane", options);
        EXPECT_TRUE(made);
        shown_->scene = (*made)->scene();
        shown_->raw_prev = (*made)->frame(0);
        shown_->raw_next = (*made)->frame(1);
        shown_->build();
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                for (const int value : {x, y, 100}) bytes_.push_back(static_cast<std::uint8_t>(value));
        drawing_.show(shown_->field(), shown_->pair(),
                      PlaneView{bytes_.data(), std::ptrdiff_t{3} * width, width, height, 1, 3},
                      Lighting::plain);
        camera_ = own_view(shown_->scene, width, height, 1e-3 * shown_->scene.depth.near);
        const double depth = planar_depth(shown_->scene.camera, shown_->scene.depth.semantics, width / 2,
                                          height / 2, shown_->field().vertex(width / 2, height / 2).depth);
        pixel_ = depth / shown_->scene.camera.fx;
        sizes_ = {20 * pixel_, 40 * pixel_};
    }
    /// Which touches at a pixel and takes the surface along by so many pixels, y upward.
    FingerMark finger_at(double x, double y, const glm::dvec3& pixels) const {
        FingerMark finger;
        const Camera& camera = shown_->scene.camera;
        finger.proxy = finger.goal = unproject(camera, x, y, pixel_ * camera.fx);
        finger.touching = true;
        finger.under = FingerMark::Under{finger.proxy, {0, 0, 1}, 0};
        finger.given_way = pixels * pixel_;
        return finger;
    }
    /// Dents alone: the picture without the fingers that make them.
    LightPicture dented(const std::vector<FingerMark>& fingers) {
        LightPicture picture{width, height, std::vector<float>(bytes_.size() / 3), {}};
        const Image flat = *drawn({});
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const std::uint8_t* rgb = &flat.samples[3 * picture.index(x, y)];
                picture.light.push_back(light_of(pack_colour(rgb[0], rgb[1], rgb[2])));
                const auto at =
                    camera_.project(unproject(shown_->scene.camera, x, y, pixel_ * shown_->scene.camera.fx));
                picture.z[picture.index(x, y)] = static_cast<float>(at->z);
            }
        std::vector<SurfaceDent> dents;
        shape_dents(fingers, sizes_, dents);
        draw_dents(dents, camera_, picture);
        return picture;
    }
    const Image* drawn(const std::vector<FingerMark>& fingers) {
        const auto picture = drawing_.draw(camera_, fingers, sizes_);
        EXPECT_TRUE(picture);
        return *picture;
    }
    static glm::vec3 bytes_at(const LightPicture& picture, int x, int y) {
        return 255.0F * brightness_of(picture.light[picture.index(x, y)]);
    }

    static constexpr int width = 240, height = 160;
    std::unique_ptr<Shown> shown_;
    std::vector<std::uint8_t> bytes_;
    CpuDrawing drawing_;
    ViewCamera camera_;
    double pixel_ = 1;  // scene units, at the plane
    MarkSizes sizes_;
};

TEST_F(DentedPlane, ColoursGoAlongWithTheFinger) {
    const LightPicture flat = dented({}), picture = dented({finger_at(120, 80, {6, 0, 0})});
    // What was 6 pixels to the left is there now; half a reach (26 pixels) away, 6 (1 - 1/4)^3 to the left.
    EXPECT_NEAR(bytes_at(picture, 120, 80).x, bytes_at(flat, 120, 80).x - 6, 0.7);
    EXPECT_NEAR(bytes_at(picture, 120, 80).y, bytes_at(flat, 120, 80).y, 0.7);
    EXPECT_NEAR(bytes_at(picture, 120, 54).x, bytes_at(flat, 120, 54).x - 6 * 0.4219, 0.7);
    // Where it does not reach (2.6 radii of 20 pixels) all is as it was, to the bit.
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            if (std::hypot(x - 120, y - 80) <= 53) continue;
            ASSERT_EQ(picture.light[picture.index(x, y)], flat.light[flat.index(x, y)]) << x << ' ' << y;
        }
}

TEST_F(DentedPlane, IsLitAsItsSlopesAre) {
    const LightPicture flat = dented({}), picture = dented({finger_at(120, 80, {0, 0, -12})});
    const auto light = [&](int x, int y) { return bytes_at(picture, x, y).z / bytes_at(flat, x, y).z; };
    // 12 pixels deep, 52 wide: at 26 pixels the slope is 6 (12/52) (3/4)^2 (1/2) = 0.389, and twice that in
    // the light, which comes from the upper left. By hand from shaders/surface_light.h and dents.h, of 100.
    EXPECT_NEAR(light(120, 80), 1, 0.01) << "the ground is level";
    EXPECT_NEAR(light(120, 106), 1.443, 0.01);
    EXPECT_NEAR(light(120, 54), 0.554, 0.01);
    EXPECT_NEAR(light(146, 80), 1.120, 0.01);
    EXPECT_NEAR(light(94, 80), 0.716, 0.01);
}

TEST_F(DentedPlane, IsNeverDeeperThanCanBeDrawn) {
    std::vector<SurfaceDent> dents;
    shape_dents(std::vector{finger_at(120, 80, {0, 0, -300})}, sizes_, dents);
    ASSERT_EQ(dents.size(), 1U);
    EXPECT_NEAR(glm::length(dents[0].moved), 1.3 * sizes_.finger_radius, 1e-9 * pixel_);
    auto free = finger_at(120, 80, {0, 0, -3});
    free.touching = false;
    auto firm = finger_at(120, 80, {0, 0, 0});
    shape_dents(std::vector{free, firm}, sizes_, dents);
    EXPECT_TRUE(dents.empty());
}

TEST_F(DentedPlane, DentsThatOverlapAreOneWhateverTheirOrder) {
    const FingerMark left = finger_at(100, 80, {4, 3, -8}), right = finger_at(140, 80, {-5, 2, -9});
    const LightPicture one = dented({left, right}), other = dented({right, left});
    for (std::size_t k = 0; k < one.light.size(); ++k)
        ASSERT_LT(glm::distance(one.light[k], other.light[k]), 1e-5F);
    const LightPicture alone = dented({left});
    EXPECT_GT(glm::distance(one.light[one.index(120, 80)], alone.light[one.index(120, 80)]), 0.005F);
}

/// A dent is on the surface alone.
TEST_F(DentedPlane, BackgroundStays) {
    LightPicture empty{width, height, std::vector<float>(bytes_.size() / 3, 0.0F),
                       std::vector<glm::vec3>(bytes_.size() / 3, glm::vec3(0.5F))};
    std::vector<SurfaceDent> dents;
    shape_dents(std::vector{finger_at(120, 80, {9, 0, -9})}, sizes_, dents);
    draw_dents(dents, camera_, empty);
    for (const glm::vec3& light : empty.light) ASSERT_EQ(light, glm::vec3(0.5F));
}

}  // namespace
}  // namespace touchable::test
