// When a silent thread's device is made unpowered, in virtual time.
#include <gtest/gtest.h>

#include "device/drivers/safety_watchdog.hpp"

namespace touchable::test {
namespace {

constexpr std::int64_t beat_ms = 1'000'000;

TEST(HeartWatch, WantsAPacketTwentyMillisecondsAfterTheLastBeat) {
    HeartWatch watch;
    EXPECT_EQ(watch.due_ns(1000 * beat_ms), 1020 * beat_ms);
    EXPECT_EQ(watch.due_ns(1001 * beat_ms), 1021 * beat_ms) << "it beats";
}

TEST(HeartWatch, WaitsForAFirstBeat) {
    HeartWatch watch;
    EXPECT_EQ(watch.due_ns(0), HeartWatch::never);
}

TEST(HeartWatch, SendsAgainInTheSameSilenceAndThenStops) {
    HeartWatch watch;
    std::int64_t now = 0;
    for (int word = 0; word < 20; ++word) {
        const std::int64_t due = watch.due_ns(1000 * beat_ms);
        ASSERT_NE(due, HeartWatch::never) << word;
        if (word > 0) {
            EXPECT_EQ(due, now + 20 * beat_ms);
        }
        now = due + 3 * beat_ms;  // it is late itself
        watch.sent(now);
    }
    EXPECT_EQ(watch.due_ns(1000 * beat_ms), HeartWatch::never) << "of a program that is stopped for an hour";
}

TEST(HeartWatch, WatchesAgainOnceTheHeartBeats) {
    HeartWatch watch;
    while (watch.due_ns(1000 * beat_ms) != HeartWatch::never) watch.sent(5000 * beat_ms);
    EXPECT_EQ(watch.due_ns(9000 * beat_ms), 9020 * beat_ms);
    watch.sent(9020 * beat_ms);
    EXPECT_EQ(watch.due_ns(9000 * beat_ms), 9040 * beat_ms);
    EXPECT_EQ(watch.due_ns(0), HeartWatch::never) << "another device in its place";
}

TEST(WatchdogMonitor, KnowsAfterASecondThatNothingBeats) {
    WatchdogMonitor watch;
    std::int64_t now = 5'000'000 * beat_ms;
    EXPECT_TRUE(watch.is_alive(7, now));
    int looks = 0;
    while (watch.is_alive(7, now += beat_ms)) ASSERT_LT(++looks, 2000);
    EXPECT_EQ(looks, 1000);
    EXPECT_TRUE(watch.is_alive(8, now)) << "it beats again";
}

TEST(WatchdogMonitor, OneThatBeatsSeldomLives) {
    WatchdogMonitor watch;
    std::int64_t now = 0;
    for (std::uint32_t beats = 0xfffffff0; beats != 0x10; ++beats)
        for (int looks = 0; looks < 900; ++looks) ASSERT_TRUE(watch.is_alive(beats, now += beat_ms));
}

/// On a machine that sleeps nobody beats.
TEST(WatchdogMonitor, TimeInWhichNobodyLookedDoesNotCount) {
    WatchdogMonitor watch;
    std::int64_t now = 0;
    watch.is_alive(7, now);
    for (int sleeps = 0; sleeps < 40; ++sleeps) ASSERT_TRUE(watch.is_alive(7, now += 3'600'000 * beat_ms));
}

}  // namespace
}  // namespace touchable::test
