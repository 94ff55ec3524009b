#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <numbers>
#include <sstream>

#include "bench/gpu/frame_ring.hpp"
#include "bench/gpu/gpu_cases.hpp"
#include "bench/loop/stability.hpp"
#include "bench/report.hpp"
#include "bench/suite.hpp"
#include "bench/touch/force_spectrum.hpp"
#include "engine/content/seeded_noise.hpp"
#include "engine/gpu/gpu_device.hpp"
#include "engine/scene/plane_memory.hpp"
#include "tests/temporary_files.hpp"

namespace touchable {
namespace {

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
    auto made = TouchSurface::make(loop.touch);
    ASSERT_TRUE(made);
    const PressedPlace place = pressed_place(**made, 51, 30);
    const double wall = colgate_schenkel_bound(loop.handle);
    EXPECT_EQ(fate_of(**made, loop, place, 0.8 * wall).value(), LoopFate::rests);
    EXPECT_EQ(fate_of(**made, loop, place, 1.2 * wall).value(), LoopFate::shakes);
    loop.handle.quantum = 0.01;  // read as 0 or 10 mm: it rests between, above the surface
    loop.handle.friction = 5;
    EXPECT_EQ(fate_of(**made, loop, place, 10'000).value(), LoopFate::leaves);
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

double value_of(const Figures& figures, const std::string& metric) {
    const auto found = std::ranges::find(figures, metric, &Figure::metric);
    EXPECT_NE(found, figures.end()) << metric;
    return found == figures.end() ? 0 : found->value;
}

std::string text_of(const std::filesystem::path& file) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
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

    if (std::system("/usr/bin/python3 -c 'import matplotlib' 2>/dev/null") != 0)
        GTEST_SKIP() << "no matplotlib: the page is not made";
    const test::TemporaryFolder folder;
    const auto json = folder / "gpu.json", page = folder / "gpu.html";
    const CaseFigures machine{"machine",
                              {named("gpu", "RTX <1>"), named("gpu_driver", "N"), named("vulkan", "1.3")}};
    ASSERT_TRUE(
        write_report(json, "gpu", {machine, {"ways-320x240-m3", frames}, {"ways-320x240-m3-1f", fingers}}));
    const std::string command =
        "/usr/bin/python3 " TOUCHABLE_SOURCE_DIR "/bench/plot.py gpu " + json.string() + " " + page.string();
    ASSERT_EQ(std::system(command.c_str()), 0);
    const std::string html = text_of(page);
    EXPECT_NE(html.find("<svg"), std::string::npos);
    EXPECT_NE(html.find("cost on RTX &lt;1&gt;</h1>"), std::string::npos);
    EXPECT_NE(html.find("Force error on a moving surface"), std::string::npos);
    EXPECT_EQ(html.find("Jitter"), std::string::npos) << "it was not measured";
}

TEST(GpuSuite, PlotRejectsForeignReport) {
    if (std::system("/usr/bin/python3 -c 'import matplotlib' 2>/dev/null") != 0) GTEST_SKIP();
    const test::TemporaryFolder folder;
    ASSERT_TRUE(write_report(folder / "loop.json", "loop", {{"bumps", {{"time", 1, "us"}}}}));
    const std::string command = "/usr/bin/python3 " TOUCHABLE_SOURCE_DIR "/bench/plot.py gpu " +
                                (folder / "loop.json").string() + " " + (folder / "page.html").string() +
                                " 2>/dev/null";
    EXPECT_NE(std::system(command.c_str()), 0);
    EXPECT_FALSE(std::filesystem::exists(folder / "page.html"));
}

TEST(FrameRing, ChangesEveryPixel) {
    const auto ring = ring_of_bumps(320, 240);
    ASSERT_TRUE(ring) << ring.error().message;
    for (int n = 0; n < ring->count(); ++n) {
        const RawFrame a = ring->frame(n), b = ring->frame(n + 1);
        EXPECT_TRUE(plane_block_of(a.depth.data, 2));
        int same = 0;
        for (int y = 0; y < a.depth.height; ++y)
            for (int x = 0; x < a.depth.width; ++x) same += a.depth.sample(x, y) == b.depth.sample(x, y);
        EXPECT_EQ(same, 0) << n;
    }
}

/// The surface moves at most 63 mm/s, and its stiffness is 0.6 N/mm.
TEST(MovingForce, ErrorFollowsFrameAge) {
    const auto moving = MovingForce::make(320, 240);
    ASSERT_TRUE(moving) << moving.error().message;
    const TimedFilter& none = timed_filters()[0];
    const auto off = [&](double rate, double latency_ms, double interval_ms) {
        const auto result = moving->off(none, {rate, latency_ms, interval_ms});
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
    const auto by_filter = moving->off_by_filter(none);
    ASSERT_TRUE(by_filter);
    EXPECT_LT(*by_filter, fast.n);
    const auto by_median = moving->off(timed_filters()[1], {60, 0, 0});
    ASSERT_TRUE(by_median && *by_median);
    EXPECT_NEAR((*by_median)->n, off(60, 0, 0).n, 0.05);
    const auto never = moving->off(none, {30, 2000, 1});
    ASSERT_TRUE(never);
    EXPECT_FALSE(*never) << "no frame is there within the second";
}

}  // namespace
}  // namespace touchable
