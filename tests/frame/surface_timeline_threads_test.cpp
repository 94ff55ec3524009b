#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <thread>

#include "engine/scene/frames.hpp"
#include "tests/frame/random.hpp"

namespace touchable {
namespace {

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
    test::Random random(6);
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

TEST(SurfaceTimelineThreads, ASaturatingWriterNeverTearsTurnsBackOrHidesAFrame) {
    expect_order({3, 1, 512});
    expect_order({8, 3, 512});
}

TEST(SurfaceTimelineThreads, UnchangedFramesAtFullSpeedDoNotEither) {
    expect_order({3, 100, 2});
}

}  // namespace
}  // namespace touchable
