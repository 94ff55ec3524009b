#include "engine/stream/listeners.hpp"

#include <gtest/gtest.h>

namespace touchable {
namespace {

constexpr std::int64_t narrow_ms = 1'000'000, narrow_second = 1'000 * narrow_ms;

/// Behind from one moment to another, asked every 5 ms: how often colour is left out from then on.
int stays_behind(NarrowLink& link, std::int64_t from_ns, std::int64_t to_ns) {
    int losses = 0;
    for (std::int64_t now = from_ns; now < to_ns; now += 5 * narrow_ms) losses += link.is_behind(now) ? 1 : 0;
    return losses;
}

TEST(NarrowLink, ColourGoesBeforeFramesets) {
    NarrowLink link;
    EXPECT_TRUE(link.gives_colour(false, 0));
    EXPECT_EQ(stays_behind(link, 0, narrow_second), 0) << "it joins";
    link.has_caught_up();
    EXPECT_EQ(stays_behind(link, 2 * narrow_second, 2 * narrow_second + 150 * narrow_ms), 0);
    EXPECT_FALSE(link.is_far_behind(2 * narrow_second + 150 * narrow_ms));
    EXPECT_EQ(stays_behind(link, 2 * narrow_second + 150 * narrow_ms, 2 * narrow_second + 300 * narrow_ms), 1)
        << "told once";
    EXPECT_FALSE(link.gives_colour(true, 2 * narrow_second + 200 * narrow_ms));
    EXPECT_FALSE(link.is_far_behind(2 * narrow_second + 300 * narrow_ms));
    EXPECT_TRUE(link.is_far_behind(2 * narrow_second + 301 * narrow_ms));
    link.has_caught_up();
    EXPECT_FALSE(link.is_far_behind(4 * narrow_second));
}

TEST(NarrowLink, KeepsItsColourWhileItsLinkIsTried) {
    NarrowLink link;
    for (std::int64_t now = 0; now < 5 * narrow_second; now += 5 * narrow_ms)
        EXPECT_FALSE(link.is_behind(now, true));
    EXPECT_TRUE(link.is_far_behind(5 * narrow_second)) << "framesets are left out all the same";
    EXPECT_TRUE(link.gives_colour(false, 5 * narrow_second));
    EXPECT_TRUE(link.is_behind(5 * narrow_second));
}

TEST(NarrowLink, ShortStopsCostNothing) {
    NarrowLink link;
    for (std::int64_t n = 0; n < 100; ++n) {
        EXPECT_EQ(stays_behind(link, n * narrow_second, n * narrow_second + 140 * narrow_ms), 0);
        link.has_caught_up();
        EXPECT_TRUE(link.gives_colour(false, n * narrow_second + 500 * narrow_ms));
    }
}

/// Each time in vain: after 5 s, 10 s, 20 s.
TEST(NarrowLink, ColourComesBackWithAKeyAndLessOften) {
    NarrowLink link;
    EXPECT_EQ(stays_behind(link, 0, narrow_second + 200 * narrow_ms), 1);
    std::int64_t now = narrow_second + 195 * narrow_ms;  // when it was behind last
    for (const std::int64_t trial : {5 * narrow_second, 10 * narrow_second, 20 * narrow_second}) {
        link.has_caught_up();
        EXPECT_FALSE(link.gives_colour(true, now + trial - narrow_ms));
        EXPECT_FALSE(link.gives_colour(false, now + trial)) << "colour begins with a key";
        EXPECT_TRUE(link.gives_colour(true, now + trial));
        now += trial;
        EXPECT_EQ(stays_behind(link, now, now + 155 * narrow_ms), 1);
        now += 150 * narrow_ms;
    }
}

}  // namespace
}  // namespace touchable
