#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "bench/gpu/frame_ring.hpp"
#include "bench/gpu/gpu_cases.hpp"
#include "bench/report.hpp"
#include "bench/suite.hpp"
#include "engine/gpu/gpu_device.hpp"
#include "engine/scene/plane_memory.hpp"
#include "tests/temporary_folder.hpp"

namespace touchable {
namespace {

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

TEST(GpuSuite, MeasuresATinyCaseAndPlotsIt) {
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

TEST(GpuSuite, PlotRefusesReportOfAnotherSuite) {
    if (std::system("/usr/bin/python3 -c 'import matplotlib' 2>/dev/null") != 0) GTEST_SKIP();
    const test::TemporaryFolder folder;
    ASSERT_TRUE(write_report(folder / "loop.json", "loop", {{"bumps", {{"time", 1, "us"}}}}));
    const std::string command = "/usr/bin/python3 " TOUCHABLE_SOURCE_DIR "/bench/plot.py gpu " +
                                (folder / "loop.json").string() + " " + (folder / "page.html").string() +
                                " 2>/dev/null";
    EXPECT_NE(std::system(command.c_str()), 0);
    EXPECT_FALSE(std::filesystem::exists(folder / "page.html"));
}

TEST(FrameRing, ChangesEveryPixelInPlaneMemory) {
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
TEST(MovingForce, IsOffByTheAgeOfTheFrame) {
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
