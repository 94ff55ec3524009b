#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "engine/scene/frames.hpp"
#include "tests/frame/marked_frame.hpp"
#include "tests/limits.hpp"
#include "tests/must.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

constexpr std::int64_t ms = 1'000'000;

/// Builds and publishes frame n at n ms; false where no slot was free.
bool publish(SurfaceTimeline& timeline, std::int64_t n) {
    SurfaceFrame* slot = timeline.acquire();
    if (slot == nullptr) return false;
    fill(*slot, n);
    EXPECT_TRUE(timeline.publish(n, n * ms));
    return true;
}
bool publish_all(SurfaceTimeline& timeline, const std::vector<std::int64_t>& frames) {
    return std::ranges::all_of(frames, [&](std::int64_t n) { return publish(timeline, n); });
}
bool republish(SurfaceTimeline& timeline, std::int64_t n) {
    const Result<bool> done = timeline.republish(n, n * ms);
    EXPECT_TRUE(done);
    return done && *done;
}

void expect_pair_at(SurfaceTimeline& timeline, std::int64_t time, FramePair& pair, std::int64_t prev,
                    std::int64_t next, double blend) {
    ASSERT_TRUE(timeline.pair_at(time, pair));
    EXPECT_EQ(pair.prev.number, prev);
    EXPECT_EQ(pair.prev.time_ns, prev * ms);
    EXPECT_EQ(pair.next.number, next);
    EXPECT_EQ(pair.next.time_ns, next * ms);
    EXPECT_EQ(pair.blend, blend);
}

TEST(SurfaceTimeline, HasNoPairAtFirst) {
    SurfaceTimeline timeline(3);
    FramePair pair;
    EXPECT_FALSE(timeline.pair_at(0, pair));
    EXPECT_EQ(timeline.newest_time(), std::numeric_limits<std::int64_t>::min());
    ASSERT_NE(timeline.acquire(), nullptr);
    EXPECT_FALSE(timeline.pair_at(0, pair));
    EXPECT_EQ(pair.prev.frame, nullptr);
}

TEST(SurfaceTimeline, PairsSingleFrameWithItself) {
    SurfaceTimeline timeline(3);
    ASSERT_TRUE(publish(timeline, 5));
    EXPECT_EQ(timeline.newest_time(), 5 * ms);
    for (std::int64_t t : {std::int64_t{0}, 5 * ms, 9 * ms, std::numeric_limits<std::int64_t>::min(),
                           std::numeric_limits<std::int64_t>::max()}) {
        FramePair pair;
        expect_pair_at(timeline, t, pair, 5, 5, 0);
        EXPECT_EQ(pair.prev.frame, pair.next.frame);
        EXPECT_TRUE(holds(*pair.prev.frame, 5));
    }
}

TEST(SurfaceTimeline, PairsFramesAroundTime) {
    SurfaceTimeline timeline(4);
    ASSERT_TRUE(publish_all(timeline, {10, 14, 15}));
    FramePair pair;
    expect_pair_at(timeline, 9 * ms, pair, 10, 10, 0);  // before the first
    expect_pair_at(timeline, 10 * ms, pair, 10, 14, 0);
    expect_pair_at(timeline, 11 * ms, pair, 10, 14, 0.25);
    EXPECT_TRUE(holds(*pair.prev.frame, 10));
    EXPECT_TRUE(holds(*pair.next.frame, 14));
    expect_pair_at(timeline, 14 * ms - 1, pair, 10, 14, 3999999.0 / 4000000.0);
    expect_pair_at(timeline, 14 * ms, pair, 14, 15, 0);
    expect_pair_at(timeline, 15 * ms, pair, 15, 15, 0);
    expect_pair_at(timeline, 99 * ms, pair, 15, 15, 0);  // after the last
}

TEST(SurfaceTimeline, GivesEarliestFrameForPast) {
    SurfaceTimeline timeline(4);
    ASSERT_TRUE(publish_all(timeline, {1, 2, 3}));
    FramePair pair;
    expect_pair_at(timeline, 5 * ms / 2, pair, 2, 3, 0.5);
    expect_pair_at(timeline, 1 * ms, pair, 2, 2, 0);
    expect_pair_at(timeline, 5 * ms / 2, pair, 2, 3, 0.5);
}

