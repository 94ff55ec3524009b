#include "engine/stream/hls.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace touchable {
namespace {

constexpr std::int64_t level_second = 1'000'000'000;

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
                choice.add({touch, is_low, bytes, static_cast<std::int64_t>(took_s * 1e9), level_second});
            }
        }
        return low;
    }
};

using LevelsRead = std::vector<bool>;

TEST(LevelChoice, StaysFullWhereTheLinkCarriesIt) {
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

TEST(LevelChoice, GoesUpWithTwiceTheRateOnly) {
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

TEST(LevelChoice, MissingFilesTellNothing) {
    LevelChoice choice;
    choice.add({.bytes = 0, .fetch_ns = level_second / 10, .duration_ns = level_second});
    choice.add({.bytes = 1000, .fetch_ns = level_second, .duration_ns = 0});
    EXPECT_FALSE(choice.is_low());
    EXPECT_EQ(choice.rate(), 0);
    choice.add({.bytes = 0, .fetch_ns = 10 * level_second, .duration_ns = level_second});
    EXPECT_TRUE(choice.is_low());
}

TEST(LevelChoice, ColourLeftOutNeedsNothing) {
    SlowSegments link;
    link.read(3, 1100);
    link.choice.leave_out_colour();
    EXPECT_NEAR(link.choice.need(false), 8e5, 1);
    link.choice.add({true, false, 800'000, 9 * level_second / 10, level_second});
    EXPECT_FALSE(link.choice.is_low());
}

}  // namespace
}  // namespace touchable
