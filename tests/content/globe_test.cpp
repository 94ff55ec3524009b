// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>

#include "engine/base/same_bits.hpp"
#include "engine/content/families.hpp"
#include "engine/content/mapped_ground.hpp"
#include "tests/content/exact_touch.hpp"
#include "tests/content/made_maps.hpp"
#include "tests/must.hpp"

namespace touchable::test {
namespace {

using real = long double;

struct Published {
    CameraPreset preset;
    real focal_length, pixel_width, near, far, distance;
    double width_degrees, height_degrees;
};
const Published published[] = {
    {CameraPreset::a, 6.983L, 0.00123L, 10, 200, 105, 7.26, 4.84},
    {CameraPreset::a_prime, 6.983L, 0.0123L, 10, 200, 105, 64.8, 45.8},
    {CameraPreset::b, 4.7L, 0.0112L, 40, 180, 110, 81.3, 59.5},
};

double degrees(double radians) {
    return radians * 180 / 3.14159265358979;
}

TEST(Globe, HasPublishedFieldsOfView) {
    for (const Published& p : published) {
        SceneOptions options;
        options.preset = p.preset;
        const auto globe = made("globe", options);
        const Camera& camera = globe->scene().camera;
        EXPECT_NEAR(degrees(2 * std::atan(360 / camera.fx)), p.width_degrees, 0.05);
        EXPECT_NEAR(degrees(2 * std::atan(240 / camera.fy)), p.height_degrees, 0.05);
        EXPECT_EQ(camera.cx, 360);
        EXPECT_EQ(camera.cy, 239);
        EXPECT_EQ(globe->scene().depth.semantics, DepthSemantics::range);
    }
}

TEST(Globe, ShowsNearerCrossing) {
    for (const Published& p : published)
        for (const auto& [width, height] : {std::pair{320, 240}, {720, 480}, {1920, 1080}}) {
            SceneOptions options = sized(width, height);
            options.preset = p.preset;
            const auto globe = made("globe", options);
            const real scale = p.pixel_width * 720 / width / p.focal_length;
            const real radius = p.distance * std::sin(std::atan(0.8L * (height / 2.0L) * scale));
            SplitMix64 random(static_cast<std::uint64_t>(width));
            int met = 0;
            for (int trial = 0; trial < 4000; ++trial) {
                const double x = random.within(-1, width), y = random.within(-1, height);
                // |s (u, v, -1) - (0, 0, -D)| = R for the planar depth s; the range is s L.
                const real u = (x - width / 2) * scale, v = -(y - (height / 2 - 1)) * scale;
                const real a = u * u + v * v + 1, half_b = p.distance,
                           c = p.distance * p.distance - radius * radius;
                const real under_root = half_b * half_b - a * c;
                if (std::fabs(under_root) < 1e-9L) continue;
                const real range =
                    under_root > 0 ? (half_b - std::sqrt(under_root)) / a * std::sqrt(a) : p.far;
                met += under_root > 0;
                const double limb = static_cast<double>(1 / std::sqrt(std::fabs(under_root)));
                ASSERT_NEAR(globe->depth(x, y, 0), static_cast<double>(range), 1e-12 * (100 + 1000 * limb));
            }
            EXPECT_GT(met, 500);
        }
}

TEST(Globe, Spans32MillimetresOfDevice) {
    const auto globe = made("globe");
    const GlobeSphere sphere = globe_sphere(CameraPreset::b, 720, 480);
    EXPECT_NEAR(sphere.radius, 45.77, 0.01);
    EXPECT_DOUBLE_EQ(*globe->scene().device_metres_per_unit * sphere.radius, 0.032);
    EXPECT_EQ(globe->scene().default_properties.stiffness, 1000);
    EXPECT_EQ(globe->scene().default_properties.static_friction, 0);
}

TEST(Globe, FindsClosestPointAlongNormal) {
    const ExactSurface exact("globe");
    const GlobeSphere sphere = globe_sphere(CameraPreset::b, 720, 480);
    SplitMix64 random(3);
    for (int trial = 0; trial < 200; ++trial) {
        const glm::dvec3 way{random.within(-1, 1), random.within(-1, 1), random.within(0.1, 1)};
        const double reach = random.within(0.5, 1.2) * sphere.radius;
        const glm::dvec3 goal = sphere.centre + way * (reach / length(way));
        const auto truth = exact.closest(goal, goal, 0);
        ASSERT_TRUE(truth);
        ASSERT_NEAR(length(truth->point - sphere.centre), sphere.radius, 1e-12 * sphere.radius);
        ASSERT_NEAR(length(truth->normal - way / length(way)), 0, 1e-14);
        ASSERT_NEAR(length(truth->point - goal), std::fabs(reach - sphere.radius), 1e-12 * sphere.radius);
    }
    const auto centre = exact.closest(sphere.centre, sphere.centre, 0);
    EXPECT_NEAR(length(centre->point - sphere.centre), sphere.radius, 1e-12 * sphere.radius);
}

const double half_turn = 3.14159265358979323846;

glm::dvec3 any_direction(SplitMix64& random) {
    while (true) {
        const glm::dvec3 way{random.within(-1, 1), random.within(-1, 1), random.within(-1, 1)};
        if (length(way) > 0.1 && length(way) < 1) return way / length(way);
    }
}

TEST(GlobeMaps, AreEquirectangular) {
    const auto expect = [](const glm::dvec3& direction, double east, double south) {
        const MapPlace place = map_place(2.5 * direction);
        EXPECT_NEAR(place.east, east, 1e-12);
        EXPECT_NEAR(place.south, south, 1e-12);
    };
    expect({0, 0, 1}, 0.5, 0.5);    // longitude 0 in the middle
    expect({1, 0, 0}, 0.75, 0.5);   // 90 degrees east to the right
    expect({-1, 0, 0}, 0.25, 0.5);  // and west to the left
    expect({0, 1, 1e-9}, 0.5, 0);   // north on top
    expect({0, -1, 1e-9}, 0.5, 1);
}

TEST(GlobeMaps, JoinAcrossDateLine) {
    // Smooth on the sphere: 100 (1 + x/2 + y/3).
    const MadeMap made = made_map(256, 1, 2, [](double longitude, double latitude, int) {
        return 20000 * (1 + std::sin(longitude) * std::cos(latitude) / 2 + std::sin(latitude) / 3);
    });
    const GlobeMap map = made.map();
    const auto value = [&](const glm::dvec3& direction) {
        return between_pixels(map, map_place(direction), [&](int x, int y) { return map.at(x, y, 0); });
    };
    SplitMix64 random(5);
    for (int trial = 0; trial < 3000; ++trial) {
        glm::dvec3 d = any_direction(random);
        if (trial % 3 == 0) d = {0.01 * d.x, d.y < 0 ? -1.0 : 1.0, 0.01 * d.z};  // near a pole
        if (trial % 3 == 1) d = {0.01 * d.x, d.y, -1};                           // near the date line
        d /= length(d);
        ASSERT_NEAR(value(d), 20000 * (1 + d.x / 2 + d.y / 3), 10) << d.x << " " << d.y << " " << d.z;
    }
}

TEST(GlobeMaps, RejectOtherShapes) {
    const auto refusal = [](int width, int height) {
        MadeWorld world(64);
        MadeMap odd{width, height, 1, 2,
                    std::vector<std::uint8_t>(static_cast<std::size_t>(2 * width * height))};
        world.maps.elevation = odd.map();
        const auto checked = check_globe_maps(world.maps);
        return checked ? "" : checked.error().message;
    };
    EXPECT_EQ(refusal(400, 200), "");
    EXPECT_EQ(refusal(401, 201), "");  // of grid lines, both ends of which are there
    EXPECT_NE(refusal(400, 190).find("the elevation map is 400x190; must be equirectangular"),
              std::string::npos);
    EXPECT_NE(refusal(200, 400).find("200x400"), std::string::npos);
    EXPECT_NE(refusal(2, 1).find("2x1"), std::string::npos);
    GlobeMaps none;
    expect_error(check_globe_maps(none), "the colour map is missing");
    MadeWorld world(64);
    world.maps.elevation = world.colour.map();
    expect_error(check_globe_maps(world.maps), "must be grey");
    for (const double relief : {0.0, -1.0, 0.11, std::nan("")}) {
        MadeWorld steep(64);
        steep.maps.relief = relief;
        expect_error(check_globe_maps(steep.maps), "relief");
    }
}

TEST(Shore, IsFoundForEitherPolarity) {
    for (const bool land_is_bright : {true, false}) {
        const MadeWorld world(360, land_is_bright ? 255 : 0, land_is_bright ? 0 : 255);
        const auto shore = must(find_shore(world.maps.elevation, world.maps.mask, {}));
        EXPECT_EQ(shore.bright_is_land, land_is_bright);
        // Every level between the highest sea floor and the lowest land agrees; the lowest is taken.
        EXPECT_GE(shore.sea_level, 16990);
        EXPECT_LT(shore.sea_level, 20500);
        EXPECT_DOUBLE_EQ(shore.agreement, 1);
        EXPECT_GT(shore.top, 50000);
    }
}

// In the far north land and sea are equally high: no level is between them.
TEST(Shore, LiesBetweenHeights) {
    const MadeMap mask =
        made_map(360, 1, 1, [](double longitude, double, int) { return longitude < 0 ? 255.0 : 0; });
    const MadeMap elevation = made_map(360, 1, 2, [](double longitude, double latitude, int) {
        return latitude > 1.2 ? 200.0 : longitude < 0 ? 300.0 : 100.0;
    });
    EXPECT_EQ(must(find_shore(elevation.map(), mask.map(), {})).sea_level, 100);
}

TEST(Shore, IsFoundInNumbers) {
    const MadeWorld fine(720), coarse(90);
    EXPECT_GT(find_shore(fine.maps.elevation, coarse.maps.mask, {})->agreement, 0.97);
    EXPECT_GT(find_shore(coarse.maps.elevation, fine.maps.mask, {})->agreement, 0.97);
    const MadeWorld world;
    std::vector<float> metres;
    for (int y = 0; y < 180; ++y)
        for (int x = 0; x < 360; ++x)
            metres.push_back(static_cast<float>(world.maps.elevation.at(x, y, 0) - MadeWorld::sea_level));
    metres[5] = std::numeric_limits<float>::quiet_NaN();
    const GlobeMap numbers{{}, metres, 360, 180, 1};
    const auto shore = must(find_shore(numbers, world.maps.mask, {}));
    EXPECT_LT(shore.sea_level, 500);
    EXPECT_GE(shore.sea_level, -3100);
}

TEST(Shore, IsTakenAsStated) {
    const MadeWorld world(360, 0, 255);
    const auto shore = must(find_shore(world.maps.elevation, world.maps.mask, 20520.0));
    EXPECT_EQ(shore.sea_level, 20520);
    EXPECT_FALSE(shore.bright_is_land);
    EXPECT_LT(shore.agreement, 0.99);
    for (const double beyond : {0.0, 40000.0, 65535.0, -1e9})
        EXPECT_NE(
            find_shore(world.maps.elevation, world.maps.mask, beyond).error().message.find("do not agree"),
            std::string::npos);
}

TEST(Shore, NeedsAgreeingMaps) {
    const MadeWorld world;
    // As if the mask began at longitude 0, or had south on top.
    const MadeMap turned = made_map(360, 1, 1, [](double longitude, double latitude, int) {
        return MadeWorld::is_land(longitude < 0 ? longitude + half_turn : longitude - half_turn, latitude)
                   ? 255.0
                   : 0;
    });
    expect_error(find_shore(world.maps.elevation, turned.map(), {}), ErrorKind::input, "do not agree");
    SplitMix64 random(1);
    const MadeMap noise =
        made_map(360, 1, 1, [&](double, double, int) { return random.unit() < 0.3 ? 255.0 : 0; });
    EXPECT_FALSE(find_shore(world.maps.elevation, noise.map(), {}));
    const MadeMap white = even_map(255, 360);
    expect_error(find_shore(world.maps.elevation, white.map(), {}), "same everywhere");
    const MadeMap level = even_map(700, 360, 2);
    expect_error(find_shore(level.map(), world.maps.mask, {}), "level everywhere");
}

TEST(Shore, NeedsEnoughNumbers) {
    const MadeWorld world(64);
    // In maps this wide every second pixel is looked at.
    const int width = 2050, height = 1025;
    std::vector<float> metres(static_cast<std::size_t>(width) * height, std::nanf(""));
    metres[static_cast<std::size_t>(width) * 513 + 1025] = 900;  // land
    metres[static_cast<std::size_t>(width) * 513 + 1] = -900;
    const GlobeMap sparse{{}, metres, width, height, 1};
    for (const std::optional<double> told : {std::optional<double>{}, std::optional(0.0)}) {
        expect_error(find_shore(sparse, world.maps.mask, told), "the elevation map has too few numbers");
    }
}

TEST(CubeGrid, SharesEdgePointsExactly) {
    const CubeGrid grid(32);
    std::map<std::array<double, 3>, int> places;
    for (int face = 0; face < 6; ++face)
        for (int j = 0; j <= 32; ++j)
            for (int i = 0; i <= 32; ++i) {
                const glm::dvec3 d = grid.direction(face, i, j);
                ASSERT_NEAR(length(d), 1, 1e-15);
                ++places[{d.x, d.y, d.z}];
                const CubePlace place = grid.place(3.0 * d);
                const bool edge = i % 32 == 0 || j % 32 == 0;
                if (!edge) {
                    ASSERT_EQ(place.face, face);
                    ASSERT_NEAR(place.x, i, 1e-12);
                    ASSERT_NEAR(place.y, j, 1e-12);
                }
            }
    // 8 corners of three faces, 12 edges of two.
    EXPECT_EQ(places.size(), 6U * 33 * 33 - 12U * 31 - 8U * 2);
}

TEST(CubeGrid, HasNearlyEqualCells) {
    const CubeGrid grid(64);
    double least = 10, most = 0;
    SplitMix64 random(3);
    for (int trial = 0; trial < 200000; ++trial) {
        const glm::dvec3 a = any_direction(random);
        glm::dvec3 b = a + 1e-4 * any_direction(random);
        b /= length(b);
        const CubePlace p = grid.place(a), q = grid.place(b);
        if (p.face != q.face) continue;
        const double cells = std::sqrt((p.x - q.x) * (p.x - q.x) + (p.y - q.y) * (p.y - q.y));
        if (cells < 1e-4) continue;
        least = std::min(least, length(a - b) / cells);
        most = std::max(most, length(a - b) / cells);
    }
    EXPECT_GE(least, grid.least_spacing());
    EXPECT_LT(least, 1.1 * grid.least_spacing());
    EXPECT_LT(most, 1.2 * grid.spacing());
}

TEST(ValleyFloor, LiesUnderTheGround) {
    HeightGrid ground{180, 90, {}};
    SplitMix64 random(4);
    for (int y = 0; y < 90; ++y)
        for (int x = 0; x < 180; ++x)
            ground.values.push_back(x < 60 ? 0.0F : static_cast<float>(0.2 + 0.8 * random.unit()));
    RowBands rows(2);
    const double radius = 6 * half_turn / 180;  // three cells
    const HeightGrid floor = valley_floor(ground, radius, rows);
    const auto at = [](const HeightGrid& grid, int x, int y) {
        return grid.values[static_cast<std::size_t>(y * 180 + (x + 180) % 180)];
    };
    for (int y = 0; y < 90; ++y)
        for (int x = 0; x < 180; ++x) {
            ASSERT_LE(at(floor, x, y), at(ground, x, y));
            ASSERT_GE(at(floor, x, y), 0);
        }
    for (int y = 0; y < 90; ++y) {
        for (int x = 0; x < 60; ++x) ASSERT_EQ(at(floor, x, y), 0);
        ASSERT_EQ(at(floor, 60, y), 0);  // so that it is level up to the coast
        ASSERT_EQ(at(floor, -1, y), 0);  // also across the date line
    }
    for (int y = 20; y < 70; ++y) {
        ASSERT_GT(at(floor, 120, y), 0.19F);
        ASSERT_LT(at(floor, 120, y), 0.4F);  // near the lowest, 0.2
        for (int x = 75; x < 165; ++x)       // a fourth of the distance of two cells' heights at most
            ASSERT_LT(std::fabs(at(floor, x, y) - at(floor, x + 1, y)), 0.03F);
    }
}

TEST(ValleyFloor, TreatsPoleLikeAnyPlace) {
    RowBands rows(1);
    HeightGrid level{72, 36, std::vector<float>(72 * 36, 0.7F)};
    for (const float value : valley_floor(level, 0.3, rows).values) ASSERT_NEAR(value, 0.7F, 1e-6F);
    // A hole at the pole is felt all around it, as one at the equator is: the same distance in every
    // direction.
    HeightGrid holed = level;
    for (int x = 0; x < 72; ++x) holed.values[static_cast<std::size_t>(x)] = 0;
    const HeightGrid floor = valley_floor(holed, 0.3, rows);
    for (std::size_t x = 0; x < 72; ++x) {
        ASSERT_EQ(floor.values[2 * 72 + x], floor.values[2 * 72]);
        ASSERT_LT(floor.values[3 * 72 + x], 0.2F);           // 15 degrees from the hole's edge
        ASSERT_NEAR(floor.values[9 * 72 + x], 0.7F, 1e-6F);  // beyond both radii
    }
}

TEST(ValleyFloor, ReachesAcrossPole) {
    RowBands rows(1);
    HeightGrid holed{72, 36, std::vector<float>(72 * 36, 0.7F)};
    holed.values[36] = 0;  // one cell of the row next to the pole, in reach of all others there
    const HeightGrid floor = valley_floor(holed, 0.3, rows);
    for (std::size_t x = 0; x < 72; ++x) ASSERT_EQ(floor.values[x], 0) << x;
}

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

TEST(Planet, AlwaysShowsLandAndSea) {
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

TEST(Planet, FeelsDifferentOnLand) {
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

TEST(Planet, TurnsRightIn12Seconds) {
    const auto globe = planet_globe(360, 240);
    // 5 degrees of a radius of 96 pixels; the axis leans, so a little less along a row.
    EXPECT_NEAR(best_shift(globe->frame(20), globe->frame(25)), 8, 2);
    const RawFrame first = globe->frame(0), again = globe->frame(360);
    int differ = 0;
    for (int y = 0; y < 240; ++y)
        for (int x = 0; x < 360; ++x) differ += kind(first, x, y) != kind(again, x, y);
    EXPECT_LE(differ, 1);
}

TEST(Planet, KeepsDepthWhileTurning) {
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

TEST(Planet, HasContinuousGround) {
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
}  // namespace touchable::test