TEST(SurfaceTimeline, BlendsFarthestTimesExactly) {
    SurfaceTimeline timeline(3);
    const std::int64_t first = std::numeric_limits<std::int64_t>::min() + 1;
    const std::int64_t last = std::numeric_limits<std::int64_t>::max();
    ASSERT_NE(timeline.acquire(), nullptr);
    ASSERT_TRUE(timeline.publish(0, first));
    ASSERT_NE(timeline.acquire(), nullptr);
    ASSERT_TRUE(timeline.publish(1, last));
    FramePair pair;
    ASSERT_TRUE(timeline.pair_at(0, pair));
    EXPECT_EQ(pair.blend, 0.5);
    ASSERT_TRUE(timeline.pair_at(last - 1, pair));
    EXPECT_EQ(pair.next.number, 1);
    EXPECT_LT(pair.blend, 1.0);
    EXPECT_GT(pair.blend, 0.999999);
}

TEST(SurfaceTimeline, HoldsNewestFrame) {
    SurfaceTimeline timeline(3);
    ASSERT_TRUE(publish_all(timeline, {0, 1}));
    FramePair pair;
    for (std::int64_t t = 1; t < 1000; ++t) {
        expect_pair_at(timeline, t * ms, pair, 1, 1, 0);
        ASSERT_TRUE(holds(*pair.prev.frame, 1));
    }
    ASSERT_TRUE(publish(timeline, 1200));
    ASSERT_TRUE(timeline.pair_at(1100 * ms, pair));
    EXPECT_EQ(pair.prev.number, 1);
    EXPECT_EQ(pair.next.number, 1200);
}

TEST(SurfaceTimeline, WrapsAroundItsRing) {
    for (int slots : {3, 4, 7}) {
        SurfaceTimeline timeline(slots);
        FramePair pair;
        for (std::int64_t n = 0; n < 2000; ++n) {
            ASSERT_TRUE(publish(timeline, n));
            if (n == 0) continue;
            expect_pair_at(timeline, n * ms - ms / 2, pair, n - 1, n, 0.5);
            ASSERT_TRUE(holds(*pair.prev.frame, n - 1));
            ASSERT_TRUE(holds(*pair.next.frame, n));
        }
    }
}

TEST(SurfaceTimeline, StopsWriterForSlowReader) {
    SurfaceTimeline timeline(5);
    for (int n = 0; n < 5; ++n) ASSERT_TRUE(publish(timeline, n));  // the reader has not even begun
    EXPECT_EQ(timeline.acquire(), nullptr);

    FramePair pair;
    expect_pair_at(timeline, 0, pair, 0, 1, 0);
    EXPECT_EQ(timeline.acquire(), nullptr);

    ASSERT_TRUE(timeline.pair_at(2 * ms + ms / 2, pair));  // moves past 0 and 1
    ASSERT_TRUE(publish_all(timeline, {5, 6}));
    EXPECT_EQ(timeline.acquire(), nullptr);
    EXPECT_TRUE(holds(*pair.prev.frame, 2));
    EXPECT_TRUE(holds(*pair.next.frame, 3));
    for (std::int64_t n = 2; n <= 6; ++n) {
        ASSERT_TRUE(timeline.pair_at(n * ms, pair));
        EXPECT_EQ(pair.prev.number, n);
        EXPECT_TRUE(holds(*pair.prev.frame, n));
    }
}

TEST(SurfaceTimeline, NeverRecyclesHeldPair) {
    SurfaceTimeline timeline(3);
    ASSERT_TRUE(publish_all(timeline, {0, 1}));
    FramePair pair;
    ASSERT_TRUE(timeline.pair_at(ms / 2, pair));
    SurfaceFrame* slot = timeline.acquire();
    ASSERT_NE(slot, nullptr);
    EXPECT_NE(slot, pair.prev.frame);
    EXPECT_NE(slot, pair.next.frame);
    fill(*slot, 2);
    ASSERT_TRUE(timeline.publish(2, 2 * ms));
    EXPECT_EQ(timeline.acquire(), nullptr);
    EXPECT_TRUE(holds(*pair.prev.frame, 0));

    const SurfaceFrame* first = pair.prev.frame;
    ASSERT_TRUE(timeline.pair_at(1 * ms, pair));
    EXPECT_EQ(timeline.acquire(), first);
}

TEST(SurfaceTimeline, AcquiresSameSlotAgain) {
    SurfaceTimeline timeline(3);
    SurfaceFrame* slot = timeline.acquire();
    ASSERT_NE(slot, nullptr);
    EXPECT_EQ(timeline.acquire(), slot);
    ASSERT_TRUE(timeline.publish(0, 0));
    EXPECT_NE(timeline.acquire(), slot);
}

