#include "engine/scene/scene.hpp"

#include <gtest/gtest.h>

#include "tests/scene/random.hpp"

namespace touchable::test {
namespace {

constexpr std::int64_t ms = 1'000'000;

TEST(FrameRate, OfOwnTimesIsTheirsAndGoesOnAtTheirMean) {
    const auto rate = rate_of_own_times({50 * ms, 60 * ms, 100 * ms, 150 * ms});
    ASSERT_TRUE(rate);
    EXPECT_EQ(rate->per_second(), 30);
    EXPECT_EQ(rate->num, 30);
    EXPECT_EQ(rate->den, 1);
    EXPECT_EQ(*rate->own_times, (std::vector<std::int64_t>{0, 10 * ms, 50 * ms, 100 * ms}));
    EXPECT_EQ(rate->time_ns(3), 100 * ms);
    EXPECT_EQ(rate->time_ns(4), 133'333'333);
    EXPECT_EQ(rate->time_ns(6), 200 * ms);
    EXPECT_EQ(rate->time_ns(-3), -100 * ms);
}

/// Against a search through all frames.
TEST(FrameRate, FindsTheFrameAtAMomentAndTheNearest) {
    Random random(16);
    std::vector<std::int64_t> times_ns{0};
    for (int n = 1; n < 40; ++n)
        times_ns.push_back(times_ns.back() + ms + static_cast<std::int64_t>(random.below(90)) * ms / 3);
    for (const FrameRate& rate : {FrameRate{30000, 1001}, *rate_of_own_times(times_ns)})
        for (std::int64_t time_ns = -100 * ms; time_ns < times_ns.back() + 200 * ms; time_ns += ms / 3 + 1) {
            std::int64_t at = -10, nearest = -10;
            for (std::int64_t n = -10; n < 200; ++n) {
                if (rate.time_ns(n) <= time_ns) at = n;
                if (std::abs(rate.time_ns(n) - time_ns) < std::abs(rate.time_ns(nearest) - time_ns))
                    nearest = n;
            }
            ASSERT_EQ(rate.frame_at(time_ns), at) << time_ns;
            ASSERT_EQ(rate.nearest(time_ns), nearest) << time_ns;
        }
    for (std::int64_t n = -5; n < 100; ++n) {
        const auto own = *rate_of_own_times(times_ns);
        ASSERT_EQ(own.frame_at(own.time_ns(n)), n);
        ASSERT_EQ(own.frame_at(own.time_ns(n) - 1), n - 1);
    }
}

TEST(FrameRate, OfTimesThatNoClipHasIsNone) {
    EXPECT_FALSE(rate_of_own_times({}));
    EXPECT_FALSE(rate_of_own_times({5}));
    EXPECT_FALSE(rate_of_own_times({0, ms - 1}));
    EXPECT_FALSE(rate_of_own_times({0, 5 * ms, 4 * ms}));
    EXPECT_FALSE(rate_of_own_times({-4'000'000'000'000'000'000, 4'000'000'000'000'000'000}));
    EXPECT_TRUE(rate_of_own_times({-9'000'000'000'000'000'000, -9'000'000'000'000'000'000 + ms}));
}

}  // namespace
}  // namespace touchable::test
