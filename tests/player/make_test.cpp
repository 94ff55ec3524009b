#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>

#include "engine/content/scenes.hpp"
#include "engine/media/clip.hpp"
#include "tests/player/program.hpp"

namespace touchable::test {
namespace {

void expect_same_samples(const PlaneView& a, const PlaneView& b) {
    ASSERT_EQ(a.width, b.width);
    ASSERT_EQ(a.height, b.height);
    ASSERT_EQ(a.channels, b.channels);
    int different = 0;
    for (int y = 0; y < a.height; ++y)
        for (int x = 0; x < a.width; ++x)
            for (int c = 0; c < a.channels; ++c) different += a.sample(x, y, c) != b.sample(x, y, c);
    EXPECT_EQ(different, 0);
}

TEST(Make, SameOptionsGiveTheSameFileByteForByte) {
    const TemporaryFolder folder;
    for (const char* name : {"one.mkv", "two.mkv"})
        ASSERT_EQ(run_touchable({"make", "globe", folder / name, "--size", "72x48", "--frames", "3"}).code,
                  0);
    EXPECT_FALSE(file_contents(folder / "one.mkv").empty());
    EXPECT_EQ(file_contents(folder / "one.mkv"), file_contents(folder / "two.mkv"));
}

TEST(Make, ClipHoldsTheGeneratorsFrames) {
    const TemporaryFolder folder;
    const std::string clip = folder / "noise.mkv";
    ASSERT_EQ(run_touchable({"make", "noise", clip, "--frames", "3", "--bits", "10", "--seed", "7"}).code, 0);
    SceneOptions options;
    options.width = options.height = 128;
    options.bits = 10;
    options.seed = 7;
    const auto source = make_scene("noise", options);
    ASSERT_TRUE(source.ok());
    auto reader = open_clip(clip);
    ASSERT_TRUE(reader.ok()) << reader.error().message;
    for (std::int64_t n = 0; n < 3; ++n) {
        const auto frame = (*reader)->next();
        ASSERT_TRUE(frame.ok()) << frame.error().message;
        ASSERT_TRUE(frame->has_value());
        expect_same_samples((*frame)->depth, (*source)->frame(n).depth);
    }
    EXPECT_FALSE((*reader)->next()->has_value());
}

TEST(Make, GlobeIsAPlanetUnlessPlain) {
    const TemporaryFolder folder;
    ASSERT_EQ(run_touchable({"make", "globe", folder / "show.mkv", "--size", "72x48", "--frames", "1"}).code,
              0);
    ASSERT_EQ(
        run_touchable({"make", "globe", folder / "plain.mkv", "--size", "72x48", "--frames", "1", "--plain"})
            .code,
        0);
    const auto has_haptics = [&](const char* name) {
        auto reader = open_clip(folder / name);
        return reader.ok() && !(*reader)->next()->value().haptic.empty();
    };
    EXPECT_TRUE(has_haptics("show.mkv"));
    EXPECT_FALSE(has_haptics("plain.mkv"));
}

TEST(Make, ImpossibleOptionsAreCode2AndLeaveNoFile) {
    const TemporaryFolder folder;
    const std::string out = folder / "out.mkv";
    const std::vector<std::vector<std::string>> wrong{{"make", "teapot", out},
                                                      {"make", "plane", out, "--size", "720"},
                                                      {"make", "plane", out, "--size", "720x"},
                                                      {"make", "plane", out, "--size", "0x10"},
                                                      {"make", "plane", out, "--size", "99999x10"},
                                                      {"make", "plane", out, "--bits", "7"},
                                                      {"make", "plane", out, "--bits", "17"},
                                                      {"make", "plane", out, "--frames", "0"},
                                                      {"make", "plane", out, "--tilt", "75"},
                                                      {"make", "globe", out, "--preset", "C"},
                                                      {"make", "globe", out, "--plain", "--properties"}};
    for (const auto& words : wrong) {
        const Outcome run = run_touchable(words);
        EXPECT_EQ(run.code, 2) << words.back() << ": " << run.err;
        EXPECT_TRUE(run.one_line_of_error()) << run.err;
        EXPECT_TRUE(names_in(folder.path()).empty()) << words.back();
    }
    EXPECT_NE(run_touchable({"make", "teapot", out}).err.find("globe"), std::string::npos);
}

TEST(Make, OptionThatWouldDoNothingIsRefused) {
    const TemporaryFolder folder;
    for (const auto& [scene, option] : std::vector<std::pair<std::string, std::vector<std::string>>>{
             {"bumps", {"--preset", "A"}},
             {"bumps", {"--plain"}},
             {"globe", {"--tilt", "10"}},
             {"globe", {"--plain", "--seed", "3"}}}) {
        std::vector<std::string> words{"make", scene, folder / "out.mkv"};
        words.insert(words.end(), option.begin(), option.end());
        const Outcome run = run_touchable(words);
        EXPECT_EQ(run.code, 2);
        EXPECT_NE(run.err.find(option.size() > 2 ? option[1] : option[0]), std::string::npos) << run.err;
    }
}

TEST(Make, UnwritableFileIsCode3) {
    const Outcome run =
        run_touchable({"make", "plane", "/no-such-folder/out.mkv", "--size", "16x12", "--frames", "1"});
    EXPECT_EQ(run.code, 3);
    EXPECT_TRUE(run.one_line_of_error()) << run.err;
}

TEST(Make, FullDiskIsCode3AndLeavesNothing) {
    const TemporaryFolder folder;
    const std::string limited = "ulimit -f 40; exec " + std::string(TOUCHABLE_PROGRAM) + " make noise " +
                                (folder / "out.mkv") + " --size 320x240 --frames 20 2>/dev/null";
    const int status = std::system(limited.c_str());
    ASSERT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 3);
    EXPECT_TRUE(names_in(folder.path()).empty());
}

TEST(Make, InterruptedIsCode130AndLeavesNothing) {
    const TemporaryFolder folder;
    const Outcome run = run_interrupted(
        {"make", "noise", folder / "out.mkv", "--size", "640x480", "--frames", "100000"}, folder.path());
    EXPECT_EQ(run.code, 130) << run.err;
    EXPECT_TRUE(names_in(folder.path()).empty());
}

}  // namespace
}  // namespace touchable::test
