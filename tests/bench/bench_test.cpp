// What benchmarks are made of: sensors and clips that they measure with; loops, spectra and the GPU's
// cases; targets and reports.

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <map>
#include <numbers>
#include <regex>
#include <set>
#include <sstream>
#include <string>

#include "bench/clocks.hpp"
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
#include "bench/report.hpp"
#include "bench/suite.hpp"
#include "bench/targets.hpp"
#include "bench/tick_times.hpp"
#include "bench/touch/force_spectrum.hpp"
#include "engine/base/hand_thresholds.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/gpu/gpu_device.hpp"
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

std::string text_of(const std::filesystem::path& file) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
}

bool says(const std::string& text, const std::string& words) {
    return text.find(words) != std::string::npos;
}

struct Answer {
    int code = -1;
    std::string text;
};

Answer answer_to(const std::string& command) {
    Answer answer;
    FILE* const program = popen((command + " 2>&1").c_str(), "r");
    std::array<char, 4096> some;
    while (std::fgets(some.data(), some.size(), program)) answer.text += some.data();
    answer.code = WEXITSTATUS(pclose(program));
    return answer;
}

bool has_matplotlib() {
    return answer_to("/usr/bin/python3 -c 'import matplotlib'").code == 0;
}

Answer plot(const std::string& words) {
    return answer_to("/usr/bin/python3 " TOUCHABLE_SOURCE_DIR "/bench/plot.py " + words);
}

