// Colour that nobody looks at is not decoded, and all else stays as it is.
#include <gtest/gtest.h>

#include "tests/clip/clip_fixture.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

struct Reading {
    std::string error;
    std::vector<RawFrame> frames;
};

Reading read_without_colour(const std::filesystem::path& file, bool twice = false) {
    auto reader = open_clip(file);
    if (!reader) return {reader.error().message, {}};
    (*reader)->leave_out_colour();
    if (twice) {
        if (auto first = read_all(**reader); !first) return {first.error().message, {}};
        if (auto back = (*reader)->rewind(); !back) return {back.error().message, {}};
    }
    auto frames = read_all(**reader);
    if (!frames) return {frames.error().message, {}};
    return {"", std::move(*frames)};
}

TEST(LeftOutColour, OtherPlanesAreTheSameAndColourIsGone) {
    const TemporaryFolder folder;
    const auto file = folder / "clip.mkv";
    ASSERT_EQ(message(write_clip(file, small_scene(40, 30, 16), 6, all_planes)), "");
    auto reader = open_clip(file);
    ASSERT_TRUE(reader);
    const auto whole = read_all(**reader);
    ASSERT_TRUE(whole);
    for (const bool twice : {false, true}) {
        const Reading less = read_without_colour(file, twice);
        ASSERT_EQ(less.error, "");
        ASSERT_EQ(less.frames.size(), whole->size());
        for (std::size_t n = 0; n < whole->size(); ++n) {
            RawFrame expected = (*whole)[n], frame = less.frames[n];
            EXPECT_EQ(frame.colour.empty(), n > 0 || twice) << "the first frame tells what there is";
            expected.colour = frame.colour = {};
            EXPECT_TRUE(same_frame(expected, frame)) << n;
        }
    }
}

TEST(LeftOutColour, DamageOfColourIsFoundAllTheSame) {
    const TemporaryFolder folder;
    ASSERT_EQ(message(write_clip(folder / "whole.mkv", small_scene(8, 8, 12), 2, {true})), "");
    const std::string bytes = read_bytes(folder / "whole.mkv");
    std::size_t refused = 0;
    for (std::size_t at = 0; at < bytes.size(); at += 3 * sweep_step()) {
        std::string damaged = bytes;
        damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
        std::filesystem::remove(folder / "damaged.mkv");
        write_bytes(folder / "damaged.mkv", damaged);
        std::string error;
        auto reader = open_clip(folder / "damaged.mkv");
        if (!reader)
            error = reader.error().message;
        else if (const auto frames = read_all(**reader); !frames)
            error = frames.error().message;
        EXPECT_EQ(read_without_colour(folder / "damaged.mkv").error, error) << "byte " << at;
        refused += !error.empty();
    }
    EXPECT_GT(refused, 50 / sweep_step());
}

}  // namespace
}  // namespace touchable::test
