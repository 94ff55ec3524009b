#include "engine/content/mapped_ground.hpp"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <map>

#include "engine/content/seeded_noise.hpp"
#include "tests/content/made.hpp"
#include "tests/content/made_maps.hpp"

namespace touchable {
namespace {

const double half_turn = 3.14159265358979323846;

glm::dvec3 any_direction(SplitMix64& random) {
    while (true) {
        const glm::dvec3 way{random.within(-1, 1), random.within(-1, 1), random.within(-1, 1)};
        if (length(way) > 0.1 && length(way) < 1) return way / length(way);
    }
}

TEST(GlobeMaps, PlacesAreWhereMapsHaveThem) {
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

TEST(GlobeMaps, PixelsAreJoinedAcrossTheDateLineAndThePoles) {
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

TEST(GlobeMaps, OfOtherShapesAreRefused) {
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
    EXPECT_NE(check_globe_maps(none).error().message.find("the colour map is missing"), std::string::npos);
    MadeWorld world(64);
    world.maps.elevation = world.colour.map();
    EXPECT_NE(check_globe_maps(world.maps).error().message.find("must be grey"), std::string::npos);
    for (const double relief : {0.0, -1.0, 0.11, std::nan("")}) {
        MadeWorld steep(64);
        steep.maps.relief = relief;
        EXPECT_NE(check_globe_maps(steep.maps).error().message.find("relief"), std::string::npos);
    }
}

TEST(Shore, IsFoundWhicheverIsBright) {
    for (const bool land_is_bright : {true, false}) {
        const MadeWorld world(360, land_is_bright ? 255 : 0, land_is_bright ? 0 : 255);
        const auto shore = find_shore(world.maps.elevation, world.maps.mask, {});
        ASSERT_TRUE(shore) << shore.error().message;
        EXPECT_EQ(shore->bright_is_land, land_is_bright);
        // Every level between the highest sea floor and the lowest land agrees; the lowest is taken.
        EXPECT_GE(shore->sea_level, 16990);
        EXPECT_LT(shore->sea_level, 20500);
        EXPECT_DOUBLE_EQ(shore->agreement, 1);
        EXPECT_GT(shore->top, 50000);
    }
}

TEST(Shore, IsFoundOfMapsOfOtherSizesAndOfNumbers) {
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
    const auto shore = find_shore(numbers, world.maps.mask, {});
    ASSERT_TRUE(shore) << shore.error().message;
    EXPECT_LT(shore->sea_level, 500);
    EXPECT_GE(shore->sea_level, -3100);
}

TEST(Shore, ToldIsTaken) {
    const MadeWorld world(360, 0, 255);
    const auto shore = find_shore(world.maps.elevation, world.maps.mask, 20520.0);
    ASSERT_TRUE(shore) << shore.error().message;
    EXPECT_EQ(shore->sea_level, 20520);
    EXPECT_FALSE(shore->bright_is_land);
    EXPECT_LT(shore->agreement, 0.99);
    for (const double beyond : {0.0, 40000.0, 65535.0, -1e9})
        EXPECT_NE(
            find_shore(world.maps.elevation, world.maps.mask, beyond).error().message.find("do not agree"),
            std::string::npos);
}

TEST(Shore, MapsThatDoNotAgreeAreRefused) {
    const MadeWorld world;
    // As if the mask began at longitude 0, or had south on top.
    const MadeMap turned = made_map(360, 1, 1, [](double longitude, double latitude, int) {
        return MadeWorld::is_land(longitude < 0 ? longitude + half_turn : longitude - half_turn, latitude)
                   ? 255.0
                   : 0;
    });
    const auto refused = find_shore(world.maps.elevation, turned.map(), {});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, ErrorKind::input);
    EXPECT_NE(refused.error().message.find("do not agree"), std::string::npos);
    SplitMix64 random(1);
    const MadeMap noise =
        made_map(360, 1, 1, [&](double, double, int) { return random.unit() < 0.3 ? 255.0 : 0; });
    EXPECT_FALSE(find_shore(world.maps.elevation, noise.map(), {}));
    const MadeMap white = made_map(360, 1, 1, [](double, double, int) { return 255.0; });
    EXPECT_NE(find_shore(world.maps.elevation, white.map(), {}).error().message.find("same everywhere"),
              std::string::npos);
    const MadeMap level = made_map(360, 1, 2, [](double, double, int) { return 700.0; });
    EXPECT_NE(find_shore(level.map(), world.maps.mask, {}).error().message.find("level everywhere"),
              std::string::npos);
}

TEST(Shore, OfNumbersInTooFewPlacesIsRefused) {
    const MadeWorld world(64);
    // Of maps this wide every second pixel is looked at.
    const int width = 2050, height = 1025;
    std::vector<float> metres(static_cast<std::size_t>(width) * height, std::nanf(""));
    metres[static_cast<std::size_t>(width) * 513 + 1025] = 900;  // land
    metres[static_cast<std::size_t>(width) * 513 + 1] = -900;
    const GlobeMap sparse{{}, metres, width, height, 1};
    for (const std::optional<double> told : {std::optional<double>{}, std::optional(0.0)}) {
        const auto shore = find_shore(sparse, world.maps.mask, told);
        ASSERT_FALSE(shore);
        EXPECT_NE(shore.error().message.find("the elevation map has too few numbers"), std::string::npos)
            << shore.error().message;
    }
}

TEST(CubeGrid, PointsOfAnEdgeAreTheSameBitsOnEachFace) {
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

TEST(CubeGrid, CellsAreNearlyEqualAndNoneSmallerThanSaid) {
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

TEST(ValleyFloor, IsNowhereAboveTheGroundAndLevelBesideTheSea) {
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

TEST(ValleyFloor, OfLevelGroundIsThatGroundAndThePoleIsAPlaceLikeAnyOther) {
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

TEST(ValleyFloor, BesideAPoleReachesTheOtherSideOfIt) {
    RowBands rows(1);
    HeightGrid holed{72, 36, std::vector<float>(72 * 36, 0.7F)};
    holed.values[36] = 0;  // one cell of the row next to the pole, in reach of all others there
    const HeightGrid floor = valley_floor(holed, 0.3, rows);
    for (std::size_t x = 0; x < 72; ++x) ASSERT_EQ(floor.values[x], 0) << x;
}

}  // namespace
}  // namespace touchable
