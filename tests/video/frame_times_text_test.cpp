#include "engine/clip/containers.hpp"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

TEST(FrameTimesText, ComesBackToTheNanosecond) {
    const std::vector<std::int64_t> times_ns{0, 1'000'000, 33'366'667, 4'000'000'000'000'001};
    const std::string text = frame_times_text(*rate_of_own_times(times_ns));
    EXPECT_EQ(text, "# timestamp format v2\n0.000000\n1.000000\n33.366667\n4000000000.000001\n");
    const auto back = parse_frame_times(text, "x");
    ASSERT_EQ(message(back), "");
    EXPECT_EQ(*back->own_times, times_ns);
}

TEST(FrameTimesText, IsReadAsOtherProgramsWriteIt) {
    const auto rate = parse_frame_times("# timecode format v2\r\n40\r\n\r\n# cut here\r\n80.5\r\n100", "x");
    ASSERT_EQ(message(rate), "");
    EXPECT_EQ(*rate->own_times, (std::vector<std::int64_t>{0, 40'500'000, 60'000'000}));
}

TEST(FrameTimesText, IsRefusedByLine) {
    const std::string head = "# timestamp format v2\n";
    const std::pair<std::string, const char*> bad[] = {
        {"", "must be a line \"# timestamp format v2\""},
        {"# timestamp format v1\n1\n2\n", "must be a line"},
        {head, "of 0 frames"},
        {head + "1\n", "of 1 frames"},
        {head + "1\nx\n", "x.txt, line 3: is \"x\": must be the time of a frame"},
        {head + "1 2\n3\n", "line 2"},
        {head + "1\nnan\n", "line 3"},
        {head + "1\n1e300\n", "line 3"},
        {head + "1\n1.5\n", "line 3: is \"1.5\": must be 1 ms or more after"},
        {head + "2\n1\n", "line 3"},
        {head + "-4e12\n4e12\n", "126 years"},
    };
    for (const auto& [text, words] : bad)
        EXPECT_NE(message(parse_frame_times(text, "x.txt")).find(words), std::string::npos)
            << text << message(parse_frame_times(text, "x.txt"));
}

/// A clip of `frames` frames with the times of `listed`, 40 ms apart.
std::string refusal_with_times(int listed, int frames) {
    const TemporaryFolder folder;
    std::vector<std::int64_t> times_ns;
    for (int n = 0; n < listed; ++n) times_ns.push_back(40'000'000L * n + (n % 2) * 3'000'000L);
    Scene scene = small_scene(16, 16, 10);
    scene.rate = *rate_of_own_times(times_ns);
    if (auto written = write_clip(folder / "clip.mkv", scene, frames, {}); !written) return message(written);
    const auto reader = open_clip(folder / "clip.mkv");
    return message(reader);
}

TEST(FrameTimesText, MustBeAsManyAsTheClipHasPictures) {
    EXPECT_EQ(refusal_with_times(10, 10), "");
    for (const auto& [listed, words] :
         {std::pair{
              4, "its timestamps.txt has the times of 4 frames, but depth has 10 pictures: must be one time"},
          {9, "the times of 9 frames, but depth has 10 pictures"},
          {13, "the times of 13 frames, but depth has 10 pictures"}})
        EXPECT_NE(refusal_with_times(listed, 10).find(words), std::string::npos)
            << refusal_with_times(listed, 10);
}

}  // namespace
}  // namespace touchable::test
