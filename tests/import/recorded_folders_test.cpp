#include <gtest/gtest.h>

#include "engine/clip/clip_file.hpp"
#include "engine/scene/scene.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/real_data.hpp"
#include "tests/stand_ins.hpp"

namespace touchable::test {
namespace {

/// A real recording beside the checkout, its scene in the repository, or its stand-in.
struct Recording {
    const char* scene;
    const char* folder;  ///< null: the stand-in
    int frames;
    double nearest_mm, median_mm[2];  ///< no valid depth is nearer; the median lies between
    double valid_share;               ///< at least, of all pixels
};

// Ranges read off the recordings: a model on a table, a cube on a table, a chair in a room, a rendered room.
constexpr Recording recordings[] = {
    {"castel_sr300", "castel_sr300", 30, 150, {240, 280}, 0.5},
    {"visp_cube_realsense", "visp_cube_realsense", 10, 150, {380, 500}, 0.7},
    {"redwood5", "stills/redwood5", 5, 900, {1700, 2000}, 0.85},
    {"icl_nuim5", "stills/icl_nuim5", 5, 700, {1400, 3100}, 0.999},
};
// Of the wall, which is most of the picture, and what stands at three quarters of the way to it.
constexpr Recording generated[] = {
    {"castel_sr300", nullptr, 4, 200, {240, 350}, 0.97},
    {"visp_cube_realsense", nullptr, 4, 350, {420, 600}, 0.96},
    {"redwood5", nullptr, 4, 1400, {1600, 2300}, 0.97},
    {"icl_nuim5", nullptr, 4, 2000, {2200, 3200}, 0.999},
};

class RecordedFolder : public ::testing::TestWithParam<Recording> {
protected:
    std::filesystem::path folder() const {
        return GetParam().folder ? real_data(GetParam().folder) : written_.path();
    }
    std::filesystem::path scene_file() const {
        if (!GetParam().folder) return folder() / "scene.json";
        return std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "tests/scenes" /
               (std::string(GetParam().scene) + ".json");
    }
    void SetUp() override {
        if (!GetParam().folder) write_stand_in(written_.path(), stand_in(GetParam().scene));
        TOUCHABLE_NEEDS_DATA(folder());
    }

private:
    const TemporaryFolder written_;
};

bool varies(const PlaneView& picture) {
    for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x)
            if (picture.sample(x, y) != picture.sample(0, 0)) return true;
    return false;
}

TEST_P(RecordedFolder, GivesAllFramesAtPlausibleDepths) {
    auto reader = open_clip(folder(), scene_file());
    ASSERT_EQ(message(reader), "");
    const Scene& scene = (*reader)->scene();
    EXPECT_DOUBLE_EQ(scene.metres_per_unit, 0.001);
    ASSERT_EQ((*reader)->tracks().size(), 2U);
    const auto frames = read_all(**reader);
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), static_cast<std::size_t>(GetParam().frames));
    for (const RawFrame& frame : *frames) {
        EXPECT_EQ(frame.time_ns, frame.number * 1'000'000'000 / 30);
        ASSERT_EQ(frame.depth.bytes_per_sample, 2);
        ASSERT_EQ(frame.colour.channels, 3);
        EXPECT_TRUE(varies(frame.colour));
        std::vector<std::size_t> histogram(65536);
        std::size_t valid = 0,
                    pixels = static_cast<std::size_t>(scene.width) * static_cast<std::size_t>(scene.height);
        for (int y = 0; y < scene.height; ++y)
            for (int x = 0; x < scene.width; ++x) {
                const std::uint16_t code = frame.depth.sample(x, y);
                if (!scene.depth.is_valid(code)) continue;
                ++histogram[code];
                ++valid;
            }
        EXPECT_GT(static_cast<double>(valid), GetParam().valid_share * static_cast<double>(pixels));
        std::uint16_t least = 0, median = 0;
        while (histogram[least] == 0) ++least;
        for (std::size_t below = 0; below <= valid / 2; ++median) below += histogram[median];
        EXPECT_GT(scene.depth.depth(least), GetParam().nearest_mm);
        EXPECT_GT(scene.depth.depth(median), GetParam().median_mm[0]);
        EXPECT_LT(scene.depth.depth(median), GetParam().median_mm[1]);
    }
}

TEST_P(RecordedFolder, ComesBackExactlyFromAClip) {
    const TemporaryFolder output;
    auto reader = open_clip(folder(), scene_file());
    ASSERT_EQ(message(reader), "");
    auto writer = create_clip(output / "clip.mkv", (*reader)->scene(), exact_clip);
    ASSERT_EQ(message(writer), "");
    std::vector<RawFrame> originals;
    for (int n = 0; n < 3; ++n) {
        auto frame = (*reader)->next();
        ASSERT_EQ(message(frame), "");
        ASSERT_EQ(message((*writer)->write(**frame)), "");
        originals.push_back(std::move(**frame));
    }
    ASSERT_EQ(message((*writer)->finish()), "");
    const auto frames = read_clip(output / "clip.mkv");
    ASSERT_EQ(message(frames), "");
    EXPECT_TRUE(std::equal(originals.begin(), originals.end(), frames->begin(), frames->end(), same_frame));
}

INSTANTIATE_TEST_SUITE_P(Real, RecordedFolder, ::testing::ValuesIn(recordings),
                         [](const auto& parameter) { return std::string(parameter.param.scene); });
INSTANTIATE_TEST_SUITE_P(Generated, RecordedFolder, ::testing::ValuesIn(generated),
                         [](const auto& parameter) { return std::string(parameter.param.scene); });

}  // namespace
}  // namespace touchable::test
