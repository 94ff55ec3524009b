// A picture that does not change is stored once, and given again at no cost.
#include <gtest/gtest.h>

#include "engine/clip/clip_file.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/video/clip_remux.hpp"

namespace touchable::test {
namespace {

constexpr Planes still_planes{true, true, true, false};

/// Depth changes in every frame, colour in every fifth, haptic at frame 7, height never.
RawFrame partly_still(const Scene& scene, std::int64_t number) {
    RawFrame frame = test_frame(scene, number, still_planes);
    const auto still = [&](PlaneView RawFrame::*plane, std::int64_t since) {
        const RawFrame other = test_frame(scene, since, still_planes);
        frame.*plane = other.*plane;
        frame.storage = std::make_shared<std::pair<std::shared_ptr<const void>, std::shared_ptr<const void>>>(
            frame.storage, other.storage);
    };
    still(&RawFrame::colour, number - number % 5);
    still(&RawFrame::haptic, number < 7 ? 0 : 7);
    still(&RawFrame::height, 0);
    return frame;
}

constexpr int still_frames = 37;

std::filesystem::path partly_still_clip(const TemporaryFolder& folder, const Scene& scene, Archive archive) {
    const auto file = folder / "still.mkv";
    auto writer = create_clip(file, scene, {archive, true});
    EXPECT_EQ(message(writer), "");
    for (int n = 0; n < still_frames; ++n) EXPECT_EQ(message((*writer)->write(partly_still(scene, n))), "");
    EXPECT_EQ(message((*writer)->finish()), "");
    return file;
}

TEST(UnchangedPictures, ComeBackExactlyAndFromAnyFrame) {
    for (const Archive archive : {Archive::fast, Archive::small})
        for (const int width : {24, 320}) {
            const TemporaryFolder folder;
            const Scene scene = small_scene(width, 160, 16);
            auto reader = open_clip(partly_still_clip(folder, scene, archive));
            ASSERT_EQ(message(reader), "");
            EXPECT_EQ((*reader)->frame_count(), still_frames);
            for (int n = 0; n < still_frames; ++n) {
                const auto frame = (*reader)->next();
                ASSERT_EQ(message(frame), "");
                ASSERT_TRUE(same_frame(**frame, partly_still(scene, n))) << n;
            }
            EXPECT_FALSE((*reader)->next()->has_value());
            for (const std::int64_t n : {36, 9, 6, 15, 21, 29}) {
                ASSERT_EQ(message((*reader)->seek(n)), "");
                ASSERT_TRUE(same_frame(**(*reader)->next(), partly_still(scene, n))) << n;
            }
        }
}

TEST(UnchangedPictures, AreStoredOnceBetweenAccessPoints) {
    const TemporaryFolder folder;
    const auto file = partly_still_clip(folder, small_scene(24, 16, 16), Archive::fast);
    // Frames 0, 15 and 30 have all; beyond them depth 34, colour 5, 10, 20, 25 and 35, haptic 7.
    EXPECT_EQ(packets(file).size(), 3U * 4U + 34U + 5U + 1U);
}

/// So that whoever compares frames compares no sample.
TEST(UnchangedPictures, AreTheSameMemory) {
    const TemporaryFolder folder;
    const auto all = read_clip(partly_still_clip(folder, small_scene(24, 16, 16), Archive::fast));
    ASSERT_EQ(message(all), "");
    for (std::size_t n = 1; n < all->size(); ++n) {
        const RawFrame &before = (*all)[n - 1], &now = (*all)[n];
        EXPECT_EQ(now.height.data, before.height.data) << n;
        EXPECT_EQ(now.haptic.data == before.haptic.data, n != 7) << n;
        EXPECT_EQ(now.colour.data == before.colour.data, n % 5 != 0) << n;
        EXPECT_NE(now.depth.data, before.depth.data) << n;
    }
}

/// A block that is lost is missed, though gaps belong to the format.
TEST(UnchangedPictures, ALostPictureIsNoGap) {
    const TemporaryFolder folder;
    const auto file = partly_still_clip(folder, small_scene(24, 16, 16), Archive::fast);
    Remux changes;
    changes.drop = [](const std::string& role, int number) { return role == "colour" && number == 2; };
    remux(file, folder / "lost.mkv", changes);
    EXPECT_TRUE(is_refused(read_clip(folder / "lost.mkv"), "track colour, frame 10: is missing"));
}

}  // namespace
}  // namespace touchable::test
