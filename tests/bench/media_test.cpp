#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

#include "bench/media/byte_codecs.hpp"
#include "bench/paper/chest_scene.hpp"
#include "bench/paper/paper_clip.hpp"
#include "bench/paper/scripted_path.hpp"
#include "bench/real/depth_plane.hpp"
#include "bench/real/edges.hpp"
#include "bench/real/sensor_models.hpp"
#include "bench/suite.hpp"
#include "engine/content/seeded_noise.hpp"
#include "engine/scene/frames.hpp"
#include "haptics_cpu/height_field.hpp"

namespace touchable {
namespace {

/// Samples of the whole range with holes among them, rows apart by more than their length.
struct HoleyPicture {
    HoleyPicture(int width, int height, int bytes, int channels) {
        const int stride = width * bytes * channels + 6;
        samples.resize(static_cast<std::size_t>(stride * height));
        SplitMix64 random(3);
        for (std::uint8_t& sample : samples)
            sample = random.unit() < 0.5 ? 0 : static_cast<std::uint8_t>(random.next());
        view = {samples.data(), stride, width, height, bytes, channels};
    }
    std::vector<std::uint8_t> samples;
    PlaneView view;
};

void expect_back(PlaneCodec& codec, const PlaneView& view) {
    Packet packet;
    ASSERT_TRUE(codec.encode(view, packet));
    ASSERT_TRUE(codec.decode(packet));
    EXPECT_TRUE(same_samples(*codec.plane(), view));
}

TEST(ByteCodecs, GiveBackWhatWentIn) {
    for (const auto& [bytes, channels] : {std::pair{1, 1}, {2, 1}, {1, 3}}) {
        const HoleyPicture picture(37, 11, bytes, channels);
        expect_back(*make_raw_codec(picture.view), picture.view);
        if (channels == 1) expect_back(*make_rvl_codec(picture.view), picture.view);
        for (const auto make : {make_zstd_codec, make_zstd_gradient_codec})
            expect_back(*make(picture.view), picture.view);
    }
}

TEST(ByteCodecs, RvlWritesRunsAndDifferences) {
    // Two zeros, then 5, 3 and 20: differences 5, -2, 17 become 10, 3, 34, of which 10 and 34 take two
    // groups.
    const std::vector<std::uint16_t> row{0, 0, 5, 3, 20};
    const PlaneView view{reinterpret_cast<const std::uint8_t*>(row.data()), 10, 5, 1, 2, 1};
    Packet packet;
    ASSERT_TRUE(make_rvl_codec(view)->encode(view, packet));
    // From the lowest group on: 2, 3, 10 = 2 + 8 * 1, 3, 34 = 2 + 8 * 4.
    EXPECT_EQ(packet, (Packet{0x32, 0x1a, 0xa3, 0x04}));
}

TEST(ByteCodecs, RefuseWhatIsCutOff) {
    const HoleyPicture picture(37, 11, 2, 1);
    for (const auto& codec : {make_raw_codec(picture.view), make_rvl_codec(picture.view)}) {
        Packet packet;
        ASSERT_TRUE(codec->encode(picture.view, packet));
        packet.resize(packet.size() / 2);
        EXPECT_FALSE(codec->decode(packet));
    }
}

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
    const auto seen = seen_from(leaning_map(1.0 / 1000), 200);
    ASSERT_TRUE(seen) << seen.error().message;
    // a Z + ... = 1 with Z = Z' + 200: all of 1 / depth grows by 1 / (1 - 200 a).
    for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 64; ++x)
            EXPECT_NEAR(seen->at(x, y), 0.8 / leaning(x, y, 1.0 / 1000), 1e-9) << x << ' ' << y;
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
