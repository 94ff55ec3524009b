#include "engine/stream/link_rate.hpp"

#include <gtest/gtest.h>

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
};

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
    EXPECT_NEAR(static_cast<double>(link.rate.bytes_per_second()), 4e6, 1e5);
    EXPECT_NEAR(static_cast<double>(link.rate.window_bytes()), 4e6 * 0.18, 2e4);
}

/// What waits in front of a full link counts in the round trip as it is measured.
TEST(LinkRate, QueueDoesNotWidenTheWindow) {
    Link link;
    link.go_on(3 * second, 4'000'000, 20 * ms);
    const auto before = static_cast<double>(link.rate.window_bytes());
    link.is_full = true;
    for (std::int64_t rtt = 100 * ms; rtt < 2 * second; rtt += 100 * ms)
        link.go_on(10 * second, 4'000'000, rtt);
    EXPECT_NEAR(static_cast<double>(link.rate.window_bytes()), before, 1e4);
}

TEST(LinkRate, FollowsAWayThatBecomesLonger) {
    Link link;
    link.go_on(3 * second, 4'000'000, 20 * ms);
    link.go_on(3 * second, 4'000'000, 800 * ms);
    EXPECT_NEAR(static_cast<double>(link.rate.window_bytes()), 4e6 * 0.88, 5e4);
}

TEST(LinkRate, LossWidensTheWindowByRetransmission) {
    Link link;
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
