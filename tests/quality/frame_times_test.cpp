// How frames follow each other.
#include "engine/authoring/quality_estimators.hpp"

#include <gtest/gtest.h>

#include <array>
#include <memory>

namespace touchable::test {
namespace {

/// A frame of one pixel of depth and one of colour.
RawFrame frame_at(std::int64_t number, std::int64_t ms, std::uint8_t depth, std::uint8_t colour = 0) {
    auto bytes = std::make_shared<std::array<std::uint8_t, 4>>(std::array{depth, colour, colour, colour});
    RawFrame frame;
    frame.number = number;
    frame.time_ns = ms * 1000000;
    frame.depth = {bytes->data(), 1, 1, 1, 1, 1};
    frame.colour = {bytes->data() + 1, 3, 1, 1, 1, 3};
    frame.storage = bytes;
    return frame;
}

TEST(FrameTimes, AreAllRight) {
    FrameTimesEstimator estimator;
    for (int k = 0; k < 20; ++k) estimator.add(frame_at(k, 33 * k, static_cast<std::uint8_t>(k)));
    const ClipQuality::FrameTimes times = estimator.times();
    EXPECT_EQ(times.frames, 20);
    EXPECT_EQ(times.repeated, 0);
    EXPECT_EQ(times.missing, 0);
    EXPECT_EQ(times.jumps, 0);
    EXPECT_EQ(times.usual_ms, 33);
}

TEST(FrameTimes, RepeatedOnesAreCountedAndThoseUnderNewColour) {
    FrameTimesEstimator estimator;
    for (int k = 0; k < 20; ++k)
        estimator.add(
            frame_at(k, 33 * k, static_cast<std::uint8_t>(k / 2), static_cast<std::uint8_t>(k / 4)));
    EXPECT_EQ(estimator.times().repeated, 8);  // not the first and the last, which are not between changes
    EXPECT_EQ(estimator.times().of_new_colour, 0);  // colour changes with every fourth, when depth does
    FrameTimesEstimator quick;
    for (int k = 0; k < 20; ++k)
        quick.add(frame_at(k, 33 * k, static_cast<std::uint8_t>(k / 2), static_cast<std::uint8_t>(k)));
    EXPECT_EQ(quick.times().of_new_colour, 8);
}

TEST(FrameTimes, WhatStandsStillForLongIsNotRepeated) {
    FrameTimesEstimator estimator;
    for (int k = 0; k < 30; ++k)  // moves, stands still for ten frames, moves on
        estimator.add(frame_at(k, 33 * k, static_cast<std::uint8_t>(k < 10 ? k : k < 20 ? 10 : k)));
    EXPECT_EQ(estimator.times().repeated, 0);
    EXPECT_EQ(estimator.times().changed, 20);
    FrameTimesEstimator still;
    for (int k = 0; k < 30; ++k) still.add(frame_at(k, 33 * k, 7));
    EXPECT_EQ(still.times().repeated, 0);
}

TEST(FrameTimes, GapsAndJumpsAreCounted) {
    FrameTimesEstimator estimator;
    std::int64_t ms = 0;
    for (int k = 0; k < 20; ++k) {
        ms += k == 5 ? 132 : k == 9 ? 0 : k == 12 ? 66 : 33;
        estimator.add(frame_at(k, ms, static_cast<std::uint8_t>(k)));
    }
    const ClipQuality::FrameTimes times = estimator.times();
    EXPECT_EQ(times.missing, 3 + 1);
    EXPECT_EQ(times.jumps, 1);
    EXPECT_EQ(times.longest_ms, 132);
    EXPECT_EQ(times.longest_at, 5);
}

TEST(FrameTimes, OfOneFrameThereAreNone) {
    FrameTimesEstimator estimator;
    EXPECT_EQ(estimator.times().frames, 0);
    estimator.add(frame_at(0, 0, 1));
    EXPECT_EQ(estimator.times().usual_ms, 0);
}

}  // namespace
}  // namespace touchable::test
