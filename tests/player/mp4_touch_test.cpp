// A clip in MP4, or as a glTF scene, is felt as the same clip in Matroska, to the bit.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"

namespace touchable::test {
namespace {

class Mp4Touch : public ::testing::TestWithParam<int> {};

TEST_P(Mp4Touch, ForcesAreTheSameInMatroskaInMp4AndThereAndBack) {
    const TemporaryFolder folder;
    const auto at = [&](const char* name) { return std::string(folder / name); };
    const std::string hand = zigzag_hand(at("zigzag.csv"));
    const auto forces = [&](const char* name) {
        return force_hash({at(name), "--hand", hand, "--fingers", "2", "--seconds", "0.25"});
    };
    for (const char* name : {"made.mkv", "made.mp4"})
        make_clip("globe", at(name),
                  {"--size", "320x240", "--frames", "6", "--bits", std::to_string(GetParam())});
    const std::string known = forces("made.mkv");
    EXPECT_EQ(forces("made.mp4"), known);
    for (const auto& [from, to] : {std::pair{"made.mkv", "converted.mp4"},
                                   {"converted.mp4", "scene.gltf"},
                                   {"scene.gltf", "back.mkv"}}) {
        const Outcome run = run_touchable({"convert", at(from), at(to)});
        ASSERT_EQ(run.code, 0) << run.err;
        EXPECT_EQ(forces(to), known) << to;
    }
}

INSTANTIATE_TEST_SUITE_P(Bits, Mp4Touch, ::testing::Values(8, 10, 12, 16));

class FragmentedTouch : public ::testing::TestWithParam<int> {};

TEST_P(FragmentedTouch, ForcesAreThoseOfTheClipAlsoWhereItIsCut) {
    const TemporaryFolder folder;
    const auto at = [&](const char* name) { return std::string(folder / name); };
    const std::string hand = zigzag_hand(at("zigzag.csv"));
    const auto forces = [&](const char* name) {
        return force_hash({at(name), "--hand", hand, "--fingers", "2", "--seconds", "0.25"});
    };
    const auto make = [&](const char* name, std::vector<std::string> options) {
        options.insert(options.end(),
                       {"--size", "320x240", "--frames", "20", "--bits", std::to_string(GetParam())});
        make_clip("globe", at(name), options);
    };
    make("made.mkv", {});
    make("made.mp4", {"--fragmented"});
    const std::string known = forces("made.mkv");
    EXPECT_EQ(forces("made.mp4"), known);
    for (const std::vector<std::string>& step :
         {std::vector<std::string>{at("made.mkv"), at("converted.mp4"), "--fragmented"},
          {at("converted.mp4"), at("back.mkv")}}) {
        std::vector<std::string> words{"convert"};
        words.insert(words.end(), step.begin(), step.end());
        const Outcome run = run_touchable(words);
        ASSERT_EQ(run.code, 0) << run.err;
        EXPECT_EQ(run.out.find("has no MPEG-4 scene in fragments") != std::string::npos, step.size() > 2);
    }
    EXPECT_EQ(forces("converted.mp4"), known);
    EXPECT_EQ(forces("back.mkv"), known);
    // Without its last fragment 15 frames are there, which is more than is touched.
    const std::string whole = file_contents(at("made.mp4"));
    std::ofstream(at("cut.mp4"), std::ios::binary) << whole.substr(0, whole.size() * 9 / 10);
    EXPECT_EQ(forces("cut.mp4"), known);
    const Outcome told = run_touchable({"info", at("cut.mp4")});
    EXPECT_NE(told.out.find("the file is cut: its first 15 frames are whole"), std::string::npos) << told.out;
}

INSTANTIATE_TEST_SUITE_P(Bits, FragmentedTouch, ::testing::Values(8, 16));

TEST(FragmentedClip, IsAskedForByNamesOfMp4Alone) {
    const TemporaryFolder folder;
    const std::string clip = folder / "clip.mkv";
    make_clip("globe", clip, {"--size", "64x48", "--frames", "2"});
    for (const char* out : {"out.mkv", "out/", "out.png"}) {
        const Outcome run = run_touchable({"convert", clip, folder / out, "--fragmented"});
        EXPECT_EQ(run.code, 2) << out;
        EXPECT_NE(run.err.find("--fragmented is for NAME.mp4"), std::string::npos) << run.err;
    }
    const Outcome made = run_touchable({"make", "globe", folder / "out.mkv", "--fragmented"});
    EXPECT_EQ(made.code, 2);
    EXPECT_NE(made.err.find("--fragmented is for NAME.mp4"), std::string::npos) << made.err;
}

TEST(FragmentedClip, SoundThatItCannotHoldIsLostAndThatIsSaid) {
    if (std::system("command -v ffmpeg >/dev/null") != 0)
        GTEST_SKIP() << "there is no program ffmpeg here (Debian: ffmpeg)";
    const TemporaryFolder folder;
    make_clip("globe", folder / "clip.mkv", {"--size", "64x48", "--frames", "20"});
    for (const auto& [codec, words] : {std::pair{"aac", "kept as it is (aac)"},
                                       {"ac3", "LOST: ac3, which an MP4 file in fragments cannot hold"}}) {
        const std::string sounding = std::string(folder / codec) + ".mkv", out = sounding + ".mp4";
        ASSERT_EQ(
            std::system(("ffmpeg -loglevel error -i '" + std::string(folder / "clip.mkv") +
                         "' -f lavfi -i sine=d=1 -map 0 -map 1 -c copy -c:a " + codec + " '" + sounding + "'")
                            .c_str()),
            0);
        const Outcome run = run_touchable({"convert", sounding, out, "--fragmented"});
        EXPECT_EQ(run.code, 0) << run.err;
        EXPECT_NE(run.out.find(words), std::string::npos) << run.out;
    }
}

}  // namespace
}  // namespace touchable::test
