// SPDX-License-Identifier: Apache-2.0
// What benchmarks are made of: sensors and clips that they measure with; loops and spectra.

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <string>

#include "bench/gpu/frame_ring.hpp"
#include "bench/gpu/gpu_cases.hpp"
#include "bench/loop/stability.hpp"
#include "bench/paper/chest_scene.hpp"
#include "bench/paper/paper_clip.hpp"
#include "bench/paper/scripted_path.hpp"
#include "bench/paper/sweep_run.hpp"
#include "bench/real/depth_plane.hpp"
#include "bench/real/edges.hpp"
#include "bench/real/sensor_models.hpp"
#include "bench/suite.hpp"
#include "bench/tick_times.hpp"
#include "bench/touch/force_spectrum.hpp"
#include "engine/base/hand_thresholds.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/plane_memory.hpp"
#include "haptics_cpu/height_field.hpp"
#include "tests/must.hpp"
#include "tests/temporary_files.hpp"

namespace touchable {
namespace {

using test::must;

// The parts of the benchmark on real depth: cameras, pictures from elsewhere, planes, spectra.

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

TEST(SeenFrom, PlaneAheadComesNearer) {
    const auto seen = must(seen_from(leaning_map(1.0 / 1000), 200));
    // a Z + ... = 1 with Z = Z' + 200: all of 1 / depth grows by 1 / (1 - 200 a).
    for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 64; ++x)
            EXPECT_NEAR(seen.at(x, y), 0.8 / leaning(x, y, 1.0 / 1000), 1e-9) << x << ' ' << y;
}

TEST(SeenFrom, NearerSurfaceHidesOther) {
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

TEST(SeenFrom, ReportsEmptyView) {
    EXPECT_FALSE(seen_from(leaning_map(1.0 / 1000), -200));
}

TEST(DepthPlane, FindsExactPlane) {
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

TEST(DepthPlane, StandardErrorMatchesNoise) {
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

TEST(SensorModels, MatchPublishedNoise) {
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

TEST(SensorModels, StoredDepthDeviatesAsStated) {
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

TEST(SensorModels, NoiseVariesByFrameReproducibly) {
    const SensorModel model = kinect_v1();
    const DepthMap truth = leaning_map(1.0 / 1000);
    const Scene scene = scene_of(model, 64, 48, truth.camera);
    const auto depths = [&](int number) {
        return depths_of(stored_frame(model, scene, truth, number), scene).depths;
    };
    EXPECT_EQ(depths(1), depths(1));
    EXPECT_NE(depths(1), depths(2));
}

TEST(Edges, UnfilteredSceneIsUnchanged) {
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

/// Stored depth less the true one, in levels, of the chest's middle.
std::vector<double> noise_of(double levels, std::int64_t frame) {
    const Scene scene = chest_scene();
    const RawFrame raw = noisy_chest_frame(scene, levels, frame);
    std::vector<double> noise;
    for (int y = 80; y < 160; ++y)
        for (int x = 120; x < 200; ++x) {
            const std::uint8_t code = raw.depth.data[raw.depth.stride * y + x];
            const double truth = chest_range(scene.camera, x, y);
            noise.push_back((scene.depth.depth(code) - truth) / scene.depth.level());
        }
    return noise;
}

double mean_product(const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (std::size_t n = 0; n < a.size(); ++n) sum += a[n] * b[n];
    return sum / static_cast<double>(a.size());
}

TEST(PaperChest, HasRequestedNoise) {
    for (const double levels : {1.0, 2.0}) {
        const std::vector<double> noise = noise_of(levels, 3);
        EXPECT_NEAR(mean_product(noise, noise), levels * levels + 1.0 / 12, 0.1 * levels * levels);
    }
    for (const double off : noise_of(0, 3)) EXPECT_LE(std::fabs(off), 0.5 + 1e-9);
}

TEST(PaperChest, NoiseIsIndependent) {
    const std::vector<double> noise = noise_of(1, 0);
    EXPECT_NEAR(mean_product(noise, noise_of(1, 1)), 0, 0.06);
    std::vector<double> neighbours(noise.begin() + 1, noise.end());
    neighbours.push_back(noise[0]);
    EXPECT_NEAR(mean_product(noise, neighbours), 0, 0.06);
}

TEST(PaperChest, SurfaceIsEllipsoid) {
    const auto clip = make_chest_clip(1, 1);
    const double metres_per_unit = clip->scene.device_metres_per_unit.value();
    const glm::dvec3 front = clip->surface_at({0, 0});
    EXPECT_NEAR(glm::distance(front, {0, 0, -100}), 0, 1e-9);
    for (const glm::dvec2 place : {glm::dvec2{0.02, 0}, {0, -0.02}, {-0.01, 0.015}}) {
        const glm::dvec3 point = clip->surface_at(place);
        const glm::dvec3 shape{point.x / 20, point.y / 35, (point.z + 112) / 12};
        EXPECT_NEAR(glm::length(shape), 1, 1e-12);
        EXPECT_NEAR(point.x / -point.z * 100 * metres_per_unit, place.x, 1e-12);
        EXPECT_NEAR(point.y / -point.z * 100 * metres_per_unit, place.y, 1e-12);
    }
}

TEST(PlayedClip, LazyEqualsWholeAcrossLoop) {
    constexpr std::int64_t ms = 1'000'000;
    const auto clip = make_chest_clip(1, 7);
    auto whole = PlayedClip::make(clip, {3});
    auto lazy = PlayedClip::make(clip, {3, false, false, true});
    ASSERT_TRUE(whole && lazy);
    for (const bool again : {false, true}) {
        (*lazy)->restart();
        // As batches of 64 ticks have it, over two loops of 233 ms.
        for (std::int64_t batch = 0; batch < 512; batch += 64) {
            (*lazy)->play_to((batch + 63) * ms);
            for (const std::int64_t k : {batch, batch + 20, batch + 63}) {
                const HeightField a((*whole)->scene(), (*whole)->pair_at(k * ms));
                const HeightField b((*lazy)->scene(), (*lazy)->pair_at(k * ms));
                for (int x = 100; x < 200; x += 9)
                    ASSERT_EQ(a.vertex(x, 120).depth, b.vertex(x, 120).depth) << k << ' ' << x << again;
            }
        }
    }
    const HeightField first((*whole)->scene(), (*whole)->pair_at(0));
    const HeightField fourth((*whole)->scene(), (*whole)->pair_at(100 * ms));
    const HeightField eighth((*whole)->scene(), (*whole)->pair_at(clip->scene.rate.time_ns(7)));
    int differ = 0;
    for (int x = 100; x < 200; ++x) {
        EXPECT_EQ(first.vertex(x, 120).depth, eighth.vertex(x, 120).depth);
        differ += first.vertex(x, 120).depth != fourth.vertex(x, 120).depth;
    }
    EXPECT_GT(differ, 20);
}

double value_of(const Figures& figures, const std::string& metric) {
    const auto found = std::ranges::find(figures, metric, &Figure::metric);
    EXPECT_NE(found, figures.end()) << metric;
    return found == figures.end() ? 0 : found->value;
}

TEST(ScriptedPaths, FastHandsStayOnGlobe) {
    for (const ScriptedPath& path : fast_hands) {
        double fastest = 0, farthest = 0;
        for (int k = 0; k < 10'000; ++k) {
            fastest = std::max(fastest, glm::distance(path.at(0.001 * k), path.at(0.001 * (k + 1))) * 1000);
            farthest = std::max(farthest, glm::length(path.at(0.001 * k)));
        }
        EXPECT_NEAR(fastest, 0.3, 0.03) << path.name;
        EXPECT_LT(farthest, 0.0135) << path.name;
    }
}

TEST(PaperSuite, MeasuresSizesAndFingers) {
    std::set<std::string> names;
    for (const BenchCase& c : paper_cases(true)) EXPECT_TRUE(names.insert(c.name).second) << c.name;
    for (const char* size : {"720x480", "1280x720", "1920x1080", "3840x2160"})
        for (const char* fingers : {"1", "2", "5", "10"})
            for (const char* way : {"world-t", "pixel-m3-lazy"})
                EXPECT_TRUE(
                    names.contains(std::string("globe-") + size + "-8-" + fingers + "f-" + way + "-circle"));
}

TEST(SweepRun, FingersFollowEachOther) {
    const auto clip = must(make_globe_clip(320, 240, 2));
    EXPECT_EQ(clip->frames.size(), 4U);
    EXPECT_EQ(clip->scene.width, 320);
    SweepRun run{{}, {0, true}, fast_hands[1], 1};
    Figures one, three;
    ASSERT_TRUE(count_primitives(clip, run, one));
    run.setup.fingers = 3;
    ASSERT_TRUE(count_primitives(clip, run, three));
    // All go round the same circle, so that each passes as much as one alone and all together pass more.
    EXPECT_NEAR(value_of(three, "primitives_mean") / value_of(one, "primitives_mean"), 1, 0.05);
    EXPECT_GT(value_of(three, "primitives_second_max"), 1.3 * value_of(one, "primitives_second_max"));
    EXPECT_EQ(value_of(three, "contact_pct"), 100);
}

TEST(PaperTables, TellDecibelsAndAverages) {
    std::vector<CaseFigures> measured{
        {"chest-320x240-8-1f-pixel-scratch-n1", {{"force_band_mn", 200, "mN"}, {"held_back_mm", 7, "mm"}}},
        {"chest-320x240-8-1f-pixel-m3-scratch-n1", {{"force_band_mn", 20, "mN"}, {"held_back_mm", 3, "mm"}}}};
    double time = 1;
    for (const char* const hand : {"line", "circle", "eight"}) {
        CaseFigures c{std::string("globe-720x480-8-1f-world-t-") + hand, {}};
        for (const char* const metric :
             {"tick_us_second_max", "tick_us_second_max_undisturbed", "tick_us_p50", "tick_us_p99",
              "primitives_second_max", "primitives_mean"})
            c.figures.push_back({metric, time, ""});
        measured.push_back(c);
        time *= 4;
    }
    testing::internal::CaptureStdout();
    EXPECT_TRUE(conclude_paper(measured));
    const std::string text = testing::internal::GetCapturedStdout();
    EXPECT_NE(text.find("20.0  -20.0 dB    3.0 mm"), std::string::npos) << text;
    const std::size_t average = text.find("ours, average");
    ASSERT_NE(average, std::string::npos) << text;
    EXPECT_NE(text.find(" 7 ", average), std::string::npos) << text;  // of 1, 4 and 16
    EXPECT_EQ(text.find("one frame"), std::string::npos) << "nothing of it was measured";
}

constexpr double period = ClosedLoop::period_s;

class Stability : public testing::Test {
protected:
    Stability() {
        loop.touch.scene = "plane";
        loop.touch.width = 96;
        loop.touch.height = 64;
        loop.touch.bits = TouchCase::exact;
    }
    double boundary() {
        auto made = TouchSurface::make(loop.touch);
        EXPECT_TRUE(made);
        const TouchSurface& surface = **made;
        const auto found = stability_boundary(surface, loop, pressed_place(surface, 51, 30));
        EXPECT_TRUE(found) << (found ? "" : found.error().message);
        return found ? *found : 0;
    }
    LoopCase loop;
};

/// For a mass with viscous loss before a sampled and held spring: the stiffness at which the determinant of
/// its step becomes 1 (Jury's criterion; the others do not bind here).
double jury_boundary(double mass, double damping) {
    const double tau = mass / damping, a = std::exp(-period / tau);
    const double place_gain = tau / mass * (period - tau * (1 - a)), speed_gain = tau / mass * (1 - a);
    return (1 - a) / (speed_gain * tau * (1 - a) - place_gain * a);
}

TEST_F(Stability, FlatWallMatchesTheory) {
    for (const double damping : {1.0, 5.0, 20.0})
        for (const double mass : {0.2, 0.5}) {
            loop.handle.damping = damping;
            loop.handle.mass = mass;
            const double found = boundary(), exact = jury_boundary(mass, damping);
            EXPECT_NEAR(found / exact, 1, 0.03) << damping << " N s/m, " << mass << " kg";
            EXPECT_NEAR(exact / colgate_schenkel_bound(loop.handle), 1, 0.05);
        }
}

TEST_F(Stability, ShrinksWithDelay) {
    loop.handle.damping = 5;
    for (const int delay : {0, 1, 2, 4}) {
        loop.delay_ticks = delay;
        EXPECT_NEAR(boundary() / gil_bound(loop.handle, delay), 1, 0.05) << delay << " ticks";
    }
}

TEST_F(Stability, QuantisedReadingsNeedFriction) {
    loop.handle.damping = 5;
    loop.handle.quantum = 60e-6;
    const double without = boundary();
    EXPECT_LT(without, 0.5 * colgate_schenkel_bound(loop.handle)) << "it shakes by a quantum for ever";
    for (const double friction : {0.1, 0.3}) {
        loop.handle.friction = friction;
        EXPECT_GE(boundary(), abbott_okamura_bound(loop.handle)) << friction << " N";
    }
}

TEST_F(Stability, IsFoundOnMovingSurface) {
    loop.touch.scene = "moving";
    loop.touch.width = 80;
    loop.touch.height = 60;
    loop.handle.damping = 5;
    EXPECT_NEAR(boundary() / colgate_schenkel_bound(loop.handle), 1, 0.2);
}

TEST_F(Stability, FatesAreToldApart) {
    auto made = must(TouchSurface::make(loop.touch));
    const PressedPlace place = pressed_place(*made, 51, 30);
    const double wall = colgate_schenkel_bound(loop.handle);
    EXPECT_EQ(fate_of(*made, loop, place, 0.8 * wall).value(), LoopFate::rests);
    EXPECT_EQ(fate_of(*made, loop, place, 1.2 * wall).value(), LoopFate::shakes);
    loop.handle.quantum = 0.01;  // read as 0 or 10 mm: it rests between, above the surface
    loop.handle.friction = 5;
    EXPECT_EQ(fate_of(*made, loop, place, 10'000).value(), LoopFate::leaves);
}

TEST(StabilityTheory, Bounds) {
    HandleDynamics handle;
    handle.damping = 5;
    EXPECT_DOUBLE_EQ(colgate_schenkel_bound(handle), 10'000);
    EXPECT_DOUBLE_EQ(gil_bound(handle, 0), 10'000);
    EXPECT_DOUBLE_EQ(gil_bound(handle, 1), 5 / 0.0015);
    EXPECT_DOUBLE_EQ(abbott_okamura_bound(handle), 10'000);
    handle.quantum = 60e-6;
    handle.friction = 0.3;
    EXPECT_DOUBLE_EQ(abbott_okamura_bound(handle), 10'000);
    handle.friction = 0.15;
    EXPECT_DOUBLE_EQ(abbott_okamura_bound(handle), 5'000);
}

constexpr double rate = 1000;  // Hz
constexpr std::size_t segment = 10'000;

std::vector<double> sine_wave(double amplitude, double hz, double offset, std::size_t count) {
    std::vector<double> series;
    for (std::size_t n = 0; n < count; ++n)
        series.push_back(
            offset + amplitude * std::sin(2 * std::numbers::pi * hz * static_cast<double>(n) / rate + 0.4));
    return series;
}

/// Uniform in -1 to 1: variance 1/3.
std::vector<double> white_noise(std::size_t count) {
    SplitMix64 random(7);
    std::vector<double> series;
    for (std::size_t n = 0; n < count; ++n) series.push_back(random.within(-1, 1));
    return series;
}

TEST(ForceSpectrum, SinePowerLiesInBand) {
    const std::vector<double> series = sine_wave(3, 50, 12, segment);
    EXPECT_NEAR(band_power(series, rate, 49, 51), 4.5, 1e-9);
    EXPECT_NEAR(band_power(series, rate, 20, 500), 4.5, 1e-9);
    EXPECT_NEAR(band_power(series, rate, 0, 49), 0, 1e-12);
    EXPECT_NEAR(band_power(series, rate, 51, 500), 0, 1e-12);
}

TEST(ForceSpectrum, FindsSineBetweenBins) {
    const std::vector<double> series = sine_wave(3, 50.037, 0, segment);
    EXPECT_NEAR(band_power(series, rate, 49, 51), 4.5, 1e-3);
    EXPECT_LT(band_power(series, rate, 60, 500), 1e-6);
}

TEST(ForceSpectrum, IsFlatOfWhiteNoise) {
    const Spectrum spectrum = welch_spectrum(white_noise(10 * segment), rate, 10);
    ASSERT_EQ(spectrum.power.size(), segment / 2 + 1);
    EXPECT_DOUBLE_EQ(spectrum.hz_step, 0.1);
    const double density = 1.0 / 3 / (rate / 2);
    // The mean of n independent waves strays by 1/sqrt(n); a window of Hann's leaves two in three, ten times.
    for (double from = 15.625; from < 500; from *= 2) {
        const double waves = 10 * from / spectrum.hz_step * 2 / 3;
        EXPECT_NEAR(spectrum.between(from, 2 * from) / (density * from), 1, 4 / std::sqrt(waves)) << from;
    }
}

TEST(ForceSpectrum, BandsSumToWhole) {
    const Spectrum spectrum = welch_spectrum(white_noise(999), rate, 1);
    double sum = 0;
    for (const double power : spectrum.power) sum += power;
    const double parts =
        spectrum.between(0, 31.25) + spectrum.between(31.25, 250) + spectrum.between(250, 500);
    EXPECT_GT(sum, 0.2);
    EXPECT_NEAR(parts, sum, 1e-12);
}

TEST(ForceSpectrum, MatchesSlowTransform) {
    using std::numbers::pi_v;
    for (const std::size_t count : {2U, 7U, 30U, 48U, 121U}) {
        const std::vector<double> series = white_noise(count);
        const Spectrum spectrum = welch_spectrum(series, rate, 1);
        long double mean = 0, window_power = 0;
        for (const double value : series) mean += value / static_cast<long double>(count);
        std::vector<long double> windowed;
        for (std::size_t n = 0; n < count; ++n) {
            const long double half =
                std::sin(pi_v<long double> * static_cast<long double>(n) / static_cast<long double>(count));
            windowed.push_back(half * half * (series[n] - mean));
            window_power += half * half * half * half;
        }
        ASSERT_EQ(spectrum.power.size(), count / 2 + 1);
        for (std::size_t k = 0; k < spectrum.power.size(); ++k) {
            long double in = 0, out = 0;
            for (std::size_t n = 0; n < count; ++n) {
                const long double angle = 2 * pi_v<long double> * static_cast<long double>(k * n % count) /
                                          static_cast<long double>(count);
                in += windowed[n] * std::cos(angle);
                out += windowed[n] * std::sin(angle);
            }
            const long double twice = k == 0 || 2 * k == count ? 1 : 2;
            const auto expected = static_cast<double>(twice * (in * in + out * out) /
                                                      (static_cast<long double>(count) * window_power));
            EXPECT_NEAR(spectrum.power[k], expected, 1e-13) << count << ", wave " << k;
        }
    }
}

TEST(ForceSpectrum, OfSegmentsIsTheirMean) {
    std::vector<double> series = sine_wave(2, 100, 5, 1000);
    const std::vector<double> louder = sine_wave(4, 100, -5, 1000);
    series.insert(series.end(), louder.begin(), louder.end());
    EXPECT_NEAR(welch_spectrum(series, rate, 2).between(95, 105), (2 + 8) / 2.0, 1e-9);
}

TEST(FrameRing, ChangesEveryPixel) {
    const auto ring = must(ring_of_bumps(320, 240));
    for (int n = 0; n < ring.count(); ++n) {
        const RawFrame a = ring.frame(n), b = ring.frame(n + 1);
        EXPECT_TRUE(plane_block_of(a.depth.data, 2));
        int same = 0;
        for (int y = 0; y < a.depth.height; ++y)
            for (int x = 0; x < a.depth.width; ++x) same += a.depth.sample(x, y) == b.depth.sample(x, y);
        EXPECT_EQ(same, 0) << n;
    }
}

/// The surface moves at most 63 mm/s, and its stiffness is 0.6 N/mm.
TEST(MovingForce, ErrorFollowsFrameAge) {
    const auto moving = must(MovingForce::make(320, 240));
    const TimedFilter& none = timed_filters()[0];
    const auto off = [&](double frames_per_s, double latency_ms, double interval_ms) {
        const auto result = moving.off(none, {frames_per_s, latency_ms, interval_ms});
        EXPECT_TRUE(result) << result.error().message;
        EXPECT_TRUE(*result);
        return (*result).value_or(MovingForce::Off{});
    };
    const auto fast = off(120, 0, 0), slow = off(30, 0, 0), late = off(30, 20, 1), overrun = off(120, 30, 30);
    EXPECT_NEAR(fast.age_ms, 0.5 * 1000 / 120, 1);
    EXPECT_NEAR(slow.age_ms, 0.5 * 1000 / 30, 1);
    EXPECT_NEAR(late.age_ms, slow.age_ms + 20, 1);
    EXPECT_GT(overrun.age_ms, 40) << "frames that come while one is built are left out";
    EXPECT_GT(slow.n, 3 * fast.n);
    EXPECT_GT(late.n, 1.5 * slow.n);
    EXPECT_LT(late.n, 0.6 * 0.063 * 1000 * (0.020 + 1.0 / 30));
    const auto by_filter = must(moving.off_by_filter(none));
    EXPECT_LT(by_filter, fast.n);
    const auto by_median = moving.off(timed_filters()[1], {60, 0, 0});
    ASSERT_TRUE(by_median && *by_median);
    EXPECT_NEAR((*by_median)->n, off(60, 0, 0).n, 0.05);
    const auto never = must(moving.off(none, {30, 2000, 1}));
    EXPECT_FALSE(never) << "no frame is there within the second";
}

/// Ticks of 2000 dependent square roots each; one in fifty has four times as many.
class Roots final : public TimedRun {
public:
    int ticks() const override { return 1000; }
    void restart() override {}
    void tick(int k) override {
        double x = begin_at_;
        for (int n = 0; n < (k % 50 == 0 ? 8000 : 2000); ++n) x = std::sqrt(x + 1);
        end_at_ = x;
    }

private:
    volatile double begin_at_ = 2, end_at_ = 0;  // so that the compiler computes all of them
};

TEST(TickTimes, CountSquareRoots) {
    Roots run;
    const TickTimes times = time_hot(run, 7);
    EXPECT_NEAR(times.roots, 0.98 * 2000 + 0.02 * 8000, 300);
    EXPECT_NEAR(times.roots_p99, 8000, 1200);
    EXPECT_EQ(times.wall_us.size(), 7000U);
}

}  // namespace
}  // namespace touchable
