#include "device/point_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace touchable::test {
namespace {

constexpr std::int64_t tick_ns = 1'000'000;

TEST(PlausibleMotion, BelievesAHandThatMoves) {
    PlausibleMotion motion;
    for (std::int64_t tick = 1; tick <= 1000; ++tick)
        ASSERT_TRUE(
            motion.believe({0.002 * std::abs(static_cast<double>(tick % 100 - 50)), 0, 0}, tick * tick_ns))
            << tick;
}

TEST(PlausibleMotion, LeavesOutOneDamagedPlaceAndGoesOn) {
    PlausibleMotion motion;
    ASSERT_TRUE(motion.believe({0, 0, 0}, 1 * tick_ns));
    EXPECT_FALSE(motion.believe({0.131, 0, 0}, 2 * tick_ns));
    EXPECT_FALSE(motion.believe({0, std::numeric_limits<double>::quiet_NaN(), 0}, 3 * tick_ns));
    EXPECT_FALSE(motion.believe({0, 0, std::numeric_limits<double>::infinity()}, 4 * tick_ns));
    const auto next = motion.believe({0.001, 0, 0}, 5 * tick_ns);
    ASSERT_TRUE(next);
    EXPECT_EQ(next->x, 0.001);
}

TEST(PlausibleMotion, AFingerThatIsElsewhereIsLostFirst) {
    PlausibleMotion motion;
    ASSERT_TRUE(motion.believe({0, 0, 0}, 1 * tick_ns));
    for (std::int64_t tick = 2; tick < 152; ++tick)
        ASSERT_FALSE(motion.believe({0.3, 0, 0}, tick * tick_ns)) << "believed after " << tick - 2 << " ms";
    EXPECT_TRUE(motion.believe({0.3, 0, 0}, 152 * tick_ns));
}

TEST(PlausibleMotion, PlacesThatLeapAboutAreNeverBelieved) {
    PlausibleMotion motion;
    ASSERT_TRUE(motion.believe({0, 0, 0}, 1 * tick_ns));
    for (std::int64_t tick = 2; tick < 1000; ++tick)
        EXPECT_FALSE(motion.believe({tick % 2 == 0 ? 0.3 : -0.3, 0, 0}, tick * tick_ns));
}

TEST(PlausibleMotion, AGapIsNoLicenceToLeap) {
    PlausibleMotion motion;
    ASSERT_TRUE(motion.believe({0, 0, 0}, 1 * tick_ns));
    EXPECT_FALSE(motion.believe({0.06, 0, 0}, 1000 * tick_ns));
    motion.forget();
    EXPECT_TRUE(motion.believe({0.06, 0, 0}, 1001 * tick_ns));
}

/// docs/devices.md: 5 m/s, and 52 mm after any gap; 2 mm of them are slack.
TEST(PlausibleMotion, AHandGoesFiveMetresASecondAndNoFartherThan52MillimetresUnseen) {
    const auto believes = [](double metres, std::int64_t ms) {
        PlausibleMotion motion;
        EXPECT_TRUE(motion.believe({0, 0, 0}, tick_ns));
        return motion.believe({0, metres, 0}, tick_ns + ms * tick_ns).has_value();
    };
    EXPECT_TRUE(believes(0.0069, 1));
    EXPECT_FALSE(believes(0.0071, 1));
    EXPECT_TRUE(believes(0.0269, 5));
    EXPECT_FALSE(believes(0.0271, 5));
    for (const std::int64_t gap_ms : {10, 11, 100, 100'000}) {
        EXPECT_TRUE(believes(0.0519, gap_ms)) << gap_ms;
        EXPECT_FALSE(believes(0.0521, gap_ms)) << gap_ms;
    }
}

TEST(PlausibleMotion, NothingIsBeyondTheRoom) {
    PlausibleMotion motion;
    EXPECT_FALSE(motion.believe({0, 5.1, 0}, 1 * tick_ns));
    EXPECT_TRUE(motion.believe({0, 4.9, 0}, 2 * tick_ns));
}

}  // namespace
}  // namespace touchable::test