/// The page of one suite's records; `old`: to compare with, if any.
std::string page_of(const test::TemporaryFolder& folder, const char* suite,
                    const std::vector<CaseFigures>& records, const std::vector<CaseFigures>& old = {}) {
    const std::string now = folder / "now.json", before = folder / "before.json", page = folder / "page.html";
    EXPECT_TRUE(write_report(now, suite, records));
    EXPECT_TRUE(old.empty() || write_report(before, suite, old));
    const Answer answer = plot("report " + now + " " + page + (old.empty() ? "" : " --compare " + before));
    EXPECT_EQ(answer.code, 0) << answer.text;
    EXPECT_EQ(answer.text, "");
    return text_of(page);
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

Result<void> measure(const std::string& name, Figures& figures) {
    for (const BenchCase& c : gpu_cases(true))
        if (c.name == name) return c.measure(figures);
    return usage_error("no case " + name);
}

TEST(GpuSuite, MeasuresAndPlotsTinyCase) {
    if (!GpuDevice::open()) GTEST_SKIP() << "no Vulkan";
    Figures frames, fingers;
    const auto by_frame = measure("ways-320x240-m3", frames),
               by_finger = measure("ways-320x240-m3-1f", fingers);
    ASSERT_TRUE(by_frame) << by_frame.error().message;
    ASSERT_TRUE(by_finger) << by_finger.error().message;
    EXPECT_EQ(value_of(frames, "lazy_possible"), 1);
    EXPECT_GT(value_of(fingers, "cpu_ms_per_s_60hz"), value_of(fingers, "cpu_ms_per_s_30hz"));
    EXPECT_GT(value_of(fingers, "lazy_tick_us"), 0);

    if (!has_matplotlib()) GTEST_SKIP() << "no matplotlib: the page is not made";
    const test::TemporaryFolder folder;
    const CaseFigures machine{"machine",
                              {named("gpu", "RTX <1>"), named("gpu_driver", "N"), named("vulkan", "1.3")}};
    const std::string page =
        page_of(folder, "gpu", {machine, {"ways-320x240-m3", frames}, {"ways-320x240-m3-1f", fingers}});
    EXPECT_PRED2(says, page, "<svg");
    EXPECT_PRED2(says, page, "GPU: RTX &lt;1&gt;</h2>");
    EXPECT_PRED2(says, page, "Force error on a moving surface");
    EXPECT_FALSE(says(page, "Jitter")) << "it was not measured";
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

Target target(Limit::Sense sense, double value = 0) {
    return {"a time", {"here", "there"}, "us", {value, sense, "us"}};
}

std::vector<CaseFigures> measured(double here, double there) {
    return {{"here", {{"other", 1000, ""}, {"us", here, "us"}}}, {"there", {{"us", there, "us"}}}};
}

constexpr auto below = Limit::Sense::below, at_most = Limit::Sense::at_most,
               at_least = Limit::Sense::at_least, no_limit = Limit::Sense::none;

TEST(Targets, AreJudgedByWorstCase) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const struct {
        Target target;
        std::vector<CaseFigures> figures;
        bool met;
        double value;  // nan: of no matter
    } cases[] = {{target(below, 3), measured(1, 2.5), true, 2.5},
                 {target(below, 3), measured(3.5, 1), false, 3.5},
                 {target(below, 3), measured(3, 1), false, 3},
                 {target(at_most, 3), measured(3, 1), true, 3},
                 {target(at_most, 0), measured(0, 1e-12), false, 1e-12},
                 {target(at_least, 2), measured(5, 2), true, 2},
                 {target(at_least, 2), measured(5, 1.9), false, 1.9},
                 {target(at_least, 2), measured(nan, 5), false, nan},
                 {target(at_least, 2), {}, false, nan},
                 {target(no_limit), measured(4, 5), true, 5},
                 {target(no_limit), {}, false, nan},
                 {target(below, 3), {}, false, nan},
                 {target(below, 3), {{"elsewhere", {{"us", 1, "us"}}}}, false, nan},
                 {target(below, 3), measured(nan, 1), false, nan},
                 {target(below, 3), measured(1, nan), false, nan}};
    for (const auto& one : cases) {
        const Verdict verdict = judge(one.target, one.figures);
        EXPECT_EQ(verdict.met, one.met) << &one - cases;
        EXPECT_TRUE(std::isnan(one.value) || verdict.value == one.value) << &one - cases << verdict.value;
    }
    EXPECT_EQ(judge(target(below, 3), measured(1, 2.5)).cases, 2U);
}

TEST(Targets, SkipWhereNotApplicable) {
    Target t = target(below, 3);
    t.only_where = "on_gpu";
    std::vector<CaseFigures> figures = measured(5, 1);
    figures[0].figures.push_back({"on_gpu", 0, ""});
    figures[1].figures.push_back({"on_gpu", 1, ""});
    EXPECT_TRUE(judge(t, figures).met);
    EXPECT_EQ(judge(t, figures).cases, 1U);
    figures[1].figures.back().value = 0;
    EXPECT_FALSE(judge(t, figures).asked);
    EXPECT_NE(table_of({t}, figures).find("not asked here\n"), std::string::npos);
    EXPECT_TRUE(judge(t, {}).asked);  // whether it applies is unknown
    EXPECT_FALSE(judge(t, {}).met);
    const std::vector<Target> left =
        measured_targets({target(below, 3), {"elsewhere", {"nowhere"}, "us", t.limit}}, {{"there", {}}});
    ASSERT_EQ(left.size(), 1U);
    EXPECT_EQ(left[0].what, "a time");
}

TEST(Targets, MayBeRelative) {
    Target t = target(at_most, 1);
    t.cases = {"there"};
    t.relative_to = "here";
    EXPECT_EQ(judge(t, measured(4, 3)).value, 0.75);
    EXPECT_TRUE(judge(t, measured(4, 3)).met);
    EXPECT_FALSE(judge(t, measured(4, 5)).met);
    t.relative_to = "nowhere";
    EXPECT_FALSE(judge(t, measured(4, 3)).met);
}

TEST(Targets, TableShowsVerdicts) {
    const std::string table = table_of({target(below, 3), target(below, 2)}, measured(2.5, 1));
    for (const char* words : {"< 3 us", "2.5 us", "met\n", "MISSED\n"})
        EXPECT_NE(table.find(words), std::string::npos) << table;
    EXPECT_EQ(table_of({target(no_limit)}, measured(4, 5)).find("met\n"), std::string::npos);
}

TEST(Targets, RecordsNameParentAndWorstCase) {
    std::vector<Target> targets{target(below, 3), target(at_least, 2), target(below, 2), target(below, 3)};
    targets[1].cases = targets[2].cases = {"nowhere"};
    targets[2].what = "unmeasured";
    targets[3].what = "  on a GPU";
    const std::vector<CaseFigures> records = records_of(targets, measured(1, 3.5));
    ASSERT_EQ(records.size(), 2U) << "two were not measured";
    EXPECT_EQ(records[0].name, "target: a time");
    EXPECT_EQ(records[1].name, "target: unmeasured: on a GPU");
    std::map<std::string, std::string> words;
    for (const Figure& figure : records[0].figures) words[figure.metric] = figure.name.value_or("");
    EXPECT_EQ(words["verdict"], "MISSED");
    EXPECT_EQ(words["limit"], "< 3 us");
    EXPECT_EQ(words["worst_case"], "there");
    EXPECT_EQ(words["metric"], "us");
    EXPECT_EQ(records[0].figures[0].metric, "worst");
    EXPECT_EQ(records[0].figures[0].value, 3.5);
    EXPECT_EQ(records[0].figures[0].unit, "us");
}

void expect_cases_of(const std::vector<Target>& targets, std::vector<BenchCase> (&cases)(bool quick)) {
    std::set<std::string> full, quick;
    for (const BenchCase& c : cases(false)) full.insert(c.name);
    for (const BenchCase& c : cases(true)) quick.insert(c.name);
    for (const Target& t : targets) {
        std::size_t in_quick = 0;
        for (const std::string& name : t.cases) {
            EXPECT_TRUE(full.contains(name)) << t.what << ": " << name;
            in_quick += quick.count(name);
        }
        EXPECT_GT(in_quick, 0U) << t.what;
        EXPECT_TRUE(t.relative_to.empty() || quick.contains(t.relative_to)) << t.relative_to;
    }
}

TEST(Targets, NameExistingCases) {
    expect_cases_of(touch_targets(), touch_cases);
    expect_cases_of(surface_targets(), surface_cases);
}

TEST(Suites, NameNoCaseTwice) {
    for (const bool quick : {false, true})
        for (const auto& cases : {touch_cases(quick), loop_cases(quick), surface_cases(quick),
                                  gpu_cases(quick), target_cases(quick)}) {
            std::set<std::string> names;
            for (const BenchCase& c : cases) EXPECT_TRUE(names.insert(c.name).second) << c.name;
            EXPECT_GT(names.size(), 8U);
        }
}

/// With so many more metrics, named 1000, 1001, ...
CaseFigures widened(CaseFigures c) {
    for (int n = 0; n < 31; ++n) c.figures.push_back({std::to_string(1000 + n), 0, ""});
    return c;
}

/// Barbagli et al. 2006; Pang, Tan and Durlach 1991.
TEST(HandThresholds, MatchTheirSources) {
    EXPECT_DOUBLE_EQ(direction_jnd(18.4), 1);
    EXPECT_NEAR(direction_jnd(1.74), 0.09, 0.005) << "the globe";
    EXPECT_NEAR(direction_jnd(49), 2.7, 0.05) << "the paper's method";
    EXPECT_EQ(hand_thresholds::felt_degrees, 25.6);
    EXPECT_EQ(direction_jnd_words(9.2), "0.5 of what a hand just notices where it sees the scene");
    EXPECT_DOUBLE_EQ(just_noticed_newtons(2.5).value_or(0), 0.175);
    EXPECT_DOUBLE_EQ(just_noticed_newtons(10).value_or(0), 0.7);
    EXPECT_FALSE(just_noticed_newtons(2.4) || just_noticed_newtons(10.1));
}

TEST(Report, AddsJndBesideDirections) {
    Figures figures{{"tick_us_mean", 1, "us"},
                    {"force_angle_deg_rms", 9.2, "deg"},
                    {"force_angle_deg_rms_0_15", 36.8, "deg"},
                    {"plane_error_deg", 1, "deg"}};
    add_jnd(figures);
    ASSERT_EQ(figures.size(), 6U);
    EXPECT_EQ(figures[2].metric, "force_angle_jnd_rms");
    EXPECT_DOUBLE_EQ(figures[2].value, 0.5);
    EXPECT_EQ(figures[2].unit, "JND");
    EXPECT_EQ(figures[4].metric, "force_angle_jnd_rms_0_15");
    EXPECT_DOUBLE_EQ(figures[4].value, 2);
    EXPECT_EQ(figures[5].metric, "plane_error_deg") << "is no error of a force";
}

TEST(Report, ManyMetricsGetRows) {
    const std::string table =
        tables_of({widened({"one", {{"common_ms", 1, "ms"}, {"last", 3, ""}}}),
                   widened({"another", {{"common_ms", 2.5, "ms"}, {"between", 7, ""}, {"last", 4, ""}}})});
    EXPECT_EQ(table.substr(0, table.find("1000")),
              "                one  another\n"
              "common_ms (ms)    1      2.5\n"
              "between                    7\n"
              "last              3        4\n");
    std::vector<CaseFigures> cases;
    for (int n = 0; n < 12; ++n) cases.push_back(widened({"case" + std::to_string(n), {}}));
    const std::string tables = tables_of(cases);
    for (const char* end : {"case9\n", "case11\n"}) EXPECT_NE(tables.find(end), std::string::npos) << tables;
}

TEST(Report, ShowsNamesAsValues) {
    const CaseFigures c{"machine", {{"cores", 2, ""}, named("gpu", "llvmpipe")}};
    CaseFigures plotted = c;
    plotted.figures.push_back({"curve", 1, "", false});
    EXPECT_EQ(tables_of({plotted}), "         cores       gpu\nmachine      2  llvmpipe\n");
    const test::TemporaryFolder folder;
    ASSERT_TRUE(write_report(folder / "r.json", "gpu", {c}));
    std::stringstream text;
    text << std::ifstream(folder / "r.json").rdbuf();
    EXPECT_NE(text.str().find(R"("metric":"gpu","value":"llvmpipe")"), std::string::npos) << text.str();
}

/// The part of a page from a heading to the next one.
std::string part_of(const std::string& page, const std::string& heading) {
    const std::size_t begin = page.find(">" + heading);
    if (begin == std::string::npos) return "";
    return page.substr(begin, page.find("<h", begin) - begin);
}

TEST(Page, TellsWhatGotWorse) {
    if (!has_matplotlib()) GTEST_SKIP();
    const auto records = [](double mean, double p99, double roots, double angle, double lost, double rate,
                            double odd, const char* hash) {
        return std::vector<CaseFigures>{
            {"machine", {{"quick", 1, ""}}},
            {"rough-1f",
             {{"tick_us_mean", mean, "us"},
              {"tick_us_p99", p99, "us"},
              {"tick_roots", roots, ""},
              {"force_angle_deg_rms", angle, "deg"},
              {"contact_lost_ticks", lost, ""},
              {"frames_per_s", rate, ""},
              {"odd_share", odd, ""},
              {"strange", odd, ""},
              named("force_hash", hash)}},
            {"target: odd", {named("metric", "odd_share"), named("limit", ">= 2"), named("verdict", "met")}}};
    };
    const auto old = records(1, 10, 50, 2, 0, 30, 3, "aa");
    const test::TemporaryFolder folder;
    const std::string page = page_of(folder, "touch", records(1.2, 19, 52, 1.9, 3, 20, 2.5, "bb"), old);
    const std::string worse = part_of(page, "Worse: 4 figures"), better = part_of(page, "Better: 1 figure<"),
                      changed = part_of(page, "Changed, neither better nor worse: 2 figures");
    for (const char* metric : {"tick_us_mean", "contact_lost_ticks", "frames_per_s", "odd_share"})
        EXPECT_PRED2(says, worse, metric);
    EXPECT_PRED2(says, worse, "<td class=n>1 µs</td><td class=n>1.20 µs</td><td class=n>1.20</td>");
    EXPECT_PRED2(says, worse, "<code>touchable-bench touch --quick --filter rough-1f</code>");
    EXPECT_PRED2(says, better, "force_angle_deg_rms");
    EXPECT_PRED2(says, changed, "force_hash");
    EXPECT_PRED2(says, changed, "strange") << "no target, name or unit tells what is better";
    EXPECT_FALSE(says(worse + better + changed, "tick_us_p99")) << "less than twice as long";
    EXPECT_FALSE(says(worse + better + changed, "tick_roots")) << "4 %";

    const std::string same = page_of(folder, "touch", old, old);
    for (const char* heading : {"Worse: 0", "Better: 0", "Changed, neither better nor worse: 0"})
        EXPECT_PRED2(says, part_of(same, heading), "Nothing.");
    EXPECT_FALSE(says(same, "Not the same"));
    auto elsewhere = old;
    elsewhere[0].figures.push_back(named("cpu", "another"));
    EXPECT_PRED2(says, page_of(folder, "touch", elsewhere, old), "Not the same processor");
    EXPECT_FALSE(says(page_of(folder, "touch", old), "got worse")) << "there is nothing to compare with";
}

TEST(Page, TellsBestTargetsAndTableOne) {
    if (!has_matplotlib()) GTEST_SKIP();
    const test::TemporaryFolder folder;
    const auto globe = [](const char* name, double time, double angle) {
        return CaseFigures{std::string("globe-720x480-") + name,
                           {{"tick_us_mean", time, "us"}, {"force_angle_deg_rms", angle, "deg"}}};
    };
    const CaseFigures hand{"hand",
                           {{"direction_seen_deg", 18.4, "deg"}, {"direction_felt_deg", 25.6, "deg"}}};
    const std::string best = page_of(folder, "touch",
                                     {hand,
                                      globe("8-1f-pixel", 1, 60),
                                      globe("16-1f-world", 3, 2),
                                      globe("exact-1f-world", 4, 1),
                                      {"target: a tick",
                                       {{"worst", 3, "us"},
                                        named("worst_case", "globe-720x480-16-1f-world"),
                                        named("metric", "tick_us_mean"),
                                        named("limit", "< 2 us"),
                                        named("verdict", "MISSED")}}});
    EXPECT_PRED2(says, part_of(best, "Time of a tick of one finger"),
                 "<td>16-world</td><td class=n>3 µs</td><td>exact-world</td><td class=n>4 µs</td>")
        << "the fastest is so wrong that a hand notices";
    EXPECT_PRED2(says, part_of(best, "Error of the force"), "<td>exact-world</td><td class=n>1°</td>");
    EXPECT_PRED2(says, part_of(best, "Missed"),
                 "<td>a tick</td><td class=n>&lt; 2 µs</td><td class=n>3 µs</td>");
    EXPECT_PRED2(says, part_of(best, "Run time against error</h2>"), "<svg");

    std::vector<CaseFigures> sweeps;
    for (const char* size : {"720x480", "3840x2160"})
        for (const char* fingers : {"1", "5"})
            sweeps.push_back({std::string("globe-") + size + "-8-" + fingers + "f-pixel-m3-lazy-circle",
                              {{"tick_us_mean", 2.5 * std::stod(fingers), "us"},
                               {"papers_tick_us", 253.4 * std::stod(fingers), "us"}}});
    const std::string table = part_of(page_of(folder, "paper", sweeps), "The paper's method");
    EXPECT_PRED2(says, table, "<td>720x480 in the paper</td><td class=n>253</td><td class=n>1,267</td>");
    EXPECT_PRED2(says, table, "<td>3840x2160</td><td class=n>2.50 (none)</td><td class=n>12.5 (none)</td>");
}

TEST(Page, EscapesNamesAndLoadsNothing) {
    if (!has_matplotlib()) GTEST_SKIP();
    const test::TemporaryFolder folder;
    const std::string script = "<script src=https://x.y/z.js></script>";
    const std::vector<CaseFigures> records{
        {"machine", {named("gpu", script), named("commit", script), {script, 1, "<i>"}}},
        {script, {{"tick_us_mean", 1, "us"}, {script, 2, "<i>"}}},
        {"globe-720x480-8-1f-pixel", {{"tick_us_mean", 1, "us"}, {"force_angle_deg_rms", 60, "deg"}}},
        {"target: " + script, {named("metric", script), named("limit", script), named("verdict", script)}}};
    auto old = records;
    old[1].figures = {{"tick_us_mean", 3, "us"}, {script, 5, "<i>"}};
    std::string page = page_of(folder, "touch", records, old);
    EXPECT_PRED2(says, page, "&lt;script src=https://x.y/z.js&gt;");
    for (const char* loaded : {"<script", "<link", "<img", "<iframe", "@import", "<i>"})
        EXPECT_FALSE(says(page, loaded)) << loaded;
    // What is left of addresses names the language of a drawing, and is never loaded, or is a word that is
    // shown.
    page = std::regex_replace(page, std::regex(" xmlns(:xlink)?=\"http://www.w3.org/[^\"]*\""), "");
    page = std::regex_replace(page, std::regex("&lt;script src=https:"), "");
    for (const char* address : {"http:", "https:"}) EXPECT_FALSE(says(page, address)) << address;
}

TEST(Page, RefusesForeignRecords) {
    if (!has_matplotlib()) GTEST_SKIP();
    const test::TemporaryFolder folder;
    const std::string json = folder / "x.json", page = folder / "page.html";
    const std::string row = R"({"suite":"touch","case":"a","metric":"b","unit":"us","value":)";
    const std::string foreign[] = {"",
                                   "{}",
                                   "[7]",
                                   R"([{"suite":"touch","case":"a"}])",
                                   R"([{"suite":"touch","case":["a"],"metric":"b","unit":"us","value":1}])",
                                   "[" + row + "[1]}]",
                                   "[" + row + "1" + std::string(400, '0') + "}]",
                                   "\xff\xfe",
                                   std::string(100'000, '[')};
    for (const std::string& text : foreign) {
        std::ofstream(json) << text;
        const Answer answer = plot("report " + json + " " + page);
        EXPECT_EQ(answer.code, 3) << text.substr(0, 80);
        EXPECT_EQ(std::ranges::count(answer.text, '\n'), 1) << answer.text;
        EXPECT_PRED2(says, answer.text, "plot.py: " + json + ": ");
    }
    std::ofstream(json) << "[" << row << "1}]";
    const std::string nowhere = folder / "nowhere", is_there = folder.path().string();
    for (const std::string& words :
         {"report " + nowhere + " " + page, "report " + json + " " + page + " --compare " + nowhere,
          "report " + json + " " + nowhere + "/page.html", "pareto " + json + " " + page}) {
        const Answer answer = plot(words);
        EXPECT_EQ(answer.code, 3) << words;
        EXPECT_EQ(std::ranges::count(answer.text, '\n'), 1) << answer.text;
    }
    EXPECT_FALSE(std::filesystem::exists(page));
    EXPECT_EQ(plot("count " + is_there).text, is_there + ": 1 figures of touch\n");
}

TEST(Page, OutlivesOtherVersionsRecords) {
    if (!has_matplotlib()) GTEST_SKIP();
    const test::TemporaryFolder folder;
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const std::vector<CaseFigures> records{
        {"window-1920x1080-raster", {{"painter_of_later", 1, "ms"}}},
        {"pictures-1920x1080", {named("raster_cpu_ms", "a word"), {"raster_cpu_frame_ms", nan, "ms"}}},
        {"ways-320x240-m3", {{"lazy_frame_ms", nan, "ms"}}},
        {"ways-320x240-m3-1f",
         {{"lazy_ms_per_s_30hz", 1, "ms"},
          {"lazy_tick_us", nan, "us"},
          {"late_ticks_pct", 0.4, "%"},
          {"frames_in_time_pct", 80, "%"}}}};
    auto old = records;
    old[3].figures = {{"lazy_ms_per_s_30hz", nan, "ms"},
                      {"lazy_tick_us", 1, "us"},
                      {"late_ticks_pct", 0, "%"},
                      {"frames_in_time_pct", 99, "%"}};
    const std::string page = page_of(folder, "gpu", records, old);
    EXPECT_PRED2(says, page, "Not drawn; these records do not fit");
    const std::string worse = part_of(page, "Worse: 2 figures");
    EXPECT_PRED2(says, worse, "<td class=n>1 µs</td><td class=n>none</td>");
    EXPECT_PRED2(says, worse, "frames_in_time_pct") << "so much is more than threads and load do";
    EXPECT_FALSE(says(worse, "late_ticks_pct"));
    EXPECT_PRED2(says, part_of(page, "Better: 1 figure"), "<td class=n>none</td><td class=n>1 ms</td>");
}

TEST(RunBench, RefusesOptionsBeforeMeasuring) {
    const test::TemporaryFolder folder;
    const std::string there = folder.path().string();
    const std::pair<std::string, std::string> faults[] = {
        {"--compre x", "unknown option '--compre'; there is only --compare OLD"},
        {"x", "unknown option 'x'; there is only --compare OLD"},
        {"--compare", "--compare needs one file or folder of earlier records: --compare OLD"},
        {"--compare a b", "--compare needs one file or folder of earlier records: --compare OLD"},
        {"--compare " + there + "/no",
         "--compare '" + there + "/no' cannot be read; must be a file of records or a folder of such files"},
    };
    for (const auto& [words, fault] : faults) {
        const Answer answer = answer_to(TOUCHABLE_SOURCE_DIR "/run bench " + words);
        EXPECT_EQ(answer.code, 2) << words;
        EXPECT_EQ(answer.text, "run bench: " + fault + "\n");
    }
}

/// Ticks of 2000 dependent square roots each; one in fifty has four times as many.
class Roots final : public TimedRun {
public:
    int ticks() const override { return 1000; }
    void restart() override {}
    void tick(int k) override {
        for (int n = 0; n < (k % 50 == 0 ? 8 : 2); ++n) root_ns();  // times 1000
    }
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
