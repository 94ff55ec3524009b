// How forces are told beside fingers, and on the bar.
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "player/draw/light_picture.hpp"
#include "player/window/finger_halos.hpp"
#include "player/window/opened_clip.hpp"
#include "tests/view/shown.hpp"

namespace touchable::test {
namespace {

/// The figures of docs/drawing.md.
TEST(Ring, TightensWithForceAndClosesInWithTheSurface) {
    EXPECT_DOUBLE_EQ(ring_radii(0, 0, 10), 1.55);
    EXPECT_DOUBLE_EQ(ring_radii(0, 1, 10), 1.46);
    EXPECT_DOUBLE_EQ(ring_radii(0, 3, 10), 1.28);
    EXPECT_DOUBLE_EQ(ring_radii(0, 5, 10), 1.1);
    EXPECT_DOUBLE_EQ(ring_radii(0, 9, 10), 1.1) << "the ball stays in it";
    EXPECT_DOUBLE_EQ(ring_radii(0, 1, 2), 1.325) << "a device that has 2 N";
    EXPECT_DOUBLE_EQ(ring_radii(0.5 / 3.2, 0, 10), 1.6125);
    EXPECT_DOUBLE_EQ(ring_radii(4 / 3.2, 0, 10), 2.05);
    EXPECT_DOUBLE_EQ(ring_radii(50, 0, 10), 2.35);
}

TEST(Shadow, ClosesInAndDarkens) {
    FingerMark finger;
    const auto at = [&](double radii) {
        finger.proxy = {0, 0, 2 * radii - 100};
        finger.under = FingerMark::Under{{0, 0, -100}, {0, 0, 1}, 2 * radii};
        return shadow_of(finger, 2);
    };
    const BallShadow far = at(4 / 3.2), near = at(0.5 / 3.2);
    EXPECT_DOUBLE_EQ(far.reach, 2 * 2.75);
    EXPECT_DOUBLE_EQ(near.reach, 2 * 1.65625);
    EXPECT_NEAR(far.darkness, 0.3, 1e-6);
    EXPECT_NEAR(near.darkness, 0.6316, 1e-4);
    // To the lower right, as the light comes from the upper left; on the surface.
    EXPECT_DOUBLE_EQ(far.centre.x, 0.78 * 2.5);
    EXPECT_DOUBLE_EQ(far.centre.y, -0.92 * 2.5);
    EXPECT_DOUBLE_EQ(far.centre.z, -100);
    finger.touching = true;
    const BallShadow met = at(0);
    EXPECT_EQ(met.centre, finger.under->foot);
    EXPECT_DOUBLE_EQ(met.reach, 3);
    EXPECT_NEAR(met.darkness, 0.75, 1e-6);
}

/// A finger before the middle of a plane, seen by the clip's own camera.
class FingerMarksInAWindow : public ::testing::Test {
protected:
    FingerHalo halo_of(const glm::dvec3& newtons) const {
        FingerMark mark;
        mark.goal = mark.proxy = {0, 0, -0.5 * shown_->scene.depth.near};
        mark.force = newtons;
        mark.touching = true;
        const auto halos = finger_halos({&mark, 1}, {2, 6}, shown_->field(), camera_);
        EXPECT_EQ(halos.size(), 1U);
        return halos.empty() ? FingerHalo() : halos[0];
    }
    const std::unique_ptr<Shown> shown_ = shown_scene("plane", 96, 64);
    const ViewCamera camera_ = own_view(shown_->scene, 192, 128, 1e-3 * shown_->scene.depth.near);
};

TEST_F(FingerMarksInAWindow, TheRingTellsWhetherTheForceComesOrGoes) {
    EXPECT_TRUE(halo_of({0, 0, 2}).towards_eye);
    EXPECT_FALSE(halo_of({0, 0, -2}).towards_eye);
    EXPECT_EQ(halo_of({0, 0, -2}).newtons, 2);
}

TEST_F(FingerMarksInAWindow, AFullTurnOfTheRingIsTheLargestForce) {
    const FingerHalo one = halo_of({0, 0, 1}), three = halo_of({0, 0, 3}), most = halo_of({0, 0, 11});
    EXPECT_DOUBLE_EQ(one.share, 0.1);
    EXPECT_DOUBLE_EQ(three.share, 0.3);
    EXPECT_EQ(most.share, 1);
    EXPECT_DOUBLE_EQ(one.ring, 1.46 * one.radius);
    EXPECT_DOUBLE_EQ(three.ring, 1.28 * three.radius);
}

TEST_F(FingerMarksInAWindow, TheArrowGoesWhereTheFingerIsPushed) {
    const FingerHalo right = halo_of({1, 0, 0}), up = halo_of({0, 1, 0});
    EXPECT_GT(right.arrow.x, 1);
    EXPECT_NEAR(right.arrow.y, 0, 1e-9);
    EXPECT_LT(up.arrow.y, -1) << "pixels count downward";
    EXPECT_NEAR(up.arrow.x, 0, 1e-9);
}

TEST_F(FingerMarksInAWindow, TheForceIsTheOneThatWasAskedOfTheDevice) {
    WatchedTick tick;
    tick.tick = 1;
    tick.fingers.resize(1);
    tick.fingers[0].contact.touching = true;
    tick.fingers[0].contact.proxy = tick.fingers[0].contact.goal = {0, 0, -1};
    tick.fingers[0].force.force = {1, -2, 3};
    const auto marks = FingerTrails().marks(tick, 1, shown_->field());
    ASSERT_EQ(marks.size(), 1U);
    EXPECT_EQ(marks[0].force, glm::dvec3(1, -2, 3));
}

TEST(FingerHalos, LabelsStandBesideFingersThatAreCloseAndNeverOnEachOther) {
    std::vector<LabelBox> taken{{{90, 90}, {110, 110}}, {{115, 90}, {135, 110}}};  // two rings
    const glm::dvec2 size(40, 16);
    const auto place = [&](const glm::dvec2& at) {
        const auto free = place_label(at, 15, size, taken);
        if (free) taken.push_back({*free, *free + size});
        return free;
    };
    EXPECT_EQ(place({100, 100}), glm::dvec2(45, 92)) << "to the left: the other finger is to the right";
    EXPECT_EQ(place({125, 100}), glm::dvec2(140, 92));
    EXPECT_EQ(place({100, 100}), glm::dvec2(80, 69)) << "above";
    EXPECT_EQ(place({100, 100}), glm::dvec2(80, 115)) << "below";
    EXPECT_FALSE(place({100, 100}));
}

}  // namespace
}  // namespace touchable::test