TEST(SurfaceTimeline, RejectsEqualAndEarlierTimes) {
    SurfaceTimeline timeline(3);
    ASSERT_TRUE(publish(timeline, 7));
    SurfaceFrame* slot = timeline.acquire();
    fill(*slot, 8);
    for (std::int64_t time : {7 * ms, 6 * ms, -ms, std::numeric_limits<std::int64_t>::min()}) {
        const Result<void> refused = timeline.publish(8, time);
        expect_error(refused, ErrorKind::input, "frame 8");
        EXPECT_NE(refused.error().message.find(std::to_string(time)), std::string::npos);
        EXPECT_NE(refused.error().message.find("7000000"), std::string::npos);
        EXPECT_FALSE(timeline.republish(8, time));
        EXPECT_EQ(timeline.newest_time(), 7 * ms);
        EXPECT_EQ(timeline.acquire(), slot);
    }
    FramePair pair;
    expect_pair_at(timeline, 9 * ms, pair, 7, 7, 0);
    ASSERT_TRUE(timeline.publish(8, 8 * ms));
    expect_pair_at(timeline, 9 * ms, pair, 8, 8, 0);
    EXPECT_EQ(pair.prev.frame, slot);
    EXPECT_TRUE(holds(*slot, 8));
}

TEST(SurfaceTimeline, RejectsPublishingNothing) {
    SurfaceTimeline timeline(3);
    EXPECT_FALSE(timeline.publish(0, 0));
    EXPECT_FALSE(timeline.republish(0, 0));
    EXPECT_EQ(timeline.newest_time(), std::numeric_limits<std::int64_t>::min());
    ASSERT_TRUE(publish(timeline, 1));
    EXPECT_FALSE(timeline.publish(2, 2 * ms));
    EXPECT_EQ(timeline.newest_time(), 1 * ms);
}

TEST(SurfaceTimeline, RepublishesSameSlot) {
    SurfaceTimeline timeline(3);
    ASSERT_TRUE(publish(timeline, 0));
    FramePair pair;
    for (std::int64_t n = 1; n < 500; ++n) {
        ASSERT_TRUE(republish(timeline, n));
        EXPECT_EQ(timeline.newest_time(), n * ms);
        expect_pair_at(timeline, n * ms - ms / 4, pair, n - 1, n, 0.75);
        EXPECT_EQ(pair.prev.frame, pair.next.frame);
        ASSERT_TRUE(holds(*pair.next.frame, 0));
    }
}

TEST(SurfaceTimeline, KeepsAcquiredSlotWhenRepublishing) {
    SurfaceTimeline timeline(3);
    ASSERT_TRUE(publish(timeline, 0));
    SurfaceFrame* slot = timeline.acquire();
    fill(*slot, 2);
    ASSERT_TRUE(republish(timeline, 1));
    EXPECT_EQ(timeline.acquire(), slot);
    ASSERT_TRUE(timeline.publish(2, 2 * ms));
    FramePair pair;
    expect_pair_at(timeline, 3 * ms / 2, pair, 1, 2, 0.5);
    EXPECT_TRUE(holds(*pair.prev.frame, 0));
    EXPECT_TRUE(holds(*pair.next.frame, 2));
}

TEST(SurfaceTimeline, ReservesRoomForAcquiredSlot) {
    SurfaceTimeline timeline(3);
    ASSERT_TRUE(publish(timeline, 0));
    SurfaceFrame* slot = timeline.acquire();
    std::int64_t n = 1;
    while (n < 1000 && republish(timeline, n)) ++n;
    ASSERT_LT(n, 1000);
    EXPECT_EQ(timeline.newest_time(), (n - 1) * ms);
    fill(*slot, n);
    ASSERT_TRUE(timeline.publish(n, n * ms));
    EXPECT_EQ(timeline.acquire(), nullptr);  // a slot is free, an entry is not
    EXPECT_FALSE(republish(timeline, n + 1));

    FramePair pair;
    for (std::int64_t k = 0; k < n; ++k) {
        expect_pair_at(timeline, k * ms + ms / 2, pair, k, k + 1, 0.5);
        EXPECT_TRUE(holds(*pair.prev.frame, 0));
    }
    EXPECT_TRUE(holds(*pair.next.frame, n));
    EXPECT_TRUE(republish(timeline, n + 1));
    EXPECT_NE(timeline.acquire(), nullptr);
}

