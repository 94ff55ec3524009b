#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "bench/paper/chest_scene.hpp"
#include "bench/paper/paper_clip.hpp"
#include "bench/paper/scripted_path.hpp"
#include "bench/suite.hpp"
#include "haptics_cpu/height_field.hpp"

namespace touchable {
namespace {

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

TEST(PaperChest, HasTheNoiseThatWasAskedForAndThatOfRounding) {
    for (const double levels : {1.0, 2.0}) {
        const std::vector<double> noise = noise_of(levels, 3);
        EXPECT_NEAR(mean_product(noise, noise), levels * levels + 1.0 / 12, 0.1 * levels * levels);
    }
    for (const double off : noise_of(0, 3)) EXPECT_LE(std::fabs(off), 0.5 + 1e-9);
}

TEST(PaperChest, HasNoiseOfItsOwnInEachPixelAndFrame) {
    const std::vector<double> noise = noise_of(1, 0);
    EXPECT_NEAR(mean_product(noise, noise_of(1, 1)), 0, 0.06);
    std::vector<double> neighbours(noise.begin() + 1, noise.end());
    neighbours.push_back(noise[0]);
    EXPECT_NEAR(mean_product(noise, neighbours), 0, 0.06);
}

TEST(PaperChest, IsTheEllipsoidItSaysUnderAPlaceOfTheHand) {
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

TEST(PlayedClip, IsTheSameSurfaceLazilyAndWholeRoundTheLoop) {
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

TEST(ScriptedPaths, OfFastHandsReachThreeTenthsOfAMetreASecondAndStayOnTheGlobe) {
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

}  // namespace
}  // namespace touchable
