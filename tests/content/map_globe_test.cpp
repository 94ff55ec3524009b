// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "engine/base/same_bits.hpp"
#include "engine/content/families.hpp"
#include "engine/content/mapped_ground.hpp"
#include "tests/content/made_maps.hpp"
#include "tests/must.hpp"

namespace touchable::test {
namespace {

using wide = long double;
struct WideVector {
    wide x, y, z;
};
WideVector along(const glm::dvec3& from, const glm::dvec3& ray, wide s) {
    return {from.x + s * ray.x, from.y + s * ray.y, from.z + s * ray.z};
}
wide norm(const WideVector& v) {
    return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
}

/// The first place along a ray where `gap` is no longer above 0, by small steps and bisection; -1 where there
/// is none.
template <class Gap>
wide first_root(wide from, wide to, wide step, Gap&& gap) {
    for (wide s = from; s < to; s += step) {
        if (gap(s + step) > 0) continue;
        wide outside = s, inside = s + step;
        for (int round = 0; round < 80; ++round) {
            const wide middle = (outside + inside) / 2;
            (gap(middle) > 0 ? outside : inside) = middle;
        }
        return inside;
    }
    return -1;
}

TEST(DisplacedSphere, IsSphereAtConstantHeight) {
    const CubeGrid grid(128);
    RowBands rows(2);
    const DisplacedSphere sphere(grid, std::vector<float>(grid.points(), 0.03125F), rows);
    SplitMix64 random(1);
    int met = 0;
    for (int trial = 0; trial < 5000; ++trial) {
        const glm::dvec3 from{0, 0, 2.8};
        glm::dvec3 ray{random.within(-0.5, 0.5), random.within(-0.5, 0.5), -1};
        ray /= length(ray);
        const wide b = -2.8L * ray.z, c = 2.8L * 2.8L - 1.03125L * 1.03125L;
        const auto hit = sphere.first_hit(from, ray);
        ASSERT_EQ(hit.has_value(), b * b > c);
        if (!hit) continue;
        ++met;
        ASSERT_NEAR(*hit, static_cast<double>(b - std::sqrt(b * b - c)),
                    1e-12 / static_cast<double>(std::sqrt(b * b - c)));
    }
    EXPECT_GT(met, 1000);
}

TEST(DisplacedSphere, MatchesMarchedRays) {
    const CubeGrid grid(128);
    std::vector<float> rise(grid.points());
    for (int face = 0; face < 6; ++face)
        for (int j = 0; j <= 128; ++j)
            for (int i = 0; i <= 128; ++i) {
                const glm::dvec3 d = grid.direction(face, i, j);
                const double wave = sine(9 * d.x + 2 * d.y) * sine(11 * d.y) + sine(23 * d.z - 17 * d.x);
                rise[grid.index(face, i, j)] = static_cast<float>(0.03 * std::max(0.0, wave));
            }
    RowBands rows(1);
    const DisplacedSphere sphere(grid, rise, rows);
    SplitMix64 random(7);
    int met = 0, missed = 0;
    for (int trial = 0; trial < 4000; ++trial) {
        const double turn = random.within(0, 6.283), lean = random.within(-1, 1);
        const glm::dvec3 from = 2.8 * glm::dvec3(cosine(turn), lean, sine(turn)) / std::sqrt(1 + lean * lean);
        // Half of all rays pass close to the limb.
        const glm::dvec3 toward{random.within(-1, 1), random.within(-1, 1), random.within(-1, 1)};
        const double reach = trial % 2 ? random.within(0.97, 1.06) : random.within(0, 1);
        const glm::dvec3 target = reach * toward / length(toward);
        const glm::dvec3 ray = (target - from) / length(target - from);
        const auto gap = [&](wide s) {
            const WideVector p = along(from, ray, s);
            const glm::dvec3 way{static_cast<double>(p.x), static_cast<double>(p.y),
                                 static_cast<double>(p.z)};
            return norm(p) - 1 - static_cast<wide>(sphere.rise(way));
        };
        const wide expected = first_root(1.7L, 4.2L, 0.0005L, gap);
        const auto hit = sphere.first_hit(from, ray);
        if (!hit || expected < 0) {
            // A ray that only just touches may be seen by one of both.
            if (hit.has_value() != (expected >= 0)) {
                wide least = 1;
                for (wide s = 1.7L; s < 4.2L; s += 0.0001L) least = std::min(least, gap(s));
                ASSERT_LT(std::fabs(least), 1e-5L);
            }
            ++missed;
            continue;
        }
        ++met;
        // Never later, to double precision; sooner only where the small steps passed over something.
        ASSERT_LE(*hit, static_cast<double>(expected) + 1e-12);
        ASSERT_LT(std::fabs(gap(*hit)), 1e-13L) << trial;
        ASSERT_GT(*hit, static_cast<double>(expected) - 0.5);
        if (*hit < static_cast<double>(expected) - 1e-11) {
            ASSERT_GT(gap(*hit - 1e-6L), 0) << trial;
            ASSERT_LT(first_root(*hit - 0.001L, 4.2L, 0.000002L, gap) - *hit, 1e-9L) << trial;
        }
    }
    EXPECT_GT(met, 2000);
    EXPECT_GT(missed, 100);
}

TEST(CubePyramid, AveragesWithoutSeams) {
    RowBands rows(2);
    // Stripes of a cell's width, of which nothing is left from afar but their mean.
    const CubePyramid<2> pyramid(64, rows, [](const glm::dvec3& d) {
        return std::array{d.x > 0 ? 1.0 : 0.0, 0.5 + 0.5 * sine(64 * d.y)};
    });
    SplitMix64 random(11);
    for (int trial = 0; trial < 2000; ++trial) {
        glm::dvec3 d{random.within(-1, 1), random.within(-1, 1), random.within(-1, 1)};
        d /= length(d);
        if (std::fabs(d.x) > 0.6) {
            ASSERT_EQ(pyramid.mean(d, 0.03)[0], d.x > 0 ? 1 : 0);
        }
        ASSERT_NEAR(pyramid.mean(d, 0.4)[1], 0.5, 0.13);
        // Over the edges and corners of the cube.
        glm::dvec3 edge = d;
        edge.y = edge.x + random.within(-1, 1) * 1e-9;
        if (trial % 2) edge.z = -edge.x;
        edge /= length(edge);
        for (const double width : {0.01, 0.07, 0.3})
            ASSERT_NEAR(pyramid.mean(edge, width)[1],
                        pyramid.mean(edge + glm::dvec3(1e-9, -1e-9, 1e-9), width)[1], 1e-6);
    }
}

SceneOptions with_maps(const GlobeMaps& maps, int width, int height, int bits = 16) {
    SceneOptions options = sized(width, height, bits);
    options.properties = true;
    options.maps = &maps;
    options.first_longitude_degrees = 0;
    options.axial_tilt_degrees = 20;
    return options;
}

TEST(MapGlobe, IsSphereAtConstantElevation) {
    MadeWorld world(180);
    const MadeMap level = even_map(40000, 64, 2);
    const MadeMap land = even_map(255);
    world.maps.elevation = level.map();
    world.maps.mask = land.map();
    world.maps.shore = {20000, 60000, true, 127, 1};  // half of the relief
    world.maps.relief = 0.04;
    for (const double smoothing : {0.0, 1.0}) {
        world.maps.smoothing_degrees = smoothing;
        const auto globe = made("globe", with_maps(world.maps, 320, 240));
        const GlobeSphere sphere = globe_sphere(CameraPreset::b, 320, 240);
        const Camera& camera = globe->scene().camera;
        const wide distance = -sphere.centre.z;
        // As the shape keeps it, in 24 bits.
        const wide radius = sphere.radius * (1 + static_cast<wide>(static_cast<float>(0.04 * 0.5F)));
        for (int y = 0; y < 240; y += 3)
            for (int x = 0; x < 320; x += 3) {
                const wide b = distance / camera.ray_length(x, y);
                const wide under_root = b * b - (distance * distance - radius * radius);
                const double depth = globe->depth(x, y, 1.3);
                if (std::fabs(under_root) < 1e-6L) continue;
                const double truth = static_cast<double>(under_root > 0 ? b - std::sqrt(under_root) : 180);
                ASSERT_NEAR(depth, truth, 1e-6 + 1e-6 / static_cast<double>(std::sqrt(std::fabs(under_root))))
                    << x << " " << y;
            }
    }
}

/// Elevation cos^2 of the latitude, all of it in the shape: what bisection in long double finds of the closed
/// form.
TEST(MapGlobe, MatchesClosedForm) {
    MadeWorld world(180);
    const MadeMap hill = made_map(1000, 1, 2, [](double, double latitude, int) {
        return 65535 * std::cos(latitude) * std::cos(latitude);
    });
    const MadeMap land = even_map(255);
    world.maps.elevation = hill.map();
    world.maps.mask = land.map();
    world.maps.shore = {0, 65535, true, 127, 1};
    world.maps.smoothing_degrees = 0;
    const auto globe = made("globe", with_maps(world.maps, 240, 160));
    const GlobeSphere sphere = globe_sphere(CameraPreset::b, 240, 160);
    // The pole leans by 20 degrees, 0.36 to the right for every 0.25 toward the camera.
    const wide lean = 20 * 3.14159265358979323846L / 180, way = std::sqrt(0.36L * 0.36L + 0.25L * 0.25L);
    const WideVector pole{std::sin(lean) * 0.36L / way, std::cos(lean), std::sin(lean) * 0.25L / way};
    int met = 0;
    const double code = (180.0 - 40) / 65535;
    const RawFrame frame = globe->frame(9);
    for (int y = 3; y < 160; y += 4)
        for (int x = 3; x < 240; x += 4) {
            const glm::dvec3 ray = glm::dvec3(globe->scene().camera.u(x), globe->scene().camera.v(y), -1) /
                                   globe->scene().camera.ray_length(x, y);
            const auto gap = [&](wide s) {
                WideVector p = along({0, 0, 0}, ray, s);
                p.z += -static_cast<wide>(sphere.centre.z);
                const wide r = norm(p), sine_of_latitude = (p.x * pole.x + p.y * pole.y + p.z * pole.z) / r;
                return r - sphere.radius * (1 + 0.03L * (1 - sine_of_latitude * sine_of_latitude));
            };
            const wide truth = first_root(60, 112, 0.05L, gap);
            const double depth = globe->depth(x, y, globe->time_of(9));
            ASSERT_LE(std::fabs(globe->scene().depth.depth(frame.depth.sample(x, y)) - depth),
                      code * 0.500001);
            if (truth < 0) {
                EXPECT_EQ(depth, 180) << x << " " << y;
                continue;
            }
            const wide slant = gap(truth - 0.01L) / 0.01L;  // how steeply it is met: 0 at the limb
            ++met;
            ASSERT_NEAR(depth, static_cast<double>(truth), 4e-5 / static_cast<double>(slant))
                << x << " " << y;
        }
    EXPECT_GT(met, 500);
}

TEST(MapGlobe, SplitsReliefBySmoothness) {
    MadeWorld world(500);
    SceneOptions options = with_maps(world.maps, 300, 200);
    options.axial_tilt_degrees = 0;  // so that the globe's own frame is the world's
    const auto globe = made("globe", options);
    const RawFrame frame = globe->frame(0);
    const Scene& scene = globe->scene();
    const GlobeSphere sphere = globe_sphere(CameraPreset::b, 300, 200);
    ASSERT_EQ(scene.height_coding.units, HeightUnits::world);
    ASSERT_LT(scene.height_coding.max_height, 0.03 * sphere.radius);
    int high = 0, shaped = 0, ocean = 0, compared = 0;
    for (int y = 0; y < 200; ++y)
        for (int x = 0; x < 300; ++x) {
            if (frame.depth.sample(x, y) == 0) {
                EXPECT_EQ(frame.height.sample(x, y), 0);
                continue;
            }
            const glm::dvec3 outward = (seen(*globe, x, y, 0) - sphere.centre) / sphere.radius;
            const double rise = length(outward) - 1;
            const double height =
                frame.height.sample(x, y) / 255.0 * scene.height_coding.max_height / sphere.radius;
            const double longitude = std::atan2(outward.x, outward.z),
                         latitude = std::asin(outward.y / length(outward));
            ASSERT_GT(rise, -1e-12);
            shaped += rise > 0.01;
            high += height > 0.005;
            if (frame.haptic.sample(x, y) == 40) {  // 0.4 N/mm: not even a part of the pixel is land
                ++ocean;
                ASSERT_LT(rise, 1e-12) << x << " " << y;
                ASSERT_EQ(frame.height.sample(x, y), 0) << x << " " << y;
            }
            if (std::fabs(longitude) > 0.6 || std::fabs(latitude) > 0.5) continue;  // the coast is cut off
            ++compared;
            const double relief = 0.03 * (MadeWorld::height(longitude, latitude) - 20000) / 45535;
            ASSERT_NEAR(rise + height, relief, 7e-4) << x << " " << y;
        }
    EXPECT_GT(ocean, 2000);
    EXPECT_GT(shaped, 500);
    EXPECT_GT(high, 100);
    EXPECT_GT(compared, 2000);
    world.maps.smoothing_degrees = 0;
    EXPECT_TRUE(made("globe", options)->frame(0).height.empty());
}

std::array<int, 3> haptic_codes(const RawFrame& frame, int x, int y) {
    return {frame.haptic.sample(x, y, 0), frame.haptic.sample(x, y, 1), frame.haptic.sample(x, y, 2)};
}

TEST(MapGlobe, FeelsAsMapSays) {
    MadeWorld world(90);
    const RawFrame by_mask = made("globe", with_maps(world.maps, 150, 100))->frame(0);
    EXPECT_EQ(haptic_codes(by_mask, 75, 40), (std::array{148, 153, 115}));  // 1.2 N/mm, 0.6, 0.45
    EXPECT_EQ(haptic_codes(by_mask, 75, 88), (std::array{40, 38, 26}));     // 0.4 N/mm, 0.15, 0.1
    EXPECT_EQ(haptic_codes(by_mask, 2, 2), (std::array{94, 77, 51}));
    const MadeMap touch = made_map(
        128, 3, 1, [](double, double latitude, int c) { return latitude > 0 ? 10.0 + 100 * c : 33.0; });
    world.maps.haptic = touch.map();
    const RawFrame by_map = made("globe", with_maps(world.maps, 150, 100))->frame(0);
    EXPECT_EQ(haptic_codes(by_map, 75, 30), (std::array{10, 110, 210}));
    EXPECT_EQ(haptic_codes(by_map, 75, 88), (std::array{33, 33, 33}));
    EXPECT_EQ(haptic_codes(by_map, 2, 2), (std::array{94, 77, 51}));
}

TEST(MapGlobe, ScalesTenBitMaps) {
    MadeWorld world(90);
    const auto all = [](int bytes, double code) {
        return made_map(64, 3, bytes, [=](double, double, int c) { return c == 1 ? code : 0; });
    };
    const MadeMap eight = all(1, 255), ten = all(2, 1023);
    const auto frame_of = [&](const GlobeMap& map) {
        world.maps.colour = map;
        world.maps.haptic = map;
        return made("globe", with_maps(world.maps, 90, 60))->frame(0);
    };
    GlobeMap of_ten = ten.map();
    of_ten.largest = 1023;
    const RawFrame wanted = frame_of(eight.map()), found = frame_of(of_ten);
    ASSERT_EQ(haptic_codes(wanted, 45, 30), (std::array{0, 255, 0}));
    for (int y = 0; y < 60; ++y)
        for (int x = 0; x < 90; ++x) {
            ASSERT_EQ(haptic_codes(found, x, y), haptic_codes(wanted, x, y)) << x << " " << y;
            for (int c = 0; c < 3; ++c)
                ASSERT_EQ(found.colour.sample(x, y, c), wanted.colour.sample(x, y, c)) << x << " " << y;
        }
}

// Water in the mask: a lake, another one across the date line, and a bay of the ocean.
TEST(MapGlobe, KeepsElevationOfLakes) {
    MadeWorld world;
    const auto is_lake = [](double longitude, double latitude) {
        return std::hypot(longitude - 0.2, latitude + 0.2) < 0.15;
    };
    const auto is_far_lake = [](double longitude, double latitude) {
        return std::hypot(3.14159 - std::fabs(longitude), latitude) < 0.15;
    };
    const auto is_far_island = [](double longitude, double latitude) {
        return std::hypot(3.14159 - std::fabs(longitude), latitude) < 0.18;  // not as far south as the lake
    };
    const auto is_bay = [](double longitude, double latitude) {
        return longitude > -1 && longitude < -0.3 && std::fabs(latitude) < 0.1;
    };
    const MadeMap mask = made_map(360, 1, 1, [&](double x, double y, int) {
        const bool is_dry = MadeWorld::is_land(x, y) || is_far_island(x, y);
        return is_dry && !is_lake(x, y) && !is_far_lake(x, y) && !is_bay(x, y) ? 255 : 0;
    });
    const MadeMap elevation = made_map(360, 1, 2, [&](double x, double y, int) {
        return is_far_island(x, y) ? 40000 : MadeWorld::height(x, y);
    });
    world.maps.mask = mask.map();
    world.maps.elevation = elevation.map();
    RowBands rows(2);
    const auto ground = must(map_ground(world.maps, 0.02, rows));
    const auto expect_at = [&](double longitude, double latitude, double stored) {
        const glm::dvec3 place{std::cos(latitude) * std::sin(longitude), std::sin(latitude),
                               std::cos(latitude) * std::cos(longitude)};
        const double expected = std::max(0.0, (stored - 20000) / 45535);
        EXPECT_NEAR(ground->look.mean(place, 0.02)[MappedGround::elevation], expected, 0.02) << longitude;
        EXPECT_NEAR(ground->look.mean(place, 0.02)[MappedGround::land], 0, 1e-6) << longitude;
        EXPECT_NEAR(ground->shape.rise(place), 0.03 * expected, 0.005) << longitude;
    };
    expect_at(0.2, -0.2, MadeWorld::height(0.2, -0.2));
    for (const double longitude : {3.1, -3.1}) expect_at(longitude, 0, 40000);
    expect_at(-0.5, 0, 0);
    expect_at(-2, 0, 0);
}

TEST(MapGlobe, IgnoresInfiniteElevations) {
    MadeWorld world(64);
    const MadeMap land = even_map(255);
    world.maps.mask = land.map();
    world.maps.shore = {0, 1000, true, 127, 1};
    world.maps.relief = 0.04;
    world.maps.smoothing_degrees = 0;
    RowBands rows(1);
    for (const float odd : {INFINITY, -INFINITY, NAN}) {
        std::vector<float> metres(64 * 32, 500);
        metres[15 * 64 + 40] = odd;
        world.maps.elevation = {{}, metres, 64, 32, 1};
        const auto ground = must(map_ground(world.maps, 0.05, rows));
        EXPECT_NEAR(ground->shape.highest(), 0.02, 1e-8) << odd;
    }
}

TEST(MapGlobe, TurnsAsRequested) {
    MadeWorld world(180);
    SceneOptions options = with_maps(world.maps, 150, 100);
    options.axial_tilt_degrees = 0;
    options.first_longitude_degrees = 90;  // the continent is at the left limb
    options.seconds_per_turn = 40;
    const auto globe = made("globe", options);
    const auto land_at = [&](double seconds) {
        const RawFrame frame = globe->frame(static_cast<std::int64_t>(30 * seconds));
        double sum = 0, count = 0;
        for (int x = 0; x < 150; ++x)
            if (frame.depth.sample(x, 49) > 0 && frame.haptic.sample(x, 49) > 100) {
                sum += x;
                ++count;
            }
        return count > 0 ? sum / count : -1;
    };
    EXPECT_LT(land_at(0), 50);
    EXPECT_NEAR(land_at(10), 75, 1);  // in front a quarter of a turn later: moved to the right
    EXPECT_GT(land_at(20), 100);
    EXPECT_EQ(land_at(30), -1);
    EXPECT_EQ(globe->depth(60, 40, 3), globe->depth(60, 40, 43));
}

/// Bytes of all planes; the maps are made by what is the same bits on every machine, too.
TEST(MapGlobe, GivesSameBitsEverywhere) {
    const MadeMap colour = made_map(120, 3, 1, [](double longitude, double latitude, int c) {
        return 128 + 100 * sine(5 * longitude + c) * cosine(3 * latitude);
    });
    const MadeMap elevation = made_map(90, 1, 2, [](double longitude, double latitude, int) {
        return 30000 + 20000 * sine(3 * longitude) * cosine(latitude) + 5000 * sine(20 * latitude);
    });
    const MadeMap mask = made_map(64, 1, 1, [](double longitude, double latitude, int) {
        return 30000 + 20000 * sine(3 * longitude) * cosine(latitude) > 30000 ? 0.0 : 255.0;
    });
    GlobeMaps maps;
    maps.colour = colour.map();
    maps.elevation = elevation.map();
    maps.mask = mask.map();
    maps.smoothing_degrees = 3;
    const auto shore = must(find_shore(maps.elevation, maps.mask, {}));
    maps.shore = shore;
    for (const int threads : {1, 2, 5}) {
        SceneOptions options = with_maps(maps, 96, 64);
        options.threads = threads;
        const RawFrame frame = made("globe", options)->frame(7);
        ByteHash sum;
        for (const PlaneView* plane : {&frame.depth, &frame.colour, &frame.haptic, &frame.height})
            sum.add(plane->data,
                    static_cast<std::size_t>(plane->stride) * static_cast<std::size_t>(plane->height));
        EXPECT_EQ(sum.value(), 0xa174b7ca1ff1ec9cU) << threads << std::hex << " 0x" << sum.value();
    }
}

TEST(MapGlobe, RejectsImpossibleOptions) {
    MadeWorld world(64);
    const auto refusal = [](const SceneOptions& options, const char* name = "globe") {
        const auto scene = make_scene(name, options);
        return scene ? "" : scene.error().message;
    };
    SceneOptions options = with_maps(world.maps, 90, 60);
    EXPECT_EQ(refusal(options), "");
    options.properties = false;
    EXPECT_NE(refusal(options).find("maps"), std::string::npos);
    options = with_maps(world.maps, 90, 60);
    options.seconds_per_turn = 0;
    EXPECT_NE(refusal(options).find("turn"), std::string::npos);
    options = with_maps(world.maps, 90, 60);
    options.axial_tilt_degrees = 91;
    EXPECT_NE(refusal(options).find("tilt"), std::string::npos);
    world.maps.colour = {};
    EXPECT_NE(refusal(with_maps(world.maps, 90, 60)).find("colour map is missing"), std::string::npos);
}

}  // namespace
}  // namespace touchable::test
