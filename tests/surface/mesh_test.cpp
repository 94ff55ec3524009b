// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>

#include "engine/surface/surface_builder.hpp"
#include "tests/must.hpp"
#include "tests/surface/pictures.hpp"
#include "tests/temporary_files.hpp"

namespace touchable::test {
namespace {

struct Built {
    Scene scene;
    StoredPlane plane;
    std::vector<std::uint8_t> heights;
    SurfaceFrame frame;
    Mesh mesh;
};

/// A noisy picture with some holes, of ranges along the rays, with a height map in levels.
std::unique_ptr<Built> built(int width, int height, Fill fill, bool lazily = false) {
    auto made = std::make_unique<Built>();
    Scene& scene = made->scene = depth_scene(width, height, 16, Marking::zero, {3, 1});
    scene.camera = {1.3 * width, 1.1 * width, 0.45 * width, 0.6 * height};
    scene.height_coding = {20, HeightUnits::levels, 255};
    Random random(11);
    made->plane = store_plane(width, height, fill_picture(scene, fill, random), {});
    for (int n = 0; n < width * height; ++n)
        made->heights.push_back(static_cast<std::uint8_t>(random.below(256)));
    RawFrame raw = made->plane.frame();
    raw.height = {made->heights.data(), width, width, height, 1, 1};
    const auto builder = lazily ? make_lazy_builder(scene) : make_cpu_builder(scene);
    EXPECT_TRUE(builder->build(raw, made->frame));
    made->mesh = make_mesh(made->frame, scene);
    return made;
}

TEST(Mesh, UsesEveryValidPixel) {
    const auto whole = built(21, 13, Fill::random);
    EXPECT_EQ(whole->mesh.positions.size(), 21u * 13u);
    EXPECT_EQ(whole->mesh.triangles.size(), 2u * 20u * 12u);
    EXPECT_EQ(built(1, 1, Fill::random)->mesh.positions.size(), 1u);
    EXPECT_EQ(built(1, 9, Fill::random)->mesh.triangles.size(), 0u);
    EXPECT_EQ(built(9, 9, Fill::all_invalid)->mesh.positions.size(), 0u);
}

TEST(Mesh, CutsCellsAlongDiagonal) {
    const auto one = built(2, 2, Fill::random);  // pixels 0 1 / 2 3
    const std::vector<std::array<std::uint32_t, 3>> expected = {{0, 2, 3}, {0, 3, 1}};
    EXPECT_EQ(one->mesh.triangles, expected);
    EXPECT_EQ(one->mesh.pixels, (std::vector<std::uint32_t>{0, 1, 2, 3}));
}

TEST(Mesh, OmitsCellsWithInvalidVertex) {
    const auto holed = built(40, 30, Fill::many_holes);
    const SurfaceFrame& frame = holed->frame;
    std::size_t cells = 0, valid = 0;
    for (int y = 0; y < 30; ++y)
        for (int x = 0; x < 40; ++x) {
            valid += frame.is_valid(x, y);
            cells += x < 39 && y < 29 && frame.is_valid(x, y) && frame.is_valid(x + 1, y) &&
                     frame.is_valid(x, y + 1) && frame.is_valid(x + 1, y + 1);
        }
    ASSERT_GT(cells, 10u);
    ASSERT_LT(cells, 900u);
    EXPECT_EQ(holed->mesh.triangles.size(), 2 * cells);
    EXPECT_EQ(holed->mesh.positions.size(), valid);
    for (const auto& triangle : holed->mesh.triangles) {
        for (const std::uint32_t vertex : triangle) {
            ASSERT_LT(vertex, holed->mesh.positions.size());
            const int pixel = static_cast<int>(holed->mesh.pixels[vertex]);
            EXPECT_TRUE(frame.is_valid(pixel % 40, pixel / 40));
        }
        // A triangle's pixels lie in one cell.
        const auto& pixels = holed->mesh.pixels;
        const std::uint32_t across = pixels[triangle[0]] + 41;
        EXPECT_TRUE(pixels[triangle[1]] == across || pixels[triangle[2]] == across);
    }
}

TEST(Mesh, FacesTheCamera) {
    const auto noisy = built(40, 30, Fill::few_holes);
    ASSERT_GT(noisy->mesh.triangles.size(), 500u);
    for (const auto& [a, b, c] : noisy->mesh.triangles) {
        const auto& p = noisy->mesh.positions;
        const glm::dvec3 normal = glm::cross(p[b] - p[a], p[c] - p[a]);
        ASSERT_LT(glm::dot(normal, p[a]), 0) << "the camera is at the origin";
    }
}

// In long double and straight from the paper's formulas: Eq. 3 for the range, Eq. 2 for the height.
TEST(Mesh, FollowsItsCodes) {
    const auto noisy = built(40, 30, Fill::few_holes);
    const Camera& camera = noisy->scene.camera;
    long higher = 0;
    for (std::size_t n = 0; n < noisy->mesh.positions.size(); ++n) {
        const auto pixel = noisy->mesh.pixels[n];
        const long double x = pixel % 40, y = pixel / 40;
        const long double near = 500, far = 1500;
        const long double level = (far - near) / 255;
        long double range = far + (near - far) * noisy->frame.codes[pixel] / 65535;
        range -= 20 * (noisy->heights[pixel] / 255.0L) * level;
        higher += noisy->heights[pixel] > 0;
        const long double right = (x - camera.cx) / camera.fx, up = (camera.cy - y) / camera.fy;
        const long double planar = range / std::sqrt(right * right + up * up + 1);
        EXPECT_NEAR(noisy->mesh.positions[n].x, static_cast<double>(planar * right), 1e-9);
        EXPECT_NEAR(noisy->mesh.positions[n].y, static_cast<double>(planar * up), 1e-9);
        EXPECT_NEAR(noisy->mesh.positions[n].z, static_cast<double>(-planar), 1e-9);
    }
    EXPECT_GT(higher, 500);
}

TEST(Mesh, EqualsLazyFramesMesh) {
    const auto whole = built(40, 30, Fill::half_holes), lazy = built(40, 30, Fill::half_holes, true);
    EXPECT_TRUE(lazy->frame.codes.empty());
    EXPECT_EQ(lazy->mesh.positions, whole->mesh.positions);
    EXPECT_EQ(lazy->mesh.pixels, whole->mesh.pixels);
    EXPECT_EQ(lazy->mesh.triangles, whole->mesh.triangles);
    EXPECT_GT(whole->mesh.triangles.size(), 100u);
}

/// A PLY file with its name.
Result<void> write_mesh(const std::filesystem::path& name, const Mesh& mesh, const PlaneView& colour = {}) {
    NewFile file(name);
    auto written = write_ply(file, mesh, colour);
    return written ? file.commit() : written;
}

class MeshFile : public testing::Test {
protected:
    std::vector<std::string> files() const {
        std::vector<std::string> names;
        for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
            names.push_back(entry.path().filename());
        return names;
    }
    std::string content(const char* name) const {
        std::ifstream stream(folder_ / name, std::ios::binary);
        std::ostringstream text;
        text << stream.rdbuf();
        return text.str();
    }

