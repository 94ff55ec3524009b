// Integers that show how they were stored, and what stands for no depth. FFmpeg and NumPy write the files.
#include "engine/formats/value_evidence.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "engine/content/seeded_noise.hpp"
#include "engine/scene/frames.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/picture/encoded_picture.hpp"

namespace touchable::test {
namespace {

constexpr int shown_wide = 64, shown_high = 48;

/// Millimetres of a floor and a wall behind it, with holes.
int room_millimetres(int x, int y, int farthest) {
    if ((x * 7 + y * 3) % 29 == 0) return 0;
    return y < 20 ? farthest - 3 * x : farthest - 3 * x - 40 * (y - 20);
}

/// PNG of 16 bits by FFmpeg.
void write_words(const std::filesystem::path& file, const std::function<unsigned(int x, int y)>& word) {
    const std::string bytes =
        encoded("png", AV_PIX_FMT_GRAY16BE, shown_wide, shown_high, [&](AVFrame& frame) {
            for (int y = 0; y < shown_high; ++y)
                for (int x = 0; x < shown_wide; ++x) {
                    std::uint8_t* const to = frame.data[0] + std::ptrdiff_t{y} * frame.linesize[0] + 2 * x;
                    to[0] = static_cast<std::uint8_t>(word(x, y) >> 8);
                    to[1] = static_cast<std::uint8_t>(word(x, y));
                }
        });
    write_bytes(file, bytes);
}

/// Each pixel against an unprojection written out here: 60 degrees wide; 0 is a hole. Returns the notes.
std::string expect_unprojected(const std::filesystem::path& file,
                               const std::function<double(int x, int y)>& metres) {
    auto reader = open_clip(file);
    EXPECT_EQ(message(reader), "");
    if (!reader) return "";
    const auto frame = (*reader)->next();
    EXPECT_EQ(message(frame), "");
    const Scene& scene = (*reader)->scene();
    std::string notes;
    for (const std::string& note : clip_notes(**reader)) notes += note + '\n';
    const double f = shown_wide / 2.0 / std::tan(M_PI / 6);
    for (int y = 0; y < shown_high; ++y)
        for (int x = 0; x < shown_wide; ++x) {
            const std::uint16_t code = stored_code((**frame).depth, scene.depth, x, y);
            const double z = metres(x, y);
            EXPECT_EQ(scene.depth.is_valid(code), z > 0) << x << ", " << y << '\n' << notes;
            if (scene.depth.is_valid(code) != (z > 0)) return notes;
            if (z == 0) continue;
            const glm::dvec3 point = unproject(scene.camera, x, y, scene.depth.depth(code));
            EXPECT_NEAR(point.x, (x - 31.5) / f * z, 1e-6 * z) << notes;
            EXPECT_NEAR(point.y, -(y - 23.5) / f * z, 1e-6 * z);
            EXPECT_NEAR(point.z, -z, 1e-6 * z);
            if (std::abs(point.z + z) > 1e-6 * z) return notes;
        }
    return notes;
}

TEST(ValueEvidence, MillimetresTimesFiveTenAndAHundredAreMillimetres) {
    const TemporaryFolder folder;
    for (const auto& [factor, farthest] : {std::pair{5, 2400}, {10, 3700}, {10, 1600}, {100, 620}}) {
        SCOPED_TRACE(factor);
        const int far = farthest == 620 ? 640 : farthest;
        const auto millimetres = [far = far](int x, int y) {
            return far == 640 ? (x + y) % 31 == 0 ? 0 : far - x - 2 * y : room_millimetres(x, y, far);
        };
        write_words(folder / "my.png", [&, factor = factor](int x, int y) {
            return static_cast<unsigned>(factor * millimetres(x, y));
        });
        const std::string notes =
            expect_unprojected(folder / "my.png", [&](int x, int y) { return 0.001 * millimetres(x, y); });
        EXPECT_NE(notes.find("all values are multiples of " + std::to_string(factor)), std::string::npos)
            << notes;
    }
}

/// Centimetres as millimetres would be nearer than cameras see; and 20 is nobody's unit.
TEST(ValueEvidence, OtherMultiplesAreSaidAndTheUnitIsWhatItWas) {
    const TemporaryFolder folder;
    for (const int factor : {10, 20}) {
        const auto millimetres = [&](int x, int y) { return (x + y) % 31 == 0 ? 0 : factor * (140 - x - y); };
        write_words(folder / "my.png",
                    [&](int x, int y) { return static_cast<unsigned>(millimetres(x, y)); });
        const std::string notes =
            expect_unprojected(folder / "my.png", [&](int x, int y) { return 0.001 * millimetres(x, y); });
        EXPECT_NE(notes.find("multiples of " + std::to_string(factor) + ", which tells nothing"),
                  std::string::npos)
            << notes;
    }
}

TEST(ValueEvidence, BytesThatSomebodyStretchedHaveNoScale) {
    const TemporaryFolder folder;
    for (const unsigned factor : {256U, 257U}) {
        write_words(folder / "my.png",
                    [&](int x, int y) { return factor * static_cast<unsigned>(20 + (x + 3 * y) % 200); });
        auto reader = open_clip(folder / "my.png");
        ASSERT_EQ(message(reader), "");
        EXPECT_TRUE(is_noted(**reader, "8 bits stored as 16"));
        EXPECT_TRUE(is_noted(**reader, "depth has no scale"));
    }
}

/// SUN RGB-D: bitor(bitshift(depth, 3), bitshift(depth, -13)), as its readers undo it.
TEST(ValueEvidence, RotatedBitsAreThoseOfSun) {
    const TemporaryFolder folder;
    for (const int farthest : {3500, 9600}) {
        write_words(folder / "my.png", [&](int x, int y) {
            const auto depth = static_cast<unsigned>(room_millimetres(x, y, farthest));
            return (depth << 3 | depth >> 13) & 0xffffU;
        });
        const std::string notes = expect_unprojected(
            folder / "my.png", [&](int x, int y) { return 0.001 * room_millimetres(x, y, farthest); });
        EXPECT_NE(notes.find("preset sun"), std::string::npos) << notes;
    }
}

TEST(ValueEvidence, OrdinaryMillimetresHaveNone) {
    SplitMix64 random(5);
    for (int round = 0; round < 50; ++round) {
        StoredImage picture;
        picture.image = {100, 100, 2, 1, {}};
        const double from = 200 + 4000 * random.unit(), range = 100 + 8000 * random.unit();
        // Levels, as of disparities, or all.
        const bool is_levels = round % 2 == 0;
        for (int k = 0; k < 10'000; ++k) {
            const double z = from + range * random.unit(), levels = 2e5 / (from + range);
            const auto word = static_cast<std::uint16_t>(is_levels ? 2e5 / std::floor(2e5 / z + levels) : z);
            picture.image.samples.push_back(static_cast<std::uint8_t>(word));
            picture.image.samples.push_back(static_cast<std::uint8_t>(word >> 8));
        }
        EXPECT_EQ(common_divisor(picture), 1) << round;
        EXPECT_EQ(evident_preset(picture).preset, nullptr) << round;
    }
}

TEST(ValueEvidence, MinusOneIsNoDepthInArrays) {
    const TemporaryFolder folder;
    write_bytes(folder / "write.py",
                "import numpy as np\nf = '" + folder.path().string() +
                    "/'\ny, x = np.mgrid[0:48, 0:64]\n"
                    "mm = 900 + 7 * x + 5 * y\nnone = (x + y) % 9 == 0\n"
                    "np.save(f + 'metres', np.where(none, -1, mm / 1000).astype('f4'))\n"
                    "np.save(f + 'whole', np.where(none, -1, mm).astype('i2'))\n"
                    "np.savez(f + 'packed', depth=np.where(none, -1, mm / 1000), rgb=np.zeros(3))\n"
                    "np.save(f + 'batch', np.where(none, -1, mm / 1000).astype('f4')[None, None])\n"
                    "np.save(f + 'last', np.where(none, 0, mm).astype('u2')[None, ..., None])\n");
    if (std::system(("/usr/bin/python3 '" + (folder / "write.py").string() + "' 2>/dev/null").c_str()) != 0)
        GTEST_SKIP() << "needs Python with NumPy (Debian: python3-matplotlib)";
    for (const char* name : {"metres.npy", "whole.npy", "packed.npz", "batch.npy", "last.npy"}) {
        SCOPED_TRACE(name);
        const std::string notes = expect_unprojected(
            folder / name, [](int x, int y) { return (x + y) % 9 == 0 ? 0 : 0.001 * (900 + 7 * x + 5 * y); });
        EXPECT_EQ(notes.find("0 and what is below it are no depth") != std::string::npos,
                  std::string(name) != "last.npy")
            << notes;
    }
}

}  // namespace
}  // namespace touchable::test
