// The still surface that programs show which know no depth video.
#include "engine/formats/gltf_writer.hpp"

#include <cmath>

#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

/// Depth by a function of the pixel.
template <class Code>
FallbackMesh mesh_of(const Scene& scene, const Code& code) {
    Samples samples;
    for (int y = 0; y < scene.height; ++y)
        for (int x = 0; x < scene.width; ++x) samples.push_back(static_cast<std::uint8_t>(code(x, y)));
    RawFrame frame;
    frame.depth = {samples.data(), scene.width, scene.width, scene.height, 1, 1};
    return fallback_mesh(frame, scene);
}

TEST(FallbackMesh, VerticesLieWhereTheCameraSeesThem) {
    Scene scene = small_scene(300, 200);
    scene.depth.semantics = DepthSemantics::planar;
    const auto mesh = mesh_of(scene, [](int, int) { return 255; });  // near: 10 units, 10 mm
    EXPECT_EQ(mesh.positions.size(), 97U * 65U);
    EXPECT_EQ(mesh.triangles.size(), 2U * 96U * 64U);
    for (const auto& position : mesh.positions) EXPECT_FLOAT_EQ(position[2], -0.01F);
    EXPECT_FLOAT_EQ(mesh.positions.front()[0], -0.01F * 150 / 50);  // pixel 0 of a camera with cx 150, fx 50
    EXPECT_FLOAT_EQ(mesh.positions.front()[1], 0.01F * 100 / 50);
    EXPECT_NEAR(mesh.texture_places.back()[0], 299.5 / 300, 1e-6);
    for (const auto& [a, b, c] : mesh.triangles) {  // counter-clockwise
        const auto &p = mesh.positions[a], &q = mesh.positions[b], &r = mesh.positions[c];
        EXPECT_GT((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]), 0);
    }
}

TEST(FallbackMesh, NothingSpansAnEdgeOrAHole) {
    Scene scene = small_scene(96, 64);
    scene.depth.invalid_codes[0] = 0;
    scene.depth.invalid_code_count = 1;
    derive_valid_range(scene.depth);
    const auto mesh = mesh_of(scene, [](int x, int y) { return y < 8 ? 0 : x < 48 ? 250 : 20; });
    ASSERT_FALSE(mesh.triangles.empty());
    for (const auto& triangle : mesh.triangles) {
        int near = 0;
        for (const std::uint32_t corner : triangle) {
            const auto& [x, y, z] = mesh.positions[corner];
            near += std::hypot(x, y, z) < 0.05;
            EXPECT_GE(mesh.texture_places[corner][1], 8.0F / 64) << "in the hole";
        }
        EXPECT_TRUE(near == 0 || near == 3) << "across the edge";
    }
}

/// From the clip's own camera: each cell has its two triangles, and each vertex lies behind its place in the
/// picture.
TEST(FallbackMesh, LeavesNoGapAtSilhouettes) {
    const Scene scene = small_scene(96, 64);
    const auto mesh =
        mesh_of(scene, [](int x, int y) { return x > 30 && x < 60 && y > 20 && y < 50 ? 250 : 20; });
    EXPECT_EQ(mesh.triangles.size(), 2U * 95U * 63U);
    for (std::size_t k = 0; k < mesh.positions.size(); ++k) {
        const auto& [x, y, z] = mesh.positions[k];
        const double across = scene.camera.cx - scene.camera.fx * x / z,
                     down = scene.camera.cy + scene.camera.fy * y / z;
        EXPECT_NEAR(across, 96 * mesh.texture_places[k][0] - 0.5, 1e-3);
        EXPECT_NEAR(down, 64 * mesh.texture_places[k][1] - 0.5, 1e-3);
    }
}

TEST(FallbackMesh, AFrameWithoutDepthIsARectangle) {
    Scene scene = small_scene(20, 10);
    scene.depth.invalid_codes[0] = 7;
    scene.depth.invalid_code_count = 1;
    derive_valid_range(scene.depth);
    const auto mesh = mesh_of(scene, [](int, int) { return 7; });
    EXPECT_EQ(mesh.positions.size(), 4U);
    EXPECT_EQ(mesh.triangles.size(), 2U);
}

}  // namespace
}  // namespace touchable::test
