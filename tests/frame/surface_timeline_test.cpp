// SPDX-License-Identifier: Apache-2.0
// The timeline between the thread that builds frames and those that look at them: which pair is in hand when,
// beside a plain model; epochs; an eye beside the hand.

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "engine/run/touch_run.hpp"
#include "engine/scene/frames.hpp"
#include "tests/limits.hpp"
#include "tests/must.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

constexpr std::int64_t ms = 1'000'000;  // from frame to frame

/// Fills a slot so that its content can be told from any other's, and checked whole.
void fill(SurfaceFrame& frame, std::int64_t content) {
    frame.codes.assign(64, static_cast<std::uint16_t>(content * 7919));
    frame.width = static_cast<int>(content);
}
bool holds(const SurfaceFrame& frame, std::int64_t content) {
    return frame.width == content &&
           frame.codes == std::vector<std::uint16_t>(64, static_cast<std::uint16_t>(content * 7919));
}

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

TEST(SurfaceTimeline, BlendsFarthestTimesExactly) {
    SurfaceTimeline timeline(3);
    const std::int64_t first = std::numeric_limits<std::int64_t>::min() + 1;
    const std::int64_t last = std::numeric_limits<std::int64_t>::max();
    FramePair pair;
    EXPECT_FALSE(timeline.publish(0, 0)) << "nothing was acquired";
    EXPECT_EQ(timeline.newest_time(), std::numeric_limits<std::int64_t>::min());
    ASSERT_NE(timeline.acquire(), nullptr);
    EXPECT_FALSE(timeline.pair_at(0, pair));
    EXPECT_EQ(pair.prev.frame, nullptr);
    ASSERT_TRUE(timeline.publish(0, first));
    EXPECT_FALSE(timeline.publish(1, last));
    EXPECT_EQ(timeline.newest_time(), first);
    for (const std::int64_t t : {first - 1, std::int64_t{0}, last}) {
        ASSERT_TRUE(timeline.pair_at(t, pair));
        EXPECT_EQ(pair.prev.frame, pair.next.frame);
        EXPECT_EQ(pair.blend, 0);
    }
    ASSERT_NE(timeline.acquire(), nullptr);
    ASSERT_TRUE(timeline.publish(1, last));
    ASSERT_TRUE(timeline.pair_at(0, pair));
    EXPECT_EQ(pair.blend, 0.5);
    ASSERT_TRUE(timeline.pair_at(last - 1, pair));
    EXPECT_EQ(pair.next.number, 1);
    EXPECT_LT(pair.blend, 1.0);
    EXPECT_GT(pair.blend, 0.999999);
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
    ASSERT_TRUE(timeline.publish(8, 8 * ms));
    ASSERT_TRUE(timeline.pair_at(9 * ms, pair));
    EXPECT_EQ(pair.prev.frame, slot);
    EXPECT_TRUE(holds(*slot, 8));
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
    ASSERT_TRUE(must(timeline.republish(1, ms)));
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

/// The required behaviour of a timeline, derived from all frames ever published.
struct Model {
    struct Published {
        std::int64_t number, time, content;
    };
    int slots;
    std::vector<Published> all;
    std::size_t oldest = 0;
    bool acquired = false;

    std::size_t held() const { return all.size() - oldest; }
    std::size_t capacity() const { return static_cast<std::size_t>(slots) * 4; }
    std::size_t contents_held() const {
        std::set<std::int64_t> contents;
        for (std::size_t k = oldest; k < all.size(); ++k) contents.insert(all[k].content);
        return contents.size();
    }
    bool may_acquire() const {
        return acquired || (contents_held() < static_cast<std::size_t>(slots) && held() < capacity());
    }
    bool may_republish() const { return held() + 1 < capacity(); }
    bool is_later(std::int64_t time) const { return all.empty() || time > all.back().time; }
    void look(std::int64_t time) {
        while (oldest + 1 < all.size() && all[oldest + 1].time <= time) ++oldest;
    }
};

/// Both sides of a timeline driven at random beside the model; every answer is compared.
class ModelCheck {
public:
    ModelCheck(int slots, std::uint64_t seed)
        : timeline_(slots), model_{slots, {}, 0, false}, random_(seed) {}

    void step() {
        switch (random_.below(4)) {
            case 0:
                acquire();
                break;
            case 1:
                publish();
                break;
            case 2:
                republish();
                break;
            default:
                look();
        }
        if (looked_) check_contents();
    }
    std::size_t published() const { return model_.all.size(); }

private:
    std::int64_t some_time() { return time_ + random_.below(8) - 2; }

    void acquire() {
        SurfaceFrame* slot = timeline_.acquire();
        ASSERT_EQ(slot != nullptr, model_.may_acquire());
        if (slot == nullptr) return;
        model_.acquired = true;
        fill(*slot, ++content_);
    }
    void publish() {
        const std::int64_t time = some_time();
        const bool expected = model_.acquired && model_.is_later(time);
        ASSERT_EQ(bool(timeline_.publish(number_, time)), expected);
        if (!expected) return;
        model_.acquired = false;
        record(time, content_);
    }
    void republish() {
        const std::int64_t time = some_time();
        const Result<bool> done = timeline_.republish(number_, time);
        ASSERT_EQ(bool(done), !model_.all.empty() && model_.is_later(time));
        if (!done) return;
        ASSERT_EQ(*done, model_.may_republish());
        if (*done) record(time, model_.all.back().content);
    }
    void record(std::int64_t time, std::int64_t content) {
        model_.all.push_back({number_++, time, content});
        time_ = time;
        ASSERT_EQ(timeline_.newest_time(), time);
    }
    /// Mostly among the frames held, now and then before or beyond.
    void look() {
        const std::int64_t begin = model_.all.empty() ? 0 : model_.all[model_.oldest].time;
        const std::int64_t time = begin - 2 + random_.below(static_cast<int>(time_ - begin) / 2 + 6);
        FramePair pair;
        ASSERT_EQ(timeline_.pair_at(time, pair), !model_.all.empty());
        if (model_.all.empty()) return;
        looked_ = true;
        pair_ = pair;
        model_.look(time);
        prev_ = model_.all[model_.oldest];
        const bool between = time >= prev_.time && model_.held() > 1;
        next_ = between ? model_.all[model_.oldest + 1] : prev_;
        ASSERT_EQ(pair.prev.number, prev_.number);
        ASSERT_EQ(pair.prev.time_ns, prev_.time);
        ASSERT_EQ(pair.next.number, next_.number);
        ASSERT_EQ(pair.next.time_ns, next_.time);
        const double blend =
            between ? static_cast<double>(time - prev_.time) / static_cast<double>(next_.time - prev_.time)
                    : 0.0;
        ASSERT_EQ(pair.blend, blend);
    }
    /// The pair in hand stays whole whatever the writer has done since.
    void check_contents() {
        ASSERT_TRUE(holds(*pair_.prev.frame, prev_.content));
        ASSERT_TRUE(holds(*pair_.next.frame, next_.content));
    }

    SurfaceTimeline timeline_;
    Model model_;
    Random random_;
    std::int64_t number_ = 0, time_ = 0, content_ = 0;
    bool looked_ = false;
    FramePair pair_;
    Model::Published prev_{}, next_{};
};

TEST(SurfaceTimeline, MatchesListOfFrames) {
    for (int slots : {3, 4, 6})
        for (std::uint64_t seed = 0; seed < 20; ++seed) {
            SCOPED_TRACE("slots " + std::to_string(slots) + ", seed " + std::to_string(seed));
            ModelCheck check(slots, seed);
            for (int k = 0; k < 2000 && !testing::Test::HasFatalFailure(); ++k) check.step();
            ASSERT_FALSE(testing::Test::HasFatalFailure());
            EXPECT_GT(check.published(), 200U);  // many times round the ring
        }
}

// Epochs of a timeline: frames that have nothing to do with those before, whatever their times.

/// A timeline with a frame n at n ms in each epoch; its content tells epochs apart.
class TimelineEpochs : public testing::Test {
protected:
    static std::int64_t content(std::uint64_t epoch, std::int64_t n) {
        return static_cast<std::int64_t>(epoch) * 1000 + n;
    }
    bool give(std::int64_t n) {
        SurfaceFrame* slot = timeline.acquire();
        if (slot == nullptr) return false;
        fill(*slot, content(epoch_, n));
        EXPECT_TRUE(timeline.publish(n, n * ms));
        return true;
    }
    void begin(std::uint64_t epoch) { timeline.begin_epoch(epoch_ = epoch); }
    FramePair look(std::uint64_t epoch, double at_ms) {
        FramePair pair;
        EXPECT_TRUE(timeline.pair_at({epoch, static_cast<std::int64_t>(at_ms * ms), 0}, pair));
        EXPECT_TRUE(holds(*pair.prev.frame, content(pair.epoch, pair.prev.number)));
        EXPECT_TRUE(holds(*pair.next.frame, content(pair.epoch, pair.next.number)));
        return pair;
    }
    static void expect_held(const FramePair& pair, std::uint64_t epoch, std::int64_t prev, std::int64_t next,
                            double blend) {
        EXPECT_EQ(pair.epoch, epoch);
        EXPECT_EQ(pair.prev.number, prev);
        EXPECT_EQ(pair.next.number, next);
        EXPECT_EQ(pair.blend, blend);
    }

    SurfaceTimeline timeline{4};

private:
    std::uint64_t epoch_ = 0;
};

TEST_F(TimelineEpochs, MayHaveEarlierTimes) {
    for (int n : {20, 21}) ASSERT_TRUE(give(n));
    expect_held(look(0, 20.5), 0, 20, 21, 0.5);
    begin(1);
    EXPECT_EQ(timeline.newest_time(), std::numeric_limits<std::int64_t>::min());
    for (int n : {3, 4}) ASSERT_TRUE(give(n));
    EXPECT_EQ(timeline.newest_time(), 4 * ms);
    expect_held(look(0, 20.75), 0, 20, 21, 0.75);
    expect_held(look(1, 3.25), 1, 3, 4, 0.25);
    EXPECT_FALSE(timeline.publish(3, 3 * ms)) << "within an epoch times increase";
}

TEST_F(TimelineEpochs, HoldOldPairUntilReady) {
    for (int n : {20, 21, 22, 23}) ASSERT_TRUE(give(n));  // no slot is free
    look(0, 20.5);
    for (int k = 0; k < 5; ++k) expect_held(look(1, 3.0 + 0.1 * k), 0, 20, 21, 0.5);
    begin(1);
    ASSERT_TRUE(give(3)) << "what is passed over is given back";
    expect_held(look(1, 3.25), 0, 20, 21, 0.5);
    ASSERT_TRUE(give(4));
    EXPECT_FALSE(give(5)) << "the pair in hand is not given back yet";
    expect_held(look(1, 3.25), 1, 3, 4, 0.25);
    EXPECT_TRUE(give(5));
}

TEST_F(TimelineEpochs, EnterSingleFrameAtEnd) {
    ASSERT_TRUE(give(20));
    look(0, 20);
    begin(1);
    ASSERT_TRUE(give(3));
    expect_held(look(1, 9), 0, 20, 20, 0);
    timeline.end_epoch();
    expect_held(look(1, 9), 1, 3, 3, 0);
    begin(2);
    ASSERT_TRUE(give(0));
    begin(3);
    ASSERT_TRUE(give(7));
    expect_held(look(2, 0), 2, 0, 0, 0);  // another follows: it has ended
}

TEST_F(TimelineEpochs, SkipToWantedEpoch) {
    ASSERT_TRUE(give(20));
    look(0, 20);
    begin(2);
    ASSERT_TRUE(give(5));
    expect_held(look(1, 5), 0, 20, 20, 0);
    begin(4);
    for (int n : {8, 9}) ASSERT_TRUE(give(n));
    expect_held(look(3, 8), 0, 20, 20, 0);
    expect_held(look(4, 8.5), 4, 8, 9, 0.5);
    expect_held(look(2, 5), 4, 8, 9, 0.5);
}

TEST_F(TimelineEpochs, NeverMixInOnePair) {
    for (int n : {20, 21}) ASSERT_TRUE(give(n));
    begin(1);
    ASSERT_TRUE(give(22));
    expect_held(look(0, 25), 0, 21, 21, 0);
}

TEST_F(TimelineEpochs, RepublishOwnFrames) {
    ASSERT_TRUE(give(20));
    begin(1);
    EXPECT_FALSE(timeline.republish(3, 3 * ms));
    ASSERT_TRUE(give(3));
    look(2, 0);  // passes it over: its slot may be built into
    SurfaceFrame* slot = timeline.acquire();
    ASSERT_TRUE(holds(*slot, content(1, 3)));
    EXPECT_FALSE(timeline.republish(4, 4 * ms));
    fill(*slot, content(1, 4));
    EXPECT_TRUE(timeline.publish(4, 4 * ms));
    EXPECT_TRUE(timeline.republish(5, 5 * ms));
}

TEST_F(TimelineEpochs, SwitchWithoutAllocation) {
    for (int n : {20, 21}) ASSERT_TRUE(give(n));
    begin(1);
    for (int n : {3, 4}) ASSERT_TRUE(give(n));
    FramePair pair;
    timeline.pair_at({0, 20 * ms, 0}, pair);
    const std::size_t before = allocations();
    bool found = true;
    for (int k = 0; k < 10; ++k) found = timeline.pair_at({1, 3 * ms + k, 3}, pair) && found;
    EXPECT_EQ(allocations(), before);
    EXPECT_EQ(pair.epoch, 1U);
    EXPECT_TRUE(found);
}

/// A writer that begins epochs at random, and a reader that wants the newest of them: what is in hand stays
/// whole.
TEST(SurfaceTimelineThreads, SwitchEpochsSafely) {
    constexpr std::size_t codes = 256;
    constexpr int wanted_epochs = 500;
    SurfaceTimeline timeline(4);
    std::atomic<std::uint64_t> wanted{0};
    std::atomic<bool> stop{false};
    const auto code = [](std::uint64_t epoch, std::int64_t n) {
        return static_cast<std::uint16_t>(epoch * 40503 + static_cast<std::uint64_t>(n) * 7);
    };
    std::thread writer([&] {
        Random random(7);
        std::uint64_t epoch = 0;
        for (std::int64_t n = 0; !stop.load(std::memory_order_relaxed);) {
            // The wanted epoch, and now and then the next one.
            const std::uint64_t asked = wanted.load(std::memory_order_relaxed);
            if (asked > epoch || (asked == epoch && random.below(20) == 0)) {
                timeline.begin_epoch(epoch = std::max(asked, epoch + 1));
                n = random.below(1000);
            }
            SurfaceFrame* slot = timeline.acquire();
            if (slot == nullptr) {
                std::this_thread::yield();
                continue;
            }
            slot->codes.assign(codes, code(epoch, n));
            EXPECT_TRUE(timeline.publish(n, n * ms));
            ++n;
        }
    });
    Random random(8);
    FramePair pair;
    int gone_over = 0, torn = 0, backward = 0, ahead = 0;
    for (std::uint64_t epoch = 0; gone_over < wanted_epochs;) {
        const std::uint64_t before = pair.epoch;
        const std::int64_t at = std::max<std::int64_t>(0, timeline.newest_time()) - random.below(ms);
        if (!timeline.pair_at({epoch, at, 0}, pair)) continue;
        backward += pair.epoch < before;
        ahead += pair.epoch > epoch;
        gone_over += pair.epoch != before;
        for (const TimedFrame& frame : {pair.prev, pair.next})
            for (const std::uint16_t found : frame.frame->codes)
                torn += found != code(pair.epoch, frame.number);
        // It wants the next once it has got this one, and sometimes sooner.
        if (pair.epoch == epoch || random.below(2000) == 0) wanted.store(++epoch, std::memory_order_relaxed);
        std::this_thread::yield();
    }
    stop.store(true);
    writer.join();
    EXPECT_EQ(torn, 0);
    EXPECT_EQ(backward, 0);
    EXPECT_EQ(ahead, 0);
}

// An eye beside the hand: it looks at what the hand holds, and neither hand nor writer notices.

TEST(SurfaceTimelineEye, SeesHandsLastPair) {
    SurfaceTimeline timeline(6, SurfaceTimeline::Eye::one);
    EXPECT_EQ(timeline.look(), nullptr);
    for (int n : {0, 1, 2}) ASSERT_TRUE(publish(timeline, n));
    EXPECT_EQ(timeline.look(), nullptr);
    FramePair pair;
    for (const std::int64_t tick : {7, 8}) {
        ASSERT_TRUE(timeline.pair_at(ms / 4 + (tick - 7) * ms, pair));
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

TEST(SurfaceTimelineEye, KeepsFramesWithoutBlocking) {
    SurfaceTimeline timeline(6, SurfaceTimeline::Eye::one);
    for (int n : {0, 1}) ASSERT_TRUE(publish(timeline, n));
    FramePair pair;
    ASSERT_TRUE(timeline.pair_at(ms / 2, pair));
    timeline.show(0);
    const SurfaceTimeline::HeldPair* seen = timeline.look();
    for (std::int64_t n = 2; n < 200; ++n) {
        if (n % 50 == 0) timeline.begin_epoch(static_cast<std::uint64_t>(n));
        ASSERT_TRUE(publish(timeline, n)) << n;
        ASSERT_TRUE(publish(timeline, ++n)) << n;
        const auto epoch = static_cast<std::uint64_t>(n / 50 * 50);
        ASSERT_TRUE(timeline.pair_at({epoch, n * ms - ms / 2, 0}, pair));
        ASSERT_EQ(pair.next.number, n);
        timeline.show(n);
        ASSERT_TRUE(holds(*seen->pair.prev.frame, 0));
        ASSERT_TRUE(holds(*seen->pair.next.frame, 1));
        ASSERT_TRUE(holds(*pair.prev.frame, n - 1));
    }
    EXPECT_EQ(timeline.look()->pair.next.number, 199);
}

TEST(SurfaceTimelineEye, NeverAllocates) {
    SurfaceTimeline timeline(6, SurfaceTimeline::Eye::one);
    for (int n : {0, 1}) ASSERT_TRUE(publish(timeline, n));
    FramePair pair;
    timeline.pair_at(ms / 2, pair);
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
            if (!publish(timeline, n)) {
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
            const std::int64_t time = std::max<std::int64_t>(0, timeline.newest_time() - random.below(ms));
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

TEST(SurfaceTimelineThreads, LetFastEyeLook) {
    expect_three_get_on(std::chrono::microseconds(0), 1000);
}

TEST(SurfaceTimelineThreads, LetEyeStallWithoutBlocking) {
    expect_three_get_on(std::chrono::milliseconds(5), 8);
}

}  // namespace
}  // namespace touchable::test
