#include <gtest/gtest.h>

#include <fstream>
#include <tuple>

#include "engine/content/scenes.hpp"
#include "engine/formats/open_clip.hpp"
#include "tests/player/program.hpp"
#include "tests/sanitizers.hpp"

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

void expect_generators_frames(const char* archive) {
    const TemporaryFolder folder;
    const std::string clip = folder / "noise.mkv";
    ASSERT_EQ(run_touchable({"make", "noise", clip, "--frames", "3", "--bits", "10", "--seed", "7",
                             "--archive", archive})
                  .code,
              0);
    SceneOptions options;
    options.width = options.height = 128;
    options.bits = 10;
    options.seed = 7;
    const auto source = make_scene("noise", options);
    ASSERT_TRUE(source);
    auto reader = open_clip(clip);
    ASSERT_TRUE(reader) << reader.error().message;
    for (std::int64_t n = 0; n < 3; ++n) {
        const auto frame = (*reader)->next();
        ASSERT_TRUE(frame) << frame.error().message;
        ASSERT_TRUE(frame->has_value());
        expect_same_samples((*frame)->depth, (*source)->frame(n).depth);
    }
    EXPECT_FALSE((*reader)->next()->has_value());
}

TEST(Make, ClipHoldsTheGeneratorsFrames) {
    expect_generators_frames("fast");
    expect_generators_frames("small");
}

TEST(Make, ColourIsExactWhereThatIsAskedFor) {
    const TemporaryFolder folder;
    SceneOptions options;
    options.width = 72;
    options.height = 48;
    options.properties = true;
    const auto source = make_scene("globe", options);
    ASSERT_TRUE(source);
    ASSERT_EQ(run_touchable({"make", "globe", folder / "exact.mkv", "--size", "72x48", "--frames", "1",
                             "--exact-colour"})
                  .code,
              0);
    auto reader = open_clip(folder / "exact.mkv");
    ASSERT_TRUE(reader);
    expect_same_samples((*(*reader)->next())->colour, (*source)->frame(0).colour);
}

TEST(Make, RateIsStoredExactly) {
    const TemporaryFolder folder;
    const std::vector<std::tuple<const char*, std::int64_t, std::int64_t>> rates{
        {"30000/1001", 30000, 1001}, {"29.97", 2997, 100}, {"24", 24, 1}, {"0.5", 1, 2}, {"60.0", 60, 1}};
    for (const char* name : {"clip.mkv", "clip.mp4"})
        for (const auto& [rate, num, den] : rates) {
            ASSERT_EQ(run_touchable({"make", "moving", folder / name, "--size", "32x24", "--frames", "3",
                                     "--rate", rate, "--overwrite"})
                          .code,
                      0)
                << rate;
            auto reader = open_clip(folder / name);
            ASSERT_TRUE(reader) << reader.error().message;
            EXPECT_EQ((*reader)->scene().rate.num, num) << name << " " << rate;
            EXPECT_EQ((*reader)->scene().rate.den, den) << name << " " << rate;
        }
    for (const char* wrong : {"0", "-30", "1001", "30/0", "", "30,5", ".", "30.", ".5", "30/1001/2", "1/1001",
                              "1e2", "12345678901"}) {
        const Outcome run = run_touchable({"make", "moving", folder / "no.mkv", "--rate", wrong});
        EXPECT_EQ(run.code, 2) << wrong;
        EXPECT_NE(run.err.find("--rate"), std::string::npos) << run.err;
        EXPECT_TRUE(run.one_line_of_error()) << run.err;
    }
}

TEST(Make, UnknownArchiveIsNamed) {
    const TemporaryFolder folder;
    const auto refused = run_touchable({"make", "noise", folder / "noise.mkv", "--archive", "tiny"});
    EXPECT_EQ(refused.code, 2);
    EXPECT_NE(refused.err.find("--archive: tiny is not allowed; must be fast or small"), std::string::npos)
        << refused.err;
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
        return reader && !(*reader)->next()->value().haptic.empty();
    };
    EXPECT_TRUE(has_haptics("show.mkv"));
    EXPECT_FALSE(has_haptics("plain.mkv"));
}

