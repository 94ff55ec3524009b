// A clip with relief: its other planes as they were, heights that are the same bits everywhere.
#include "engine/authoring/recorded_clip.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "engine/base/same_bits.hpp"
#include "engine/clip/clip.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/video/clip_remux.hpp"

namespace touchable::test {
namespace {

Result<std::unique_ptr<ClipReader>> looked_at_and_with_relief(std::unique_ptr<ClipReader> clip,
                                                              const ReliefSettings& settings,
                                                              double max_height) {
    auto looked = look_at_relief(std::move(clip), settings);
    if (!looked) return looked.error();
    return with_relief(std::move(looked->clip), settings, looked->range, max_height);
}

constexpr int columns = 48, rows = 36, count = 20;

class ReliefClip : public ::testing::Test {
protected:
    ReliefClip() {
        scene_.rate = {30000, 1001};
        EXPECT_EQ(message(write_clip(folder_ / "clip.mkv", scene_, count, planes_, {Archive::fast, false})),
                  "");
    }
    std::unique_ptr<ClipReader> open(const ReliefSettings& settings = {}) const {
        auto clip = open_clip(folder_ / "clip.mkv");
        EXPECT_EQ(message(clip), "");
        auto relief = looked_at_and_with_relief(std::move(*clip), settings, 2);
        EXPECT_EQ(message(relief), "");
        return relief ? std::move(*relief) : nullptr;
    }
    static std::uint64_t hash_of(const std::vector<RawFrame>& frames) {
        ByteHash hash;
        for (const RawFrame& frame : frames)
            for (int y = 0; y < rows; ++y) hash.add(frame.height.row(y), columns);
        return hash.value();
    }

    const Planes planes_{.colour = true, .haptic = true, .height = false, .noisy = false};
    Scene scene_ = small_scene(columns, rows, 12);
    TemporaryFolder folder_;
};

TEST_F(ReliefClip, HasHeightsAndAllElseAsItWas) {
    auto plain = open_clip(folder_ / "clip.mkv");
    ASSERT_EQ(message(plain), "");
    const auto before = read_all(**plain);
    auto reader = open();
    const auto frames = read_all(*reader);
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), before->size());
    for (std::size_t n = 0; n < frames->size(); ++n) {
        RawFrame without = (*frames)[n];
        ASSERT_FALSE(without.height.empty());
        without.height = {};
        EXPECT_TRUE(same_frame(without, (*before)[n])) << n;
    }
    EXPECT_EQ(reader->scene().height_coding.max_height, 2);
    EXPECT_EQ(reader->scene().height_coding.code_max, 255);
    EXPECT_EQ(reader->tracks().back().role, "height");
}

TEST_F(ReliefClip, IsTheSameAgainAndWithoutSomebodyToSeeTheColour) {
    auto reader = open();
    const auto once = read_all(*reader);
    ASSERT_EQ(message(reader->rewind()), "");
    reader->leave_out_colour();
    const auto again = read_all(*reader);
    ASSERT_EQ(message(again), "");
    EXPECT_EQ(hash_of(*once), hash_of(*again));
}

TEST_F(ReliefClip, IsWrittenWithTheOtherTracksAsTheyAreStored) {
    auto reader = open();
    SceneDescription described = reader->described();
    ClipStorage storage{Archive::fast, false};
    storage.copied =
        ClipStorage::Copied{folder_ / "clip.mkv", {PlaneRole::depth, PlaneRole::colour, PlaneRole::haptic}};
    auto writer = create_clip(folder_ / "relief.mkv", described, storage);
    ASSERT_EQ(message(writer), "");
    const auto made = read_all(*reader);
    for (const RawFrame& frame : *made) ASSERT_EQ(message((*writer)->write(frame)), "");
    ASSERT_EQ(message((*writer)->finish()), "");
    auto written = open_clip(folder_ / "relief.mkv");
    ASSERT_EQ(message(written), "");
    EXPECT_EQ((*written)->frame_count(), count);
    const auto read = read_all(**written);
    ASSERT_EQ(message(read), "");
    for (std::size_t n = 0; n < made->size(); ++n) EXPECT_TRUE(same_frame((*read)[n], (*made)[n])) << n;
    // Lossy colour would be another after it was encoded once more.
    auto kept = packets(folder_ / "relief.mkv"), before = packets(folder_ / "clip.mkv");
    for (const std::string& packet : before)
        EXPECT_NE(std::find(kept.begin(), kept.end(), packet), kept.end());
    // Any frame can be sought, as in any clip.
    for (const std::int64_t frame : {15, 7, 19}) {
        ASSERT_EQ(message((*written)->seek(frame)), "");
        const auto there = (*written)->next();
        ASSERT_EQ(message(there), "");
        EXPECT_TRUE(same_frame(**there, (*made)[static_cast<std::size_t>(frame)])) << frame;
    }
}

