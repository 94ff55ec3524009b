#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <sstream>

#include "engine/surface/surface_builder.hpp"
#include "tests/temporary_folder.hpp"

namespace touchable::test {
namespace {

/// A PLY file with its name.
Result<void> write_mesh(const std::filesystem::path& name, const Mesh& mesh, const PlaneView& colour = {},
                        PlyCoordinates coordinates = PlyCoordinates::single_precision) {
    NewFile file(name);
    auto written = write_ply(file, mesh, colour, coordinates);
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

template <class T>
void expect_file(const std::string& bytes, bool coloured, const std::string& type) {
    std::string header = "ply\nformat binary_little_endian 1.0\n";
    header += "comment scene units; X right, Y up, camera at the origin looking along -Z\nelement vertex 3\n";
    for (const char* axis : {"x", "y", "z"}) header += "property " + type + " " + axis + "\n";
    if (coloured) header += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    header += "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    ASSERT_EQ(bytes.substr(0, header.size()), header);
    std::size_t position = header.size();
    const Mesh mesh = small_mesh();
    for (std::size_t n = 0; n < 3; ++n) {
        for (int axis = 0; axis < 3; ++axis)
            EXPECT_EQ(take<T>(bytes, position), static_cast<T>(mesh.positions[n][axis]));
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
    expect_file<float>(content("mesh.ply"), true, "float");
    EXPECT_EQ(files(), std::vector<std::string>{"mesh.ply"});
}

TEST_F(MeshFile, HoldsDoublesToTheirLastBit) {
    ASSERT_TRUE(write_mesh(folder_ / "mesh.ply", small_mesh(), {}, PlyCoordinates::double_precision));
    expect_file<double>(content("mesh.ply"), false, "double");
}

TEST_F(MeshFile, ReplacesAnOlderOne) {
    std::ofstream(folder_ / "mesh.ply") << "old";
    ASSERT_TRUE(write_mesh(folder_ / "mesh.ply", small_mesh()));
    expect_file<float>(content("mesh.ply"), false, "float");
    EXPECT_EQ(files(), std::vector<std::string>{"mesh.ply"});
}

TEST_F(MeshFile, IsWholeBeyondOneBlockOfTheWriter) {
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

TEST_F(MeshFile, LeavesNothingBehindWhereItCannotBeWritten) {
    const Result<void> nowhere = write_mesh(folder_ / "no such folder" / "mesh.ply", small_mesh());
    ASSERT_FALSE(nowhere);
    EXPECT_EQ(nowhere.error().kind, ErrorKind::input);
    EXPECT_NE(nowhere.error().message.find("no such folder/mesh.ply: cannot be written: No such file"),
              std::string::npos)
        << nowhere.error().message;

    std::filesystem::create_directories(folder_ / "taken" / "by a folder");
    EXPECT_FALSE(write_mesh(folder_ / "taken", small_mesh()));
    EXPECT_EQ(files(), std::vector<std::string>{"taken"});
}

TEST_F(MeshFile, RefusesColoursOfAnotherPicture) {
    for (const PlaneView& wrong : {PlaneView{colours, 6, 1, 2, 1, 3}, PlaneView{colours, 6, 2, 1, 1, 3},
                                   PlaneView{colours, 6, 2, 2, 1, 1}, PlaneView{colours, 6, 1, 2, 2, 3}}) {
        const Result<void> refused = write_mesh(folder_ / "mesh.ply", small_mesh(), wrong);
        ASSERT_FALSE(refused);
        EXPECT_NE(refused.error().message.find("2x2"), std::string::npos) << refused.error().message;
    }
    EXPECT_TRUE(files().empty());
}

}  // namespace
}  // namespace touchable::test
