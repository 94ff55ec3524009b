// The parts of the benchmark on real depth: cameras, pictures from elsewhere, planes, spectra.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "bench/real/depth_plane.hpp"
#include "bench/real/edges.hpp"
#include "bench/real/sensor_models.hpp"

namespace touchable {
namespace {

constexpr Camera small_camera{50, 60, 31.5, 23.5};

/// 1 / depth of the plane that meets the axis at 1/a, in a picture of 64x48.
double leaning(double x, double y, double a) {
    return a * (1 + 0.3 * small_camera.u(x) - 0.2 * small_camera.v(y));
}

DepthMap leaning_map(double a) {
    DepthMap map{64, 48, small_camera, {}};
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) map.depths.push_back(1 / leaning(x, y, a));
    return map;
}

TEST(SeenFrom, APlaneAheadIsThatPlaneNearer) {
    const auto seen = seen_from(leaning_map(1.0 / 1000), 200);
    ASSERT_TRUE(seen) << seen.error().message;
    // a Z + ... = 1 with Z = Z' + 200: all of 1 / depth grows by 1 / (1 - 200 a).
    for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 64; ++x)
            EXPECT_NEAR(seen->at(x, y), 0.8 / leaning(x, y, 1.0 / 1000), 1e-9) << x << ' ' << y;
}

TEST(SeenFrom, TheNearerSurfaceHidesTheOther) {
    DepthMap map = leaning_map(1.0 / 1000);
    for (int y = 0; y < 48; ++y)
        for (int x = 20; x < 40; ++x) map.depths[map.index(x, y)] = 300;
    const auto seen = seen_from(map, 100);
    ASSERT_TRUE(seen);
    EXPECT_NEAR(seen->at(30, 24), 200, 1e-9);
    // Columns 20 to 39 at 300 mm are seen at 200 mm from 31.5 - 11.5 * 1.5 on.
    EXPECT_NEAR(seen->at(15, 24), 200, 1e-9);
    EXPECT_GT(seen->at(12, 24), 600);
}

TEST(SeenFrom, SaysWhereNothingIsSeen) {
    EXPECT_FALSE(seen_from(leaning_map(1.0 / 1000), -200));
}

TEST(DepthPlaneOf, AnExactPlaneIsFoundWithItsNormal) {
    const DepthMap map = leaning_map(1.0 / 1000);
    const auto plane = plane_around(map, 30, 20, 5);
    ASSERT_TRUE(plane.has_value());
    EXPECT_NEAR(plane->residual_mm, 0, 1e-6);
    EXPECT_NEAR(plane->depth(33, 22), 1 / leaning(33, 22, 1.0 / 1000), 1e-6);
    // 1 = a (d + 0.3 X - 0.2 Y) with d = -Z, and out of the surface is towards the camera.
    const glm::dvec3 normal = glm::normalize(glm::dvec3(-0.3, 0.2, 1));
    EXPECT_LT(degrees_between(normal_of(*plane, small_camera), normal), 1e-6);
    EXPECT_LT(standard_error_deg(map, *plane, 5), 1e-6);
    EXPECT_FALSE(plane_around(map, 3, 20, 5).has_value()) << "it leaves the picture";
}

TEST(DepthPlaneOf, ItsStandardErrorIsWhatNoiseMakes) {
    SensorModel model = sr300();
    DepthMap truth{200, 200, {500, 500, 99.5, 99.5}, std::vector<double>(40000, 700.0)};
    const Scene scene = scene_of(model, 200, 200, truth.camera);
    double errors = 0, stated = 0, count = 0;
    for (int number = 0; number < 4; ++number) {
        const DepthMap stored = depths_of(stored_frame(model, scene, truth, number), scene);
        for (const DepthPlane& plane : flat_places(stored, 31, 15, {5, 0})) {
            const double error = degrees_between(normal_of(plane, truth.camera), {0, 0, 1});
            const double standard = standard_error_deg(stored, plane, 15);
            errors += error * error;
            stated += standard * standard;
            ++count;
        }
    }
    ASSERT_GE(count, 100);
    EXPECT_NEAR(std::sqrt(errors / stated), 1, 0.2);
}

TEST(SensorModels, HaveThePublishedLevelsAndNoise) {
    for (double z = 1; z <= 4; z += 0.2)
        EXPECT_NEAR(kinect_v1().level(1000 * z) / (2.73 * z * z + 0.74 * z - 0.58), 1, 0.03) << z;
    EXPECT_NEAR(kinect_v1().sigma(2000), 6.064, 1e-9);
    EXPECT_NEAR(d435(480).sigma(1000), 0.08 * 1e6 / (480 * 50), 1e-9);
    EXPECT_NEAR(d435(480).level(2000), 4e6 / (480 * 50 * 32), 1e-9);
    EXPECT_NEAR(sr300().sigma(500), 1.25, 1e-9);
    for (const SensorModel& model : {kinect_v1(), d435(480), sr300()})
        for (double z = 500; z <= 3000; z += 500)
            EXPECT_NEAR(model.stated_noise.constant + model.stated_noise.quadratic * z * z, model.sigma(z),
                        0.2 + 0.06 * model.sigma(z))
                << model.name << ' ' << z;
}

TEST(SensorModels, WhatIsStoredDeviatesAsMuchAsTheySay) {
    for (const SensorModel& model : {kinect_v1(), d435(480), sr300()}) {
        constexpr double depth = 1500;
        const DepthMap truth{160, 120, {480, 480, 79.5, 59.5}, std::vector<double>(19200, depth)};
        const Scene scene = scene_of(model, 160, 120, truth.camera);
        double sum = 0, squares = 0;
        const DepthMap stored = depths_of(stored_frame(model, scene, truth, 3), scene);
        for (const double d : stored.depths) {
            sum += d - depth;
            squares += (d - depth) * (d - depth);
        }
        EXPECT_NEAR(std::sqrt(squares / 19200) / model.sigma(depth), 1, 0.08) << model.name;
        EXPECT_LT(std::fabs(sum / 19200), 0.2 * model.sigma(depth)) << model.name;
    }
}

TEST(SensorModels, NoiseIsNewInEachFrameAndTheSameInEachRun) {
    const SensorModel model = kinect_v1();
    const DepthMap truth = leaning_map(1.0 / 1000);
    const Scene scene = scene_of(model, 64, 48, truth.camera);
    const auto depths = [&](int number) {
        return depths_of(stored_frame(model, scene, truth, number), scene).depths;
    };
    EXPECT_EQ(depths(1), depths(1));
    EXPECT_NE(depths(1), depths(2));
}

TEST(Edges, WithoutFiltersTheSceneIsAsItWasMade) {
    Figures figures;
    ASSERT_TRUE(measure_edges(kinect_v1(), filter_choices().front(), figures));
    const auto value = [&](const char* metric) {
        const auto found = std::find_if(figures.begin(), figures.end(),
                                        [&](const Figure& figure) { return figure.metric == metric; });
        return found == figures.end() ? std::nan("") : found->value;
    };
    EXPECT_NEAR(value("pen_pct"), 100, 1);
    EXPECT_NEAR(value("low_pen_pct"), 100, 1);
    EXPECT_NEAR(value("step_px"), 0.5, 0.1);
    EXPECT_EQ(value("bleed_px"), 0);
    EXPECT_NEAR(value("pen_pct_noisy"), 100, 5);
    EXPECT_NEAR(value("low_pen_pct_noisy"), 100, 5);
}

}  // namespace
}  // namespace touchable