TEST_F(ReliefClip, WithoutColourIsRefused) {
    ASSERT_EQ(message(write_clip(folder_ / "grey.mkv", scene_, 2, {})), "");
    auto clip = open_clip(folder_ / "grey.mkv");
    ASSERT_EQ(message(clip), "");
    const auto relief = looked_at_and_with_relief(std::move(*clip), {}, 2);
    ASSERT_FALSE(relief);
    EXPECT_EQ(relief.error().kind, ErrorKind::input);
    EXPECT_NE(relief.error().message.find("has no colour"), std::string::npos) << relief.error().message;
}

TEST_F(ReliefClip, LeavesRoomBeforeTheCamera) {
    auto clip = open_clip(folder_ / "clip.mkv");
    auto relief = looked_at_and_with_relief(std::move(*clip), {}, 50);
    ASSERT_EQ(message(relief), "");
    EXPECT_NEAR((*relief)->scene().height_coding.max_height, 5, 0.1);  // the nearest depth is 10
}

/// Noise that is another in each frame, and an even colour.
TEST_F(ReliefClip, SaysWhereItIsOnlyNoiseAndWhereThereIsNone) {
    const auto note_of = [&](const std::string& name, const std::function<int(int, int, int)>& grey) {
        auto writer = create_clip(folder_ / name, small_scene(columns, rows), exact_clip);
        for (int n = 0; n < 5; ++n) {
            RawFrame frame = test_frame(small_scene(columns, rows), n, {.noisy = false});
            Image colour{columns, rows, 1, 3, {}};
            for (int y = 0; y < rows; ++y)
                for (int x = 0; x < columns; ++x)
                    colour.samples.insert(colour.samples.end(), 3, static_cast<std::uint8_t>(grey(n, x, y)));
            add_plane(frame, PlaneRole::colour, plane_from(std::move(colour)));
            EXPECT_EQ(message((*writer)->write(frame)), "");
        }
        EXPECT_EQ(message((*writer)->finish()), "");
        auto clip = open_clip(folder_ / name);
        auto relief = looked_at_and_with_relief(std::move(*clip), {}, 2);
        EXPECT_EQ(message(relief), "");
        return (*relief)->notes().back();
    };
    Numbers numbers(3);
    const auto noise = [&] { return static_cast<int>(numbers.next() % 9); };
    const std::string noisy = note_of("noise.mkv", [&](int, int, int) { return 100 + noise(); });
    EXPECT_NE(noisy.find("most of what is felt is noise"), std::string::npos) << noisy;
    const std::string clear =
        note_of("clear.mkv", [&](int, int x, int y) { return 100 + noise() + (x % 8 < 4 ? 60 : 0) + y; });
    EXPECT_NE(clear.find("noise from frame to frame is"), std::string::npos) << clear;
    EXPECT_EQ(clear.find("most of what is felt"), std::string::npos) << clear;
    const std::string even = note_of("even.mkv", [](int, int, int) { return 100; });
    EXPECT_NE(even.find("nothing of it can be felt"), std::string::npos) << even;
}

/// Of GCC, Clang, with and without optimisation.
TEST_F(ReliefClip, HasTheSameBitsEverywhere) {
    Scene scene = small_scene(columns, rows);
    auto writer = create_clip(folder_ / "exact.mkv", scene, exact_clip);
    for (int n = 0; n < 5; ++n) {
        // Noise over a slope, which surfaces of random depths would cut to single pixels.
        RawFrame frame = test_frame(scene, n, {.noisy = false});
        const RawFrame noise = test_frame(scene, n, {.colour = true});
        frame.colour = noise.colour;
        ASSERT_EQ(message((*writer)->write(frame)), "");
    }
    ASSERT_EQ(message((*writer)->finish()), "");
    auto clip = open_clip(folder_ / "exact.mkv");
    auto relief = looked_at_and_with_relief(std::move(*clip), {}, 2);
    ASSERT_EQ(message(relief), "");
    const auto frames = read_all(**relief);
    const auto least =
        std::minmax_element((*frames)[2].height.row(20), (*frames)[2].height.row(20) + columns);
    EXPECT_GT(*least.second - *least.first, 60);
    EXPECT_EQ(hash_of(*frames), 15312345440906504892U);
}

}  // namespace
}  // namespace touchable::test
