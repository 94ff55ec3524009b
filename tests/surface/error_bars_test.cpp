// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <memory>

#include "engine/base/same_bits.hpp"
#include "engine/surface/surface_builder.hpp"
#include "tests/must.hpp"
#include "tests/surface/pictures.hpp"

namespace touchable::test {
namespace {

constexpr int block_side = ErrorSigns::side;

/// Codes of a wavy slope with this much noise, and holes in every `hole_every`-th pixel on average.
std::vector<std::uint16_t> wavy(const Scene& scene, double noise, int hole_every, std::uint64_t seed,
                                double height = 25) {
    Random random(seed);
    std::vector<std::uint16_t> codes;
    for (int y = 0; y < scene.height; ++y)
        for (int x = 0; x < scene.width; ++x) {
            const double depth = 900 + 1.5 * x - 0.8 * y + height * std::sin(0.05 * x) * std::cos(0.07 * y) +
                                 noise * normal([&] { return random.between(0, 1); });
            const bool is_hole = hole_every > 0 && random.below(hole_every) == 0;
            codes.push_back(is_hole ? std::uint16_t{0} : static_cast<std::uint16_t>(10 * depth));
        }
    return codes;
}

Scene wavy_scene(int width = 160, int height = 120) {
    return metric_scene(width, height, {1.2 * width, 1.25 * width, 0.48 * width, 0.52 * height}, 6000, 0.1);
}

/// A frame with its memory.
struct Measured {
    StoredPlane plane;
    SurfaceFrame frame;
};
std::unique_ptr<Measured> measured(const Scene& scene, const std::vector<std::uint16_t>& codes,
                                   std::unique_ptr<SurfaceBuilder> builder) {
    auto made = std::make_unique<Measured>();
    made->plane = store_plane(scene.width, scene.height, codes, {});
    EXPECT_TRUE(with_error_bars(std::move(builder), scene)->build(made->plane.frame(), made->frame));
    return made;
}
std::unique_ptr<Measured> measured(const Scene& scene, double noise, int hole_every = 0) {
    return measured(scene, wavy(scene, noise, hole_every, 5), make_cpu_builder(scene));
}

/// Sums over faces, in world space, by the definition.
struct Faces {
    glm::dvec3 normal{0.0};
    double q = 0, count = 0;
};
Faces faces_of(const Scene& scene, const SurfaceFrame& frame, int left, int top) {
    const auto ray = [&](double x, double y) {
        return glm::dvec3((x - scene.camera.cx) / scene.camera.fx, (scene.camera.cy - y) / scene.camera.fy,
                          -1);
    };
    const auto point = [&](int x, int y) -> std::optional<glm::dvec3> {
        const DepthSample sample = frame.vertices->at(x, y);
        if (!sample.valid) return {};
        const bool is_range = scene.depth.semantics == DepthSemantics::range;
        return ray(x, y) * (is_range ? sample.depth / scene.camera.ray_length(x, y) : sample.depth);
    };
    Faces sum;
    for (int y = top; y < top + block_side; ++y)
        for (int x = left; x < left + block_side; ++x) {
            const auto here = point(x, y), beside = point(x + 1, y), below = point(x, y + 1);
            if (!here || !beside || !below) continue;
            sum.normal += glm::normalize(glm::cross(*below - *here, *beside - *here));
            sum.q -= 1 / here->z;
            ++sum.count;
        }
    return sum;
}

/// `strip`: rows of blocks of which the middle one stands for all.
void expect_twin(const Scene& scene, const SurfaceFrame& frame, int strip = 1) {
    const ErrorSigns& signs = frame.signs;
    const int rows = (scene.height - 1) / block_side;
    ASSERT_EQ(signs.columns, (scene.width - 1) / block_side);
    ASSERT_EQ(signs.blocks.size(), static_cast<std::size_t>(signs.columns) * static_cast<std::size_t>(rows));
    const int strips = (rows + strip - 1) / strip;
    const auto row_of = [&](int s) { return std::min(s * strip + strip / 2, rows - 1); };
    std::vector<Faces> blocks;
    for (int s = 0; s < strips; ++s)
        for (int column = 0; column < signs.columns; ++column)
            blocks.push_back(faces_of(scene, frame, column * block_side, row_of(s) * block_side));
    const int bend_step = std::max(1, static_cast<int>(std::sqrt(signs.columns * strips / 3000.0)));
    std::vector<double> bends;
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < signs.columns; ++column) {
            const auto around = [&](int reach, int far, double weight = 1) {
                const int middle = row / strip;
                glm::dvec3 sum(0.0);
                for (int r = std::max(middle - far, 0); r <= std::min(middle + far, strips - 1); ++r)
                    for (int c = std::max(column - reach, 0);
                         c <= std::min(column + reach, signs.columns - 1); ++c)
                        sum += (r == middle ? weight : 1) * blocks[pixel_place(c, r, signs.columns)].normal;
                return glm::normalize(sum);
            };
            SCOPED_TRACE(::testing::Message() << "block " << column << ", " << row);
            const ErrorSigns::Block& block = signs.blocks[pixel_place(column, row, signs.columns)];
            const Faces here = blocks[pixel_place(column, row / strip, signs.columns)];
            if (here.count == 0) {
                ASSERT_EQ(block.depth, 0);
                continue;
            }
            const double depth = here.count / here.q;
            ASSERT_NEAR(block.depth, depth, 1e-4 * depth);
            // A float's rounding grows with a face's distance to the picture's middle.
            ASSERT_NEAR(block.scatter, 2 - 2 * glm::length(here.normal) / here.count, 1.25e-7 * scene.width);
            const glm::dvec3 mean = glm::normalize(here.normal);
            ASSERT_NEAR(block.lean, glm::distance(mean, around(1, 1, strip > 1 ? 4 : 1)), 1e-4);
            const double x = column * block_side + 2, y = row_of(row / strip) * block_side + 2;
            const double cosine =
                glm::dot(mean, glm::normalize(glm::dvec3((x - scene.camera.cx) / scene.camera.fx,
                                                         (scene.camera.cy - y) / scene.camera.fy, -1)));
            const double turn = cosine * cosine * scene.camera.fx / depth;
            ASSERT_NEAR(block.turn, turn, 1e-3 * turn);
            if (row % (strip * bend_step) != 0 || column % bend_step != 0) continue;
            if (here.count < 15 || cosine * cosine < 0.04) continue;
            bends.push_back(glm::distance(around(2, (strip + 1) / strip), around(8, (strip + 7) / strip)) /
                            turn);
        }
    ASSERT_GE(bends.size(), 100u);
    const double bend =
        sorted_element(bends, static_cast<std::size_t>(0.15 * static_cast<double>(bends.size())));
    EXPECT_NEAR(signs.bend, bend, 1e-3 * bend);
}

double half_of_bars(const SurfaceFrame& frame) {
    std::vector<double> bars;
    for (const ErrorSigns::Block& block : frame.signs.blocks) bars.push_back(frame.signs.bar(block).degrees);
    return sorted_element(bars, bars.size() / 2);
}

TEST(ErrorBars, AreThoseOfThePlainDefinition) {
    for (const auto semantics : {DepthSemantics::planar, DepthSemantics::range})
        for (const int hole_every : {0, 40}) {
            SCOPED_TRACE(hole_every);
            Scene scene = wavy_scene();
            scene.depth.semantics = semantics;
            expect_twin(scene, measured(scene, 3, hole_every)->frame);
        }
}

TEST(ErrorBars, OfLargePicturesAreMeasuredInStrips) {
    for (const auto& [height, strip] : {std::pair{863, 1}, {864, 2}, {1297, 3}}) {
        SCOPED_TRACE(height);
        const Scene scene = wavy_scene(1600, height);
        expect_twin(scene, measured(scene, 0.5, 40)->frame, strip);
    }
}

TEST(ErrorBars, AreTheSameForAllBuilders) {
    const Scene scene = wavy_scene();
    const auto codes = wavy(scene, 2, 30, 7);
    const auto by_cpu = measured(scene, codes, make_cpu_builder(scene));
    const auto other = measured(scene, codes, make_reference_builder(scene));
    const ErrorSigns &ones = by_cpu->frame.signs, &others = other->frame.signs;
    ASSERT_EQ(others.blocks.size(), ones.blocks.size());
    EXPECT_EQ(others.bend, ones.bend);
    for (std::size_t k = 0; k < ones.blocks.size(); ++k) {
        const ErrorBar one = ones.bar(ones.blocks[k]), two = others.bar(others.blocks[k]);
        if (std::isnan(one.degrees) && std::isnan(two.degrees)) continue;
        ASSERT_EQ(one.degrees, two.degrees) << k;
        ASSERT_EQ(one.depth, two.depth) << k;
    }
}

TEST(ErrorBars, GrowWithNoise) {
    const Scene scene = wavy_scene();
    const auto bars = [&](double noise) {
        return half_of_bars(measured(scene, wavy(scene, noise, 0, 5, 0), make_cpu_builder(scene))->frame);
    };
    EXPECT_LT(bars(0), 2);
    EXPECT_GT(bars(0.1), 2 * bars(0));
    EXPECT_GT(bars(1), 4 * bars(0.1));
}

TEST(ErrorBars, EndAtHalfATurnAndAllOfTheDepth) {
    ErrorSigns signs;
    signs.bend = 10;  // of a noisy background, which says little of what is near
    const ErrorBar bar = signs.bar({.depth = 3, .scatter = 0.1F, .lean = 0.1F, .turn = 100});
    EXPECT_EQ(bar.degrees, 180);
    EXPECT_EQ(bar.depth, 3);
}

/// The frame comes nearer and goes away by itself, or moves steadily.
TEST(ErrorBars, KnowDriftFromMotion) {
    const Scene scene = wavy_scene(200, 200);
    const auto drift_of = [&](double drift, double motion, int left_out = -1) {
        const auto builder = with_error_bars(make_cpu_builder(scene), scene);
        SurfaceFrame frame;
        for (int n = 0; n < 24; ++n) {
            if (n % 3 == left_out) continue;
            auto codes = wavy(scene, 0, 0, 5);
            const double factor = 1 + motion * n + drift * (n % 2 == 0 ? 1 : -1);
            for (auto& code : codes) code = static_cast<std::uint16_t>(factor * code);
            const StoredPlane plane = store_plane(scene.width, scene.height, codes, {});
            RawFrame raw = plane.frame();
            raw.number = n;
            EXPECT_TRUE(builder->build(raw, frame));
        }
        return frame.signs.drift;
    };
    EXPECT_LT(drift_of(0, 0), 1e-5);
    EXPECT_LT(drift_of(0, 0.003), 2e-4);
    EXPECT_LT(drift_of(0, 0.003, 1), 2e-4) << "frames are left out";
    const double drift = drift_of(0.002, 0);
    EXPECT_GT(drift, 0.002);
    EXPECT_LT(drift, 0.005);
    EXPECT_NEAR(drift_of(0.002, 0.003), drift, 5e-4);
}

TEST(ErrorBars, ForgetDriftAfterSeek) {
    const Scene scene = wavy_scene(200, 200);
    const auto builder = with_error_bars(make_cpu_builder(scene), scene);
    SurfaceFrame frame;
    const auto build = [&](std::uint64_t epoch, std::int64_t number, double factor) {
        auto codes = wavy(scene, 0, 0, 5);
        for (auto& code : codes) code = static_cast<std::uint16_t>(factor * code);
        const StoredPlane plane = store_plane(scene.width, scene.height, codes, {});
        RawFrame raw = plane.frame();
        raw.epoch = epoch;
        raw.number = number;
        EXPECT_TRUE(builder->begin(raw));
        EXPECT_TRUE(builder->finish(frame));
    };
    for (int n = 0; n < 8; ++n) build(0, n, 1);
    for (int n = 0; n < 8; ++n) build(1, 100 + n, 1.01);
    EXPECT_LT(frame.signs.drift, 1e-5);
    for (int n = 0; n < 8; ++n) build(1, n, 1);
    EXPECT_LT(frame.signs.drift, 1e-5) << "of an earlier number";
    for (int n = 8; n < 16; ++n) build(1, n, n % 2 == 0 ? 1 : 1.01);
    EXPECT_GT(frame.signs.drift, 1e-3);
    build(2, 16, 1);
    EXPECT_EQ(frame.signs.drift, 0);
}

TEST(ErrorBars, AreNotKnownWithoutSurface) {
    for (const auto& [width, height] : {std::pair{1, 1}, {5, 5}, {6, 6}, {1, 90}, {90, 1}, {90, 90}}) {
        const Scene scene = metric_scene(width, height, {100, 100, 0.5 * width, 0.5 * height}, 6000);
        const std::vector<std::uint16_t> holes(static_cast<std::size_t>(width) *
                                               static_cast<std::size_t>(height));
        const auto made = measured(scene, holes, make_cpu_builder(scene));
        for (const double x : {0.0, -1e300, 1e300, std::nan("")})
            EXPECT_TRUE(std::isnan(made->frame.signs.bar_at(x, 0).degrees));
        EXPECT_FALSE(made->frame.signs.block_at(std::nan(""), 0));
    }
    EXPECT_FALSE(SurfaceFrame().signs.block_at(0, 0));
}

/// The lazy builder filters a pixel when it is read: measuring would filter all of them.
TEST(ErrorBars, AreNotKnownOfLazyFrames) {
    const Scene scene = wavy_scene();
    const auto codes = wavy(scene, 2, 30, 7);
    const StoredPlane plane = store_plane(scene.width, scene.height, codes, {});
    SurfaceFrame slot;
    ASSERT_TRUE(with_error_bars(make_cpu_builder(scene), scene)->build(plane.frame(), slot));
    EXPECT_TRUE(slot.signs.block_at(80, 60));
    ASSERT_TRUE(with_error_bars(make_lazy_builder(scene), scene)->build(plane.frame(), slot));
    EXPECT_FALSE(slot.signs.block_at(80, 60));
}

/// A small picture has a surface, but too little of it to tell a camera's bend.
TEST(ErrorBars, AreNotKnownOfTooSmallPictures) {
    const Scene scene = wavy_scene(40, 40);
    const auto made = measured(scene, 1);
    EXPECT_TRUE(std::isnan(made->frame.signs.bar_at(20, 20).degrees));
}

TEST(ErrorBars, LeaveAFrameAsItIs) {
    const Scene scene = wavy_scene();
    const auto codes = wavy(scene, 2, 30, 9);
    const StoredPlane plane = store_plane(scene.width, scene.height, codes, {});
    SurfaceFrame plain;
    ASSERT_TRUE(make_cpu_builder(scene)->build(plane.frame(), plain));
    const auto barred = measured(scene, codes, make_cpu_builder(scene));
    EXPECT_TRUE(std::ranges::equal(plain.codes, barred->frame.codes));
    EXPECT_TRUE(std::ranges::equal(plain.validity, barred->frame.validity));
}

}  // namespace
}  // namespace touchable::test
