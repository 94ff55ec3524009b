// `touchable info --verify`, as a person calls it.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "engine/picture/image.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"

namespace touchable::test {
namespace {
namespace fs = std::filesystem;

class Verify : public ::testing::Test {
protected:
    struct Filmed {
        int frames = 6;
        int right = 0;     ///< pixels by which colour is moved
        int narrower = 0;  ///< boxes are in colour than in depth, by as many on each side
        double pulse = 0;  ///< depth is scaled by as much, frame by frame
        int blank = -1;    ///< this frame has no depth, nor has any before `from`
        int from = 0;
        int colour_period = 40;  ///< pixels from one box to the next in colour; in depth it is 40
    };
    /// Boxes before a wall, 160x120, in millimetres of 16 bits.
    std::string recording(const Filmed& filmed) const {
        const fs::path folder = at("recording");
        fs::create_directories(folder);
        for (int k = 0; k < filmed.frames; ++k) {
            Image depth{160, 120, 2, 1, {}}, colour{160, 120, 1, 3, {}};
            const double scale = 1 + filmed.pulse * (k % 3 - 1);
            for (int y = 0; y < 120; ++y)
                for (int x = 0; x < 160; ++x) {
                    const auto is_box = [&](int column, int period, int less = 0) {
                        const auto is_in = [&](int place) {
                            return place % period >= 15 + less && place % period < period - less;
                        };
                        return is_in(column + 2 * period) && is_in(y);
                    };
                    // Something moves, so that no frame repeats another.
                    const double mm = (is_box(x, 40) ? 700 : 1000) + (y < 8 ? 3 * k : 0);
                    const auto code = static_cast<std::uint16_t>(
                        std::lround(k == filmed.blank || k < filmed.from ? 0 : scale * mm));
                    depth.samples.push_back(static_cast<std::uint8_t>(code % 256));
                    depth.samples.push_back(static_cast<std::uint8_t>(code / 256));
                    for (int c = 0; c < 3; ++c)
                        colour.samples.push_back(
                            is_box(x - filmed.right, filmed.colour_period, filmed.narrower) == (c == 0) ? 200
                                                                                                        : 30);
                }
            const std::string number = "000" + std::to_string(k) + ".png";
            EXPECT_TRUE(write_png(folder / ("depth_" + number), depth.view()));
            EXPECT_TRUE(write_png(folder / ("color_" + number), colour.view()));
        }
        return folder.string();
    }
    nlohmann::json verified(const std::vector<std::string>& words) const {
        std::vector<std::string> all{"info", "--verify", "--json"};
        all.insert(all.end(), words.begin(), words.end());
        const Outcome run = run_touchable(all);
        EXPECT_EQ(run.code, 0) << run.err;
        return nlohmann::json::parse(run.out, nullptr, false);
    }
    static std::set<std::string> names(const nlohmann::json& json) {
        std::set<std::string> names;
        for (const auto& finding : json.at("findings")) {
            names.insert(finding.at("name"));
            EXPECT_NE(finding.at("mend"), "");
        }
        return names;
    }
    std::string at(const std::string& name) const { return folder_ / name; }

