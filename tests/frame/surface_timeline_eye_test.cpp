// An eye beside the hand: it looks at what the hand holds, and neither hand nor writer notices.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

#include "engine/scene/frames.hpp"
#include "tests/frame/allocations.hpp"
#include "tests/frame/marked_frame.hpp"
#include "tests/frame/random.hpp"

namespace touchable::test {
namespace {

constexpr std::int64_t frame_ns = 1'000'000;

bool write_marked(SurfaceTimeline& timeline, std::int64_t n) {
    SurfaceFrame* slot = timeline.acquire();
    if (slot == nullptr) return false;
    fill(*slot, n);
    EXPECT_TRUE(timeline.publish(n, n * frame_ns));
    return true;
}

TEST(SurfaceTimelineEye, SeesWhatTheHandHeldLast) {
    SurfaceTimeline timeline(6, SurfaceTimeline::Eye::one);
    EXPECT_EQ(timeline.look(), nullptr);
    for (int n : {0, 1, 2}) ASSERT_TRUE(write_marked(timeline, n));
    EXPECT_EQ(timeline.look(), nullptr);
    FramePair pair;
    for (const std::int64_t tick : {7, 8}) {
        ASSERT_TRUE(timeline.pair_at(frame_ns / 4 + (tick - 7) * frame_ns, pair));
        timeline.show(tick);
    }
    for (int k = 0; k < 3; ++k) {
        const SurfaceTimeline::HeldPair* seen = timeline.look();
        ASSERT_NE(seen, nullptr);
        EXPECT_EQ(seen->tick, 8);
        EXPECT_EQ(seen->pair.prev.number, 1);
        EXPECT_EQ(seen->pair.next.number, 2);
        EXPECT_EQ(seen->pair.blend, 0.25);
        EXPECT_EQ(seen->pair.epoch, 0U);
    }
}

TEST(SurfaceTimelineEye, HowEverLongItLooksItKeepsItsFramesAndNobodyElseWaits) {
    SurfaceTimeline timeline(6, SurfaceTimeline::Eye::one);
    for (int n : {0, 1}) ASSERT_TRUE(write_marked(timeline, n));
    FramePair pair;
    ASSERT_TRUE(timeline.pair_at(frame_ns / 2, pair));
    timeline.show(0);
    const SurfaceTimeline::HeldPair* seen = timeline.look();
    for (std::int64_t n = 2; n < 200; ++n) {
        if (n % 50 == 0) timeline.begin_epoch(static_cast<std::uint64_t>(n));
        ASSERT_TRUE(write_marked(timeline, n)) << n;
        ASSERT_TRUE(write_marked(timeline, ++n)) << n;
        const auto epoch = static_cast<std::uint64_t>(n / 50 * 50);
        ASSERT_TRUE(timeline.pair_at({epoch, n * frame_ns - frame_ns / 2, 0}, pair));
        ASSERT_EQ(pair.next.number, n);
        timeline.show(n);
        ASSERT_TRUE(holds(*seen->pair.prev.frame, 0));
        ASSERT_TRUE(holds(*seen->pair.next.frame, 1));
        ASSERT_TRUE(holds(*pair.prev.frame, n - 1));
    }
    EXPECT_EQ(timeline.look()->pair.next.number, 199);
}

TEST(SurfaceTimelineEye, NeitherShowingNorLookingAllocates) {
    SurfaceTimeline timeline(6, SurfaceTimeline::Eye::one);
    for (int n : {0, 1}) ASSERT_TRUE(write_marked(timeline, n));
    FramePair pair;
    timeline.pair_at(frame_ns / 2, pair);
    const std::size_t before = allocations();
    for (int tick = 0; tick < 5; ++tick) timeline.show(tick);
    const SurfaceTimeline::HeldPair* seen = timeline.look();
    EXPECT_EQ(allocations(), before);
    EXPECT_EQ(seen->tick, 4);
}

/// Writer, hand and eye on a thread each, as fast as they can; the eye looks at a pair for `stare` before it
/// looks again.
void expect_three_get_on(std::chrono::microseconds stare, int looks) {
    SurfaceTimeline timeline(6, SurfaceTimeline::Eye::one);
    std::atomic<bool> stop{false};
    std::atomic<std::int64_t> written{0}, ticks{0};
    std::thread writer([&] {
        Random random(3);
        std::uint64_t epoch = 0;
        for (std::int64_t n = 0; !stop.load();) {
            if (!write_marked(timeline, n)) {
                std::this_thread::yield();
                continue;
            }
            written.store(++n);
            if (random.below(50) == 0) timeline.begin_epoch(++epoch);
        }
    });
    int torn = 0;
    std::thread hand([&] {
        Random random(4);
        FramePair pair;
        for (std::int64_t tick = 0, wait = 0; !stop.load(); ++tick) {
            // Its own epoch for a while, then the next.
            const bool over = ++wait > 30;
            const std::int64_t time =
                std::max<std::int64_t>(0, timeline.newest_time() - random.below(frame_ns));
            if (!timeline.pair_at({pair.epoch + (over ? 1 : 0), time, 0}, pair)) continue;
            if (over) wait = 0;
            torn += !holds(*pair.prev.frame, pair.prev.number) || !holds(*pair.next.frame, pair.next.number);
            timeline.show(tick);
            ticks.store(tick);
            std::this_thread::yield();
        }
    });
    int seen_torn = 0, stuck = 0;
    std::int64_t newest = -1;
    for (int k = 0; k < looks;) {
        const SurfaceTimeline::HeldPair* seen = timeline.look();
        if (seen == nullptr || seen->tick == newest) {
            std::this_thread::yield();
            continue;
        }
        stuck += seen->tick < newest;
        newest = seen->tick;
        ++k;
        const std::int64_t before = written.load();
        const auto begin = std::chrono::steady_clock::now();
        do {
            for (const TimedFrame& frame : {seen->pair.prev, seen->pair.next})
                seen_torn += !holds(*frame.frame, frame.number);
            std::this_thread::yield();
            // While it stares the others go on, however long that takes on a busy machine.
        } while (std::chrono::steady_clock::now() - begin < stare ||
                 (stare.count() > 0 && written.load() < before + 20));
    }
    stop.store(true);
    writer.join();
    hand.join();
    EXPECT_EQ(torn, 0);
    EXPECT_EQ(seen_torn, 0);
    EXPECT_EQ(stuck, 0);
}

TEST(SurfaceTimelineThreads, AFastEyeTearsNothing) {
    expect_three_get_on(std::chrono::microseconds(0), 1000);
}

TEST(SurfaceTimelineThreads, AnEyeThatStallsKeepsNobodyWaiting) {
    expect_three_get_on(std::chrono::milliseconds(5), 8);
}

}  // namespace
}  // namespace touchable::test
