#include "player/window/clip_picture.hpp"

#include <gtest/gtest.h>

namespace touchable::test {
namespace {

/// Plays so long, with pictures that take `full` of a frame's time at full size and `rest` of it at any; with
/// all vertices `vertices` more, if a coarse picture saves any. Gives when the share was first another than
/// at the start.
double play(PictureGovernor& governor, double& now_s, double seconds, double full, double rest,
            double vertices = 0) {
    const double end = now_s + seconds, share = governor.share();
    double changed = 0;
    for (; now_s < end; now_s += 1.0 / 30) {
        const double drawing =
            rest + full * governor.share() * governor.share() + (governor.coarse() ? 0 : vertices);
        governor.add(now_s, 1, drawing <= 1 ? 1 : 0, drawing, vertices > 0);
        if (changed == 0 && governor.share() != share) changed = now_s;
    }
    return changed;
}

TEST(PictureGovernor, StaysAtFullSizeWhereThereIsTime) {
    PictureGovernor governor;
    double now = 0;
    play(governor, now, 10, 0.7, 0.2);
    EXPECT_EQ(governor.share(), 1);
}

TEST(PictureGovernor, StaysAtFullSizeWhereOtherThingsAreLate) {
    PictureGovernor governor;
    for (int k = 0; k < 300; ++k) governor.add(k / 30.0, 2, 0, 0.1, false);
    EXPECT_EQ(governor.share(), 1);
}

TEST(PictureGovernor, DrawsSmallerWhereThatIsInTimeAndLargerAgainLater) {
    PictureGovernor governor;
    double now = 0;
    EXPECT_LT(play(governor, now, 2, 1.2, 0.1), 1);
    EXPECT_EQ(governor.share(), 0.75);
    play(governor, now, 20, 1.2, 0.1);
    EXPECT_EQ(governor.share(), 0.75) << "a larger picture has no room";
    EXPECT_GT(play(governor, now, 20, 0.5, 0.1), 0);
    EXPECT_EQ(governor.share(), 1);
}

TEST(PictureGovernor, GivesUpWhereASmallerPictureSavesLittle) {
    PictureGovernor governor;
    double now = 0;
    play(governor, now, 5, 0.1, 1.5);
    EXPECT_EQ(governor.share(), 1);
    const double begin = now;
    const double tried = play(governor, now, 80, 0.1, 1.5);
    EXPECT_GT(tried, begin + 30) << "not at once again";
}

TEST(PictureGovernor, BeginsCoarseAndShowsAllVerticesWhereThereIsTime) {
    PictureGovernor governor;
    double now = 0;
    EXPECT_TRUE(governor.coarse());
    play(governor, now, 2, 0.1, 0.1, 0.3);
    EXPECT_TRUE(governor.coarse()) << "not at once: that would be seen";
    play(governor, now, 10, 0.1, 0.1, 0.3);
    EXPECT_FALSE(governor.coarse());
    play(governor, now, 2, 0.1, 0.1, 1.2);
    EXPECT_TRUE(governor.coarse());
    EXPECT_EQ(governor.share(), 1) << "which is enough";
    PictureGovernor slow;
    play(slow, now, 30, 0.2, 0.1, 2);
    EXPECT_TRUE(slow.coarse()) << "three times as much has no room";
}

TEST(PictureGovernor, GoesAllTheWayDownWhereAStepOfItSavesLittle) {
    PictureGovernor governor;
    double now = 0;
    // Decoding takes what the first step leaves.
    const auto drawing = [&] { return governor.share() == 1 ? 1.5 : governor.share() == 0.75 ? 1.45 : 0.9; };
    for (const double end = now + 3; now < end; now += 1.0 / 30)
        governor.add(now, 1, drawing() <= 1 ? 1 : 0, drawing(), true);
    EXPECT_EQ(governor.share(), 0.5);
}

TEST(PictureGovernor, LeavesOutVerticesAndNoPixelsWhereTheseCostLittle) {
    PictureGovernor governor(LessOf::vertices);
    double now = 0;
    const auto play_for = [&](double seconds, double coarse, double coarser) {
        for (const double end = now + seconds; now < end; now += 1.0 / 30) {
            const double drawing = governor.step() == 1 ? coarse : coarser;
            governor.add(now, 1, drawing <= 1 ? 1 : 0, drawing, true);
        }
    };
    EXPECT_EQ(governor.detail(), 1);
    play_for(2, 1.2, 0.7);
    EXPECT_EQ(governor.step(), 2);
    EXPECT_EQ(governor.share(), 1);
    EXPECT_EQ(governor.detail(), 0.5);
    play_for(60, 1.2, 0.7);
    EXPECT_EQ(governor.step(), 2) << "more vertices have no room";
    play_for(20, 0.7, 0.5);
    EXPECT_EQ(governor.step(), 1);
    EXPECT_TRUE(governor.coarse());
}

TEST(PictureGovernor, HeedsEveryTenthPictureThatIsLate) {
    PictureGovernor governor;
    const auto play_with_late = [&governor](double from_s, int each) {
        for (int k = 0; k < 60; ++k)
            governor.add(from_s + k / 30.0, 1, k % each == 0 ? 0 : 1, 0.9 * governor.share(), false);
    };
    play_with_late(0, 15);
    EXPECT_EQ(governor.share(), 1) << "one of fifteen";
    play_with_late(2, 7);
    EXPECT_LT(governor.share(), 1);
}

TEST(PictureGovernor, IsAtItsLowestWithinAFewPicturesWhereAllAreLate) {
    PictureGovernor governor(LessOf::vertices);
    for (int k = 0; k < 2; ++k) governor.add(k / 30.0, 1, 0, 1.5, true);
    EXPECT_EQ(governor.step(), 2);
    PictureGovernor smaller;
    for (int k = 0; k < 4; ++k) smaller.add(k / 30.0, 1, 0, 1.5, true);
    EXPECT_EQ(smaller.share(), 0.5);
    for (int k = 4; k < 19; ++k) smaller.add(k / 30.0, 1, 0, k < 8 ? 2 : 0.9, true);
    EXPECT_EQ(smaller.share(), 0.5) << "not judged by its first pictures";
}

TEST(PictureGovernor, StaysWhereLessSavesOnceTheFirstPicturesAreOver) {
    PictureGovernor governor(LessOf::vertices);
    // A clip that has just opened fills its memory beside them.
    for (int k = 0; k < 300; ++k) {
        const double drawing = governor.step() == 1 ? 1.1 : k < 20 ? 1.05 : 0.7;
        governor.add(k / 30.0, 1, drawing <= 1 ? 1 : 0, drawing, true);
        if (k > 2) {
            ASSERT_EQ(governor.step(), 2) << k;
        }
    }
}

TEST(RedrawEstimator, IsTheMedianOfTheLastFew) {
    RedrawEstimator redraw;
    EXPECT_EQ(redraw.ms(), 0);
    for (const double ms : {9, 8, 20}) redraw.add(ms);
    EXPECT_EQ(redraw.ms(), 9) << "one that had to wait says nothing of the next";
    for (int k = 0; k < 8; ++k) redraw.add(12);
    EXPECT_EQ(redraw.ms(), 12);
}

TEST(RedrawEstimator, BecomesLessWhereNoneIsDrawn) {
    RedrawEstimator redraw;
    for (int k = 0; k < 8; ++k) redraw.add(17);
    for (int k = 0; k < 60; ++k) redraw.add_frame();
    EXPECT_LT(redraw.ms(), 10) << "one is tried again within two seconds";
    redraw.add(8);
    EXPECT_EQ(redraw.ms(), 17) << "which is not all that there is";
}

TEST(RedrawEstimator, ForgetsARestInWhichMoreIsDrawn) {
    RedrawEstimator redraw;
    for (int k = 0; k < 8; ++k) redraw.add(40);
    redraw.add(12);
    EXPECT_EQ(redraw.ms(), 12);
    redraw.add(50);
    EXPECT_EQ(redraw.ms(), 12) << "one that had to wait says nothing of the next";
}

TEST(FramesShown, CountsThoseThatWereThereBeforeTheNext) {
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
