// What should worry a person stands first in the table, and with --strict in the exit code. Of live runs:
// live_test.cpp.
#include <gtest/gtest.h>

#include <fstream>

#include "engine/picture/image.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"

namespace touchable::test {
namespace {

using Words = std::vector<std::string>;

class Warnings : public ::testing::Test {
protected:
    /// A still whose pixels all have the code 7.
    std::string flat_still(const nlohmann::json& invalid) const {
        make_clip("plane", folder / "plane.mkv", {"--size", "48x32", "--frames", "1", "--bits", "8"});
        auto scene = scene_of(folder / "plane.mkv");
        scene["depth"]["invalid"] = invalid;
        scene["folder"] = {{"depth", "flat.png"}};
        std::ofstream(folder / "scene.json") << scene;
        const Image flat{48, 32, 1, 1, std::vector<std::uint8_t>(48 * 32, 7)};
        EXPECT_TRUE(write_png(folder / "flat.png", flat.view()));
        return folder / "scene.json";
    }
    /// Of an offline run, as the report has them; the table begins with them, and --strict minds them.
    Words warnings(Words words) const {
        words.insert(words.begin(), {"touch", "--overwrite", "--json", folder / "r.json"});
        const Outcome run = run_touchable(words);
        EXPECT_EQ(run.code, 0) << run.err;
        const Words told = nlohmann::json::parse(file_contents(folder / "r.json"))["warnings"];
        std::string first;
        for (const std::string& warning : told) first += "  warning               " + warning + '\n';
        EXPECT_TRUE(run.out.starts_with(first + "  touched ")) << run.out;
        words.emplace_back("--strict");
        const Outcome strict = run_touchable(words);
        EXPECT_EQ(strict.code, told.empty() ? 0 : 6) << strict.err;
        if (!told.empty()) {
            EXPECT_TRUE(strict.one_line_of_error()) << strict.err;
        }
        for (const std::string& warning : told)
            EXPECT_NE(strict.err.find(warning), std::string::npos) << strict.err;
        EXPECT_EQ(nlohmann::json::parse(file_contents(folder / "r.json"))["warnings"], told);
        return told;
    }

    TemporaryFolder folder;
};

TEST_F(Warnings, ARunAsItWasMeantHasNone) {
    EXPECT_EQ(warnings({flat_still({0}), "--hand", "press", "--seconds", "0.8"}), Words());
}

TEST_F(Warnings, AHandThatTouchesNothing) {
    const Words told = warnings({flat_still({0}), "--hand", "press", "--seconds", "0.05"});
    ASSERT_EQ(told.size(), 1U);
    EXPECT_EQ(told[0], "no finger touched anything");
}

TEST_F(Warnings, AClipWithoutASurfaceWhoeverBuildsIt) {
    const std::string scene = flat_still({7});
    for (const char* builder : {"cpu", "lazy", "reference"}) {
        const Words told = warnings({scene, "--builder", builder, "--seconds", "0.05"});
        ASSERT_EQ(told.size(), 2U) << builder;
        EXPECT_NE(told[0].find("100 % of the pixels are invalid"), std::string::npos) << told[0];
    }
}

TEST_F(Warnings, OfAReplay) {
    const std::string scene = flat_still({0}), record = folder / "run.rec";
    touch({scene, "--hand", "press", "--seconds", "0.05", "--record", record});
    EXPECT_EQ(warnings({"--replay", record}).size(), 1U);
}

}  // namespace
}  // namespace touchable::test
