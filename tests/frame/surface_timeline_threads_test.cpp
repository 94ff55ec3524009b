#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <thread>

#include "engine/frame/surface_timeline.hpp"
#include "tests/frame/random.hpp"

namespace touchable {
namespace {

constexpr std::int64_t interval = 1000;  // ns from frame to frame
constexpr std::int64_t most_frames = 2'000'000;
constexpr std::size_t codes_per_frame = 512;

/// Of four frames the second and third are the first once more.
bool is_repeat(std::int64_t number) {
    return number % 4 == 1 || number % 4 == 2;
}
std::int64_t content_of(std::int64_t number) {
    return is_repeat(number) ? number - number % 4 : number;
}

std::uint16_t code_of(std::int64_t content, std::size_t k) {
    return static_cast<std::uint16_t>(static_cast<std::size_t>(content) * 40503 + k);
}
void fill(SurfaceFrame& frame, std::int64_t content) {
    frame.codes.resize(codes_per_frame);
    for (std::size_t k = 0; k < codes_per_frame; ++k) frame.codes[k] = code_of(content, k);
}
bool is_whole(const TimedFrame& timed) {
    const SurfaceFrame& frame = *timed.frame;
    if (frame.codes.size() != codes_per_frame) return false;
    for (std::size_t k = 0; k < codes_per_frame; ++k)
        if (frame.codes[k] != code_of(content_of(timed.number), k)) return false;
    return true;
}

/// Publishes as fast as slots and entries allow; returns how many frames.
std::int64_t write_until(const std::atomic<bool>& stop, SurfaceTimeline& timeline) {
    std::int64_t number = 0;
    while (number < most_frames && !stop.load(std::memory_order_relaxed)) {
        bool done = false;
        if (is_repeat(number)) {
            const Result<bool> republished = timeline.republish(number, number * interval);
            done = republished.ok() && *republished;
        } else if (SurfaceFrame* slot = timeline.acquire()) {
            fill(*slot, number);
            done = timeline.publish(number, number * interval).ok();
        }
        if (done)
            ++number;
        else
            std::this_thread::yield();
    }
    return number;
}

struct Seen {
    std::int64_t looks = 0, between = 0, torn = 0, backward = 0, misplaced = 0, overtaken = 0;
};

/// One look of the reader: the pair fits the time, never goes back, and is whole, and still whole when
/// checked again while the writer goes on.
void look(SurfaceTimeline& timeline, std::int64_t time, FramePair& pair, Seen& seen) {
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
        if (!is_whole(pair.prev) || !is_whole(pair.next)) ++seen.torn;
}

/// Follows the newest frame in steps of a random length, sometimes a little back, sometimes beyond it.
Seen read_until(std::chrono::steady_clock::time_point end, SurfaceTimeline& timeline) {
    test::Random random(6);
    Seen seen;
    FramePair pair;
    std::int64_t time = 0;
    while (std::chrono::steady_clock::now() < end && pair.prev.number + 1 < most_frames) {
        const std::int64_t newest = timeline.newest_time();
        look(timeline, time, pair, seen);
        if (newest >= 0 && time >= newest && pair.prev.time_ns < newest) ++seen.overtaken;
        time = std::min(time + random.below(3 * interval) - interval / 4, newest + 2 * interval);
        time = std::max<std::int64_t>(time, 0);
    }
    return seen;
}

TEST(SurfaceTimelineThreads, ASaturatingWriterNeverTearsTurnsBackOrHidesAFrame) {
    for (int slots : {3, 8}) {
        SurfaceTimeline timeline(slots);
        std::atomic<bool> stop{false};
        std::int64_t written = 0;
        std::thread writer([&] { written = write_until(stop, timeline); });
        const Seen seen =
            read_until(std::chrono::steady_clock::now() + std::chrono::milliseconds(600), timeline);
        stop.store(true, std::memory_order_relaxed);
        writer.join();

        EXPECT_EQ(seen.torn, 0);
        EXPECT_EQ(seen.backward, 0);
        EXPECT_EQ(seen.misplaced, 0);
        EXPECT_EQ(seen.overtaken, 0) << "newest_time() told of a frame that pair_at did not find";
        EXPECT_GT(written, 20 * slots);  // many times round the ring, or nothing was tried
        EXPECT_GT(seen.between, 20);
        std::printf("%d slots: %lld frames written, %lld looks, %lld between two frames\n", slots,
                    static_cast<long long>(written), static_cast<long long>(seen.looks),
                    static_cast<long long>(seen.between));
    }
}

}  // namespace
}  // namespace touchable