    TemporaryFolder folder_;
};

TEST_F(Verify, FindsNothingInAGoodClip) {
    make_clip("globe", at("globe.mkv"), {"--size", "96x64", "--frames", "4"});
    EXPECT_EQ(names(verified({at("globe.mkv")})), std::set<std::string>{});
    const Outcome run = run_touchable({"info", at("globe.mkv"), "--verify"});
    EXPECT_NE(run.out.find("nothing was found that would feel wrong"), std::string::npos) << run.out;
}

TEST_F(Verify, TellsOfColourThatIsBesideDepthAndWhere) {
    const std::string clip = recording({.right = 3});
    const auto json = verified({clip, "--depth-unit", "0.001", "--fov", "60", "--picture", at("where.png")});
    EXPECT_EQ(names(json), std::set<std::string>{"registration"}) << json;
    EXPECT_NEAR(json["measures"]["colour_edges"]["right"].get<double>(), 3, 0.01);
    const auto picture = read_image(at("where.png"));
    ASSERT_TRUE(picture) << picture.error().message;
    int red = 0;
    for (std::size_t k = 0; k < picture->samples.size(); k += 3)
        red += picture->samples[k] == 255 && picture->samples[k + 1] == 40 ? 1 : 0;
    EXPECT_GT(red, 100);
    // What is there already stays.
    const Outcome again = run_touchable({"info", clip, "--verify", "--picture", at("where.png")});
    EXPECT_EQ(again.code, 2) << again.err;
}

/// Boxes whose colour is narrower and moved: both findings are of the same edges.
TEST_F(Verify, SaysTheColourOfItsMarksAndWhereThereAreNone) {
    const std::vector<std::string> more{"--depth-unit", "0.001", "--fov", "60", "--picture"};
    const auto with = [&](std::vector<std::string> words, const std::string& picture) {
        words.insert(words.end(), more.begin(), more.end());
        words.push_back(at(picture));
        return words;
    };
    const auto json = verified(with({recording({.right = 3, .narrower = 2})}, "both.png"));
    EXPECT_EQ(names(json), (std::set<std::string>{"registration", "rims"}));
    for (const auto& finding : json["findings"]) EXPECT_EQ(finding.value("colour", ""), "red") << finding;
    // Depth that pulses has no place.
    std::vector<std::string> words{"info", "--verify"};
    const auto pulses = with({recording({.frames = 9, .pulse = 0.01})}, "none.png");
    words.insert(words.end(), pulses.begin(), pulses.end());
    const Outcome run = run_touchable(words);
    EXPECT_NE(run.out.find("wrong        pumping"), std::string::npos) << run.out << run.err;
    EXPECT_NE(run.out.find("has no marks"), std::string::npos) << run.out;
}

TEST_F(Verify, OfAClipWithoutColourSaysSo) {
    make_clip("bumps", at("grey.mkv"), {"--size", "96x64", "--frames", "4"});
    const Outcome run = run_touchable({"info", at("grey.mkv"), "--verify"});
    EXPECT_NE(run.out.find("; no colour"), std::string::npos) << run.out;
    EXPECT_EQ(run.out.find("too few edges"), std::string::npos) << run.out;
}

TEST_F(Verify, TellsOfColourThatIsOfSomethingElse) {
    const auto json = verified({recording({.colour_period = 31}), "--depth-unit", "0.001", "--fov", "60"});
    EXPECT_EQ(names(json), std::set<std::string>{"registration"}) << json;
    const std::string what = json["findings"][0]["what"];
    EXPECT_NE(what.find("agree on a place"), std::string::npos) << what;
}

TEST_F(Verify, TellsOfFramesWithoutDepth) {
    const auto json = verified({recording({.blank = 3}), "--depth-unit", "0.001", "--fov", "60"});
    EXPECT_EQ(names(json), std::set<std::string>{"blank"});
    const std::string what = json["findings"][0]["what"];
    EXPECT_NE(what.find("the first is 3"), std::string::npos) << what;
}

/// What depth is, its unit too, is told from the first frames that have any.
TEST_F(Verify, OpensAClipThatBeginsBlank) {
    const std::string clip = recording({.from = 4});
    const auto json = verified({clip, "--fov", "60"});
    EXPECT_EQ(names(json), std::set<std::string>{"blank"});
    EXPECT_NE(json["findings"][0]["what"].get<std::string>().find("4 frames have"), std::string::npos);
    EXPECT_NE(json["notes"].dump().find("a code is 1 mm"), std::string::npos) << json["notes"];
    EXPECT_EQ(run_touchable({"relief", clip, at("relief.mkv"), "--fov", "60"}).code, 0);
    const Outcome none = run_touchable({"info", recording({.from = 6}), "--fov", "60"});
    EXPECT_EQ(none.code, 3);
    EXPECT_NE(none.err.find("has no depth: all values are 0"), std::string::npos) << none.err;
}

TEST_F(Verify, TellsOfDepthThatPulses) {
    const auto json =
        verified({recording({.frames = 9, .pulse = 0.01}), "--depth-unit", "0.001", "--fov", "60"});
    EXPECT_TRUE(names(json).contains("pumping")) << json;
}

TEST_F(Verify, TellsOfAFilterThatIsOffThoughItIsNeeded) {
    make_clip("globe", at("globe.mkv"), {"--size", "192x128", "--frames", "4", "--bits", "8"});
    EXPECT_TRUE(names(verified({at("globe.mkv"), "--filters", "off"})).contains("terraces"));
    EXPECT_FALSE(names(verified({at("globe.mkv"), "--filters", "auto"})).contains("terraces"));
}

TEST_F(Verify, PictureNeedsIt) {
    const Outcome run = run_touchable({"info", at("globe.mkv"), "--picture", at("where.png")});
    EXPECT_EQ(run.code, 2);
    EXPECT_NE(run.err.find("--verify"), std::string::npos) << run.err;
}

}  // namespace
}  // namespace touchable::test
