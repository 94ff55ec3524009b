// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include <cmath>
#include <string>
#include <vector>

#include "engine/content/scenes.hpp"
#include "player/view/pointer.hpp"
#include "player/window/clip_picture.hpp"

namespace touchable::test {
namespace {

class WindowViewTest : public ::testing::Test {
protected:
    ViewCamera camera() const { return view.camera(720, 480); }

    Scene scene = (*make_scene("globe", {}))->scene();
    WindowView view{scene, {0, 0, -600}};
};

double largest_difference(const glm::dmat4& a, const glm::dmat4& b) {
    double largest = 0;
    for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 4; ++r) largest = std::max(largest, std::abs(a[c][r] - b[c][r]));
    return largest;
}

TEST_F(WindowViewTest, ReturnsToOwnView) {
    const ViewCamera own = camera();
    EXPECT_EQ(largest_difference(own.clip_from_world, own_view(scene, 720, 480, 0.6).clip_from_world), 0);
    view.turn(30, 10);
    EXPECT_FALSE(view.own());
    view.near_by(2);
    view.pan(10, 10, 720, 480);
    view.go_home();
    EXPECT_EQ(largest_difference(own.clip_from_world, camera().clip_from_world), 0);
}

TEST_F(WindowViewTest, ReturnsToEarlierState) {
    const WindowView::State own = view.state();
    view.turn(30, 10);
    view.pan(10, 10, 720, 480);
    const WindowView::State moved = view.state();
    const ViewCamera then = camera();
    view.near_by(2);
    EXPECT_FALSE(view.state().looks_as(moved));
    view.go_home();
    EXPECT_TRUE(view.state().looks_as(own) && !own.looks_as(moved));
    view.set_state(moved);
    EXPECT_TRUE(view.state().looks_as(moved));
    EXPECT_EQ(largest_difference(then.clip_from_world, camera().clip_from_world), 0);
}

TEST_F(WindowViewTest, FirstTurnDoesNotJump) {
    scene.camera.cx -= 8;  // as of recordings, whose axis is not in the picture's middle
    scene.camera.cy += 6;
    WindowView beside(scene, {3, -5, -600});
    const auto own = beside.camera(720, 480).project({10, 20, -580});
    beside.turn(0, 0);
    const auto orbit = beside.camera(720, 480).project({10, 20, -580});
    ASSERT_TRUE(own && orbit);
    EXPECT_NEAR(own->x, orbit->x, 1e-6);
    EXPECT_NEAR(own->y, orbit->y, 1e-6);
}

TEST_F(WindowViewTest, PanFollowsPointer) {
    view.turn(20, 5);
    const auto before = camera().project({0, 0, -600});
    view.pan(30, -12, 720, 480);
    const auto after = camera().project({0, 0, -600});
    EXPECT_NEAR(after->x - before->x, 30, 0.5);
    EXPECT_NEAR(after->y - before->y, -12, 0.5);
}

TEST_F(WindowViewTest, LookAtKeepsDistance) {
    view.turn(15, 0);
    const double before = glm::length(camera().eye - glm::dvec3(0, 0, -600));
    const glm::dvec3 place(40, 30, -550);
    view.look_at(place);
    const ViewCamera turned = camera();
    const auto seen = turned.project(place);
    ASSERT_TRUE(seen);
    EXPECT_NEAR(seen->x, scene.camera.cx + 0.5, 1e-6);
    EXPECT_NEAR(seen->y, scene.camera.cy + 0.5, 1e-6);
    EXPECT_NEAR(glm::length(turned.eye - place), before, 1e-6);
}

/// The view and picks are those of a picture that has the upper part alone.
TEST_F(WindowViewTest, BottomMarginShrinksPicture) {
    WindowView upper(scene, {0, 0, -600});
    view.leave_free({0, 0.125});
    const glm::dvec3 place(40, -130, -550);
    for (const bool is_turned : {false, true}) {
        if (is_turned) view.turn(20, 5);
        if (is_turned) upper.turn(20, 5);
        const ViewCamera whole = camera(), small = upper.camera(720, 420);
        EXPECT_EQ(whole.height, 480);
        const auto seen = whole.project(place), wanted = small.project(place);
        ASSERT_TRUE(seen && wanted);
        EXPECT_NEAR(glm::distance(*seen, *wanted), 0, 1e-9);
        EXPECT_LT(glm::distance(whole.unproject(seen->x, seen->y, seen->z), place), 1e-6);
    }
    view.go_home();
    const ViewCamera own = camera();
    const glm::dvec4 corner = own.clip_from_lattice * glm::dvec4(0, scene.height - 0.5, 1, 1 / 600.0);
    EXPECT_NEAR((corner.y / corner.w + 1) * 240, 420, 1e-9) << "the clip's lowest row";
    view.leave_free({0, 0});
    EXPECT_EQ(largest_difference(camera().clip_from_world, own_view(scene, 720, 480, 0.6).clip_from_world),
              0);
}

TEST_F(WindowViewTest, CopiesOtherView) {
    WindowView next(scene, {0, 0, -300});
    next.look_as(view);
    EXPECT_TRUE(next.own());
    view.turn(30, 10);
    view.near_by(2);
    next.look_as(view);
    EXPECT_FALSE(next.own());
    EXPECT_EQ(next.orbit().azimuth, 30);
    EXPECT_EQ(next.orbit().zoom, 2);
    next.go_home();
    EXPECT_TRUE(next.own());
}

class PictureGovernorTest : public ::testing::Test {
protected:
    /// Plays so long, with pictures that take `full` of a frame's time at full size and `rest` of it at any;
    /// with all vertices `vertices` more, if a coarse picture saves any. Gives when the share was first
    /// another than at the start.
    double play(double seconds, double full, double rest, double vertices = 0) {
        const double end = now + seconds, share = governor.share();
        double changed = 0;
        for (; now < end; now += 1.0 / 30) {
            const double size = governor.share() * governor.share();
            add(now, rest + full * size + (governor.coarse() ? 0 : vertices), vertices > 0);
            if (changed == 0 && governor.share() != share) changed = now;
        }
        return changed;
    }
    /// One picture, which is in time if it took less than a frame.
    void add(double at_s, double drawing, bool has_vertices = true) {
        governor.add(at_s, 1, drawing <= 1 ? 1 : 0, drawing, has_vertices);
    }

