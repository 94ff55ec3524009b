#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/picture/image.hpp"
#include "tests/player/program.hpp"
#include "tests/sanitizers.hpp"

namespace touchable::test {
namespace {

using Words = std::vector<std::string>;

/// A bowl of millimetres, 60 x 40, beside which nothing lies.
class BarePicture : public ::testing::Test {
protected:
    BarePicture() {
        Image image{60, 40, 2, 1, {}};
        for (int y = 0; y < 40; ++y)
            for (int x = 0; x < 60; ++x) {
                const int depth = 400 + (x - 30) * (x - 30) / 20 + (y - 20) * (y - 20) / 20;
                image.samples.push_back(static_cast<std::uint8_t>(depth & 255));
                image.samples.push_back(static_cast<std::uint8_t>(depth >> 8));
            }
        EXPECT_TRUE(write_png(folder / "my.png", image.view()));
    }
    std::string picture() const { return folder / "my.png"; }
    const Words camera{"--intrinsics", "50,50", "--depth-unit", "0.001"};
    Outcome run(Words words, const Words& more) const {
        words.insert(words.end(), more.begin(), more.end());
        return run_touchable(words);
    }
    TemporaryFolder folder;
};

TEST_F(BarePicture, IsTouchedReplayedExportedAndDescribedByItsCamera) {
    const std::string recording = folder / "run.rec", report = folder / "report.json";
    const Outcome touched =
        run({"touch", picture(), "--seconds", "0.5", "--record", recording, "--json", report}, camera);
    ASSERT_EQ(touched.code, 0) << touched.err;
    EXPECT_GT(nlohmann::json::parse(file_contents(report))["contact_ticks"], 100);
    const Outcome replayed = run_touchable({"touch", "--replay", recording});
    EXPECT_EQ(replayed.code, 0) << replayed.err;
    EXPECT_EQ(run({"touch", "--replay", recording}, camera).code, 2);
    const Outcome told = run({"info", picture(), "--json"}, camera);
    ASSERT_EQ(told.code, 0) << told.err;
    EXPECT_EQ(nlohmann::json::parse(told.out)["first_frame"]["nearest"], 0.4);
    const Outcome exported = run({"export", picture(), "--frame", "0", "--out", folder / "out"}, camera);
    EXPECT_EQ(exported.code, 0) << exported.err;
}

/// What a recording says is what was typed: depth along rays is replayed as such.
TEST_F(BarePicture, DepthIsAlongRaysWhereThatIsSaid) {
    const std::string recording = folder / "run.rec", out = folder / "out";
    const Outcome touched =
        run({"touch", picture(), "--seconds", "0.1", "--depth", "range", "--record", recording}, camera);
    ASSERT_EQ(touched.code, 0) << touched.err;
    const Outcome replayed = run_touchable({"touch", "--replay", recording});
    EXPECT_EQ(replayed.code, 0) << replayed.err;
    for (const char* word : {"range", "planar"}) {
        const Outcome exported =
            run({"export", picture(), "--frame", "0", "--depth", word, "--out", out + word}, camera);
        ASSERT_EQ(exported.code, 0) << exported.err;
        const auto codes = nlohmann::json::parse(file_contents(out + word + "/codes.json"));
        EXPECT_EQ(codes["depth"]["semantics"], word);
    }
    EXPECT_EQ(run({"info", picture(), "--depth", "sideways"}, camera).code, 2);
}

TEST_F(BarePicture, WithoutACameraIsTouchedByWhatIsGuessedAndSaid) {
    const std::string recording = folder / "run.rec";
    const Outcome touched = run_touchable({"touch", picture(), "--seconds", "0.1", "--record", recording});
    ASSERT_EQ(touched.code, 0) << touched.err;
    EXPECT_NE(touched.out.find(" guessed of the clip (touchable info says which)"), std::string::npos)
        << touched.out;
    EXPECT_NE(run_touchable({"touch", picture(), "--seconds", "0.1", "--verbose"})
                  .out.find("guessed: the camera sees 60 degrees"),
              std::string::npos);
    EXPECT_EQ(run_touchable({"touch", "--replay", recording}).code, 0);
    const Outcome wide = run_touchable({"touch", picture(), "--seconds", "0.1", "--fov", "90", "--preset",
                                        "realsense", "--record", recording, "--overwrite"});
    ASSERT_EQ(wide.code, 0) << wide.err;
    EXPECT_EQ(run_touchable({"touch", "--replay", recording}).code, 0);
    EXPECT_EQ(run_touchable({"info", picture(), "--preset", "none"}).code, 2);
}

TEST_F(BarePicture, CameraFileIsNoGuess) {
    std::ofstream(folder / "camera.json")
        << R"({"width": 120, "height": 80, "fx": 100, "fy": 100, "cx": 59.5, "cy": 39.5})";
    const std::string own = "the camera is that of camera.json (--intrinsics FX,FY,CX,CY says otherwise)\n",
                      scaled =
                          "camera.json is of 120x80 pixels and is scaled to these pictures (--intrinsics";
    const Outcome told = run_touchable({"info", picture()});
    EXPECT_NE(told.out.find("  note         " + own), std::string::npos) << told.out;
    EXPECT_NE(told.out.find("  note         " + scaled), std::string::npos) << told.out;
    EXPECT_NE(told.out.find("verdict      good to touch if the unit is right (a code is 1 mm, "),
              std::string::npos)
        << told.out;
    EXPECT_NE(run({"info", picture()}, {"--depth-unit", "0.001"})
                  .out.find("verdict      good to touch: touchable play "),
              std::string::npos);
    const Outcome window = run_touchable(
        {"play", picture(), "--headless", "--seconds", "0.1", "--painter", "cpu", "--builder", "cpu"});
    ASSERT_EQ(window.code, 0) << window.err;
    EXPECT_NE(window.err.find("touchable: " + own), std::string::npos) << window.err;
    const Outcome typed = run_touchable({"info", picture(), "--intrinsics", "100,100,59.5,39.5"});
    EXPECT_EQ(typed.out.find("guessed: the camera"), std::string::npos) << typed.out << typed.err;
}

/// The guess that matters most comes first, with what says otherwise; none that matters, and it is good.
TEST_F(BarePicture, VerdictWeighsEveryGuess) {
    const auto verdict = [&](const std::string& clip, const Words& more) {
        return nlohmann::json::parse(run({"info", clip, "--json"}, more).out, nullptr, false)["verdict"]
            .get<std::string>();
    };
    const auto begins = [](const std::string& told, const std::string& words) {
        EXPECT_EQ(told.substr(0, words.size()), words) << told;
    };
    const auto ends = [](const std::string& told, const std::string& words) {
        EXPECT_TRUE(told.ends_with(words)) << told;
    };
    // 0.418 m, and 1.6 m if 256 codes are a metre.
    begins(verdict(picture(), {}),
           "good to touch if the unit is right (a code is 1 mm, as their median is 418; that "
           "is 0.418 m; 1.63 m if 256 codes");
    ends(verdict(picture(), {}), " --depth-unit METRES; guessed too: the camera, range or planar");
    ends(verdict(picture(), {"--depth-unit", "0.001"}), " --fov DEGREES");
    begins(verdict(picture(), camera), "good to touch: ");
    // Floats: where the lower third is larger they may be 1/depth; what goes along a ray is not said.
    const auto write_floats = [&](const std::string& file, double lower, double noise) {
        std::string bytes = "Pf\n60 40\n-1\n";
        for (int y = 39; y >= 0; --y)  // a PFM begins with its lowest row
            for (int x = 0; x < 60; ++x) {
                const auto value =
                    static_cast<float>((1 + lower * y / 39.0) * ((x + y) % 2 == 0 ? 1 : noise));
                bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
            }
        std::ofstream(file, std::ios::binary) << bytes;
    };
    const std::string floats = folder / "floats.pfm";
    write_floats(floats, -0.4, 1);
    const std::string plain = verdict(floats, {"--intrinsics", "50,50"});
    begins(plain, "good to touch if the unit is right (values are metres, ");
    ends(plain, "; guessed too: range or planar");
    ends(verdict(floats, {"--intrinsics", "50,50", "--depth-unit", "1"}),
         " --depth planar, or --depth range");
    begins(verdict(floats, {"--intrinsics", "50,50", "--depth-unit", "1", "--depth", "planar"}),
           "good to touch: ");
    begins(verdict(floats, {"--intrinsics", "500,500", "--depth-unit", "1"}), "good to touch: ");
    write_floats(floats, 2, 1);
    const std::string turned = verdict(floats, {"--depth", "planar"});
    begins(turned, "may be inside out (values are lengths, though they are larger in the lower third");
    ends(turned, " --preset relative-inverse; guessed too: the camera, the unit");
    // Of every second pixel three times as deep nothing is a surface.
    write_floats(floats, 0, 3);
    begins(verdict(floats, {}),
           "hardly depth: 100 % of neighbouring pixels differ by more than a factor of two");
}

TEST_F(BarePicture, VerdictOnAConvertedClipNamesItsSceneFile) {
    const std::string clip = folder / "clip.mkv";
    ASSERT_EQ(run({"convert", picture(), clip}, {"--depth-unit", "0.001"}).code, 0);
    const auto told = nlohmann::json::parse(run_touchable({"info", clip, "--json"}).out, nullptr, false);
    EXPECT_EQ(
        told["verdict"],
        "good to touch if the camera is right (the camera sees 60 degrees from left to right; if it sees 70, "
        "all shapes are 18 % too narrow): touchable init-scene " +
            clip + " writes a scene file to say it in");
}

TEST_F(BarePicture, FramesOfTwoKindsInTurnAreSaid) {
    std::filesystem::create_directory(folder / "mixed");
    for (int n = 0; n < 4; ++n) {
        Image image{60, 40, 2, 1, {}};
        for (int k = 0; k < 60 * 40; ++k) {
            const int depth = (n % 2 == 0 ? 500 : 1100) + k % 60;
            image.samples.push_back(static_cast<std::uint8_t>(depth & 255));
            image.samples.push_back(static_cast<std::uint8_t>(depth >> 8));
        }
        ASSERT_TRUE(write_png(folder / ("mixed/" + std::to_string(n) + ".png"), image.view()));
    }
    const auto told =
        nlohmann::json::parse(run({"info", folder / "mixed", "--json"}, camera).out, nullptr, false);
    EXPECT_TRUE(told["verdict"].get<std::string>().starts_with("frames of two kinds take turns, one 2."))
        << told["verdict"];
}

TEST_F(BarePicture, ImplausibleUnitIsDoubted) {
    const auto facts = [&](const Words& more) {
        return nlohmann::json::parse(run({"info", picture(), "--json"}, more).out, nullptr, false);
    };
    const auto verdict_begins = [](const nlohmann::json& given, const std::string& words) {
        return given["verdict"].get<std::string>().starts_with(words);
    };
    const std::string doubt = ": the unit may be wrong (",
                      mend = "0.418 m if values are millimetres: --depth-unit 0.001)";
    const auto with_unit = [&](const char* unit) { return Words{"--fov", "60", "--depth-unit", unit}; };
    for (const auto& [unit, depth] :
         {std::pair{"1000", "418 km"}, {"1", "418 m"}, {"0.000001", "0.418 mm"}}) {
        const auto told = facts(with_unit(unit));
        EXPECT_EQ(told["verdict"], std::string("the median depth is ") + depth + doubt + mend);
        EXPECT_EQ(std::count(told["notes"].begin(), told["notes"].end(), told["verdict"]), 1)
            << told["notes"];
    }
    for (const char* plausible : {"0.001", "0.0001", "0.1"})
        EXPECT_TRUE(verdict_begins(facts(with_unit(plausible)), "good to touch: ")) << plausible;
    const Outcome touched = run({"touch", picture(), "--seconds", "0.05"}, with_unit("1000"));
    EXPECT_NE(touched.out.find("the median depth is 418 km" + doubt + mend), std::string::npos)
        << touched.out << touched.err;
    // Packed, or with a scene file of its own, it has no --depth-unit.
    const std::string clip = folder / "packed.mkv", scene = folder / "far.json";
    ASSERT_EQ(run({"convert", picture(), clip}, with_unit("1000")).code, 0);
    EXPECT_TRUE(
        verdict_begins(nlohmann::json::parse(run_touchable({"info", clip, "--json"}).out, nullptr, false),
                       "the median depth is 418 km: the unit "));
    ASSERT_EQ(run({"init-scene", picture(), "--out", scene}, with_unit("0.001")).code, 0);
    auto described = nlohmann::json::parse(file_contents(scene));
    described["metres_per_unit"] = 1000;
    std::ofstream(scene) << described.dump();
    EXPECT_EQ(facts({"--scene", scene})["verdict"],
              "the median depth is 418 m" + doubt +
                  "a scene file's metres_per_unit and depth say otherwise: --scene FILE)");
}

// As much as the pixels of one frame need, twice as much to be touched.
TEST_F(BarePicture, OfManyPixelsTakesMemoryForThemAlone) {
    constexpr int side = 6000;
    [[maybe_unused]] constexpr double mebibytes = 128 + 5.0 * side * side / (1 << 20);
    Image image{side, side, 2, 1, {}};
    image.samples.resize(std::size_t{2} * side * side);
    for (std::size_t k = 0; k < image.samples.size(); k += 2) {
        const std::size_t depth = 1500 + k / 2 % side / 6;
        image.samples[k] = static_cast<std::uint8_t>(depth & 255);
        image.samples[k + 1] = static_cast<std::uint8_t>(depth >> 8);
    }
    ASSERT_TRUE(write_png_to(picture(), image.view(), picture(), PngEffort::quick));
    image = {};
    const Outcome told = run({"info", picture()}, camera);
    EXPECT_EQ(told.code, 0) << told.err;
    const Outcome touched = run({"touch", picture(), "--seconds", "0.02"}, camera);
    EXPECT_EQ(touched.code, 0) << touched.err;
#ifndef TOUCHABLE_SANITIZED
    EXPECT_LE(told.peak_mebibytes, mebibytes);
    EXPECT_LE(touched.peak_mebibytes, 2 * mebibytes);
#endif
}

TEST_F(BarePicture, ASceneFileToBeginWithIsWritten) {
    const Outcome written = run_touchable({"init-scene", picture(), "--fov", "70"});
    ASSERT_EQ(written.code, 0) << written.err;
    EXPECT_NE(written.out.find("my.json"), std::string::npos);
    EXPECT_NE(file_contents(folder / "my.json").find("guessed: a code is 1 mm"), std::string::npos);
    EXPECT_EQ(run_touchable({"info", folder / "my.json"}).code, 0);
    EXPECT_EQ(run_touchable({"init-scene", picture()}).code, 2) << "it is there already";
    EXPECT_EQ(run_touchable({"init-scene", picture(), "--overwrite"}).code, 0);
    std::filesystem::create_directory(folder / "else");
    const std::string other = folder / "else/other.json";
    const Outcome elsewhere = run_touchable({"init-scene", picture(), "--out", other});
    EXPECT_NE(elsewhere.out.find("touchable play " + picture() + " --scene " + other), std::string::npos)
        << elsewhere.out;
    EXPECT_EQ(run_touchable({"info", picture(), "--scene", other}).code, 0);
    EXPECT_EQ(run_touchable({"init-scene", picture(), "--out", picture(), "--overwrite"}).code, 2);
    EXPECT_EQ(run_touchable({"init-scene", folder / "nothing"}).code, 3);
    EXPECT_NE(run_touchable({"formats"}).out.find("--preset NAME"), std::string::npos);
}

TEST_F(BarePicture, PackedHasItsSceneWrittenToBeChanged) {
    const std::string clip = folder / "my clip.mkv";
    const std::string as_typed = "'" + clip + "'";
    ASSERT_EQ(run_touchable({"convert", picture(), clip}).code, 0);
    const Outcome told = run({"info", clip}, camera);
    EXPECT_EQ(told.code, 2);
    EXPECT_NE(told.err.find("touchable init-scene " + as_typed), std::string::npos) << told.err;
    EXPECT_EQ(run({"init-scene", clip}, camera).code, 2);
    const Outcome written = run_touchable({"init-scene", clip});
    ASSERT_EQ(written.code, 0) << written.err;
    const std::string file = folder / "my clip.json";
    EXPECT_NE(written.out.find("touchable play " + as_typed + " --scene '" + file + "'"), std::string::npos)
        << written.out;
    EXPECT_NE(written.out.find("guessed: a code is 1 mm"), std::string::npos) << written.out;
    auto scene = nlohmann::json::parse(file_contents(file));
    EXPECT_FALSE(scene.contains("folder"));
    const auto forces = [&](const std::vector<std::string>& more) {
        std::vector<std::string> words{"touch", clip, "--seconds", "0.1", "--json", "-"};
        words.insert(words.end(), more.begin(), more.end());
        const Outcome touched = run_touchable(words);
        EXPECT_EQ(touched.code, 0) << touched.err;
        return touched.code == 0 ? nlohmann::json::parse(touched.out)["force_hash"] : nlohmann::json();
    };
    EXPECT_EQ(forces({}), forces({"--scene", file})) << "the same scene";
    scene["camera"]["fx"] = 77;
    std::ofstream(file) << scene.dump();
    const Outcome changed = run_touchable({"info", clip, "--scene", file, "--json"});
    ASSERT_EQ(changed.code, 0) << changed.err;
    EXPECT_EQ(nlohmann::json::parse(changed.out)["camera"]["fx"], 77);
}

TEST_F(BarePicture, ASceneFileForWhichThereIsNoRoomSaysSo) {
    const Outcome full = run_on_full_disk({"init-scene", picture()}, 0);
    EXPECT_EQ(full.code, 3);
    EXPECT_NE(full.err.find("my.json: cannot be written: File too large"), std::string::npos) << full.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "my.json"));
}