TEST(Make, ImpossibleOptionsAreCode2AndLeaveNoFile) {
    const TemporaryFolder folder;
    const std::string out = folder / "out.mkv";
    const std::vector<std::vector<std::string>> wrong{
        {"make", "teapot", out},
        {"make", "plane", out, "--size", "720"},
        {"make", "plane", out, "--size", "720x"},
        {"make", "plane", out, "--size", "0x10"},
        {"make", "plane", out, "--size", "99999x10"},
        {"make", "plane", out, "--bits", "7"},
        {"make", "plane", out, "--bits", "17"},
        {"make", "plane", out, "--frames", "0"},
        {"make", "plane", out, "--frames", "1000001"},
        {"make", "noise", out, "--seed", "-1"},
        {"make", "noise", out, "--seed", "18446744073709551616"},
        {"make", "noise", out, "--seed", ""},
        {"make", "plane", out, "--size", ""},
        {"make", "globe", out, "--preset", ""},
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

TEST(Make, EarlierFileStaysUnlessItMayBeReplaced) {
    const TemporaryFolder folder;
    const std::string out = folder / "out.mkv";
    std::ofstream(out) << "earlier\n";
    std::vector<std::string> words{"make", "plane", out, "--size", "16x12", "--frames", "1"};
    const Outcome refused = run_touchable(words);
    EXPECT_EQ(refused.code, 2);
    EXPECT_TRUE(refused.one_line_of_error()) << refused.err;
    EXPECT_NE(refused.err.find("--overwrite"), std::string::npos) << refused.err;
    EXPECT_EQ(file_contents(out), "earlier\n");
    words.emplace_back("--overwrite");
    EXPECT_EQ(run_touchable(words).code, 0);
    EXPECT_TRUE(open_clip(out));
}

TEST(Make, OtherNamesThanOfMatroskaAndMp4AreCode2) {
    const TemporaryFolder folder;
    for (const char* name : {"clip.avi", "clip", "clip.mkv.png", "mkv", "mp4"}) {
        const Outcome run =
            run_touchable({"make", "plane", folder / name, "--size", "16x12", "--frames", "1"});
        EXPECT_EQ(run.code, 2) << name;
        EXPECT_NE(run.err.find("does not end in .mkv (Matroska) or .mp4"), std::string::npos) << run.err;
    }
    for (const char* name : {"CLIP.MKV", "CLIP.Mp4"})
        EXPECT_EQ(run_touchable({"make", "plane", folder / name, "--size", "16x12", "--frames", "1"}).code,
                  0);
    EXPECT_EQ(names_in(folder.path()), (std::vector<std::string>{"CLIP.MKV", "CLIP.Mp4"}));
}

TEST(Make, PicturesThatMemoryCannotHoldAreCode3AndSaysSo) {
#ifdef TOUCHABLE_SANITIZED
    GTEST_SKIP() << "sanitizers take more address space than this test leaves";
#endif
    const TemporaryFolder folder;
    const Outcome run =
        run_in_memory({"make", "plane", folder / "out.mkv", "--size", "16384x8192", "--frames", "1"}, 1024);
    EXPECT_EQ(run.code, 3) << run.err;
    EXPECT_TRUE(run.one_line_of_error()) << run.err;
    EXPECT_NE(run.err.find("memory does not suffice for frames of 16384x8192"), std::string::npos) << run.err;
    EXPECT_TRUE(names_in(folder.path()).empty());
}

TEST(Make, UnwritableFileIsCode3) {
    const Outcome run =
        run_touchable({"make", "plane", "/no-such-folder/out.mkv", "--size", "16x12", "--frames", "1"});
    EXPECT_EQ(run.code, 3);
    EXPECT_TRUE(run.one_line_of_error()) << run.err;
}

TEST(Make, FullDiskIsCode3AndLeavesNothing) {
    const TemporaryFolder folder;
    for (const int kibibytes : {0, 40}) {
        const Outcome run = run_on_full_disk(
            {"make", "noise", folder / "out.mkv", "--size", "320x240", "--frames", "20"}, kibibytes);
        EXPECT_EQ(run.code, 3) << run.err;
        EXPECT_TRUE(run.one_line_of_error()) << run.err;
        EXPECT_TRUE(names_in(folder.path()).empty());
    }
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