    const TemporaryFolder folder_;
};

/// Pixels 0, 1, 2 and 3 of a 2x2 picture, the last one invalid, with a triangle all the same.
Mesh small_mesh() {
    Mesh mesh;
    mesh.width = mesh.height = 2;
    mesh.positions = {{-1.5, 2.25, -1000.1}, {0.1, -0.2, -3e-7}, {12345.678, 0, -99}};
    mesh.pixels = {0, 1, 2};
    mesh.triangles = {{0, 2, 1}};
    return mesh;
}

constexpr std::uint8_t colours[] = {10, 20, 30, 40, 50, 60, 70, 80, 90, 100, 110, 120};
const PlaneView colour{colours, 6, 2, 2, 1, 3};

template <class T>
T take(const std::string& bytes, std::size_t& position) {
    T value{};  // this test runs where low bytes come first
    if (position + sizeof(T) <= bytes.size()) std::memcpy(&value, bytes.data() + position, sizeof(T));
    position += sizeof(T);
    return value;
}

void expect_file(const std::string& bytes, bool coloured) {
    std::string header = "ply\nformat binary_little_endian 1.0\n";
    header += "comment scene units; X right, Y up, camera at the origin looking along -Z\nelement vertex 3\n";
    for (const char* axis : {"x", "y", "z"}) header += std::string("property float ") + axis + "\n";
    if (coloured) header += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    header += "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    ASSERT_EQ(bytes.substr(0, header.size()), header);
    std::size_t position = header.size();
    const Mesh mesh = small_mesh();
    for (std::size_t n = 0; n < 3; ++n) {
        for (int axis = 0; axis < 3; ++axis)
            EXPECT_EQ(take<float>(bytes, position), static_cast<float>(mesh.positions[n][axis]));
        if (!coloured) continue;
        for (std::size_t channel = 0; channel < 3; ++channel)
            EXPECT_EQ(take<std::uint8_t>(bytes, position), colours[3 * n + channel]);
    }
    EXPECT_EQ(take<std::uint8_t>(bytes, position), 3);
    for (const std::int32_t vertex : {0, 2, 1}) EXPECT_EQ(take<std::int32_t>(bytes, position), vertex);
    EXPECT_EQ(position, bytes.size());
}

TEST_F(MeshFile, HoldsFloatsAndColours) {
    ASSERT_TRUE(write_mesh(folder_ / "mesh.ply", small_mesh(), colour));
    expect_file(content("mesh.ply"), true);
    EXPECT_EQ(files(), std::vector<std::string>{"mesh.ply"});
}

TEST_F(MeshFile, ReplacesOlderFile) {
    std::ofstream(folder_ / "mesh.ply") << "old";
    ASSERT_TRUE(write_mesh(folder_ / "mesh.ply", small_mesh()));
    expect_file(content("mesh.ply"), false);
    EXPECT_EQ(files(), std::vector<std::string>{"mesh.ply"});
}

TEST_F(MeshFile, SpansWriterBlocks) {
    Mesh mesh;
    mesh.width = 100000;
    mesh.height = 1;
    for (std::uint32_t n = 0; n < 100000; ++n) {
        mesh.positions.emplace_back(n, 0, -1);
        mesh.pixels.push_back(n);
    }
    ASSERT_TRUE(write_mesh(folder_ / "mesh.ply", mesh));
    const std::string bytes = content("mesh.ply");
    const std::size_t body = bytes.find("end_header\n") + 11;
    ASSERT_EQ(bytes.size(), body + 12u * 100000u);
    for (std::size_t n = 0; n < 100000; ++n) {
        std::size_t position = body + 12 * n;
        ASSERT_EQ(take<float>(bytes, position), static_cast<float>(n));
    }
}

TEST_F(MeshFile, LeavesNothingAfterFailure) {
    expect_error(write_mesh(folder_ / "no such folder" / "mesh.ply", small_mesh()), ErrorKind::input,
                 "no such folder/mesh.ply: cannot be written: No such file");

    std::filesystem::create_directories(folder_ / "taken" / "by a folder");
    EXPECT_FALSE(write_mesh(folder_ / "taken", small_mesh()));
    EXPECT_EQ(files(), std::vector<std::string>{"taken"});
}

TEST_F(MeshFile, RejectsMismatchedColours) {
    for (const PlaneView& wrong : {PlaneView{colours, 6, 1, 2, 1, 3}, PlaneView{colours, 6, 2, 1, 1, 3},
                                   PlaneView{colours, 6, 2, 2, 1, 1}, PlaneView{colours, 6, 1, 2, 2, 3}}) {
        expect_error(write_mesh(folder_ / "mesh.ply", small_mesh(), wrong), "2x2");
    }
    EXPECT_TRUE(files().empty());
}

}  // namespace
}  // namespace touchable::test
