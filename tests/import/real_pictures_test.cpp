#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <sstream>

#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/real_data.hpp"

namespace touchable::test {
namespace {

/// What a person gets of real pictures, against an unprojection of the stored values written out here.
struct Wanted {
    double fx, fy, cx, cy;
    std::function<double(int x, int y)> depth;  ///< metres; 0: none
    double relative = 1e-6;                     ///< of integers; of floats half a code
};

void expect_points(const std::filesystem::path& file, const SourceDescription& known, const Wanted& wanted) {
    auto reader = open_clip(file, std::nullopt, known);
    ASSERT_EQ(message(reader), "");
    const auto frame = (*reader)->next();
    ASSERT_EQ(message(frame), "");
    const Scene& scene = (*reader)->scene();
    std::int64_t valid = 0;
    for (int y = 0; y < scene.height; ++y)
        for (int x = 0; x < scene.width; ++x) {
            const std::uint16_t code = stored_code((*frame)->depth, scene.depth, x, y);
            const double depth = wanted.depth(x, y);
            ASSERT_EQ(scene.depth.is_valid(code), depth > 0) << x << ", " << y << " stored " << code;
            if (depth == 0) continue;
            ++valid;
            const glm::dvec3 point =
                unproject(scene.camera, x, y, scene.depth.depth(code)) * scene.metres_per_unit;
            const double tolerance = wanted.relative * depth;
            ASSERT_NEAR(point.x, (x - wanted.cx) / wanted.fx * depth, tolerance) << x << ", " << y;
            ASSERT_NEAR(point.y, -(y - wanted.cy) / wanted.fy * depth, tolerance) << x << ", " << y;
            ASSERT_NEAR(point.z, -depth, tolerance) << x << ", " << y;
        }
    EXPECT_GT(valid, scene.width * scene.height / 2);
}

SourceDescription preset(const char* name) {
    SourceDescription known;
    known.preset = name;
    return known;
}

void expect_disparities_of_swapped_bytes(const std::filesystem::path& file) {
    const std::string bytes = read_bytes(file);
    const std::size_t begin = bytes.size() - 2 * 640 * 480;
    const auto depth = [&](int x, int y) {
        const std::size_t at = begin + 2 * static_cast<std::size_t>(640 * y + x);
        // The file has the low byte first, where PGM has the high one.
        const int d = static_cast<unsigned char>(bytes[at]) | static_cast<unsigned char>(bytes[at + 1]) << 8;
        return d == 0 || d == 2047 || d > 1092 ? 0 : 351.3 / (1092.5 - d);
    };
    // Whoever says nothing gets the same: how the values are stored is to be seen.
    for (const SourceDescription& known : {preset("nyu"), SourceDescription()})
        expect_points(file, known, {582.62, 582.69, 313.04, 238.44, depth});
}

TEST(RealPictures, NyuIsDisparitiesOfSwappedBytes) {
    const auto file = real_data("other_formats/NYU_depth.pgm");
    TOUCHABLE_NEEDS_DATA(file);
    expect_disparities_of_swapped_bytes(file);
}

TEST(PictureStandIns, OfNyuAreDisparitiesOfSwappedBytes) {
    const TemporaryFolder folder;
    std::string bytes = "P5 640 480 65535\n";
    for (int y = 0; y < 480; ++y)
        for (int x = 0; x < 640; ++x) {
            // A slope, what saw nothing, and what is too far to be told.
            const int d = x % 40 == 0 ? 2047 : x % 40 == 1 ? 0 : x % 40 == 2 ? 1093 + y : 500 + x / 2 + y / 2;
            bytes += static_cast<char>(d & 0xff);
            bytes += static_cast<char>(d >> 8);
        }
    write_bytes(folder / "depth.pgm", bytes);
    expect_disparities_of_swapped_bytes(folder / "depth.pgm");
}

void expect_inverse_depth_without_a_scale(const std::filesystem::path& file) {
    const std::string bytes = read_bytes(file);
    std::vector<float> values(640 * 640);
    std::memcpy(values.data(), bytes.data() + bytes.size() - 4 * values.size(), 4 * values.size());
    const double least = *std::min_element(values.begin(), values.end()),
                 range = *std::max_element(values.begin(), values.end()) - least,
                 f = 320 / std::tan(M_PI / 6);
    const auto depth = [&](int x, int y) {
        const double share = (values[static_cast<std::size_t>(640 * y + x)] - least) / range;
        return 1 / (1 / 1.5 + share * (1 / 0.5 - 1 / 1.5));
    };
    // Half of one of 65534 steps of 1/depth, 1.33 in all, at 1.5 m.
    expect_points(file, preset("relative-inverse"),
                  {f, f, 319.5, 319.5, depth, 0.5 * 1.5 * 1.334 / 65534 * 1.01});
}

TEST(RealPictures, MidasIsInverseDepthWithoutAScale) {
    const auto file = real_data("stills/midas_moon/moon.npy");
    TOUCHABLE_NEEDS_DATA(file);
    expect_inverse_depth_without_a_scale(file);
}

TEST(PictureStandIns, OfMidasAreInverseDepthWithoutAScale) {
    const TemporaryFolder folder;
    std::string text = "{'descr': '<f4', 'fortran_order': False, 'shape': (640, 640), }";
    text.resize(117, ' ');
    std::string bytes = std::string("\x93NUMPY\1\0v\0", 10) + text + '\n';
    for (int y = 0; y < 640; ++y)
        for (int x = 0; x < 640; ++x) {
            const float value =
                3.7F + 11 * std::sin(0.01F * static_cast<float>(x)) + 0.02F * static_cast<float>(y);
            bytes.append(reinterpret_cast<const char*>(&value), 4);
        }
    write_bytes(folder / "moon.npy", bytes);
    expect_inverse_depth_without_a_scale(folder / "moon.npy");
}

TEST(RealPictures, RedwoodIsAFolderWithItsCamera) {
    const auto folder = real_data("stills/redwood5");
    TOUCHABLE_NEEDS_DATA(folder);
    auto reader = open_clip(folder);
    ASSERT_EQ(message(reader), "");
    EXPECT_EQ((*reader)->frame_count(), 5);
    EXPECT_EQ((*reader)->scene().camera.fx, 525);
    EXPECT_EQ((*reader)->scene().camera.cx, 319.5);
    EXPECT_EQ((*reader)->tracks().size(), 2U);
    EXPECT_EQ((*reader)->scene().depth.depth(1861), 1.861);
}

/// NumPy writes arrays, as most people's scripts do.
TEST(RealPictures, StacksOfNumPyAreClips) {
    const TemporaryFolder folder;
    const std::string script =
        "import numpy as n; y, x = n.mgrid[0:12, 0:16]\n"
        "n.save('" +
        (folder / "mm.npy").string() +
        "', n.stack([(500 + 3 * x + k).astype('uint16') for k in range(4)]))\n"
        "n.savez_compressed('" +
        (folder / "metres.npz").string() +
        "', depth=n.stack([0.5 + 0.003 * x + 0.001 * k for k in range(3)]))\n"
        "n.save('" +
        (folder / "holes.npy").string() + "', n.where(x < 4, n.nan, 1.25 + 0.01 * y).astype('float32'))\n";
    write_bytes(folder / "write.py", script);
    if (std::system(("/usr/bin/python3 " + (folder / "write.py").string() + " 2>/dev/null").c_str()) != 0)
        GTEST_SKIP() << "no python3 with numpy";
    for (const auto& [name, count] : {std::pair{"mm.npy", 4}, {"metres.npz", 3}}) {
        auto reader = open_clip(folder / name);
        ASSERT_EQ(message(reader), "") << name;
        EXPECT_EQ((*reader)->frame_count(), count);
        const auto frames = read_all(**reader);
        ASSERT_EQ(message(frames), "");
        ASSERT_EQ(frames->size(), static_cast<std::size_t>(count));
        const Scene& scene = (*reader)->scene();
        for (const auto& frame : *frames)
            EXPECT_NEAR(scene.depth.depth(stored_code(frame.depth, scene.depth, 5, 3)),
                        0.515 + 0.001 * static_cast<double>(frame.number), 1e-5)
                << name;
        EXPECT_EQ(message((*reader)->seek(1)), "");
        EXPECT_TRUE(same_plane((**(*reader)->next()).depth, frames->at(1).depth));
    }
    auto reader = open_clip(folder / "holes.npy");
    ASSERT_EQ(message(reader), "");
    const auto frame = (*reader)->next();
    const Scene& scene = (*reader)->scene();
    EXPECT_FALSE(scene.depth.is_valid(stored_code((*frame)->depth, scene.depth, 3, 5)));
    EXPECT_NEAR(scene.depth.depth(stored_code((*frame)->depth, scene.depth, 4, 5)), 1.3, 1e-5);
}

}  // namespace
}  // namespace touchable::test
