#include "player/window/clip_picture.hpp"

#include <gtest/gtest.h>

namespace touchable::test {
namespace {

struct Machine {
    double read_ms, build_ms, late_share;
};

/// After so many frames, 16.7 ms apart.
bool is_why_after(int frames, const Machine& machine) {
    SlowReading reading;
    WatchedFigures figures;
    for (int frame = 1; frame <= frames; ++frame) {
        figures.feed.frames = frame;
        figures.feed.read_ms = machine.read_ms;
        figures.feed.build_ms = machine.build_ms;
        figures.late_frames = static_cast<std::int64_t>(machine.late_share * frame);
        // Looked at by every picture, of which a frame has several.
        for (int picture = 0; picture < 3; ++picture) reading.add(figures, 16.7);
    }
    EXPECT_NEAR(reading.read_ms(), machine.read_ms, 1e-9);
    return reading.is_why();
}

TEST(SlowReading, IsNoticedWhereFramesAreLateForIt) {
    EXPECT_TRUE(is_why_after(64, {18, 6, 0.8}));
    EXPECT_TRUE(is_why_after(64, {10, 6, 0.3}));
}

TEST(SlowReading, IsNotTheReasonWhereFramesAreInTimeOrOtherThingsAreSlow) {
    EXPECT_FALSE(is_why_after(64, {18, 6, 0})) << "frames are in time";
    EXPECT_FALSE(is_why_after(15, {18, 6, 1})) << "they were few, as at the beginning";
    EXPECT_FALSE(is_why_after(1000, {18, 6, 0.1})) << "few of many";
    EXPECT_FALSE(is_why_after(64, {10, 30, 0.8})) << "building takes longer";
    EXPECT_FALSE(is_why_after(64, {2, 1, 0.8})) << "something else of the machine";
}

}  // namespace
}  // namespace touchable::test
