// Clips whose disk becomes full: whoever stops when that is said has a whole one.
#include <gtest/gtest.h>

#include "engine/clip/clip.hpp"
#include "engine/clip/clip_file.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/full_disk.hpp"

namespace touchable::test {
namespace {

namespace fs = std::filesystem;

TEST(ReservedOutput, AClipThatStopsWhenItsDiskIsFullIsWholeUpToThere) {
    const TemporaryFolder folder;
    constexpr std::uintmax_t room = 600'000;
    const fs::path file = folder / "clip.mkv";
    const Scene scene = small_scene(64, 48, 16);
    std::int64_t written = 0;
    {
        const FullDisk full(room);
        const auto clip = create_clip(file, scene);
        ASSERT_TRUE(clip) << clip.error().message;
        while (!(*clip)->is_full()) {
            const auto done = (*clip)->write(test_frame(scene, written, {}));
            ASSERT_TRUE(done) << "after " << written << " frames: " << done.error().message;
            ASSERT_LT(++written, 1000) << "the disk is larger than it is";
        }
        const auto finished = (*clip)->finish();
        ASSERT_TRUE(finished) << finished.error().message;
    }
    EXPECT_LE(fs::file_size(file), room);
    EXPECT_GT(fs::file_size(file), room / 2) << "most of the room is for pictures";
    const auto reader = open_clip(file);
    ASSERT_TRUE(reader) << reader.error().message;
    for (std::int64_t number = 0; number < written; ++number) {
        const auto frame = (*reader)->next();
        ASSERT_TRUE(frame && frame->has_value()) << number;
    }
    EXPECT_FALSE((*reader)->next()->has_value()) << "and no more";
}

TEST(ReservedOutput, LeavesNothingBehindAWholeFile) {
    const TemporaryFolder folder;
    const Scene scene = small_scene(8, 8);
    const auto clip = create_clip(folder / "clip.mkv", scene);
    ASSERT_TRUE(clip);
    ASSERT_TRUE((*clip)->write(test_frame(scene, 0, {})));
    EXPECT_FALSE((*clip)->is_full());
    ASSERT_TRUE((*clip)->finish());
    EXPECT_LT(fs::file_size(folder / "clip.mkv"), 4096U) << "what was reserved is given back";
}

}  // namespace
}  // namespace touchable::test
