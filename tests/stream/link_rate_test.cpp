#include "engine/stream/listeners.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <utility>

namespace touchable {
namespace {

constexpr std::int64_t ms = 1'000'000, second = 1'000 * ms;

/// A link on which so many bytes a second arrive, looked at every 5 ms.
struct Link {
    LinkRate rate;
    LinkRate::Look now{};
    bool is_full = false;
    void go_on(std::int64_t for_ns, std::int64_t bytes_per_second, std::int64_t rtt_ns,
               std::int64_t loses_one_in = 0) {
        for (const std::int64_t end = now.now_ns + for_ns; now.now_ns < end; now.now_ns += 5 * ms) {
            now.arrived_bytes += bytes_per_second / 200;
            now.datagrams += 10;
            if (loses_one_in > 0 && now.datagrams % loses_one_in == 0) ++now.lost;
            now.rtt_ns = rtt_ns;
            now.is_full = is_full;
            rate.look(now);
        }
    }
    /// Until no more arrives, however much may be on its way.
    void fill(std::int64_t bytes_per_second, std::int64_t rtt_ns) {
        is_full = true;
        go_on(5 * second, bytes_per_second, rtt_ns);
        is_full = false;
        EXPECT_FALSE(rate.is_growing());
    }
};

/// A link of so many bytes a second and so long a way, to which a sender that always has more gives what the
/// window allows.
struct FullLink {
    FullLink(std::int64_t rate_of_link, std::int64_t way) : bytes_per_second(rate_of_link), way_ns(way) {}
    std::int64_t bytes_per_second, way_ns;
    LinkRate rate;
    LinkRate::Look now{.is_full = true};
    std::int64_t handed_over = 0, served = 0, most_on_its_way = 0;
    std::deque<std::pair<std::int64_t, std::int64_t>> acknowledged;  // from when on, and how much
    std::int64_t timed = 0, timed_since_ns = 0;
    void go_on(std::int64_t for_ns) {
        for (const std::int64_t end = now.now_ns + for_ns; now.now_ns < end; now.now_ns += 5 * ms) {
            for (; !acknowledged.empty() && acknowledged.front().first <= now.now_ns;
                 acknowledged.pop_front())
                now.arrived_bytes = acknowledged.front().second;
            if (timed > 0 && now.arrived_bytes >= timed) {
                now.rtt_ns = now.now_ns - timed_since_ns;
                timed = 0;
            }
            rate.look(now);
            now.rtt_ns = 0;
            const std::int64_t before =
                std::exchange(handed_over, std::max(handed_over, now.arrived_bytes + rate.window_bytes()));
            if (timed == 0 && handed_over > before) {
                timed = before + 1;
                timed_since_ns = now.now_ns;
            }
            most_on_its_way = std::max(most_on_its_way, handed_over - now.arrived_bytes);
            served = std::min(handed_over, served + bytes_per_second / 200);
            acknowledged.emplace_back(now.now_ns + way_ns, served);
        }
    }
};

TEST(LinkRate, GrowsToWhatALongWayTakes) {
    FullLink link(4'000'000, 400 * ms);
    link.go_on(4 * second);
    const std::int64_t before = link.now.arrived_bytes;
    link.go_on(4 * second);
    EXPECT_GT(link.now.arrived_bytes - before, 4 * 3'900'000);
    EXPECT_FALSE(link.rate.is_growing());
    EXPECT_LT(link.most_on_its_way, 3 * 1'600'000) << "three times what fits on the way";
    EXPECT_NEAR(static_cast<double>(link.rate.window_bytes()), 4e6 * 0.5, 1e5);
}

TEST(LinkRate, ANarrowLinkIsNotFlooded) {
    FullLink link(200'000, 20 * ms);
    link.go_on(8 * second);
    EXPECT_FALSE(link.rate.is_growing());
    EXPECT_LE(link.most_on_its_way, LinkRate::first_window_bytes);
    EXPECT_EQ(link.rate.window_bytes(), LinkRate::least_window_bytes);
}

TEST(LinkRate, BeginsWithAWindowOfItsOwn) {
    Link link;
    EXPECT_EQ(link.rate.window_bytes(), LinkRate::first_window_bytes);
    link.go_on(second / 2, 0, 100 * ms);
    EXPECT_EQ(link.rate.window_bytes(), LinkRate::first_window_bytes);
    link.go_on(second, 0, 100 * ms);
    EXPECT_EQ(link.rate.window_bytes(), LinkRate::least_window_bytes);
}

TEST(LinkRate, WindowIsRateTimesRoundTripAndSlack) {
    Link link;
    link.go_on(second, 4'000'000, 100 * ms);
    EXPECT_NEAR(static_cast<double>(link.rate.window_bytes()), 4e6 * 0.28, 2e4)
        << "twice the way while it grows";
    link.fill(4'000'000, 100 * ms);
    EXPECT_NEAR(static_cast<double>(link.rate.bytes_per_second()), 4e6, 1e5);
    EXPECT_NEAR(static_cast<double>(link.rate.window_bytes()), 4e6 * 0.18, 2e4);
}

/// What waits in front of a full link counts in the round trip as it is measured.
TEST(LinkRate, QueueDoesNotWidenTheWindow) {
    Link link;
    link.fill(4'000'000, 20 * ms);
    const auto before = static_cast<double>(link.rate.window_bytes());
    link.is_full = true;
    for (std::int64_t rtt = 100 * ms; rtt < 2 * second; rtt += 100 * ms)
        link.go_on(10 * second, 4'000'000, rtt);
    EXPECT_NEAR(static_cast<double>(link.rate.window_bytes()), before, 1e4);
}

TEST(LinkRate, FollowsAWayThatBecomesLonger) {
    Link link;
    link.fill(4'000'000, 20 * ms);
    link.go_on(3 * second, 4'000'000, 800 * ms);
    EXPECT_NEAR(static_cast<double>(link.rate.window_bytes()), 4e6 * 1.0, 5e4) << "a quarter of the way more";
}

TEST(LinkRate, LossWidensTheWindowByRetransmission) {
    Link link;
    link.fill(4'000'000, 100 * ms);
    link.go_on(3 * second, 4'000'000, 100 * ms, 20);
    EXPECT_NEAR(static_cast<double>(link.rate.window_bytes()), 4e6 * 0.68, 5e4);
    link.go_on(3 * second, 4'000'000, 100 * ms);
    EXPECT_NEAR(static_cast<double>(link.rate.window_bytes()), 4e6 * 0.18, 2e4);
}

TEST(LinkRate, FollowsALinkThatNarrows) {
    Link link;
    link.go_on(3 * second, 4'000'000, 20 * ms);
    link.go_on(3 * second, 1'000'000, 20 * ms);
    EXPECT_NEAR(static_cast<double>(link.rate.bytes_per_second()), 1e6, 1e5);
    link.go_on(3 * second, 0, 20 * ms);
    EXPECT_EQ(link.rate.window_bytes(), LinkRate::least_window_bytes);
}

TEST(LinkRate, CountsThatFallAreNoRate) {
    LinkRate rate;
    for (int k = 0; k < 100; ++k)
        rate.look({.now_ns = k * 50 * ms, .arrived_bytes = 1'000'000 - k, .rtt_ns = 10 * ms});
    EXPECT_EQ(rate.bytes_per_second(), 0) << "no rate is below 0";
    EXPECT_EQ(rate.window_bytes(), LinkRate::least_window_bytes);
}

}  // namespace
}  // namespace touchable
