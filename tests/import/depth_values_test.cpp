// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <stop_token>
#include <tuple>

#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "engine/formats/depth_values.hpp"
#include "engine/formats/formats_read.hpp"
#include "engine/formats/value_evidence.hpp"
#include "engine/scene/frames.hpp"
#include "tests/clip_notes.hpp"
#include "tests/picture/results.hpp"

namespace touchable::test {
namespace {

Scene scene_of(int width, int height) {
    Scene scene = small_scene(width, height, 16);
    scene.camera = {500, 500, 0.5, 0.5};
    scene.depth.semantics = DepthSemantics::planar;
    return scene;
}

Scene scene_of_lengths(int width, int height, double scale = 1) {
    Scene scene = scene_of(width, height);
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.scale = scale;
    scene.depth.near = 0;
    return scene;
}

StoredImage floats(int width, std::vector<float> values) {
    StoredImage picture;
    picture.image.width = width;
    picture.image.height = static_cast<int>(values.size()) / width;
    picture.values = std::move(values);
    return picture;
}

StoredImage words(int width, const std::vector<std::uint16_t>& values) {
    StoredImage picture;
    picture.image = {width, static_cast<int>(values.size()) / width, 2, 1, {}};
    picture.image.samples.resize(2 * values.size());
    std::memcpy(picture.image.samples.data(), values.data(), 2 * values.size());
    return picture;
}

/// The depth of a pixel by the settled scene; 0 where it is not valid.
double depth_at(const Scene& scene, const Image& codes, int x) {
    const std::uint16_t code = static_cast<std::uint16_t>(codes.view().sample(x, 0));
    return scene.depth.is_valid(code) ? scene.depth.depth(code) : 0;
}

/// The same, but for a far plane that is stated.
SceneDescription without_far(const Scene& scene) {
    SceneDescription described(scene);
    described.unstated.far = true;
    return described;
}

/// Looks at a picture and settles the scene, whose far plane is not stated if it `lacks_far`.
DepthValues settled(Scene& scene, const StoredImage& picture, bool lacks_far = false) {
    DepthValues values(lacks_far ? without_far(scene) : SceneDescription(scene));
    values.look(picture);
    EXPECT_EQ(message(values.settle(scene)), "");
    return values;
}

TEST(DepthValues, KeepFloatsWithinHalfCode) {
    const float inf = std::numeric_limits<float>::infinity();
    const std::vector<float> depths{0.4F, 1, 1.7F, 2.5F, 3.999F, 0, -1, NAN, inf, -inf};
    for (const double metres : {1.0, 0.001}) {
        Scene scene = scene_of_lengths(10, 1, metres);
        scene.metres_per_unit = 1;
        scene.depth.far = 65.535;
        std::vector<float> stored;
        for (const float depth : depths) stored.push_back(static_cast<float>(depth / metres));
        DepthValues values(without_far(scene));
        ASSERT_TRUE(values.needs_looks(floats(10, stored)));
        values.look(floats(10, stored));
        const auto said = must(values.settle(scene));
        const Image codes = values.codes(floats(10, stored));
        for (int x = 0; x < 5; ++x) {
            const double wanted = depths[static_cast<std::size_t>(x)], near = scene.depth.near,
                         far = scene.depth.far;
            const double half = scene.depth.kind == DepthCodingKind::linear
                                    ? 0.5 * (far - near) / scene.depth.code_max
                                    : 0.5 * wanted * wanted * (1 / near - 1 / far) / scene.depth.code_max;
            EXPECT_NEAR(depth_at(scene, codes, x), wanted, 1.01 * half + 1e-6 * wanted) << x << " " << said;
        }
        for (int x = 5; x < 10; ++x) EXPECT_EQ(depth_at(scene, codes, x), 0) << x;
        EXPECT_TRUE(has_words(said, "half a code is"));
    }
}

/// Leaning planes whose 1/depth goes by p steps to the right and q down: what is called exact is, within the
/// rounding of floats, though p and q leave the same rest by small numbers.
TEST(DepthValues, KeepLeaningPlanesExactly) {
    const std::tuple<int, int, int> planes[] = {{256, 7, 2}, {256, 2, 7}, {160, 1, 4}, {160, 5, 2}};
    for (const auto& [width, p, q] : planes) {
        const int height = width == 256 ? 128 : 120;
        std::vector<float> plane;
        for (int k = 0; k < width * height; ++k)
            plane.push_back(static_cast<float>(1 / (0.3 + 1.7e-4 * (p * (k % width) + q * (k / width)))));
        Scene scene = scene_of_lengths(width, height);
        DepthValues values(without_far(scene));
        values.look(floats(width, plane));
        EXPECT_TRUE(must(values.settle(scene)).ends_with("kept exactly")) << p << ':' << q;
        const Image codes = values.codes(floats(width, plane));
        double farthest = 0;
        for (std::size_t k = 0; k < plane.size(); ++k) {
            const auto code = static_cast<std::uint16_t>(sample_at(codes, k));
            farthest = std::max(farthest, std::abs(scene.depth.depth(code) / plane[k] - 1));
        }
        EXPECT_LT(farthest, 1e-6) << p << ':' << q;
    }
}

TEST(DepthValues, KeepNearStepsBelowSkies) {
    std::vector<float> stored(1000, 0.5F);
    for (std::size_t k = 0; k < 100; ++k) stored[k] = 10000;
    Scene scene = scene_of_lengths(1000, 1);
    DepthValues values = settled(scene, floats(1000, stored), true);
    EXPECT_EQ(scene.depth.kind, DepthCodingKind::inverse);
    EXPECT_NEAR(depth_at(scene, values.codes(floats(1000, stored)), 500), 0.5, 1e-5);
    EXPECT_NEAR(depth_at(scene, values.codes(floats(1000, stored)), 5), 10000, 800);
}

/// Values in millimetres may be 65.504 m away, and codes have no background.
TEST(DepthValues, KeepLargestHalfIfExceeded) {
    std::vector<float> stored(100, 65504);
    stored[1] = 65510;
    Scene scene = scene_of_lengths(100, 1, 0.001);
    DepthValues values = settled(scene, floats(100, stored), true);
    EXPECT_NEAR(depth_at(scene, values.codes(floats(100, stored)), 0), 65.504, 1e-3);
    EXPECT_EQ(estimate_values(words(3, {65504, 65504, 100})).median, 65504);
}

/// A background says that values have a unit: shares of a range have none.
TEST(DepthValues, HaveUnitIfBackground) {
    std::vector<float> stored(1000);
    for (std::size_t k = 0; k < 1000; ++k) stored[k] = static_cast<float>(k) / 999;
    EXPECT_TRUE(estimate_values(floats(1000, stored)).is_normalised);
    stored[500] = 1e10F;
    EXPECT_FALSE(estimate_values(floats(1000, stored)).is_normalised);
}

/// Whatever the frames hold that were looked at: a later one may go from plane to plane.
TEST(DepthValues, KeepStatedPlanes) {
    const float near = 0.7F, far = 9.1F;  // of which the doubles 0.7 and 9.1 are beyond or before
    for (const bool is_seen : {true, false}) {
        Scene scene = scene_of_lengths(6, 1);
        scene.depth.near = 0.7;
        scene.depth.far = 9.1;
        DepthValues values = settled(scene, floats(6, std::vector<float>(6, is_seen ? 2.0F : 1e10F)));
        EXPECT_EQ(scene.depth.near, 0.7);
        EXPECT_EQ(scene.depth.far, 9.1);
        EXPECT_EQ(scene.depth.code_max, 65534);
        const Image codes = values.codes(floats(6, {near, far, 0.8F, 8.9F, 0.69F, 9.2F}));
        EXPECT_EQ(depth_at(scene, codes, 0), 0.7);
        EXPECT_DOUBLE_EQ(depth_at(scene, codes, 1), 9.1);
        EXPECT_NEAR(depth_at(scene, codes, 2), 0.8, 1e-4);
        EXPECT_NEAR(depth_at(scene, codes, 3), 8.9, 1e-3);
        EXPECT_EQ(depth_at(scene, codes, 4), 0);
        EXPECT_EQ(depth_at(scene, codes, 5), 0);
    }
}

TEST(DepthValues, DropExtremeValues) {
    std::vector<float> stored(1000, 2.0F);
    stored[0] = 1e10F;
    stored[1] = 1e-7F;
    stored[2] = -1;
    Scene scene = scene_of_lengths(1000, 1);
    DepthValues values = settled(scene, floats(1000, stored), true);
    const Image codes = values.codes(floats(1000, stored));
    for (int x = 0; x < 3; ++x) EXPECT_EQ(depth_at(scene, codes, x), 0) << x;
    EXPECT_NEAR(depth_at(scene, codes, 3), 2, 1e-2);
}

/// docs/scene_file.md: what is nearer than a metric scene's near, or deeper than its far, is no depth.
TEST(DepthValues, DropFloatsBeyondPlanes) {
    const std::vector<float> stored{0.3F, 0.49F, 0.6F, 1, 2.9F, 3.1F, 50};
    Scene scene = scene_of_lengths(7, 1);
    scene.depth.near = 0.5;
    scene.depth.far = 3;
    DepthValues values = settled(scene, floats(7, stored));
    EXPECT_GE(scene.depth.near, 0.5);
    EXPECT_LE(scene.depth.far, 3);
    const Image codes = values.codes(floats(7, stored));
    for (const int x : {0, 1, 5, 6})
        EXPECT_EQ(depth_at(scene, codes, x), 0) << stored[static_cast<std::size_t>(x)];
    for (const int x : {2, 3, 4})
        EXPECT_NEAR(depth_at(scene, codes, x), stored[static_cast<std::size_t>(x)], 1e-4);
}

/// Not every frame is looked at before.
TEST(DepthValues, ClampNearerAndDropFarther) {
    Scene scene = scene_of_lengths(4, 1);
    DepthValues values = settled(scene, floats(4, {1, 2, 3, 4}), true);
    const Image codes = values.codes(floats(4, {0.5F, 2, 4.1F, 4.3F}));
    EXPECT_DOUBLE_EQ(depth_at(scene, codes, 0), 1);
    EXPECT_NEAR(depth_at(scene, codes, 1), 2, 1e-3);
    EXPECT_NEAR(depth_at(scene, codes, 2), 4.1, 1e-3);
    EXPECT_EQ(depth_at(scene, codes, 3), 0);
}

TEST(DepthValues, UseAllSixteenBits) {
    Scene scene = scene_of(3, 1);
    scene.depth.kind = DepthCodingKind::inverse;
    scene.depth.near = 0.5;
    scene.depth.far = 1.5;
    scene.stored.kind = StoredDepth::Kind::relative;
    DepthValues values(scene);
    values.look(words(3, {0, 65535, 1000}));
    const auto said = must(values.settle(scene));
    EXPECT_EQ(said, "depth values from 0 to 65535 are depths from 1.5 to 0.5") << "large values near";
    const Image codes = values.codes(words(3, {0, 65535, 1000}));
    EXPECT_EQ(depth_at(scene, codes, 0), 1.5);
    EXPECT_EQ(depth_at(scene, codes, 1), 0.5);
}

TEST(DepthValues, KeepIntegerDisparities) {
    for (const double scale : {1.0 / 16, -1.0}) {
        Scene scene = scene_of(7, 1);
        scene.depth.kind = DepthCodingKind::inverse;
        scene.stored = {StoredDepth::Kind::disparity, 0.2, scale, scale > 0 ? 2.5 : 1092.5, false, 0};
        scene.depth.invalid_codes[0] = 0;
        scene.depth.invalid_code_count = 1;
        const std::vector<std::uint16_t> stored{17, 100, 333, 999, 1000, 0, 500};
        DepthValues values = settled(scene, words(7, stored));
        EXPECT_TRUE(scene.stored.is_plain());
        const Image codes = values.codes(words(7, stored));
        for (int x = 0; x < 7; ++x) {
            const double value = stored[static_cast<std::size_t>(x)];
            const double wanted = value == 0 ? 0 : 500 * 0.2 / (scale * value + (scale > 0 ? 2.5 : 1092.5));
            EXPECT_NEAR(depth_at(scene, codes, x), wanted, 1e-12 * wanted) << x << " scale " << scale;
        }
        EXPECT_GE(scene.depth.far,
                  1.04 * scene.depth.depth(stored_code(codes.view(), scene.depth, scale > 0 ? 0 : 4, 0)));
    }
}

// As of a camera file that is wrong: what was seen keeps its steps, and the far plane lies no farther than
// codes go.
TEST(DepthValues, KeepDisparitiesWithLargeOffset) {
    for (const double scale : {1.0, -1.0}) {
        Scene scene = scene_of(200, 1);
        scene.depth.kind = DepthCodingKind::inverse;
        scene.stored = {StoredDepth::Kind::disparity, 0.2, scale, 1e7, false, 0};
        std::vector<float> stored;
        for (int k = 0; k < 200; ++k) stored.push_back(static_cast<float>(20 + 0.25 * (k * 37 % 200)));
        DepthValues values = settled(scene, floats(200, stored));
        EXPECT_GT(scene.depth.code_max, 60000);
        const Image codes = values.codes(floats(200, stored));
        for (int x = 0; x < 200; ++x) {
            const double wanted = 500 * 0.2 / (scale * stored[static_cast<std::size_t>(x)] + 1e7);
            EXPECT_NEAR(depth_at(scene, codes, x), wanted, 1e-12 * wanted) << x << " scale " << scale;
        }
    }
}

TEST(DepthValues, KeepOrderWithoutScale) {
    for (const bool near_is_high : {true, false})
        for (const DepthCodingKind kind : {DepthCodingKind::inverse, DepthCodingKind::linear}) {
            Scene scene = scene_of(4, 1);
            scene.depth.kind = kind;
            scene.depth.near = 0.5;
            scene.depth.far = 1.5;
            scene.depth.near_is_high = near_is_high;
            scene.stored.kind = StoredDepth::Kind::relative;
            const std::vector<float> stored{-0.5F, 0.25F, 0.75F, 1.5F};
            DepthValues values = settled(scene, floats(4, stored));
            const Image codes = values.codes(floats(4, stored));
            EXPECT_NEAR(depth_at(scene, codes, near_is_high ? 3 : 0), 0.5, 1e-9);
            EXPECT_NEAR(depth_at(scene, codes, near_is_high ? 0 : 3), 1.5, 1e-9);
            const double q = 1 / depth_at(scene, codes, 2);  // 1.25 of 2 from the first
            if (kind == DepthCodingKind::inverse)
                EXPECT_NEAR(q, 2.0 / 3 + (near_is_high ? 0.625 : 0.375) * (2 - 2.0 / 3), 2e-5);
            else
                EXPECT_NEAR(1 / q, near_is_high ? 1.5 - 0.625 : 0.5 + 0.625, 2e-5);
        }
}

TEST(DepthValues, RestoreRotatedAndSwappedWords) {
    Scene scene = scene_of(3, 1);
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.scale = 0.001;
    scene.stored.rotated = 3;
    // SUN RGB-D: depth << 3 with its upper bits below.
    const Image turned =
        DepthValues(scene).codes(words(3, {800 << 3, static_cast<std::uint16_t>(9000 << 3 | 9000 >> 13), 5}));
    EXPECT_EQ(turned.view().sample(0, 0), 800);
    EXPECT_EQ(turned.view().sample(1, 0), 9000);
    EXPECT_EQ(turned.view().sample(2, 0), 5 << 13);
    scene.stored.used_bits = 13;
    EXPECT_EQ(DepthValues(scene).codes(words(1, {800 << 3 | 5})).view().sample(0, 0), 800);
    scene.stored = {};
    scene.stored.bytes_swapped = true;
    EXPECT_EQ(DepthValues(scene).codes(words(3, {0x0102, 0xff00, 7})).view().sample(0, 0), 0x0201);
}

TEST(DepthValues, RefuseFramesWithoutDepth) {
    Scene scene = scene_of_lengths(2, 1);
    DepthValues values(without_far(scene));
    values.look(floats(2, {NAN, 0}));
    EXPECT_TRUE(is_refused(values.settle(scene), "no frame has a valid depth"));
}

/// As sorting all of them tells it.
TEST(EstimatedValues, MedianIsExact) {
    Random numbers(3);
    for (const int count : {1, 2, 3, 1000, 300'001}) {
        std::vector<float> stored;
        for (int k = 0; k < count; ++k)
            stored.push_back(static_cast<float>(numbers.below(2000) - 1000) / 7 + 0.001F);
        std::vector<float> sorted = stored;
        std::sort(sorted.begin(), sorted.end());
        EXPECT_EQ(estimate_values(floats(1, stored)).median, sorted[sorted.size() / 2]) << count;
    }
}

TEST(EstimatedValues, EndsWhenStopped) {
    std::stop_source given_up;
    const StopScope until(given_up.get_token());
    EXPECT_TRUE(estimate_values(words(3, {1, 2, 3})).any);
    given_up.request_stop();
    EXPECT_FALSE(estimate_values(words(3, {1, 2, 3})).any);
}

// Integers that show how they were stored, and what stands for no depth. FFmpeg and NumPy write the files.

constexpr int shown_wide = 64, shown_high = 48;

/// Millimetres of a floor and a wall behind it, with holes.
int room_millimetres(int x, int y, int farthest) {
    if ((x * 7 + y * 3) % 29 == 0) return 0;
    return y < 20 ? farthest - 3 * x : farthest - 3 * x - 40 * (y - 20);
}

void write_words(const std::filesystem::path& file, const std::function<unsigned(int x, int y)>& word) {
    write_in_folder(file,
                    made_image(shown_wide, shown_high, 2, 1, [&](int x, int y, int) { return word(x, y); }));
}

struct FirstFrame {
    RawFrame frame;
    Scene scene;
    std::string notes;
    FirstFrame(const std::filesystem::path& file, const SourceDescription& known = {}) {
        const auto reader = must(open_clip(file, std::nullopt, known));
        frame = *must(reader->next());
        scene = reader->scene();
        for (const std::string& note : clip_notes(*reader)) notes += note + '\n';
    }
    std::uint16_t code(int x, int y) const { return stored_code(frame.depth, scene.depth, x, y); }
};

/// Depth along the camera's axis at each pixel, whatever the camera is; 0 is a hole. Returns the notes.
std::string expect_depths(const std::filesystem::path& path,
                          const std::function<double(int x, int y)>& metres, double tolerance = 1e-6,
                          const SourceDescription& known = {}) {
    const FirstFrame first(path, known);
    const Scene& scene = first.scene;
    const std::string& notes = first.notes;
    for (int y = 0; y < shown_high; ++y)
        for (int x = 0; x < shown_wide; ++x) {
            const std::uint16_t code = first.code(x, y);
            const double z = metres(x, y);
            const double got =
                scene.depth.is_valid(code) ? scene.depth.depth(code) * scene.metres_per_unit : 0;
            EXPECT_NEAR(got, z, tolerance * z) << x << ", " << y << '\n' << notes;
            if (std::abs(got - z) > tolerance * z) return notes;
        }
    return notes;
}

using ValueEvidence = FolderTest;

TEST_F(ValueEvidence, UndoesMultipliedMillimetres) {
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
            expect_depths(folder / "my.png", [&](int x, int y) { return 0.001 * millimetres(x, y); });
        EXPECT_TRUE(has_words(notes, "all values are multiples of " + std::to_string(factor)));
    }
}

/// Centimetres as millimetres would be nearer than cameras see; and no program uses 20.
TEST_F(ValueEvidence, NotesOtherMultiples) {
    for (const int factor : {10, 20}) {
        const auto millimetres = [&](int x, int y) { return (x + y) % 31 == 0 ? 0 : factor * (140 - x - y); };
        write_words(folder / "my.png",
                    [&](int x, int y) { return static_cast<unsigned>(millimetres(x, y)); });
        const std::string notes =
            expect_depths(folder / "my.png", [&](int x, int y) { return 0.001 * millimetres(x, y); });
        EXPECT_TRUE(has_words(notes, "multiples of " + std::to_string(factor) + ", which tells nothing"));
    }
}

TEST_F(ValueEvidence, RecognisesStretchedBytes) {
    for (const unsigned factor : {256U, 257U}) {
        write_words(folder / "my.png",
                    [&](int x, int y) { return factor * static_cast<unsigned>(20 + (x + 3 * y) % 200); });
        auto reader = must(open_clip(folder / "my.png"));
        EXPECT_TRUE(is_noted(*reader, "8 bits stored as 16"));
        EXPECT_TRUE(is_noted(*reader, "depth has no scale"));
    }
}

/// SUN RGB-D: bitor(bitshift(depth, 3), bitshift(depth, -13)), as its readers undo it.
TEST_F(ValueEvidence, RecognisesSunByRotation) {
    for (const int farthest : {3500, 9600}) {
        write_words(folder / "my.png", [&](int x, int y) {
            const auto depth = static_cast<unsigned>(room_millimetres(x, y, farthest));
            return (depth << 3 | depth >> 13) & 0xffffU;
        });
        const std::string notes = expect_depths(
            folder / "my.png", [&](int x, int y) { return 0.001 * room_millimetres(x, y, farthest); });
        EXPECT_TRUE(has_words(notes, "preset sun"));
    }
}

/// A wall, a box before it that stands on a floor, and holes beside the box.
double room(int x, int y) {
    const bool is_box = x > 20 && x < 44 && y > 12 && y < 40;
    if (!is_box && x >= 44 && x < 47 && y > 12 && y < 40) return 0;
    const double wall = 2.2 + 0.004 * x, floor = 2.2 - 0.03 * (y - 20);
    return is_box ? 1.3 + 0.002 * x : y > 20 ? std::min(wall, floor) : wall;
}

unsigned millimetres_of(double metres) {
    return static_cast<unsigned>(std::lround(1000 * metres));
}

/// Millimetres that are as small, with a pile at what a Kinect has for none, but not without what it sees.
TEST_F(ValueEvidence, KeepsSmallMillimetres) {
    write_words(folder / "a.png", [&](int x, int y) { return millimetres_of(room(x, y) / 2.5); });
    const std::string notes =
        expect_depths(folder / "a.png", [](int x, int y) { return millimetres_of(room(x, y) / 2.5) / 1e3; });
    EXPECT_TRUE(has_words(notes, "depth codes are millimetres"));
    write_words(folder / "b.png",
                [&](int x, int y) { return x < 8 ? 2047U : 1000U + static_cast<unsigned>(10 * x + 7 * y); });
    expect_depths(folder / "b.png",
                  [](int x, int y) { return x < 8 ? 2.047 : (1000 + 10 * x + 7 * y) / 1e3; });
}

/// Depth beyond 8.191 m is not a person, even behind something near.
TEST_F(ValueEvidence, KeepsDepthBeyondEightMetres) {
    const auto millimetres = [](int x, int y) {
        return x > 20 && x < 40 && y < 30 ? 2000U + static_cast<unsigned>(x)
                                          : static_cast<unsigned>(9300 - 60 * y + x);
    };
    write_words(folder / "a.png",
                [&](int x, int y) { return (millimetres(x, y) << 3 | millimetres(x, y) >> 13) & 0xffffU; });
    const std::string notes =
        expect_depths(folder / "a.png", [&](int x, int y) { return millimetres(x, y) / 1e3; });
    EXPECT_TRUE(has_words(notes, "preset sun"));
}

TEST_F(ValueEvidence, DropsConfidenceInHighBits) {
    write_words(folder / "a.png", [](int x, int y) {
        return millimetres_of(room(x, y)) | static_cast<unsigned>((x / 3 + y / 5) % 8) << 13;
    });
    const std::string notes =
        expect_depths(folder / "a.png", [](int x, int y) { return millimetres_of(room(x, y)) / 1e3; });
    EXPECT_TRUE(has_words(notes, "preset depth16"));
}

/// A floor and two walls, by rays: planes of a pinhole. Metres from 0.86 to 0.99.
double corner(int x, int y) {
    const double right = (x - 31.5) / 55, down = (y - 23.5) / 55;
    return 0.86 / std::max({0.87 + 0.09 * right, 0.9 - 0.06 * right, 0.9 + 0.18 * down});
}

void write_floats(const std::filesystem::path& file, const std::function<double(int x, int y)>& value) {
    write_bytes(file, pfm_of(shown_wide, shown_high, value));
}

TEST_F(ValueEvidence, TellsDepthBuffersByFlatPlaces) {
    SourceDescription planes;
    planes.near = 0.1;
    planes.far = 20;
    for (const bool is_reversed : {false, true}) {
        const auto metres = [](int x, int y) { return x < 3 ? 0 : 2 * corner(x, y); };
        write_floats(folder / "a.pfm", [&](int x, int y) {
            const double share = x < 3 ? 1 : (1 / 0.1 - 1 / metres(x, y)) / (1 / 0.1 - 1 / 20.0);
            return is_reversed ? 1 - share : share;
        });
        const FirstFrame first(folder / "a.pfm");
        EXPECT_TRUE(has_words(first.notes, "depth is a renderer's depth buffer")) << first.notes;
        EXPECT_EQ(std::ranges::count(first.scene.remarks, RemarkKind::planes, &Remark::kind), 1);
        expect_depths(folder / "a.pfm", metres, 2e-4, planes);
    }
    write_floats(folder / "b.pfm", corner);
    const std::string notes = expect_depths(folder / "b.pfm", corner, 1e-4);
    EXPECT_TRUE(has_words(notes, "values are metres")) << notes;
    EXPECT_FALSE(has_words(notes, "buffer")) << notes;
    planes.far.reset();
    EXPECT_TRUE(
        is_refused(open_clip(folder / "b.pfm", std::nullopt, planes), "near and far need each other"));
}

/// Words of a depth buffer are near the largest, and integers may go evenly from plane to plane, as floats
/// may; shares of the far plane are evenly spaced from 0 on.
TEST_F(ValueEvidence, TellsHowValuesGoFromPlaneToPlane) {
    SourceDescription planes;
    planes.near = 0.1;
    planes.far = 5;
    const auto metres = [](int x, int y) { return 2 * corner(x, y); };
    write_words(folder / "buffer.png", [&](int x, int y) {
        return static_cast<unsigned>(65535 * (1 / 0.1 - 1 / metres(x, y)) / (1 / 0.1 - 1 / 5.0) + 0.5);
    });
    EXPECT_TRUE(has_words(FirstFrame(folder / "buffer.png").notes, "as all values are near the largest"));
    expect_depths(folder / "buffer.png", metres, 1e-3, planes);
    write_bytes(folder / "sensor.json", R"({"near": 0.1, "far": 5})");
    EXPECT_TRUE(has_words(expect_depths(folder / "buffer.png", metres, 1e-3), "as sensor.json says"));
    std::filesystem::remove(folder / "sensor.json");
    for (const bool is_high : {false, true}) {
        const auto even = [&](int x, int y) {
            const double share = (metres(x, y) - 0.1) / (5 - 0.1);
            return is_high ? 1 - share : share;
        };
        write_floats(folder / "even.pfm", even);
        const std::string notes = expect_depths(folder / "even.pfm", metres, 1e-4, planes);
        EXPECT_TRUE(has_words(notes, "evenly in depth, " + std::string(is_high ? "large" : "small")))
            << notes;
    }
    write_floats(folder / "shares.pfm", [&](int x, int y) { return metres(x, y) / 5; });
    expect_depths(folder / "shares.pfm", metres, 1e-4, planes);
    write_floats(folder / "up.pfm", [](int x, int y) { return 1 / (1.5 - (y + 0.1 * x) / shown_high); });
    EXPECT_TRUE(has_words(FirstFrame(folder / "up.pfm").notes, "rows may go from the bottom up"));
}

/// What is alone before a background goes away from its middle, whichever values are large.
TEST_F(ValueEvidence, TellsWhatIsNearFromEmptyBackground) {
    for (const bool is_high : {false, true})
        for (const bool is_empty_high : {false, true}) {
            const auto ball = [](int x, int y) { return 1 - std::hypot(x - 31, y - 23) / 16; };
            write_floats(folder / "a.pfm", [&](int x, int y) {
                const double share = 0.01 + 0.99 * std::sqrt(std::max(ball(x, y), 0.0));
                return ball(x, y) < 0 ? is_empty_high : is_high ? share : 1 - share;
            });
            if (!is_high && !is_empty_high) continue;  // as lengths around which 0 is no depth
            const FirstFrame first(folder / "a.pfm");
            EXPECT_EQ(first.scene.depth.near_is_high, is_high) << first.notes;
            EXPECT_FALSE(first.scene.depth.is_valid(first.code(0, 0)));
            EXPECT_LT(first.scene.depth.depth(first.code(31, 23)),
                      first.scene.depth.depth(first.code(20, 23)));
        }
}

TEST_F(ValueEvidence, ReadsNegatedLengthsAndRoundBackgrounds) {
    const auto metres = [](int x, int y) { return x < 3 ? 0 : corner(x, y); };
    write_floats(folder / "a.pfm", [&](int x, int y) { return -metres(x, y); });
    expect_depths(folder / "a.pfm", metres, 1e-4);
    for (const double none : {1000.0, double{NAN}, double{INFINITY}}) {
        write_floats(folder / "b.pfm", [&](int x, int y) { return x < 3 ? none : corner(x, y); });
        expect_depths(folder / "b.pfm", metres, 1e-4);
    }
    // A stated unit does not make 65535 a surface.
    write_words(folder / "c.png", [&](int x, int y) { return x < 3 ? 65535 : millimetres_of(corner(x, y)); });
    expect_depths(folder / "c.png", metres, 1e-3, stated(&SourceDescription::metres_per_code, 0.001));
}

/// Noise hides what is flat: the lengths are metres, and the other meaning is named.
TEST_F(ValueEvidence, NamesDepthBufferWhereNothingTells) {
    SplitMix64 random(3);
    write_floats(folder / "a.pfm", [&](int x, int y) { return corner(x, y) + 0.002 * random.unit(); });
    const FirstFrame first(folder / "a.pfm");
    EXPECT_NEAR(first.scene.depth.depth(first.code(30, 20)), corner(30, 20), 0.003);
    EXPECT_TRUE(has_words(first.notes, "a renderer's depth buffer has such values too")) << first.notes;
}

TEST_F(ValueEvidence, KeepsShallowScenesWithinOneConfidence) {
    const auto lengths = [](int x, int y) { return millimetres_of(10 * corner(x, y)); };
    write_words(folder / "a.png", lengths);
    expect_depths(folder / "a.png", [&](int x, int y) { return lengths(x, y) / 1e3; });
    const auto below = [](int x, int y) {
        return millimetres_of(1 / (1.2 + (y - 23.5) / 44 + (x - 31.5) / 210));
    };
    write_words(folder / "b.png", [&](int x, int y) { return below(x, y) | 3U << 13; });
    const std::string notes =
        expect_depths(folder / "b.png", [&](int x, int y) { return below(x, y) / 1e3; });
    EXPECT_TRUE(has_words(notes, "preset depth16")) << notes;
}

/// 24 bits over three channels.
void write_packed(const std::filesystem::path& file, double scale) {
    write_in_folder(file, made_image(shown_wide, shown_high, 1, 3, [&](int x, int y, int c) {
                        const double z = room(x, y) == 0 ? 1000 : scale * room(x, y);
                        return std::lround(z / 1000 * 0xffffff) >> 8 * c & 255;
                    }));
}

TEST_F(ValueEvidence, ReadsDepthOfThreeChannels) {
    const auto metres = [](int x, int y) { return 8 * room(x, y); };
    for (const std::string number : {"1.png", "2.png"}) {
        write_packed(folder / ("clip/a/" + number), 8);
        write_in_folder(folder / ("clip/b/" + number),
                        made_image(shown_wide, shown_high, 1, 3, [](int x, int y, int c) {
                            return (3 * (shown_wide * y + x) + c) * 5 / 7 + c;
                        }));
    }
    for (const char* name : {"clip/a/1.png", "clip"})
        EXPECT_TRUE(has_words(expect_depths(folder / name, metres, 1e-4), "preset carla"));
    // Nothing shows within one step of the highest byte; a person says it.
    write_packed(folder / "near.png", 1);
    EXPECT_TRUE(is_refused(open_clip(folder / "near.png"), "is in colour"));
    expect_depths(folder / "near.png", room, 1e-4, stated(&SourceDescription::preset, "carla"));
}

/// Red, green, blue and alpha of each pixel.
void write_rgba(const std::filesystem::path& file,
                const std::function<std::array<unsigned, 4>(int x, int y)>& bytes) {
    write_in_folder(file, rgba_png(shown_wide, shown_high, [&](int x, int y, int c) {
                        return bytes(x, y)[static_cast<std::size_t>(c)];
                    }));
}

TEST_F(ValueEvidence, ReadsFloatsInFourChannels) {
    // Which byte of the float, the lowest first, is in red, green, blue and alpha.
    const std::pair<const char*, std::array<unsigned, 4>> orders[] = {
        {"rgba32f", {0, 1, 2, 3}}, {"bgra32f", {2, 1, 0, 3}}, {"abgr32f", {3, 2, 1, 0}}};
    for (const double times : {1.0, 0.7}) {  // at 1.4 to 1.6 m all have one exponent
        const auto metres = [&](int x, int y) { return times * room(x, y); };
        for (const auto& [name, places] : orders) {
            write_rgba(folder / name / "depth/0.png", [&, places = places](int x, int y) {
                const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(metres(x, y)));
                std::array<unsigned, 4> bytes{};
                for (std::size_t c = 0; c < 4; ++c) bytes[c] = bits >> 8 * places[c] & 0xffU;
                return bytes;
            });
            const std::string preset = std::string("preset ") + name;
            EXPECT_TRUE(has_words(expect_depths(folder / name / "depth/0.png", metres, 1e-4), preset));
            const std::string notes = expect_depths(folder / name, metres, 1e-4);
            EXPECT_TRUE(has_words(notes, preset));
            EXPECT_TRUE(has_words(notes, "values are metres"));
            write_bytes(folder / name / "scene.json", scene_to_json(must(guess_folder(folder / name, {}))));
            expect_depths(folder / name, metres, 1e-4);
            std::filesystem::remove(folder / name / "scene.json");
        }
    }
}

/// Too smooth for evidence; an alpha that only cuts out is none of a float.
TEST_F(ValueEvidence, NamesPresetsOfColour) {
    const auto refusal = [&](bool are_floats) {
        write_rgba(folder / "a.png", [&](int x, int y) -> std::array<unsigned, 4> {
            const auto bits = std::bit_cast<std::uint32_t>(2 + 0.5F * static_cast<float>(y < shown_high / 2));
            if (are_floats) return {bits >> 16 & 0xffU, bits >> 8 & 0xffU, bits & 0xffU, bits >> 24};
            return {x < 5 ? 200U : 20U, 30, 40, x < 5 ? 255U : 0U};
        });
        const auto refused = open_clip(folder / "a.png");
        return refused ? Error{} : refused.error();
    };
    EXPECT_TRUE(has_words(refusal(true).message, "is in colour: its bytes and its alpha's may be floats"));
    EXPECT_EQ(refusal(true).hints.at(0).value, "bgra32f");
    EXPECT_TRUE(has_words(refusal(false).message, "is in colour: a colour map's colours are no depth"));
    EXPECT_EQ(refusal(false).hints.at(0).value, "bgr24");
}

TEST_F(ValueEvidence, ReadsWordsInTwoChannels) {
    for (const bool red_is_high : {true, false}) {
        write_rgba(folder / "a.png", [&](int x, int y) -> std::array<unsigned, 4> {
            const unsigned z = millimetres_of(room(x, y));
            return {red_is_high ? z >> 8 : z & 0xffU, red_is_high ? z & 0xffU : z >> 8, 0, 255};
        });
        const std::string notes =
            expect_depths(folder / "a.png", [](int x, int y) { return millimetres_of(room(x, y)) / 1e3; });
        EXPECT_TRUE(has_words(notes, red_is_high ? "preset gr16" : "preset rg16"));
        EXPECT_TRUE(has_words(notes, "depth codes are millimetres"));
    }
}

/// Shares of a far plane, which nothing tells: --depth-unit does.
TEST_F(ValueEvidence, ReadsSharesWithHighestByteInRed) {
    const auto metres = [](int x, int y) {
        return room(x, y) == 0 ? 0 : room(x, y) + 0.0003 * ((x * 37 + y * 11) % 64);  // of many values
    };
    for (const unsigned base : {255U, 256U}) {
        const double whole = base == 255 ? std::pow(255, 3) : 0xffffff;
        write_rgba(folder / "a.png", [&](int x, int y) -> std::array<unsigned, 4> {
            const auto code = static_cast<unsigned>(std::lround(metres(x, y) / 40 * whole));
            return room(x, y) == 0 ? std::array{255U, 255U, 255U, 255U}
                                   : std::array{code / base / base, code / base % base, code % base, 255U};
        });
        const auto reader = must(open_clip(folder / "a.png"));
        EXPECT_TRUE(is_noted(*reader, "depth has no scale"));
        EXPECT_TRUE(is_noted(*reader, base == 255 ? "preset bgr255" : "preset bgr24"));
        expect_depths(folder / "a.png", metres, 1e-4, stated(&SourceDescription::metres_per_code, 40));
    }
}

/// Where too little shows, the message names the likeliest, and the preset opens it.
TEST_F(ValueEvidence, NamesLikelyPacking) {
    write_rgba(folder / "depth/a.png", [&](int x, int y) -> std::array<unsigned, 4> {
        const unsigned z = 2560U + static_cast<unsigned>(y > 40 ? 0 : x < 4 && y < 4 ? -9 : x % 30);
        return {z >> 8, z & 0xffU, 0, 255};
    });
    for (const char* name : {"depth/a.png", ""}) {
        const auto refused = open_clip(folder / name);
        ASSERT_FALSE(refused);
        EXPECT_TRUE(has_words(message(refused), "its bytes look like 16 bits: green + 256 red")) << name;
        ASSERT_EQ(refused.error().hints.size(), 1U);
        EXPECT_EQ(refused.error().hints.front().value, "gr16");
        EXPECT_EQ(message(open_clip(folder / name, {}, stated(&SourceDescription::preset, "gr16"))), "")
            << name;
    }
}

TEST_F(ValueEvidence, IgnoresColourMaps) {
    for (int map = 0; map < 3; ++map) {
        write_in_folder(folder / "a.png", made_image(256, 64, 1, 3, [&](int x, int y, int c) {
                            const int up = (x + y) & 255, wave = std::abs(((x * 3 + y) & 511) - 255);
                            const int of_maps[][3] = {{up, wave, 255 - up},
                                                      {wave, 255 - wave, up},
                                                      {x * 7 + y * 13, x * 31, y * 17}};
                            return of_maps[map][c];
                        }));
        EXPECT_TRUE(is_refused(open_clip(folder / "a.png"), "is in colour")) << map;
    }
}

TEST_F(ValueEvidence, RecognisesDisparitiesByName) {
    const auto disparity = [](int x, int y) { return y < 4 ? 0U : static_cast<unsigned>(40 + x + 2 * y); };
    for (const char* name : {"disp1.png", "left_disparity.png", "display.png"})
        write_words(folder / name, disparity);
    for (const char* name : {"disp1.png", "left_disparity.png"}) {
        auto reader = must(open_clip(folder / name));
        EXPECT_TRUE(is_noted(*reader, "depth is disparities, as the name says, and no calib.txt"));
        EXPECT_EQ(reader->scene().depth.kind, DepthCodingKind::inverse);
        EXPECT_TRUE(reader->scene().depth.near_is_high);
        const auto frame = must(reader->next());
        const DepthCoding& depth = reader->scene().depth;
        EXPECT_FALSE(depth.is_valid(stored_code((*frame).depth, depth, 5, 2)));
        EXPECT_TRUE(depth.is_valid(stored_code((*frame).depth, depth, 5, 9)));
    }
    auto other = must(open_clip(folder / "display.png"));
    EXPECT_FALSE(is_noted(*other, "disparities"));
    write_bytes(folder / "calib.txt",
                "cam0=[80 0 31.5; 0 80 23.5; 0 0 1]\ncam1=[80 0 31.5; 0 80 23.5; 0 0 1]\ndoffs=0\n"
                "baseline=200\nwidth=64\nheight=48\n");
    const std::string notes = expect_depths(
        folder / "disp1.png",
        [&](int x, int y) { return disparity(x, y) == 0 ? 0 : 80 * 0.2 / disparity(x, y); }, 1e-3);
    EXPECT_TRUE(has_words(notes, "baseline and focal length are those of calib.txt"));
    EXPECT_EQ(
        must(open_clip(folder / "disp1.png", std::nullopt, stated(&SourceDescription::fov, 60)))->inputs(),
        (std::vector{folder / "disp1.png", folder / "calib.txt"}));
}

/// Values that mean something else by themselves, and lengths by what a file or a name says.
TEST_F(ValueEvidence, PrefersStatedUnit) {
    const auto scale_of = [&](const std::string& name, const std::string& part) {
        auto reader = open_clip(folder / name);
        EXPECT_EQ(message(reader), "") << name;
        if (!reader) return 0.0;
        EXPECT_TRUE(is_noted(**reader, part)) << name;
        return (*reader)->scene().depth.scale * (*reader)->scene().metres_per_unit;
    };
    const auto multiples_of_8 = [](int x, int y) {
        return 8 * static_cast<unsigned>(room_millimetres(x, y, 1500));
    };
    write_words(folder / "plain.png", multiples_of_8);
    (void)scale_of("plain.png", "depth is as preset sun has it");
    write_words(folder / "stated.png", multiples_of_8);
    write_bytes(folder / "stated.json", R"({"fx": 70, "fy": 70, "cx": 32, "cy": 24, "depth_scale": 0.0002})");
    EXPECT_DOUBLE_EQ(scale_of("stated.png", "a code is 0.2 mm, as stated.json says"), 0.0002);
    // A folder of disparities may have depth in it, and a folder's word counts where the file has none.
    const auto millimetres = [](int x, int y) { return static_cast<unsigned>(room_millimetres(x, y, 1500)); };
    for (const char* name : {"disp/depth_1.png", "range/kinect.png", "range/1.png", "depth_cm.png"})
        write_words(folder / name, millimetres);
    EXPECT_DOUBLE_EQ(scale_of("disp/depth_1.png", "depth codes are millimetres"), 0.001);
    EXPECT_DOUBLE_EQ(scale_of("range/kinect.png", "if it goes along each pixel's ray"), 0.001);
    EXPECT_DOUBLE_EQ(scale_of("range/1.png", "each pixel's ray, as the name says"), 0.001);
    EXPECT_DOUBLE_EQ(scale_of("depth_cm.png", "values are centimetres, as the name says"), 0.01);
    // 8 bits are no lengths, whatever a camera's file says of its 16.
    write_in_folder(folder / "eight.png", made_image(shown_wide, shown_high, 1, 1, [](int x, int y, int) {
                        return 20 + (shown_wide * y + x) % 200;
                    }));
    write_bytes(folder / "eight.json", R"({"fx": 70, "fy": 70, "cx": 32, "cy": 24, "depth_scale": 0.001})");
    (void)scale_of("eight.png", "depth has no scale");
}

/// A code far above all others is a sensor's "nothing there"; with others near it, it is a wall.
TEST_F(ValueEvidence, DropsLoneLargestCode) {
    const auto is_none = [&](unsigned largest, int farthest) {
        write_words(folder / "a.png", [&](int x, int y) {
            return x < 4 ? largest : static_cast<unsigned>(room_millimetres(x, y, farthest));
        });
        auto reader = open_clip(folder / "a.png");
        EXPECT_EQ(message(reader), "");
        return reader && is_noted(**reader, std::to_string(largest) + " is no depth, as many pixels have it");
    };
    for (const unsigned largest : {4095U, 8191U, 10'000U, 32'767U})
        EXPECT_TRUE(is_none(largest, 2000)) << largest;
    EXPECT_FALSE(is_none(4095, 3900));
    EXPECT_FALSE(is_none(5000, 2000)) << "no number by which devices say none";
}

/// Values that more than one unit fits: each is named with what the scene is in it.
TEST_F(ValueEvidence, NamesOtherFittingUnits) {
    const auto noted = [&](const std::function<unsigned(int x, int y)>& word, const std::string& part) {
        write_words(folder / "a.png", word);
        auto reader = open_clip(folder / "a.png");
        EXPECT_EQ(message(reader), "");
        return reader && is_noted(**reader, part);
    };
    const auto of_256 = [](int x, int y) { return static_cast<unsigned>(std::lround(256 * room(x, y))); };
    EXPECT_TRUE(noted(of_256, "m if 256 codes are a metre"));
    const auto with_sky = [](int x, int y) {
        return y < 10 ? 65535U : 2000U + static_cast<unsigned>(3 * x + y);
    };
    EXPECT_TRUE(noted(with_sky, "if they are centimetres and 65535 is the sky"));
    // A small sky does not make of lengths what uses the whole range.
    const auto with_little = [](int x, int y) {
        return y < 1 ? 65535U : 1000U + static_cast<unsigned>(13 * x + y);
    };
    EXPECT_TRUE(noted(with_little, "if they are centimetres and 65535 is the sky"));
    EXPECT_TRUE(noted(with_sky, "if they are centimetres and 65535 is the sky"));
    expect_depths(
        folder / "a.png", [&](int x, int y) { return y < 10 ? 0 : 0.01 * with_sky(x, y); }, 1e-6,
        stated(&SourceDescription::preset, "vkitti"));
    const auto of_tum = [](int x, int y) { return static_cast<unsigned>(std::lround(5003 * room(x, y))); };
    EXPECT_TRUE(noted(of_tum, "if 5000 codes are a metre"));
    EXPECT_TRUE(noted(of_tum, "if they are tenths of a millimetre"));
    const auto plain = [](int x, int y) { return millimetres_of(room(x, y)); };
    EXPECT_FALSE(noted(plain, "codes are a metre"));
    EXPECT_FALSE(noted(plain, "if they are"));
}

TEST_F(ValueEvidence, FindsNothingInOrdinaryMillimetres) {
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
        EXPECT_EQ(estimate_values(picture).divisor, 1) << round;
        EXPECT_EQ(evident_preset(picture).preset, nullptr) << round;
    }
}

TEST_F(ValueEvidence, DropsMinusOneInArrays) {
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
        const std::string notes = expect_depths(
            folder / name, [](int x, int y) { return (x + y) % 9 == 0 ? 0 : 0.001 * (900 + 7 * x + 5 * y); });
        EXPECT_EQ(notes.find("0 and what is below it are no depth") != std::string::npos,
                  std::string(name) != "last.npy")
            << notes;
    }
}

}  // namespace
}  // namespace touchable::test
