// Epochs of a timeline: frames that have nothing to do with those before, whatever their times.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <limits>
#include <thread>

#include "engine/scene/frames.hpp"
#include "tests/frame/allocations.hpp"
#include "tests/frame/marked_frame.hpp"
#include "tests/frame/random.hpp"

namespace touchable::test {
namespace {

constexpr std::int64_t step_ns = 1'000'000;  // from frame to frame

/// A timeline with a frame n at n ms in each epoch; its content tells epochs apart.
class Epochs : public testing::Test {
protected:
    static std::int64_t content(std::uint64_t epoch, std::int64_t n) {
        return static_cast<std::int64_t>(epoch) * 1000 + n;
    }
    bool give(std::int64_t n) {
        SurfaceFrame* slot = timeline.acquire();
        if (slot == nullptr) return false;
        fill(*slot, content(epoch_, n));
        EXPECT_TRUE(timeline.publish(n, n * step_ns));
        return true;
    }
    void begin(std::uint64_t epoch) { timeline.begin_epoch(epoch_ = epoch); }
    FramePair look(std::uint64_t epoch, double at_ms) {
        FramePair pair;
        EXPECT_TRUE(timeline.pair_at({epoch, static_cast<std::int64_t>(at_ms * step_ns), 0}, pair));
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

TEST_F(Epochs, ALaterOneMayHaveEarlierTimes) {
    for (int n : {20, 21}) ASSERT_TRUE(give(n));
    expect_held(look(0, 20.5), 0, 20, 21, 0.5);
    begin(1);
    EXPECT_EQ(timeline.newest_time(), std::numeric_limits<std::int64_t>::min());
    for (int n : {3, 4}) ASSERT_TRUE(give(n));
    EXPECT_EQ(timeline.newest_time(), 4 * step_ns);
    expect_held(look(0, 20.75), 0, 20, 21, 0.75);
    expect_held(look(1, 3.25), 1, 3, 4, 0.25);
    EXPECT_FALSE(timeline.publish(3, 3 * step_ns)) << "within an epoch times increase";
}

TEST_F(Epochs, UntilItsPairIsThereTheOldOneStaysAtRest) {
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

TEST_F(Epochs, AFrameAloneIsGoneOverToOnceTheEpochEnds) {
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

TEST_F(Epochs, OnesInBetweenArePassedOverAndNoneIsEnteredBeforeItIsWanted) {
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

TEST_F(Epochs, TheLastPairOfAnEpochHasNoFrameOfTheNext) {
    for (int n : {20, 21}) ASSERT_TRUE(give(n));
    begin(1);
    ASSERT_TRUE(give(22));
    expect_held(look(0, 25), 0, 21, 21, 0);
}

TEST_F(Epochs, RepublishingIsOfTheEpochsOwnFrames) {
    ASSERT_TRUE(give(20));
    begin(1);
    EXPECT_FALSE(timeline.republish(3, 3 * step_ns));
    ASSERT_TRUE(give(3));
    look(2, 0);  // passes it over: its slot may be built into
    SurfaceFrame* slot = timeline.acquire();
    ASSERT_TRUE(holds(*slot, content(1, 3)));
    EXPECT_FALSE(timeline.republish(4, 4 * step_ns));
    fill(*slot, content(1, 4));
    EXPECT_TRUE(timeline.publish(4, 4 * step_ns));
    EXPECT_TRUE(timeline.republish(5, 5 * step_ns));
}

TEST_F(Epochs, TheReaderDoesNotAllocateOnItsWayOver) {
    for (int n : {20, 21}) ASSERT_TRUE(give(n));
    begin(1);
    for (int n : {3, 4}) ASSERT_TRUE(give(n));
    FramePair pair;
    timeline.pair_at({0, 20 * step_ns, 0}, pair);
    const std::size_t before = allocations();
    bool found = true;
    for (int k = 0; k < 10; ++k) found = timeline.pair_at({1, 3 * step_ns + k, 3}, pair) && found;
    EXPECT_EQ(allocations(), before);
    EXPECT_EQ(pair.epoch, 1U);
    EXPECT_TRUE(found);
}

/// A writer that begins epochs at random, and a reader that wants the newest of them: what is in hand stays
/// whole.
TEST(SurfaceTimelineThreads, EpochsThatComeAtAnyTimeNeitherTearNorTurnBackNorStop) {
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
            // What is wanted, and now and then what will be wanted next.
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
            EXPECT_TRUE(timeline.publish(n, n * step_ns));
            ++n;
        }
    });
    Random random(8);
    FramePair pair;
    int gone_over = 0, torn = 0, backward = 0, ahead = 0;
    for (std::uint64_t epoch = 0; gone_over < wanted_epochs;) {
        const std::uint64_t before = pair.epoch;
        const std::int64_t at = std::max<std::int64_t>(0, timeline.newest_time()) - random.below(step_ns);
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

}  // namespace
}  // namespace touchable::test
