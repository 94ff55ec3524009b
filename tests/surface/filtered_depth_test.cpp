// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <cmath>

#include "engine/surface/surface_builder.hpp"
#include "tests/must.hpp"
#include "tests/surface/pictures.hpp"

namespace touchable::test {
namespace {

constexpr FilterSettings median_and_holes{.median = 3, .fill_holes = 2},
    terraces_too{.median = 3, .terraces = TerraceRemoval::on, .levels = {0.01, 0}};

/// Stored again, filtered codes say the same of every pixel, whatever marks pixels without depth.
TEST(FilteredScene, CodesKeepTheirDepth) {
    for (const Marking marking : all_markings)
        for (const int bits : {8, 12, 16})
            for (const FilterSettings& filter : {FilterSettings{}, median_and_holes, terraces_too}) {
                const Scene scene = depth_scene(41, 23, bits, marking, filter);
                const StoredPlane plane = noisy_plane(scene, Fill::few_holes, 5);
                SurfaceFrame built, again;
                must(make_cpu_builder(scene)->build(plane.frame(), built));

                const Scene stored = filtered_scene(scene);
                must(validate(stored));
                std::vector<std::uint16_t> codes(built.codes.size());
                copy_codes(built, code_of_no_depth(stored.depth).value_or(0), codes.data());
                RawFrame raw;
                raw.depth = plane_of_codes(codes.data(), scene.width, scene.height);
                must(make_reference_builder(stored)->build(raw, again));
                for (int y = 0; y < scene.height; ++y)
                    for (int x = 0; x < scene.width; ++x) {
                        const DepthSample was = sample_of(built, x, y), is = sample_of(again, x, y);
                        ASSERT_EQ(is.valid, was.valid) << x << ", " << y;
                        ASSERT_EQ(is.depth, was.depth) << x << ", " << y;
                    }
            }
}

/// A plane through (0, 0, -1) with this normal, a wall 1 m behind it in the last columns, and a hole.
class Leaning : public ::testing::TestWithParam<DepthSemantics> {
protected:
    static constexpr int width = 48, height = 36, wall_from = 40, hole_x = 10, hole_y = 12;
    Leaning() : scene(metric_scene(width, height, {40, 44, 20.3, 15.1}, 0.65, 1e-5)) {
        scene.depth.far = 65535 * scene.depth.scale;
        scene.depth.semantics = GetParam();
        scene.metres_per_unit = 2;
        derive_valid_range(scene.depth);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const glm::dvec3 ray(scene.camera.u(x), scene.camera.v(y), -1);
                double depth = 0.2 * normal.z / -glm::dot(ray, normal);
                if (x >= wall_from) depth = 0.6;
                if (GetParam() == DepthSemantics::range && x < wall_from) depth *= glm::length(ray);
                const bool is_hole = x == hole_x && y == hole_y;
                codes.push_back(is_hole ? std::uint16_t{0} : scene.depth.code(depth));
            }
        RawFrame raw;
        raw.depth = plane_of_codes(codes.data(), width, height);
        must(with_error_bars(make_cpu_builder(scene), scene)->build(raw, frame));
    }
    /// Floats of all pixels, by a method of FilteredDepth, in rows with room between them.
    template <class Method>
    std::vector<float> floats(Method method, int channels) {
        FilteredDepth depth(scene);
        const auto row = static_cast<std::size_t>(channels * width), pitch = row + 5;
        std::vector<float> roomy(pitch * height, 7.0F), all;
        (depth.*method)(frame, FloatRows{roomy.data(), static_cast<std::ptrdiff_t>(pitch * sizeof(float))});
        for (std::size_t y = 0; y < height; ++y) {
            all.insert(all.end(), roomy.begin() + y * pitch, roomy.begin() + y * pitch + row);
            EXPECT_EQ(roomy[y * pitch + row], 7.0F);
        }
        return all;
    }

    const glm::dvec3 normal = glm::normalize(glm::dvec3(0.4, -0.3, 1));
    Scene scene;
    std::vector<std::uint16_t> codes;
    SurfaceFrame frame;
};

TEST_P(Leaning, NormalsAreThePlanesUpToItsEdge) {
    const std::vector<float> normals = floats(&FilteredDepth::normals, 3);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const float* const at = &normals[3 * frame.index(x, y)];
            if (x == hole_x && y == hole_y) {
                EXPECT_TRUE(std::isnan(at[0]) && std::isnan(at[1]) && std::isnan(at[2]));
            } else if (x < wall_from) {
                const double cosine = glm::dot(glm::dvec3(at[0], at[1], at[2]), normal);
                EXPECT_GT(cosine, std::cos(1.0 * 3.14159 / 180)) << x << ", " << y;
            }
        }
}

TEST_P(Leaning, MetresAndBarsAreEachPixels) {
    const std::vector<float> metres = floats(&FilteredDepth::metres, 1),
                             degrees = floats(&FilteredDepth::error_degrees, 1);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const DepthSample sample = sample_of(frame, x, y);
            const std::size_t k = frame.index(x, y);
            EXPECT_EQ(std::isnan(metres[k]), !sample.valid);
            if (!sample.valid) continue;
            EXPECT_EQ(metres[k], static_cast<float>(sample.depth * 2));
            const auto bar = static_cast<float>(frame.signs.bar_at(x, y).degrees);
            EXPECT_TRUE(degrees[k] == bar || (std::isnan(degrees[k]) && std::isnan(bar)));
        }
}

INSTANTIATE_TEST_SUITE_P(Semantics, Leaning,
                         ::testing::Values(DepthSemantics::planar, DepthSemantics::range));

}  // namespace
}  // namespace touchable::test