TEST(SurfaceTimeline, RecyclesRepublishedSlotLast) {
    SurfaceTimeline timeline(3);
    ASSERT_TRUE(publish(timeline, 0));
    const SurfaceFrame* first = nullptr;
    for (int n : {1, 2}) ASSERT_TRUE(republish(timeline, n));
    ASSERT_TRUE(publish_all(timeline, {3, 4}));
    FramePair pair;
    for (int n : {0, 1, 2}) {  // at 2 ms it is still the earlier of the pair
        ASSERT_TRUE(timeline.pair_at(n * ms, pair));
        first = pair.prev.frame;
        EXPECT_EQ(timeline.acquire(), nullptr);
        EXPECT_TRUE(holds(*pair.prev.frame, 0));
    }
    ASSERT_TRUE(timeline.pair_at(3 * ms, pair));
    EXPECT_EQ(timeline.acquire(), first);
}

TEST(SurfaceTimeline, RecyclesNewestFreeSlot) {
    SurfaceTimeline timeline(5);
    ASSERT_TRUE(publish_all(timeline, {0, 1, 2, 3}));
    FramePair pair;
    ASSERT_TRUE(timeline.pair_at(3 * ms, pair));
    const SurfaceFrame* slot = timeline.acquire();
    ASSERT_NE(slot, nullptr);
    EXPECT_TRUE(holds(*slot, 2));
}

TEST(SurfaceTimeline, NumbersContents) {
    SurfaceTimeline timeline(3);
    ASSERT_TRUE(publish(timeline, 0));
    FramePair pair;
    ASSERT_TRUE(timeline.pair_at(0, pair));
    const SurfaceFrame& first = *pair.prev.frame;
    const std::uint64_t content = first.content;
    EXPECT_NE(content, 0U);
    ASSERT_TRUE(republish(timeline, 1));
    EXPECT_EQ(first.content, content);
    for (int n : {2, 3, 4}) {
        ASSERT_TRUE(publish(timeline, n));
        ASSERT_TRUE(timeline.pair_at(n * ms, pair));
        EXPECT_GT(pair.prev.frame->content, content);
    }
    EXPECT_GT(first.content, content) << "the slot was not recycled";
}

TEST(SurfaceTimeline, ReadsWithoutAllocation) {
    SurfaceTimeline timeline(4);
    ASSERT_TRUE(publish_all(timeline, {0, 1, 2, 3}));
    FramePair pair;
    const std::size_t before = allocations();
    ASSERT_GT(before, 0U);  // the counter counts
    bool found = true;
    for (std::int64_t t = -1; t < 40; ++t) found = timeline.pair_at(t * ms / 8, pair) && found;
    EXPECT_EQ(allocations(), before);
    EXPECT_TRUE(found);
}

constexpr std::int64_t interval = 1000;  // ns from frame to frame
constexpr std::int64_t most_frames = 2'000'000;
constexpr std::int64_t enough_between = 500;  // looks that found two frames

/// One writer and one reader at full speed. Frames come in groups of equal content, so that both slots and
/// entries are in short supply in turn.
struct Run {
    int slots;
    std::int64_t group;           // one new frame, and group - 1 times the same again
    std::size_t codes_per_frame;  // how long a frame is in the writer's and the reader's hands

    bool is_repeat(std::int64_t number) const { return number % group != 0; }
    std::uint16_t code(std::int64_t number, std::size_t k) const {
        return static_cast<std::uint16_t>(static_cast<std::size_t>(number / group) * 40503 + k);
    }
    void fill(SurfaceFrame& frame, std::int64_t number) const {
        frame.codes.resize(codes_per_frame);
        for (std::size_t k = 0; k < codes_per_frame; ++k) frame.codes[k] = code(number, k);
    }
    bool is_whole(const TimedFrame& timed) const {
        if (timed.frame->codes.size() != codes_per_frame) return false;
        for (std::size_t k = 0; k < codes_per_frame; ++k)
            if (timed.frame->codes[k] != code(timed.number, k)) return false;
        return true;
    }
};

