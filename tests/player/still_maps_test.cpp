// One map of touch for a whole clip, from the command line: the same forces by every way it comes in.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/picture/image.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"

namespace touchable::test {
namespace {

class StillMap : public ::testing::Test {
protected:
    StillMap() {
        make_clip("globe", clip(), {"--size", "64x48", "--frames", "4"});
        Image grey{32, 24, 1, 1, {}};
        for (int k = 0; k < 32 * 24; ++k) grey.samples.push_back(static_cast<std::uint8_t>(k * 7 % 256));
        EXPECT_TRUE(write_png(folder / "s.png", grey.view()));
        std::ofstream(folder / "m.x3d")
            << "<X3D><Scene><HapticTexturesSurface useRelativeValues='false' minStiffness='300' "
               "maxStiffness='900' "
               "staticFriction='0.5' dynamicFriction='0.2'><ImageTexture containerField='stiffnessMap' "
               "url='s.png'/></HapticTexturesSurface></Scene></X3D>";
    }
    std::string clip() const { return folder / "clip.mkv"; }
    std::string map() const { return folder / "m.x3d"; }
    std::string hash(const std::string& of, std::vector<std::string> more = {}) const {
        more.insert(more.begin(), {of, "--seconds", "0.5"});
        return force_hash(more);
    }
    TemporaryFolder folder;
};

TEST_F(StillMap, IsFeltTheSameByEveryWayIn) {
    const std::string plain = hash(clip()), felt = hash(clip(), {"--haptic", map()});
    EXPECT_NE(plain, felt);
    const std::vector<std::string> convert{"convert", clip(), folder / "out.mkv", "--haptic", map()};
    const Outcome converted = run_touchable(convert);
    ASSERT_EQ(converted.code, 0) << converted.err;
    EXPECT_EQ(hash(folder / "out.mkv"), felt);
    EXPECT_EQ(run_touchable({"convert", clip(), folder / "out"}).code, 0);
    auto scene = nlohmann::json::parse(file_contents(folder / "out/scene.json"));
    scene["folder"]["haptic"] = "../m.x3d";
    std::ofstream(folder / "out/scene.json") << scene;
    EXPECT_EQ(hash(folder / "out"), felt);
}

TEST_F(StillMap, IsKeptByARecordingAndNeverWrittenOver) {
    const std::string recording = folder / "run.rec";
    const std::vector<std::string> maps{"--haptic", map(), "--height", folder / "s.png"};
    EXPECT_NE(hash(clip(), {"--height", folder / "s.png"}), hash(clip()));
    std::vector<std::string> words{"touch", clip(), "--seconds", "0.3", "--record", recording};
    words.insert(words.end(), maps.begin(), maps.end());
    const Outcome touched = run_touchable(words);
    ASSERT_EQ(touched.code, 0) << touched.err;
    const Outcome replayed = run_touchable({"touch", "--replay", recording});
    EXPECT_EQ(replayed.code, 0) << replayed.err;
    EXPECT_EQ(replayed.out.find("are not the recorded ones"), std::string::npos);
    std::filesystem::rename(folder / "m.x3d", folder / "moved.x3d");
    const Outcome gone = run_touchable({"touch", "--replay", recording});
    EXPECT_NE(gone.err.find("--haptic FILE"), std::string::npos) << gone.err;
    EXPECT_EQ(run_touchable({"touch", "--replay", recording, "--haptic", folder / "moved.x3d"}).code, 0);
    const Outcome over =
        run_touchable({"convert", clip(), folder / "s.png", "--overwrite", "--haptic", folder / "moved.x3d"});
    EXPECT_EQ(over.code, 2);
    EXPECT_TRUE(over.one_line_of_error()) << over.err;
    EXPECT_EQ(run_touchable({"info", clip(), "--haptic", folder / "gone.x3d"}).code, 3);
}

}  // namespace
}  // namespace touchable::test
