// `touchable relief`, as a person calls it.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "engine/formats/open_clip.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"

namespace touchable::test {
namespace {
namespace fs = std::filesystem;

class Relief : public ::testing::Test {
protected:
    Relief() { make_clip("globe", at("globe.mkv"), {"--size", "96x64", "--frames", "4"}); }
    std::string at(const std::string& name) const { return folder_ / name; }

    TemporaryFolder folder_;
};

TEST_F(Relief, GivesAClipThatIsFeltOtherwise) {
    const Outcome run = run_touchable({"relief", at("globe.mkv"), at("relief.mkv"), "--max-height", "2"});
    ASSERT_EQ(run.code, 0) << run.err;
    EXPECT_NE(run.out.find("colour  every value kept (h264)"), std::string::npos) << run.out;
    EXPECT_NE(run.out.find("relief: the largest height stands for details of"), std::string::npos) << run.out;
    auto clip = open_clip(at("relief.mkv"));
    ASSERT_TRUE(clip) << clip.error().message;
    // The globe's radius is 32 mm of the hand.
    EXPECT_NEAR((*clip)->scene().height_coding.max_height * *(*clip)->scene().device_metres_per_unit, 0.002,
                1e-9);
    const auto first = (*clip)->next();
    ASSERT_TRUE(first && *first);
    EXPECT_FALSE((*first)->height.empty());
    // One that has relief already gets another.
    const Outcome again = run_touchable({"relief", at("relief.mkv"), at("relief.mkv")});
    EXPECT_EQ(again.code, 2) << again.err;
    const Outcome other =
        run_touchable({"relief", at("relief.mkv"), at("other.mkv"), "--amount", "0", "--invert"});
    ASSERT_EQ(other.code, 0) << other.err;
    auto flat = open_clip(at("other.mkv"));
    ASSERT_TRUE(flat);
    const auto level = (*flat)->next();
    ASSERT_TRUE(level && *level);
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 96; ++x) EXPECT_EQ((*level)->height.sample(x, y), 128);
}

TEST_F(Relief, SaysWhatIsFeltOfIt) {
    const Outcome run = run_touchable({"relief", at("globe.mkv"), at("relief.mkv")});
    ASSERT_EQ(run.code, 0) << run.err;
    EXPECT_NE(run.out.find("relief: a pixel is"), std::string::npos) << run.out;
    EXPECT_NE(run.out.find("heights change by"), std::string::npos) << run.out;
}

TEST_F(Relief, OfSeveralClipsGoesIntoAFolderAndOnWhereItWasStopped) {
    fs::copy_file(at("globe.mkv"), at("other.mkv"));
    std::ofstream(at("broken.mkv")) << "nothing";
    const std::vector<std::string> words{"relief", at("globe.mkv"), at("broken.mkv"), at("other.mkv"),
                                         at("out") + "/"};
    const Outcome run = run_touchable(words);
    EXPECT_EQ(run.code, 3) << run.err;
    EXPECT_NE(run.err.find("broken.mkv"), std::string::npos) << run.err;
    EXPECT_NE(run.err.find("1 of 3 clips were not made"), std::string::npos) << run.err;
    ASSERT_TRUE(fs::exists(at("out/globe.mkv")));
    ASSERT_TRUE(fs::exists(at("out/other.mkv")));
    fs::remove(at("out/other.mkv"));
    const auto made = fs::last_write_time(at("out/globe.mkv"));
    const Outcome again = run_touchable({"relief", at("globe.mkv"), at("other.mkv"), at("out") + "/"});
    EXPECT_EQ(again.code, 0) << again.err;
    EXPECT_NE(again.out.find("globe.mkv: is there already"), std::string::npos) << again.out;
    EXPECT_EQ(fs::last_write_time(at("out/globe.mkv")), made);
    EXPECT_TRUE(fs::exists(at("out/other.mkv")));
}

TEST_F(Relief, OfSeveralClipsNeedsAFolderAndNamesOfTheirOwn) {
    const Outcome file = run_touchable({"relief", at("globe.mkv"), at("other.mkv"), at("third.mkv")});
    EXPECT_EQ(file.code, 2);
    EXPECT_NE(file.err.find("is no folder"), std::string::npos) << file.err;
    fs::create_directory(at("a"));
    fs::copy_file(at("globe.mkv"), at("a/globe.mkv"));
    const Outcome same = run_touchable({"relief", at("globe.mkv"), at("a/globe.mkv"), at("out") + "/"});
    EXPECT_EQ(same.code, 2);
    EXPECT_NE(same.err.find("would both be"), std::string::npos) << same.err;
    EXPECT_FALSE(fs::exists(at("out")));
    // Without its slash a folder is a clip of pictures, as a shell gives all that is there.
    const Outcome last = run_touchable({"relief", at("globe.mkv"), at("a")});
    EXPECT_EQ(last.code, 2);
    EXPECT_NE(last.err.find("does not end in .mkv"), std::string::npos) << last.err;
    const Outcome several = run_touchable({"relief", at("globe.mkv"), at("globe.mkv"), at("a")});
    EXPECT_EQ(several.code, 2);
    EXPECT_NE(several.err.find("is no folder"), std::string::npos) << several.err;
    EXPECT_EQ(names_in(at("a")), std::vector<std::string>{"globe.mkv"});
}

TEST_F(Relief, OfSeveralClipsWritesOverNoneOfThem) {
    fs::create_directory(at("a"));
    fs::copy_file(at("globe.mkv"), at("a/other.mkv"));
    for (const bool overwrite : {false, true}) {
        std::vector<std::string> words{"relief", at("globe.mkv"), at("a/other.mkv"), at("a") + "/"};
        if (overwrite) words.emplace_back("--overwrite");
        const Outcome run = run_touchable(words);
        EXPECT_EQ(run.code, 2);
        EXPECT_NE(run.err.find("is one of the clips"), std::string::npos) << run.err;
        EXPECT_EQ(names_in(at("a")), std::vector<std::string>{"other.mkv"});
    }
}

TEST_F(Relief, IsOfTheWorldWhereThatIsSaid) {
    const Outcome run =
        run_touchable({"relief", at("globe.mkv"), at("relief.mkv"), "--max-height", "2", "--of-world"});
    ASSERT_EQ(run.code, 0) << run.err;
    auto clip = open_clip(at("relief.mkv"));
    ASSERT_TRUE(clip) << clip.error().message;
    EXPECT_NEAR((*clip)->scene().height_coding.max_height * (*clip)->scene().metres_per_unit, 0.002, 1e-9);
}

TEST_F(Relief, TakesAHapticMapInPlaceOfTheClipsOwn) {
    ASSERT_EQ(run_touchable({"convert", at("globe.mkv"), at("planes")}).code, 0);
    const Outcome run = run_touchable(
        {"relief", at("globe.mkv"), at("relief.mkv"), "--haptic", at("planes/haptic_000002.png")});
    ASSERT_EQ(run.code, 0) << run.err;
    EXPECT_NE(run.out.find("colour  every value kept (h264)"), std::string::npos) << run.out;
}

/// What was tried in a window, the command makes a clip of.
TEST_F(Relief, OfAWindowIsKeptByTheCommandThatTheWindowNames) {
    std::ofstream(at("kept.json")) << R"({"a": {"relief": 60, "relief-fine": 30, "relief-invert": "on"}})";
    const Outcome window = run_touchable({"play", at("globe.mkv"), "--headless", "--seconds", "0.1",
                                          "--settings", at("kept.json"), "--size", "160x120"});
    ASSERT_EQ(window.code, 0) << window.err;
    const std::string wanted = "touchable relief " + at("globe.mkv") +
                               " OUT.mkv --amount 60 --max-height 0.5 --fine 30 --medium 70 --coarse 40 "
                               "--invert";
    EXPECT_NE(window.out.find(wanted), std::string::npos) << window.out;
    const Outcome kept =
        run_touchable({"relief", at("globe.mkv"), at("kept.mkv"), "--amount", "60", "--max-height", "0.5",
                       "--fine", "30", "--medium", "70", "--coarse", "40", "--invert"});
    EXPECT_EQ(kept.code, 0) << kept.err;
}

TEST_F(Relief, RefusesWhatCannotBe) {
    make_clip("bumps", at("grey.mkv"), {"--size", "32x24", "--frames", "1"});
    const auto expect = [&](const std::vector<std::string>& words, int code, const std::string& why) {
        const Outcome run = run_touchable(words);
        EXPECT_EQ(run.code, code) << run.err;
        EXPECT_TRUE(run.one_line_of_error()) << run.err;
        EXPECT_NE(run.err.find(why), std::string::npos) << run.err;
        EXPECT_FALSE(fs::exists(at("out.mkv")));
    };
    expect({"relief", at("grey.mkv"), at("out.mkv")}, 3, "has no colour");
    expect({"relief", at("globe.mkv"), at("out.mp4")}, 2, "does not end in .mkv");
    expect({"relief", at("globe.mkv"), at("out.mkv"), "--height", at("none.png")}, 2, "--height");
    expect({"relief", at("globe.mkv"), at("out.mkv"), "--fine", "500"}, 2, "--fine");
    expect({"relief", at("globe.mkv"), at("out.mkv"), "--max-height", "0"}, 2, "--max-height");
    expect({"relief", at("none.mkv"), at("out.mkv")}, 3, "none.mkv");
}

}  // namespace
}  // namespace touchable::test
