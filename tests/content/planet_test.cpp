#include "engine/content/planet.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "tests/content/made.hpp"

namespace touchable {
namespace {

std::unique_ptr<AnalyticScene> planet_globe(int width, int height, std::uint64_t seed = 1) {
    SceneOptions options = sized(width, height);
    options.properties = true;
    options.seed = seed;
    return made("globe", options);
}

/// 1 on land, 0 at sea, -1 beside the planet.
int kind(const RawFrame& frame, int x, int y) {
    if (frame.depth.sample(x, y) == 0) return -1;
    return frame.haptic.sample(x, y) >= 94;  // half way between 0.4 and 1.2 N/mm in 0.1 to 2
}

TEST(Planet, ShowsLandAndSeaInEveryFrameOfATurn) {
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
        const auto globe = planet_globe(180, 120, seed);
        for (int n = 0; n < 360; n += 30) {
            const RawFrame frame = globe->frame(n);
            int land = 0, disc = 0;
            for (int y = 0; y < 120; ++y)
                for (int x = 0; x < 180; ++x) {
                    disc += kind(frame, x, y) >= 0;
                    land += kind(frame, x, y) == 1;
                }
            EXPECT_GT(disc, 6000);
            EXPECT_GE(land, 0.15 * disc) << "seed " << seed << " frame " << n;
            EXPECT_LE(land, 0.60 * disc) << "seed " << seed << " frame " << n;
        }
    }
}

TEST(Planet, HeightsRiseOnlyOnLand) {
    const auto globe = planet_globe(240, 160);
    int high = 0;
    for (const int n : {0, 45, 200}) {
        const RawFrame frame = globe->frame(n);
        for (int y = 0; y < 160; ++y)
            for (int x = 0; x < 240; ++x) {
                ASSERT_TRUE(kind(frame, x, y) == 1 || frame.height.sample(x, y) == 0) << x << " " << y;
                high += frame.height.sample(x, y) > 128;
            }
    }
    EXPECT_GT(high, 200);
    EXPECT_EQ(globe->scene().height_coding.max_height, 1);
    EXPECT_EQ(globe->scene().height_coding.units, HeightUnits::levels);
}

TEST(Planet, LandIsStifferAndRougherThanTheSeaAndTheBackgroundHasItsOwnFeel) {
    const auto globe = planet_globe(240, 160);
    const HapticRanges& ranges = globe->scene().haptic;
    const RawFrame frame = globe->frame(0);
    int pure_land = 0, pure_sea = 0;
    for (int y = 0; y < 160; ++y)
        for (int x = 0; x < 240; ++x) {
            const auto code = [&](int channel) {
                return static_cast<std::uint8_t>(frame.haptic.sample(x, y, channel));
            };
            const HapticProperties felt = ranges.at(code(0), code(1), code(2));
            if (kind(frame, x, y) < 0) {
                ASSERT_NEAR(felt.stiffness, 800, 4);
                ASSERT_NEAR(felt.static_friction, 0.3, 0.002);
                continue;
            }
            ASSERT_GE(felt.stiffness, 396);
            ASSERT_LE(felt.stiffness, 1204);
            ASSERT_GT(felt.static_friction, felt.dynamic_friction);
            pure_land += std::fabs(felt.stiffness - 1200) < 4 &&
                         std::fabs(felt.static_friction - 0.60) < 0.002 &&
                         std::fabs(felt.dynamic_friction - 0.45) < 0.002;
            pure_sea += std::fabs(felt.stiffness - 400) < 4 &&
                        std::fabs(felt.static_friction - 0.15) < 0.002 &&
                        std::fabs(felt.dynamic_friction - 0.10) < 0.002;
        }
    EXPECT_GT(pure_land, 2000);
    EXPECT_GT(pure_sea, 4000);
}

/// Shift of the disc's middle rows from one frame to another that lets most pixels agree in kind.
int best_shift(const RawFrame& from, const RawFrame& to) {
    int best = 0, most = -1;
    for (int shift = -15; shift <= 15; ++shift) {
        int agree = 0;
        for (int y = 100; y < 140; ++y)
            for (int x = 140; x < 220; ++x) agree += kind(from, x, y) == kind(to, x + shift, y);
        if (agree > most) {
            most = agree;
            best = shift;
        }
    }
    return best;
}

TEST(Planet, TurnsToTheRightOnceInTwelveSeconds) {
    const auto globe = planet_globe(360, 240);
    // 5 degrees of a radius of 96 pixels; the axis leans, so a little less along a row.
    EXPECT_NEAR(best_shift(globe->frame(20), globe->frame(25)), 8, 2);
    const RawFrame first = globe->frame(0), again = globe->frame(360);
    int differ = 0;
    for (int y = 0; y < 240; ++y)
        for (int x = 0; x < 360; ++x) differ += kind(first, x, y) != kind(again, x, y);
    EXPECT_LE(differ, 1);
}

TEST(Planet, DepthStandsStillWhileTheSurfaceTurns) {
    const auto globe = planet_globe(90, 60);
    const RawFrame a = globe->frame(0), b = globe->frame(1);
    EXPECT_EQ(std::memcmp(a.depth.data, b.depth.data, 90U * 60U * 2U), 0);
    EXPECT_NE(std::memcmp(a.colour.data, b.colour.data, 90U * 60U * 3U), 0);
    EXPECT_NE(std::memcmp(a.haptic.data, b.haptic.data, 90U * 60U * 3U), 0);
    EXPECT_NE(std::memcmp(a.height.data, b.height.data, 90U * 60U), 0);
}

TEST(Planet, SeedsMakeDifferentPlanets) {
    const RawFrame a = planet_globe(90, 60, 1)->frame(0), b = planet_globe(90, 60, 2)->frame(0);
    EXPECT_NE(std::memcmp(a.haptic.data, b.haptic.data, 90U * 60U * 3U), 0);
}

TEST(Planet, ClaimsNoTruthForItsRelief) {
    const glm::dvec3 goal{0, 0, -70};
    EXPECT_FALSE(planet_globe(90, 60)->closest(goal, goal, 0));
}

TEST(Planet, GroundIsContinuousAcrossTheWholeSphere) {
    const Planet planet(1);
    SplitMix64 random(9);
    for (int trial = 0; trial < 2000; ++trial) {
        glm::dvec3 place{random.within(-1, 1), random.within(-1, 1), random.within(-1, 1)};
        place /= length(place);
        glm::dvec3 beside = place + glm::dvec3(1e-7, -1e-7, 1e-7);
        beside /= length(beside);
        const Ground a = planet.ground(place), b = planet.ground(beside);
        ASSERT_NEAR(a.elevation, b.elevation, 1e-4);
        ASSERT_NEAR(a.relief, b.relief, 1e-4);
        ASSERT_GE(a.relief, 0);
        ASSERT_LE(a.relief, 1);
    }
}

}  // namespace
}  // namespace touchable
