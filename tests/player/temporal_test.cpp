// The temporal filter makes a frame of all frames before it: whoever builds frames has to see them all, in
// order.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"

namespace touchable::test {
namespace {
namespace fs = std::filesystem;

using Words = std::vector<std::string>;

class TemporalFilter : public ::testing::Test {
protected:
    std::string clip() const { return folder / "clip.mkv"; }
    Words with(const Words& more) const {
        Words words{clip(), "--hand", "wander", "--fingers", "2", "--seconds", "0.6"};
        words.insert(words.end(), more.begin(), more.end());
        return words;
    }
    std::string hash(const Words& more) const { return force_hash(with(more)); }

    TemporaryFolder folder;
};

TEST_F(TemporalFilter, IsFeltAlikeByEveryBuilderThatCan) {
    make_clip("moving", clip(), {"--size", "64x48", "--frames", "12"});
    const std::string on = hash({"--temporal", "5"});
    EXPECT_NE(on, hash({}));
    EXPECT_EQ(hash({"--temporal", "off"}), hash({}));
    EXPECT_NE(on, hash({"--temporal", "2"}));
    EXPECT_NE(hash({"--temporal", "1,2e-6"}), hash({"--temporal", "1"})) << "a metre away: 3 and 1";
    EXPECT_EQ(on, hash({"--temporal", "5,0"}));
    for (const char* builder : {"reference", "vulkan"})
        EXPECT_EQ(hash({"--temporal", "5", "--builder", builder}), on) << builder;
}

TEST_F(TemporalFilter, LeavesAClipThatStandsStillAsItIs) {
    make_clip("bumps", clip(), {"--size", "64x48", "--frames", "12"});
    EXPECT_EQ(hash({"--temporal", "5"}), hash({}));
}

TEST_F(TemporalFilter, IsWhatTheSceneFileSaysUnlessToldOtherwise) {
    make_clip("moving", clip(), {"--size", "64x48", "--frames", "12"});
    auto scene = scene_of(clip());
    scene["filter"]["temporal"] = "on";
    scene["filter"]["temporal_noise"] = {5, 0};
    std::ofstream(folder / "noisy.json") << scene;
    const std::string file = folder / "noisy.json";
    EXPECT_EQ(hash({"--scene", file}), hash({"--temporal", "5"}));
    EXPECT_EQ(hash({"--scene", file, "--temporal", "off"}), hash({}));
    EXPECT_EQ(hash({"--scene", file, "--temporal", "2"}), hash({"--temporal", "2"}));
    scene["filter"]["temporal"] = "off";
    std::ofstream(file) << scene;
    EXPECT_EQ(hash({"--scene", file, "--temporal", "on"}), hash({"--temporal", "5"}));
    const Outcome info = run_touchable({"info", clip(), "--scene", file});
    EXPECT_NE(info.out.find("filters      none (stated)"), std::string::npos) << info.out;
    const Outcome on = run_touchable({"info", clip(), "--scene", file, "--temporal", "on"});
    EXPECT_NE(on.out.find("temporal for 5 mm (stated)"), std::string::npos) << on.out;
}

TEST_F(TemporalFilter, OfALiveSessionReplaysToItsHash) {
    make_clip("moving", clip(), {"--size", "64x48", "--frames", "12"});
    const auto live = touch(with({"--temporal", "5", "--live", "--record", folder / "live.rec"}));
    for (const char* builder : {"cpu", "reference"}) {
        const auto replay = touch({"--replay", folder / "live.rec", "--builder", builder});
        EXPECT_EQ(replay["force_hash"], live["force_hash"]) << builder;
    }
    const Outcome lazy = run_touchable({"touch", "--replay", folder / "live.rec", "--builder", "lazy"});
    EXPECT_EQ(lazy.code, 2);
    EXPECT_TRUE(lazy.one_line_of_error()) << lazy.err;
}

TEST_F(TemporalFilter, OfAFrameThatIsExportedAloneSawTheFramesBeforeIt) {
    make_clip("moving", clip(), {"--size", "64x48", "--frames", "8"});
    const auto exported = [&](const char* frames, const char* which, const Words& more,
                              const std::string& out) {
        Words words{"export", clip(), frames, which, "--out", folder / out};
        words.insert(words.end(), more.begin(), more.end());
        EXPECT_EQ(run_touchable(words).code, 0);
    };
    exported("--frames", "all", {"--temporal", "5"}, "all");
    exported("--frames", "5-6", {"--temporal", "5"}, "few");
    exported("--frame", "6", {"--temporal", "5"}, "one");
    exported("--frame", "6", {}, "off");
    const std::string all = file_contents(folder / "all/6/codes.png");
    EXPECT_EQ(file_contents(folder / "few/6/codes.png"), all);
    EXPECT_EQ(file_contents(folder / "one/codes.png"), all);
    EXPECT_NE(file_contents(folder / "off/codes.png"), all);
}

/// A motion that dips into the first frame's surface early on and is above it for the rest.
std::string lifted_hand(const std::string& file) {
    std::ofstream rows(file);  // tenths of a millimetre
    for (int k = 0; k < 100; ++k) rows << k % 2 << ",0," << (k == 10 ? 0 : 400) << '\n';
    return "csv:" + file + ":columns=1+2+3,rate=50,scale=0.0001,contact=0.01";
}

// Two clips that end alike. The finger is in the air by then, so that pictures show the surface alone.
TEST_F(TemporalFilter, OfAPictureSawTheFramesBeforeIt) {
    make_clip("moving", clip(), {"--size", "64x48", "--frames", "8"});
    ASSERT_EQ(run_touchable({"export", clip(), "--frames", "all", "--out", folder / "all"}).code, 0);
    auto scene = scene_of(clip());
    scene["folder"] = {{"depth", "d_%d.png"}};
    const std::vector<std::string> moves{"6", "0", "0", "6"};
    for (const char* name : {"moves", "stands"}) {
        const fs::path to = folder.path() / name;
        fs::create_directory(to);
        for (std::size_t n = 0; n < moves.size(); ++n) {
            const std::string from = to.filename() == "moves" ? moves[n] : "6";
            fs::copy_file(folder / ("all/" + from + "/depth.png"), to / ("d_" + std::to_string(n) + ".png"));
        }
        std::ofstream(to / "scene.json") << scene;
    }
    const std::string hand = lifted_hand(folder / "hand.csv");
    const auto picture = [&](const std::string& name, const char* temporal) {
        const Outcome drawn = run_touchable({"touch", folder / name, "--hand", hand, "--temporal", temporal,
                                             "--picture", folder / "p.png", "--picture-size", "96x64",
                                             "--picture-at", "1.9", "--overwrite"});
        EXPECT_EQ(drawn.code, 0) << drawn.err;
        return file_contents(folder / "p.png");
    };
    EXPECT_EQ(picture("moves", "off"), picture("stands", "off"));
    EXPECT_NE(picture("moves", "9"), picture("stands", "9"));
    EXPECT_EQ(picture("stands", "9"), picture("stands", "off"));
}

}  // namespace
}  // namespace touchable::test
