// SPDX-License-Identifier: Apache-2.0
// Organised clouds of points (PCD, PLY): depth, colour and the camera from a point for each pixel.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/formats/open_clip.hpp"
#include "engine/formats/organised_cloud.hpp"
#include "engine/scene/scene.hpp"
#include "tests/picture/results.hpp"

namespace touchable::test {
namespace {

constexpr int cloud_width = 16, cloud_height = 12;
constexpr double fx = 20.5, fy = 21, cx = 7.25, cy = 5.75;
using Point = std::array<double, 3>;
using Points = std::vector<Point>;

double cloud_depth(int i, int j) {
    return i == 3 && j == 2 ? std::nan("") : 1 + 0.01 * i + 0.02 * j * j;
}
/// Red, green, blue of a pixel.
std::uint32_t cloud_colour(int i, int j) {
    return static_cast<std::uint32_t>(i + 1) << 16 | static_cast<std::uint32_t>(j) << 8 | 200U;
}

/// Row by row. OpenGL's frame has y up and z backwards.
Points points(bool of_opengl = false) {
    const double sign = of_opengl ? -1 : 1;
    Points all;
    for (int j = 0; j < cloud_height; ++j)
        for (int i = 0; i < cloud_width; ++i) {
            const double z = cloud_depth(i, j);
            all.push_back({(i - cx) / fx * z, sign * (j - cy) / fy * z, sign * z});
        }
    return all;
}

/// A number's bytes, the lowest first, or the highest.
template <class Number>
std::string bytes_of(Number number, bool big_endian = false) {
    std::string bytes(reinterpret_cast<const char*>(&number), sizeof number);
    if (big_endian) std::ranges::reverse(bytes);
    return bytes;
}

std::string pcd_header(const std::string& data, const std::string& fields = "x y z rgb") {
    return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS " + fields +
           "\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH 16\nHEIGHT 12\nVIEWPOINT 0 0 0 1 0 0 0\n"
           "POINTS 192\nDATA " +
           data + '\n';
}

std::uint32_t colour_of(std::size_t k) {
    return cloud_colour(static_cast<int>(k) % cloud_width, static_cast<int>(k) / cloud_width);
}

std::string pcd_text(const Points& all) {
    std::string text = pcd_header("ascii");
    for (std::size_t k = 0; k < all.size(); ++k) {
        for (const double number : all[k]) text += std::to_string(number) + ' ';
        text += std::to_string(colour_of(k)) + '\n';
    }
    return text;
}

std::string pcd_binary(const Points& all) {
    std::string bytes = pcd_header("binary");
    for (std::size_t k = 0; k < all.size(); ++k) {
        for (const double number : all[k]) bytes += bytes_of(static_cast<float>(number));
        bytes += bytes_of(colour_of(k));
    }
    return bytes;
}

/// Fields one behind the other, packed by LZF: literals, and where a byte is the one before, references.
std::string pcd_packed(const Points& all) {
    std::string planes;
    for (const std::size_t axis : {0U, 1U, 2U})
        for (const Point& point : all) planes += bytes_of(static_cast<float>(point[axis]));
    for (std::size_t k = 0; k < all.size(); ++k) planes += bytes_of(colour_of(k));
    planes.resize(planes.size() - 4);
    std::string packed;
    for (std::size_t at = 0; at < planes.size(); at += 32) {
        const std::string some = planes.substr(at, 32);
        packed += static_cast<char>(some.size() - 1) + some;
    }
    packed += std::string("\x20\x03", 2);  // 3 bytes again, of 4 before
    packed += std::string("\0\0", 2);      // and one, 0
    return pcd_header("binary_compressed") + bytes_of(static_cast<std::uint32_t>(packed.size())) +
           bytes_of(static_cast<std::uint32_t>(planes.size() + 4)) + packed;
}

std::string ply_header(const std::string& format, const std::string& size, std::size_t count,
                       const std::string& type, const std::string& more = "") {
    std::string text = "ply\nformat " + format + " 1.0\n" + size + "element vertex " + std::to_string(count);
    for (const char* axis : {"x", "y", "z"}) text += "\nproperty " + type + ' ' + axis;
    for (const char* colour : {"red", "green", "blue"}) text += std::string("\nproperty uchar ") + colour;
    return text + '\n' + more + "end_header\n";
}

const std::string num_cols = "obj_info num_cols 16\nobj_info num_rows 12\n",
                  comments = "comment width 16\ncomment height 12\n",
                  grid_of_points = "element range_grid 192\nproperty list uchar int vertex_indices\n";

std::string ply_colour(std::size_t k) {
    const std::uint32_t rgb = colour_of(k);
    return {static_cast<char>(rgb >> 16), static_cast<char>(rgb >> 8), static_cast<char>(rgb)};
}

template <class Number>
std::string ply_binary(const Points& all, bool big_endian, const std::string& size) {
    std::string bytes = ply_header(big_endian ? "binary_big_endian" : "binary_little_endian", size,
                                   all.size(), sizeof(Number) == 8 ? "double" : "float32");
    for (std::size_t k = 0; k < all.size(); ++k) {
        for (const double number : all[k]) bytes += bytes_of(static_cast<Number>(number), big_endian);
        bytes += ply_colour(k);
    }
    return bytes;
}

std::string ply_text(const Points& all) {
    std::string text = ply_header("ascii", num_cols, all.size(), "float");
    for (std::size_t k = 0; k < all.size(); ++k) {
        for (const double number : all[k]) text += std::to_string(number) + ' ';
        for (const char colour : ply_colour(k))
            text += std::to_string(static_cast<unsigned char>(colour)) + ' ';
        text += '\n';
    }
    return text;
}

/// Only pixels with depth have a point, and a list says which.
std::string ply_range_grid(const Points& all) {
    std::string seen, grid;
    std::int32_t count = 0;
    for (std::size_t k = 0; k < all.size(); ++k) {
        if (std::isnan(all[k][2])) {
            grid += '\0';
            continue;
        }
        for (const double number : all[k]) seen += bytes_of(static_cast<float>(number));
        seen += ply_colour(k);
        grid += '\1' + bytes_of(count++);
    }
    return ply_header("binary_little_endian", num_cols, static_cast<std::size_t>(count), "float",
                      grid_of_points) +
           seen + grid;
}

/// The last row first.
Points from_below(const Points& all) {
    Points turned;
    for (int j = cloud_height; j-- > 0;)
        turned.insert(turned.end(), all.begin() + j * cloud_width, all.begin() + (j + 1) * cloud_width);
    return turned;
}

void expect_camera(const Scene& scene) {
    EXPECT_NEAR(scene.camera.fx, fx, 0.01);
    EXPECT_NEAR(scene.camera.fy, fy, 0.01);
    EXPECT_NEAR(scene.camera.cx, cx, 0.01);
    EXPECT_NEAR(scene.camera.cy, cy, 0.01);
}

void expect_depth(const Scene& scene, const RawFrame& frame) {
    for (int j = 0; j < cloud_height; ++j)
        for (int i = 0; i < cloud_width; ++i) {
            const auto code = frame.depth.sample(i, j);
            ASSERT_EQ(scene.depth.is_valid(code), !std::isnan(cloud_depth(i, j)));
            if (std::isnan(cloud_depth(i, j))) continue;
            ASSERT_NEAR(scene.depth.depth(code) * scene.metres_per_unit, cloud_depth(i, j), 1e-3);
        }
}

using OrganisedCloud = FolderTest;

TEST_F(OrganisedCloud, GivesDepthColourAndCamera) {
    const std::pair<const char*, std::string> all[] = {
        {"text.pcd", pcd_text(points())},
        {"binary.pcd", pcd_binary(points())},
        {"packed.pcd", pcd_packed(points())},
        {"opengl.pcd", pcd_binary(points(true))},
        {"text.ply", ply_text(points())},
        {"little.ply", ply_binary<float>(points(), false, comments)},
        {"big.ply", ply_binary<double>(points(), true, num_cols)},
        {"grid.ply", ply_range_grid(points(true))},
    };
    for (const auto& [name, bytes] : all) {
        SCOPED_TRACE(name);
        write_bytes(folder / name, bytes);
        auto reader = must(open_clip(folder / name));
        EXPECT_TRUE(is_noted(*reader, std::string("the camera is that of ") + name));
        const auto frames = must(read_all(*reader));
        ASSERT_EQ(frames.size(), 1U);
        expect_camera(reader->scene());
        expect_depth(reader->scene(), frames.front());
        const PlaneView& colour = frames.front().colour;
        ASSERT_FALSE(colour.empty());
        for (const auto& [i, j] : {std::pair{0, 0}, {15, 0}, {5, 7}, {14, 11}})
            for (int channel = 0; channel < 3; ++channel)
                EXPECT_EQ(colour.sample(i, j, channel), cloud_colour(i, j) >> (16 - 8 * channel) & 255U);
    }
}

TEST_F(OrganisedCloud, TurnsRowsFromBelow) {
    write_bytes(folder / "cloud.ply", ply_binary<float>(from_below(points(true)), false, num_cols));
    const auto [reader, frames] = must_read(open_clip(folder / "cloud.ply"));
    expect_camera(reader->scene());
    expect_depth(reader->scene(), frames.front());
}

TEST_F(OrganisedCloud, TakesStatedCamera) {
    write_bytes(folder / "cloud.pcd", pcd_binary(points()));
    const auto reader = must(open_clip(
        folder / "cloud.pcd", {}, stated(&SourceDescription::intrinsics, Intrinsics{.fx = 30, .fy = 31})));
    EXPECT_DOUBLE_EQ(reader->scene().camera.fx, 30);
    EXPECT_FALSE(is_noted(*reader, "the camera is that of cloud.pcd"));
}

/// The first one has no point.
TEST_F(OrganisedCloud, OpensSeveralAsFrames) {
    write_bytes(folder / "cloud_0.pcd", pcd_binary(Points(cloud_width * cloud_height, Point{0, 0, 0})));
    for (const char* name : {"cloud_1.pcd", "cloud_2.pcd"}) write_bytes(folder / name, pcd_binary(points()));
    // A mesh is none, nor does it keep the others from being opened.
    write_bytes(folder / "depth_mesh.ply",
                "ply\nformat ascii 1.0\nelement vertex 3\nelement face 1\nend_header\n");
    auto reader = must(open_clip(folder.path()));
    EXPECT_TRUE(is_noted(*reader, "depth is cloud_*.pcd, colour is in the same files"));
    EXPECT_TRUE(is_noted(*reader, "the camera is that of cloud_0.pcd"));
    const auto frames = must(read_all(*reader));
    ASSERT_EQ(frames.size(), 3U);
    expect_camera(reader->scene());
    expect_depth(reader->scene(), frames[2]);
}

/// A cloud that was made of them, of the same number of frames, is not read in their place.
TEST_F(OrganisedCloud, GivesWayToPictures) {
    for (const char* name : {"0", "1"}) {
        write_in_folder(folder / (std::string(name) + ".png"), even_image(16, 12, 2, 1, 771));
        write_bytes(folder / (std::string("a") + name + ".pcd"), pcd_binary(points()));
    }
    const auto reader = must(open_clip(folder.path()));
    EXPECT_TRUE(is_noted(*reader, "depth is *.png"));
}

TEST_F(OrganisedCloud, RefusesDamage) {
    const auto refusal = [](const std::string& bytes) { return message(decode_organised_cloud(bytes, "c")); };
    const std::string binary = pcd_binary(points()), packed = pcd_packed(points()), text = pcd_text(points()),
                      ply = ply_binary<float>(points(), false, num_cols), grid = ply_range_grid(points()),
                      ply_words = ply_text(points());
    const auto with = [](std::string bytes, const std::string& old, const std::string& other) {
        return bytes.replace(bytes.find(old), old.size(), other);
    };
    for (const std::string& whole : {binary, packed, text, ply, grid, ply_words}) {
        EXPECT_EQ(refusal(whole), "");
        EXPECT_TRUE(
            has_words(refusal(whole.substr(0, whole.size() - 25)), "has fewer points than its header"))
            << refusal(whole.substr(0, whole.size() - 25));
    }
    std::string none = ply_header("ascii", num_cols, 0, "float", grid_of_points) + '0';
    for (std::size_t k = 1; k < points().size(); ++k) none += " 0";
    EXPECT_EQ(refusal(none), "") << "no pixel has a point, and the last one ends the file";
    const std::pair<std::string, const char*> damaged[] = {
        {pcd_header("binary", "x y w rgb"), "has no fields x, y and z"},
        {with(binary, "TYPE F", "TYPE Q"), "has no fields x, y and z"},
        {with(binary, "SIZE 4", "SIZE 3"), "has no fields x, y and z"},
        {pcd_header("ascii2"), "are \"ascii2\""},
        {"# .PCD v0.7\nWIDTH 2", "its header is not that of a PCD file"},
        {with(binary, "POINTS 192", "POINTS 191"), "has 191 points: must be 192"},
        {with(binary, "WIDTH 16", "WIDTH 99999999"), "is 99999999x12 pixels"},
        {with(with(binary, "WIDTH 16", "WIDTH 16384"), "POINTS 192", "#"), "has fewer points"},
        {with(with(packed, "WIDTH 16", "WIDTH 9216"), "POINTS 192", "#"), "are said to unpack to 3072 bytes"},
        {with(text, "DATA ascii\n", "DATA ascii\ntwo "), "point 0 has \"two\": must be a number"},
        {with(ply, "element vertex 192", "element vertex 191"), "its header is not that of a PLY"},
        {with(ply, "format binary_little_endian", "format text"), "its format is \"text\""},
        {with(ply, "property float32 z", "property float32 w"), "have no x, y and z"},
        {with(grid, "element range_grid 192", "element range_grid 193"), "its header is not that of a PLY"},
        {grid.substr(0, grid.size() - 4) + std::string(4, '\x7f'), "pixel 191 has point 2139062143 of 191"},
    };
    for (const auto& [bytes, why] : damaged) EXPECT_TRUE(has_words(refusal(bytes), why));
    std::string bad = packed;
    bad[bad.size() - 3] = '\x7f';  // what is so far back is not there, or not what follows
    bad[bad.size() - 4] = '\x3f';
    EXPECT_TRUE(has_words(refusal(bad), "cannot be unpacked"));
    // A gigabyte is stated of a few bytes.
    std::string bomb = pcd_header("binary_compressed");
    bomb = with(with(with(bomb, "WIDTH 16", "WIDTH 8192"), "HEIGHT 12", "HEIGHT 8192"), "POINTS 192", "#");
    bomb += bytes_of(std::uint32_t{64}) + bytes_of(std::uint32_t{1} << 30) + std::string(64, '\0');
    EXPECT_TRUE(has_words(refusal(bomb), "is damaged, or too large"));
}

/// Even steps of an angle, as of a lidar; and rays that are parallel.
TEST_F(OrganisedCloud, RefusesOtherCameras) {
    Points ring = points(), parallel = points();
    for (std::size_t k = 0; k < ring.size(); ++k) {
        const auto column = static_cast<double>(k % cloud_width), row = static_cast<double>(k / cloud_width);
        const double angle = column * 2 * 3.14159265 / cloud_width;
        ring[k] = {std::sin(angle), row, std::cos(angle) + 0.01};
        parallel[k] = {column, row, 1 + static_cast<double>(k * k % 17)};
    }
    for (const Points& all : {ring, parallel}) {
        const std::string said = message(decode_organised_cloud(pcd_binary(all), "c"));
        EXPECT_TRUE(has_words(said, "not the pixels of one pinhole camera"));
        EXPECT_TRUE(has_words(said, "project_to_depth_image"));
    }
}

}  // namespace
}  // namespace touchable::test
