#include "engine/scene/frames.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "tests/frame/allocations.hpp"
#include "tests/frame/marked_frame.hpp"

namespace touchable {
namespace {

using test::fill;
using test::holds;

constexpr std::int64_t ms = 1'000'000;

/// Builds and publishes frame n at n ms; false where no slot was free.
bool publish(SurfaceTimeline& timeline, std::int64_t n) {
    SurfaceFrame* slot = timeline.acquire();
    if (slot == nullptr) return false;
    fill(*slot, n);
    EXPECT_TRUE(timeline.publish(n, n * ms));
    return true;
}
bool republish(SurfaceTimeline& timeline, std::int64_t n) {
    const Result<bool> done = timeline.republish(n, n * ms);
    EXPECT_TRUE(done);
    return done && *done;
}

void expect_pair(const FramePair& pair, std::int64_t prev, std::int64_t next, double blend) {
    EXPECT_EQ(pair.prev.number, prev);
    EXPECT_EQ(pair.prev.time_ns, prev * ms);
    EXPECT_EQ(pair.next.number, next);
    EXPECT_EQ(pair.next.time_ns, next * ms);
    EXPECT_EQ(pair.blend, blend);
}

TEST(SurfaceTimeline, BeforeTheFirstFrameThereIsNoPair) {
    SurfaceTimeline timeline(3);
    FramePair pair;
    EXPECT_FALSE(timeline.pair_at(0, pair));
    EXPECT_EQ(timeline.newest_time(), std::numeric_limits<std::int64_t>::min());
    ASSERT_NE(timeline.acquire(), nullptr);
    EXPECT_FALSE(timeline.pair_at(0, pair));
    EXPECT_EQ(pair.prev.frame, nullptr);
}

TEST(SurfaceTimeline, OneFrameIsThePairAtEveryTime) {
    SurfaceTimeline timeline(3);
    ASSERT_TRUE(publish(timeline, 5));
    EXPECT_EQ(timeline.newest_time(), 5 * ms);
    for (std::int64_t t : {std::int64_t{0}, 5 * ms, 9 * ms, std::numeric_limits<std::int64_t>::min(),
                           std::numeric_limits<std::int64_t>::max()}) {
        FramePair pair;
        ASSERT_TRUE(timeline.pair_at(t, pair));
        expect_pair(pair, 5, 5, 0);
        EXPECT_EQ(pair.prev.frame, pair.next.frame);
        EXPECT_TRUE(holds(*pair.prev.frame, 5));
    }
}

TEST(SurfaceTimeline, ThePairIsTheFramesAroundTheTimeAndItsBlend) {
    SurfaceTimeline timeline(4);
    for (int n : {10, 14, 15}) ASSERT_TRUE(publish(timeline, n));
    FramePair pair;
    ASSERT_TRUE(timeline.pair_at(9 * ms, pair));
    expect_pair(pair, 10, 10, 0);  // before the first
    ASSERT_TRUE(timeline.pair_at(10 * ms, pair));
    expect_pair(pair, 10, 14, 0);
    ASSERT_TRUE(timeline.pair_at(11 * ms, pair));
    expect_pair(pair, 10, 14, 0.25);
    EXPECT_TRUE(holds(*pair.prev.frame, 10));
    EXPECT_TRUE(holds(*pair.next.frame, 14));
    ASSERT_TRUE(timeline.pair_at(14 * ms - 1, pair));
    expect_pair(pair, 10, 14, 3999999.0 / 4000000.0);
    ASSERT_TRUE(timeline.pair_at(14 * ms, pair));
    expect_pair(pair, 14, 15, 0);
    ASSERT_TRUE(timeline.pair_at(15 * ms, pair));
    expect_pair(pair, 15, 15, 0);
    ASSERT_TRUE(timeline.pair_at(99 * ms, pair));
    expect_pair(pair, 15, 15, 0);  // after the last
}

TEST(SurfaceTimeline, AnEarlierTimeGivesTheEarliestFrameHeldAtBlendZero) {
    SurfaceTimeline timeline(4);
    for (int n : {1, 2, 3}) ASSERT_TRUE(publish(timeline, n));
    FramePair pair;
    ASSERT_TRUE(timeline.pair_at(5 * ms / 2, pair));
    expect_pair(pair, 2, 3, 0.5);
    ASSERT_TRUE(timeline.pair_at(1 * ms, pair));
    expect_pair(pair, 2, 2, 0);
    ASSERT_TRUE(timeline.pair_at(5 * ms / 2, pair));
    expect_pair(pair, 2, 3, 0.5);
}

TEST(SurfaceTimeline, BlendIsBelowOneAndExactForTheFarthestTimes) {
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

TEST(SurfaceTimeline, ALateProducerLeavesTheNewestFrameStanding) {
    SurfaceTimeline timeline(3);
    ASSERT_TRUE(publish(timeline, 0));
    ASSERT_TRUE(publish(timeline, 1));
    FramePair pair;
    for (std::int64_t t = 1; t < 1000; ++t) {
        ASSERT_TRUE(timeline.pair_at(t * ms, pair));
        expect_pair(pair, 1, 1, 0);
        ASSERT_TRUE(holds(*pair.prev.frame, 1));
    }
    ASSERT_TRUE(publish(timeline, 1200));
    ASSERT_TRUE(timeline.pair_at(1100 * ms, pair));
    EXPECT_EQ(pair.prev.number, 1);
    EXPECT_EQ(pair.next.number, 1200);
}

TEST(SurfaceTimeline, RunsManyTimesAroundItsRing) {
    for (int slots : {3, 4, 7}) {
        SurfaceTimeline timeline(slots);
        FramePair pair;
        for (std::int64_t n = 0; n < 2000; ++n) {
            ASSERT_TRUE(publish(timeline, n));
            if (n == 0) continue;
            ASSERT_TRUE(timeline.pair_at(n * ms - ms / 2, pair));
            expect_pair(pair, n - 1, n, 0.5);
            ASSERT_TRUE(holds(*pair.prev.frame, n - 1));
            ASSERT_TRUE(holds(*pair.next.frame, n));
        }
    }
}

TEST(SurfaceTimeline, ASlowReaderStopsTheWriterAndLosesNothing) {
    SurfaceTimeline timeline(5);
    for (int n = 0; n < 5; ++n) ASSERT_TRUE(publish(timeline, n));  // the reader has not even begun
    EXPECT_EQ(timeline.acquire(), nullptr);

    FramePair pair;
    ASSERT_TRUE(timeline.pair_at(0, pair));
    expect_pair(pair, 0, 1, 0);
    EXPECT_EQ(timeline.acquire(), nullptr);

    ASSERT_TRUE(timeline.pair_at(2 * ms + ms / 2, pair));  // moves past 0 and 1
    ASSERT_TRUE(publish(timeline, 5));
    ASSERT_TRUE(publish(timeline, 6));
    EXPECT_EQ(timeline.acquire(), nullptr);
    EXPECT_TRUE(holds(*pair.prev.frame, 2));
    EXPECT_TRUE(holds(*pair.next.frame, 3));
    for (std::int64_t n = 2; n <= 6; ++n) {
        ASSERT_TRUE(timeline.pair_at(n * ms, pair));
        EXPECT_EQ(pair.prev.number, n);
        EXPECT_TRUE(holds(*pair.prev.frame, n));
    }
}

TEST(SurfaceTimeline, ThePairInHandIsNeverRecycled) {
    SurfaceTimeline timeline(3);
    ASSERT_TRUE(publish(timeline, 0));
    ASSERT_TRUE(publish(timeline, 1));
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

TEST(SurfaceTimeline, AcquiringAgainGivesTheSameSlot) {
    SurfaceTimeline timeline(3);
    SurfaceFrame* slot = timeline.acquire();
    ASSERT_NE(slot, nullptr);
    EXPECT_EQ(timeline.acquire(), slot);
    ASSERT_TRUE(timeline.publish(0, 0));
    EXPECT_NE(timeline.acquire(), slot);
}

TEST(SurfaceTimeline, EqualAndEarlierTimesAreRefusedByNameAndTheSlotIsKept) {
    SurfaceTimeline timeline(3);
    ASSERT_TRUE(publish(timeline, 7));
    SurfaceFrame* slot = timeline.acquire();
    fill(*slot, 8);
    for (std::int64_t time : {7 * ms, 6 * ms, -ms, std::numeric_limits<std::int64_t>::min()}) {
        const Result<void> refused = timeline.publish(8, time);
        ASSERT_FALSE(refused);
        EXPECT_EQ(refused.error().kind, ErrorKind::input);
        EXPECT_NE(refused.error().message.find("frame 8"), std::string::npos);
        EXPECT_NE(refused.error().message.find(std::to_string(time)), std::string::npos);
        EXPECT_NE(refused.error().message.find("7000000"), std::string::npos);
        EXPECT_FALSE(timeline.republish(8, time));
        EXPECT_EQ(timeline.newest_time(), 7 * ms);
        EXPECT_EQ(timeline.acquire(), slot);
    }
    FramePair pair;
    ASSERT_TRUE(timeline.pair_at(9 * ms, pair));
    expect_pair(pair, 7, 7, 0);
    ASSERT_TRUE(timeline.publish(8, 8 * ms));
    ASSERT_TRUE(timeline.pair_at(9 * ms, pair));
    expect_pair(pair, 8, 8, 0);
    EXPECT_EQ(pair.prev.frame, slot);
    EXPECT_TRUE(holds(*slot, 8));
}

TEST(SurfaceTimeline, PublishingWithoutAFrameIsRefused) {
    SurfaceTimeline timeline(3);
    EXPECT_FALSE(timeline.publish(0, 0));
    EXPECT_FALSE(timeline.republish(0, 0));
    EXPECT_EQ(timeline.newest_time(), std::numeric_limits<std::int64_t>::min());
    ASSERT_TRUE(publish(timeline, 1));
    EXPECT_FALSE(timeline.publish(2, 2 * ms));
    EXPECT_EQ(timeline.newest_time(), 1 * ms);
}

TEST(SurfaceTimeline, RepublishingShowsTheSameSlotAtALaterTime) {
    SurfaceTimeline timeline(3);
    ASSERT_TRUE(publish(timeline, 0));
    FramePair pair;
    for (std::int64_t n = 1; n < 500; ++n) {
        ASSERT_TRUE(republish(timeline, n));
        EXPECT_EQ(timeline.newest_time(), n * ms);
        ASSERT_TRUE(timeline.pair_at(n * ms - ms / 4, pair));
        expect_pair(pair, n - 1, n, 0.75);
        EXPECT_EQ(pair.prev.frame, pair.next.frame);
        ASSERT_TRUE(holds(*pair.next.frame, 0));
    }
}

TEST(SurfaceTimeline, RepublishingKeepsTheSlotBeingBuilt) {
    SurfaceTimeline timeline(3);
    ASSERT_TRUE(publish(timeline, 0));
    SurfaceFrame* slot = timeline.acquire();
    fill(*slot, 2);
    ASSERT_TRUE(republish(timeline, 1));
    EXPECT_EQ(timeline.acquire(), slot);
    ASSERT_TRUE(timeline.publish(2, 2 * ms));
    FramePair pair;
    ASSERT_TRUE(timeline.pair_at(3 * ms / 2, pair));
    expect_pair(pair, 1, 2, 0.5);
    EXPECT_TRUE(holds(*pair.prev.frame, 0));
    EXPECT_TRUE(holds(*pair.next.frame, 2));
}

TEST(SurfaceTimeline, AFullRingRefusesRepublishingYetHasRoomForTheSlotBeingBuilt) {
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
        ASSERT_TRUE(timeline.pair_at(k * ms + ms / 2, pair));
        expect_pair(pair, k, k + 1, 0.5);
        EXPECT_TRUE(holds(*pair.prev.frame, 0));
    }
    EXPECT_TRUE(holds(*pair.next.frame, n));
    EXPECT_TRUE(republish(timeline, n + 1));
    EXPECT_NE(timeline.acquire(), nullptr);
}

TEST(SurfaceTimeline, ARepublishedSlotIsRecycledOnlyPastItsLastTime) {
    SurfaceTimeline timeline(3);
    ASSERT_TRUE(publish(timeline, 0));
    const SurfaceFrame* first = nullptr;
    for (int n : {1, 2}) ASSERT_TRUE(republish(timeline, n));
    ASSERT_TRUE(publish(timeline, 3));
    ASSERT_TRUE(publish(timeline, 4));
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

TEST(SurfaceTimeline, OfTheFreeSlotsTheNewestContentIsRecycled) {
    SurfaceTimeline timeline(5);
    for (int n : {0, 1, 2, 3}) ASSERT_TRUE(publish(timeline, n));
    FramePair pair;
    ASSERT_TRUE(timeline.pair_at(3 * ms, pair));
    const SurfaceFrame* slot = timeline.acquire();
    ASSERT_NE(slot, nullptr);
    EXPECT_TRUE(holds(*slot, 2));
}

TEST(SurfaceTimeline, NumbersWhatASlotHolds) {
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

TEST(SurfaceTimeline, TheReaderDoesNotAllocate) {
    SurfaceTimeline timeline(4);
    for (int n : {0, 1, 2, 3}) ASSERT_TRUE(publish(timeline, n));
    FramePair pair;
    const std::size_t before = test::allocations();
    ASSERT_GT(before, 0U);  // the counter counts
    bool found = true;
    for (std::int64_t t = -1; t < 40; ++t) found = timeline.pair_at(t * ms / 8, pair) && found;
    EXPECT_EQ(test::allocations(), before);
    EXPECT_TRUE(found);
}

}  // namespace
}  // namespace touchable
