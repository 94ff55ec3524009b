#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <utility>
#include <vector>

#include "engine/stream/hls.hpp"
#include "engine/stream/listeners.hpp"

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

void expect_window(const LinkRate& rate, double bytes, double within) {
    EXPECT_NEAR(static_cast<double>(rate.window_bytes()), bytes, within);
}

TEST(LinkRate, FillsLongLink) {
    FullLink link(4'000'000, 400 * ms);
    link.go_on(4 * second);
    const std::int64_t before = link.now.arrived_bytes;
    link.go_on(4 * second);
    EXPECT_GT(link.now.arrived_bytes - before, 4 * 3'900'000);
    EXPECT_FALSE(link.rate.is_growing());
    EXPECT_LT(link.most_on_its_way, 3 * 1'600'000) << "three times what fits on the way";
    expect_window(link.rate, 4e6 * 0.5, 1e5);
}

TEST(LinkRate, SparesNarrowLink) {
    FullLink link(200'000, 20 * ms);
    link.go_on(8 * second);
    EXPECT_FALSE(link.rate.is_growing());
    EXPECT_LE(link.most_on_its_way, LinkRate::first_window_bytes);
    EXPECT_EQ(link.rate.window_bytes(), LinkRate::least_window_bytes);
}

TEST(LinkRate, BeginsWithFirstWindow) {
    Link link;
    EXPECT_EQ(link.rate.window_bytes(), LinkRate::first_window_bytes);
    link.go_on(second / 2, 0, 100 * ms);
    EXPECT_EQ(link.rate.window_bytes(), LinkRate::first_window_bytes);
    link.go_on(second, 0, 100 * ms);
    EXPECT_EQ(link.rate.window_bytes(), LinkRate::least_window_bytes);
}

TEST(LinkRate, SizesWindowByRoundTrip) {
    Link link;
    link.go_on(second, 4'000'000, 100 * ms);
    expect_window(link.rate, 4e6 * 0.28, 2e4);  // twice the way while it grows
    link.fill(4'000'000, 100 * ms);
    EXPECT_NEAR(static_cast<double>(link.rate.bytes_per_second()), 4e6, 1e5);
    expect_window(link.rate, 4e6 * 0.18, 2e4);
}

/// The queue in front of a full link counts in the measured round trip.
TEST(LinkRate, QueueWidensNoWindow) {
    Link link;
    link.fill(4'000'000, 20 * ms);
    const auto before = static_cast<double>(link.rate.window_bytes());
    link.is_full = true;
    for (std::int64_t rtt = 100 * ms; rtt < 2 * second; rtt += 100 * ms)
        link.go_on(10 * second, 4'000'000, rtt);
    expect_window(link.rate, before, 1e4);
}

TEST(LinkRate, FollowsLongerRoundTrip) {
    Link link;
    link.fill(4'000'000, 20 * ms);
    link.go_on(3 * second, 4'000'000, 800 * ms);
    expect_window(link.rate, 4e6 * 1.0, 5e4);  // a quarter of the way more
}

TEST(LinkRate, LossWidensTheWindow) {
    Link link;
    link.fill(4'000'000, 100 * ms);
    link.go_on(3 * second, 4'000'000, 100 * ms, 20);
    expect_window(link.rate, 4e6 * 0.68, 5e4);
    link.go_on(3 * second, 4'000'000, 100 * ms);
    expect_window(link.rate, 4e6 * 0.18, 2e4);
}

TEST(LinkRate, FollowsNarrowingLink) {
    Link link;
    link.go_on(3 * second, 4'000'000, 20 * ms);
    link.go_on(3 * second, 1'000'000, 20 * ms);
    EXPECT_NEAR(static_cast<double>(link.rate.bytes_per_second()), 1e6, 1e5);
    link.go_on(3 * second, 0, 20 * ms);
    EXPECT_EQ(link.rate.window_bytes(), LinkRate::least_window_bytes);
}

TEST(LinkRate, IgnoresFallingCounts) {
    LinkRate rate;
    for (int k = 0; k < 100; ++k)
        rate.look({.now_ns = k * 50 * ms, .arrived_bytes = 1'000'000 - k, .rtt_ns = 10 * ms});
    EXPECT_EQ(rate.bytes_per_second(), 0) << "no rate is below 0";
    EXPECT_EQ(rate.window_bytes(), LinkRate::least_window_bytes);
}

/// A stream of segments of a second, of 800 + 200 KB or half of that, over a link of `rate` KB/s.
struct SlowSegments {
    LevelChoice choice;
    /// Fetches `segments` of both renditions; the levels that were read: "full full low".
    std::vector<bool> read(int segments, double rate) {
        std::vector<bool> low;
        for (; segments > 0; --segments) {
            const bool is_low = choice.is_low();
            low.push_back(is_low);
            for (const bool touch : {false, true}) {
                const std::int64_t bytes = (touch ? 800'000 : 200'000) / (is_low ? 2 : 1);
                const double took_s = static_cast<double>(bytes) / (1000 * rate);
                choice.add({touch, is_low, bytes, static_cast<std::int64_t>(took_s * 1e9), second});
            }
        }
        return low;
    }
};

using LevelsRead = std::vector<bool>;

TEST(LevelChoice, StaysFullOnGoodLink) {
    SlowSegments link;
    EXPECT_EQ(link.read(20, 1100), LevelsRead(20, false));
    EXPECT_NEAR(link.choice.need(false), 1e6, 1);
    EXPECT_NEAR(link.choice.rate(), 1.1e6, 1);
}

/// The first segment takes longer than it lasts.
TEST(LevelChoice, GoesDownAtOnce) {
    SlowSegments link;
    link.read(5, 5000);
    EXPECT_EQ(link.read(3, 900), LevelsRead({false, true, true}));
}

TEST(LevelChoice, GoesUpAtTwiceRate) {
    SlowSegments link;
    link.read(2, 600);
    EXPECT_EQ(link.read(50, 1900), LevelsRead(50, true));
    EXPECT_EQ(link.read(20, 0.5), LevelsRead(20, true));
    // The slow mean has to reach 2000 KB/s, then four segments in a row.
    const LevelsRead up = link.read(30, 4000);
    int low = 0;
    while (up[static_cast<std::size_t>(low)]) ++low;
    EXPECT_GE(low, 4 + 3);
    EXPECT_LE(low, 4 + 5);
    EXPECT_EQ(LevelsRead(up.begin() + low, up.end()),
              LevelsRead(up.size() - static_cast<std::size_t>(low), false));
}

/// A link that falters between 40 and 150 % of the rate never makes it go up and down.
TEST(LevelChoice, DoesNotFlap) {
    SlowSegments link;
    int changes = 0;
    for (int n = 0; n < 200; ++n) {
        const bool was_low = link.choice.is_low();
        link.read(1, n % 3 == 0 ? 400 : 1500);
        changes += was_low != link.choice.is_low() ? 1 : 0;
    }
    EXPECT_EQ(changes, 1);
}

TEST(LevelChoice, IgnoresMissingFiles) {
    LevelChoice choice;
    choice.add({.bytes = 0, .fetch_ns = second / 10, .duration_ns = second});
    choice.add({.bytes = 1000, .fetch_ns = second, .duration_ns = 0});
    EXPECT_FALSE(choice.is_low());
    EXPECT_EQ(choice.rate(), 0);
    choice.add({.bytes = 0, .fetch_ns = 10 * second, .duration_ns = second});
    EXPECT_TRUE(choice.is_low());
}

TEST(LevelChoice, ColourLeftOutNeedsNothing) {
    SlowSegments link;
    link.read(3, 1100);
    link.choice.leave_out_colour();
    EXPECT_NEAR(link.choice.need(false), 8e5, 1);
    link.choice.add({true, false, 800'000, 9 * second / 10, second});
    EXPECT_FALSE(link.choice.is_low());
}

/// Behind from one moment to another, asked every 5 ms: how often colour is left out from then on.
int stays_behind(NarrowLink& link, std::int64_t from_ns, std::int64_t to_ns) {
    int losses = 0;
    for (std::int64_t now = from_ns; now < to_ns; now += 5 * ms) losses += link.is_behind(now) ? 1 : 0;
    return losses;
}

TEST(NarrowLink, DropsColourBeforeFramesets) {
    NarrowLink link;
    EXPECT_TRUE(link.gives_colour(false, 0));
    EXPECT_EQ(stays_behind(link, 0, second), 0) << "it joins";
    link.has_caught_up();
    EXPECT_EQ(stays_behind(link, 2 * second, 2 * second + 150 * ms), 0);
    EXPECT_FALSE(link.is_far_behind(2 * second + 150 * ms));
    EXPECT_EQ(stays_behind(link, 2 * second + 150 * ms, 2 * second + 300 * ms), 1) << "told once";
    EXPECT_FALSE(link.gives_colour(true, 2 * second + 200 * ms));
    EXPECT_FALSE(link.is_far_behind(2 * second + 300 * ms));
    EXPECT_TRUE(link.is_far_behind(2 * second + 301 * ms));
    link.has_caught_up();
    EXPECT_FALSE(link.is_far_behind(4 * second));
}

TEST(NarrowLink, KeepsColourWhileProbing) {
    NarrowLink link;
    for (std::int64_t now = 0; now < 5 * second; now += 5 * ms) EXPECT_FALSE(link.is_behind(now, true));
    EXPECT_TRUE(link.is_far_behind(5 * second)) << "framesets are left out all the same";
    EXPECT_TRUE(link.gives_colour(false, 5 * second));
    EXPECT_TRUE(link.is_behind(5 * second));
}

TEST(NarrowLink, ToleratesShortStops) {
    NarrowLink link;
    for (std::int64_t n = 0; n < 100; ++n) {
        EXPECT_EQ(stays_behind(link, n * second, n * second + 140 * ms), 0);
        link.has_caught_up();
        EXPECT_TRUE(link.gives_colour(false, n * second + 500 * ms));
    }
}

/// Each time in vain: after 5 s, 10 s, 20 s.
TEST(NarrowLink, RetriesColourEverLessOften) {
    NarrowLink link;
    EXPECT_EQ(stays_behind(link, 0, second + 200 * ms), 1);
    std::int64_t now = second + 195 * ms;  // when it was behind last
    for (const std::int64_t trial : {5 * second, 10 * second, 20 * second}) {
        link.has_caught_up();
        EXPECT_FALSE(link.gives_colour(true, now + trial - ms));
        EXPECT_FALSE(link.gives_colour(false, now + trial)) << "colour begins with a key";
        EXPECT_TRUE(link.gives_colour(true, now + trial));
        now += trial;
        EXPECT_EQ(stays_behind(link, now, now + 155 * ms), 1);
        now += 150 * ms;
    }
}

}  // namespace
}  // namespace touchable