    PictureGovernor governor;
    double now = 0;
};

TEST_F(PictureGovernorTest, KeepsFullSizeWithTime) {
    play(10, 0.7, 0.2);
    EXPECT_EQ(governor.share(), 1);
}

TEST_F(PictureGovernorTest, IgnoresOtherDelays) {
    for (int k = 0; k < 300; ++k) governor.add(k / 30.0, 2, 0, 0.1, false);
    EXPECT_EQ(governor.share(), 1);
}

TEST_F(PictureGovernorTest, ShrinksAndGrowsWithLoad) {
    EXPECT_LT(play(2, 1.2, 0.1), 1);
    EXPECT_EQ(governor.share(), 0.75);
    play(20, 1.2, 0.1);
    EXPECT_EQ(governor.share(), 0.75) << "a larger picture has no room";
    EXPECT_GT(play(20, 0.5, 0.1), 0);
    EXPECT_EQ(governor.share(), 1);
}

TEST_F(PictureGovernorTest, GivesUpUselessShrinking) {
    play(5, 0.1, 1.5);
    EXPECT_EQ(governor.share(), 1);
    const double begin = now;
    const double tried = play(80, 0.1, 1.5);
    EXPECT_GT(tried, begin + 30) << "not at once again";
}

TEST_F(PictureGovernorTest, StartsCoarseAndRefines) {
    EXPECT_TRUE(governor.coarse());
    play(2, 0.1, 0.1, 0.3);
    EXPECT_TRUE(governor.coarse()) << "not at once: that would be seen";
    play(10, 0.1, 0.1, 0.3);
    EXPECT_FALSE(governor.coarse());
    play(2, 0.1, 0.1, 1.2);
    EXPECT_TRUE(governor.coarse());
    EXPECT_EQ(governor.share(), 1) << "which is enough";
    governor = PictureGovernor();
    play(30, 0.2, 0.1, 2);
    EXPECT_TRUE(governor.coarse()) << "three times as much has no room";
}

TEST_F(PictureGovernorTest, SkipsUselessStep) {
    // Decoding takes what the first step leaves.
    const auto drawing = [&] { return governor.share() == 1 ? 1.5 : governor.share() == 0.75 ? 1.45 : 0.9; };
    for (const double end = now + 3; now < end; now += 1.0 / 30) add(now, drawing());
    EXPECT_EQ(governor.share(), 0.5);
}

// A picture that takes most of a frame comes in time by luck of its phase.
TEST_F(PictureGovernorTest, KeepsWhatComesInTime) {
    for (int k = 0; k < 30; ++k)
        governor.add(k / 30.0, 1, governor.share() < 1 ? 1 : 0, governor.share() < 1 ? 0.88 : 0.9, true);
    EXPECT_EQ(governor.share(), 0.75);
}

TEST_F(PictureGovernorTest, HeedsEveryTenthLatePicture) {
    const auto play_with_late = [&](double from_s, int each) {
        for (int k = 0; k < 60; ++k)
            governor.add(from_s + k / 30.0, 1, k % each == 0 ? 0 : 1, 0.9 * governor.share(), false);
    };
    play_with_late(0, 15);
    EXPECT_EQ(governor.share(), 1) << "one of fifteen";
    play_with_late(2, 7);
    EXPECT_LT(governor.share(), 1);
}

TEST_F(PictureGovernorTest, DropsFastForLatePictures) {
    for (int k = 0; k < 2; ++k) add(k / 30.0, 1.5);
    EXPECT_EQ(governor.share(), 0.75);
    PictureGovernor smaller;
    for (int k = 0; k < 4; ++k) smaller.add(k / 30.0, 1, 0, 1.5, true);
    EXPECT_EQ(smaller.share(), 0.5);
    for (int k = 4; k < 19; ++k) smaller.add(k / 30.0, 1, 0, k < 8 ? 2 : 0.9, true);
    EXPECT_EQ(smaller.share(), 0.25) << "not judged by its first pictures";
}

TEST_F(PictureGovernorTest, GoesToWhatFits) {
    for (const auto& [drawing, share] : {std::pair{3.5, 0.25}, {2.2, 0.5}}) {
        governor = {};
        for (int k = 0; k < 2; ++k) add(k / 30.0, drawing);
        EXPECT_EQ(governor.share(), share) << "in one step";
    }
}

TEST_F(PictureGovernorTest, IgnoresWarmUpPictures) {
    // A clip that has just opened fills its memory beside them.
    for (int k = 0; k < 300; ++k) {
        add(k / 30.0, governor.share() == 1 ? 1.1 : k < 20 ? 1.05 : 0.7);
        if (k > 2) {
            ASSERT_LT(governor.share(), 1) << k;
        }
    }
}

TEST(RedrawEstimator, IsMedianOfLastFew) {
    RedrawEstimator redraw;
    EXPECT_EQ(redraw.ms(), 0);
    for (const double ms : {9, 8, 20}) redraw.add(ms);
    EXPECT_EQ(redraw.ms(), 9) << "one that had to wait says nothing of the next";
    for (int k = 0; k < 8; ++k) redraw.add(12);
    EXPECT_EQ(redraw.ms(), 12);
}

TEST(RedrawEstimator, DecaysWithoutDrawing) {
    RedrawEstimator redraw;
    for (int k = 0; k < 8; ++k) redraw.add(17);
    for (int k = 0; k < 60; ++k) redraw.add_frame();
    EXPECT_LT(redraw.ms(), 10) << "one is tried again within two seconds";
    redraw.add(8);
    EXPECT_EQ(redraw.ms(), 17) << "which is not all that there is";
}

TEST(RedrawEstimator, ForgetsDecayOnDrawing) {
    RedrawEstimator redraw;
    for (int k = 0; k < 8; ++k) redraw.add(40);
    redraw.add(12);
    EXPECT_EQ(redraw.ms(), 12);
    redraw.add(50);
    EXPECT_EQ(redraw.ms(), 12) << "one that had to wait says nothing of the next";
}

TEST(FramesShown, CountsFramesInTime) {
    FramesShown shown;
    const auto at = [](std::uint64_t epoch, std::int64_t number) {
        FramePair pair;
        pair.epoch = epoch;
        pair.prev = {number, number * 10, nullptr};
        return pair;
    };
    shown.add(at(1, 4), 49, 10);
    EXPECT_EQ(shown.due(), 0) << "the first of an epoch is waited for";
    shown.add(at(1, 5), 60, 10);
    shown.add(at(1, 5), 69, 10);
    EXPECT_EQ(shown.due(), 1);
    EXPECT_EQ(shown.in_time(), 1);
    shown.add(at(1, 6), 71, 10);  // late
    shown.add(at(1, 9), 95, 10);  // two not at all
    EXPECT_EQ(shown.due(), 5);
    EXPECT_EQ(shown.in_time(), 2);
    shown.add(at(2, 0), 400, 10);
    shown.forget();
    shown.add(at(2, 7), 500, 10);
    EXPECT_EQ(shown.due(), 5);
}

}  // namespace
}  // namespace touchable::test
