// A clip that ffmpeg made alone, by the command that docs/formats.md gives.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "engine/formats/open_clip.hpp"
#include "engine/picture/image.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"

namespace touchable::test {
namespace {
namespace fs = std::filesystem;

/// The page's only block of shell commands.
std::string command_of_the_page() {
    const std::string page = file_contents(fs::path(TOUCHABLE_SOURCE_DIR) / "docs/formats.md");
    const std::string fence = "```sh\n";
    const auto begin = page.find(fence);
    EXPECT_NE(begin, std::string::npos);
    const auto from = begin + fence.size();
    return page.substr(from, page.find("\n```", from) - from);
}

TEST(FfmpegClip, MadeByTheCommandOfThePageHoldsEveryValue) {
    if (std::system("command -v ffmpeg >/dev/null") != 0)
        GTEST_SKIP() << "there is no program ffmpeg here (Debian: ffmpeg)";
    const TemporaryFolder folder;
    const fs::path pictures = folder / "pictures";
    make_clip("globe", folder / "globe.mkv", {"--size", "64x48", "--frames", "7", "--bits", "16"});
    ASSERT_EQ(run_touchable({"convert", folder / "globe.mkv", pictures}).code, 0);
    // One map for the whole video, as the page has it.
    fs::rename(pictures / "haptic_000003.png", pictures / "haptic.png");
    const std::string run = "cd '" + pictures.string() + "' && " + command_of_the_page();
    ASSERT_EQ(std::system((run + " >ffmpeg.log 2>&1").c_str()), 0) << file_contents(pictures / "ffmpeg.log");

    auto made = open_clip(pictures / "clip.mkv"), before = open_clip(folder / "globe.mkv");
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_EQ((*made)->frame_count(), 7);
    const auto map = read_image(pictures / "haptic.png");
    ASSERT_TRUE(map);
    for (int n = 0; n < 7; ++n) {
        const auto is = (*made)->next(), was = (*before)->next();
        ASSERT_TRUE(is) << is.error().message;
        ASSERT_TRUE(*is && *was);
        EXPECT_EQ((*is)->time_ns, (*was)->time_ns);
        EXPECT_TRUE(same_samples((*is)->depth, (*was)->depth)) << n;
        EXPECT_TRUE(same_samples((*is)->haptic, map->view())) << n;
        EXPECT_FALSE((*is)->colour.empty());
    }
    EXPECT_FALSE((*made)->next()->has_value());
}

}  // namespace
}  // namespace touchable::test