/// Publishes as fast as slots and entries allow; returns how many frames.
std::int64_t write_until(const std::atomic<bool>& stop, const Run& run, SurfaceTimeline& timeline) {
    std::int64_t number = 0;
    while (number < most_frames && !stop.load(std::memory_order_relaxed)) {
        bool done = false;
        if (run.is_repeat(number)) {
            const Result<bool> republished = timeline.republish(number, number * interval);
            done = republished && *republished;
        } else if (SurfaceFrame* slot = timeline.acquire()) {
            run.fill(*slot, number);
            done = bool(timeline.publish(number, number * interval));
        }
        if (done)
            ++number;
        else
            std::this_thread::yield();
    }
    return number;
}

struct Seen {
    std::int64_t looks = 0, between = 0, torn = 0, backward = 0, misplaced = 0, hidden = 0;
};

/// One look of the reader: the pair fits the time, never goes back, and is whole, and still whole when
/// checked again while the writer goes on.
void look(SurfaceTimeline& timeline, std::int64_t time, const Run& run, FramePair& pair, Seen& seen) {
    const TimedFrame before = pair.prev;
    if (!timeline.pair_at(time, pair)) return;
    ++seen.looks;
    if (pair.prev.number < before.number) ++seen.backward;
    for (const TimedFrame& frame : {pair.prev, pair.next})
        if (frame.time_ns != frame.number * interval) ++seen.misplaced;
    if (pair.next.number != pair.prev.number) {
        ++seen.between;
        const bool around =
            pair.prev.time_ns <= time && time < pair.next.time_ns && pair.next.number == pair.prev.number + 1;
        if (!around || !(pair.blend >= 0 && pair.blend < 1)) ++seen.misplaced;
    } else if (pair.blend != 0) {
        ++seen.misplaced;
    }
    for (int repeat = 0; repeat < 3; ++repeat)
        if (!run.is_whole(pair.prev) || !run.is_whole(pair.next)) ++seen.torn;
}

/// Follows the newest frame in steps of a random length, sometimes a little back, sometimes beyond it; and
/// now and then asks for the newest itself, which it must then find. Runs for a while, and on until it has
/// seen enough, since on a busy machine the two may hardly meet.
Seen read_for_a_while(const Run& run, SurfaceTimeline& timeline) {
    using clock = std::chrono::steady_clock;
    const clock::time_point begin = clock::now();
    const auto goes_on = [&](const Seen& seen) {
        const auto spent = clock::now() - begin;
        return spent < std::chrono::milliseconds(400) ||
               (seen.between < enough_between && spent < std::chrono::seconds(30));
    };
    Random random(6);
    Seen seen;
    FramePair pair;
    std::int64_t time = 0, newest = 0;
    while (goes_on(seen) && pair.prev.number + 1 < most_frames) {
        // Rarely, since newest_time() too hands frames over, and pair_at must do so alone.
        const bool newest_itself = random.below(8) == 0;
        if (newest_itself) newest = std::max<std::int64_t>(0, timeline.newest_time());
        const std::int64_t step = random.below(3 * interval) - interval / 4;
        time = newest_itself ? std::max(time, newest) : std::min(time + step, newest + 8 * interval);
        look(timeline, time, run, pair, seen);
        if (newest_itself && pair.prev.time_ns < newest) ++seen.hidden;
        if (time > newest) std::this_thread::yield();
    }
    return seen;
}

void expect_order(const Run& run) {
    SurfaceTimeline timeline(run.slots);
    std::atomic<bool> stop{false};
    std::int64_t written = 0;
    std::thread writer([&] { written = write_until(stop, run, timeline); });
    const Seen seen = read_for_a_while(run, timeline);
    stop.store(true, std::memory_order_relaxed);
    writer.join();

    EXPECT_EQ(seen.torn, 0);
    EXPECT_EQ(seen.backward, 0);
    EXPECT_EQ(seen.misplaced, 0);
    EXPECT_EQ(seen.hidden, 0) << "newest_time() told of a frame that pair_at did not find";
    EXPECT_GE(seen.between, enough_between) << "the two hardly met: nothing was tried";
    EXPECT_GT(written, 20 * run.slots);  // several times round the ring
    std::printf("%d slots: %lld frames written, %lld looks, %lld between two frames\n", run.slots,
                static_cast<long long>(written), static_cast<long long>(seen.looks),
                static_cast<long long>(seen.between));
}

TEST(SurfaceTimelineThreads, KeepOrderAtFullSpeed) {
    expect_order({3, 1, 512});
    expect_order({8, 3, 512});
}

TEST(SurfaceTimelineThreads, KeepOrderOfUnchangedFrames) {
    expect_order({3, 100, 2});
}

}  // namespace
}  // namespace touchable::test