TEST_F(BarePicture, CommasForPointsInACameraAreRefused) {
    for (const char* text : {"525,5,525,5", "525,5", "5,525", "525,-200"}) {
        const Outcome told = run_touchable({"info", picture(), "--intrinsics", text});
        EXPECT_EQ(told.code, 2) << text;
        EXPECT_NE(told.err.find("one more than twice the other"), std::string::npos) << told.err;
    }
    const std::string file = folder / "camera.json";
    std::ofstream(file) << R"({"fx": 525, "fy": 5})";
    EXPECT_EQ(run_touchable({"info", picture(), "--intrinsics", file}).code, 2);
    std::filesystem::remove(folder / "camera.json");
    EXPECT_EQ(run_touchable({"info", picture(), "--intrinsics", "52,104"}).code, 0);
    const Outcome far = run_touchable({"info", picture(), "--intrinsics", "50,50,-40,5"});
    EXPECT_NE(far.out.find("the principal point that was said, -40, 5, is far beside the picture"),
              std::string::npos)
        << far.out;
    EXPECT_EQ(run_touchable({"info", picture(), "--intrinsics", "50,50,8,5"}).out.find("far beside"),
              std::string::npos);
}

TEST_F(BarePicture, ACameraThatIsNoneIsCode2) {
    for (const char* text : {"", "50", "50,50,3", "50,fifty", "50,50,1,2,3", "50,nan", "0,50", "50,50,"})
        EXPECT_EQ(run_touchable({"info", picture(), "--intrinsics", text}).code, 2) << text;
    EXPECT_EQ(run_touchable({"info", picture(), "--fov", "180"}).code, 2);
    EXPECT_EQ(run({"info", picture(), "--scene", picture()}, camera).code, 2);
    EXPECT_EQ(run_touchable({"info", picture(), "--intrinsics", "50,50", "--depth-unit", "0"}).code, 2);
}

}  // namespace
}  // namespace touchable::test
