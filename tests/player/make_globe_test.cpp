#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "engine/formats/open_clip.hpp"
#include "engine/picture/image.hpp"
#include "player/commands/make_command.hpp"
#include "tests/player/program.hpp"
#include "tests/real_data.hpp"
#include "tests/sanitizers.hpp"

namespace touchable::test {
namespace {

/// Maps of one continent around longitude 0 in a folder; its mask white or black on land.
class MapsInAFolder {
public:
    explicit MapsInAFolder(int width = 64, bool land_is_white = true) {
        const int height = width / 2;
        Image colour{width, height, 1, 3, {}}, elevation{width, height, 2, 1, {}},
            mask{width, height, 1, 1, {}};
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const double across = 2.0 * x / width - 1, down = 2.0 * y / height - 1;
                const bool land = across * across + down * down < 0.25;
                const auto metres =
                    static_cast<std::uint16_t>(land ? 12000 + 4000 * (1 - std::fabs(across)) : 8000);
                for (const int value : {land ? 120 : 10, 90, land ? 40 : 150})
                    colour.samples.push_back(static_cast<std::uint8_t>(value));
                elevation.samples.push_back(static_cast<std::uint8_t>(metres & 255));
                elevation.samples.push_back(static_cast<std::uint8_t>(metres >> 8));
                mask.samples.push_back(land == land_is_white ? 255 : 0);
            }
        EXPECT_TRUE(write_png(folder_.path() / "colour.png", colour.view()));
        EXPECT_TRUE(write_png(folder_.path() / "elevation.png", elevation.view()));
        EXPECT_TRUE(write_png(folder_.path() / "mask.png", mask.view()));
    }
    std::string operator/(const std::string& name) const { return folder_ / name; }
    const TemporaryFolder& folder() const { return folder_; }
    /// `make globe` of them, small and short, with more words.
    std::vector<std::string> words(const std::vector<std::string>& more = {}) const {
        std::vector<std::string> all{"make",
                                     "globe",
                                     folder_ / "out.mkv",
                                     "--size",
                                     "96x64",
                                     "--frames",
                                     "2",
                                     "--colour",
                                     folder_ / "colour.png",
                                     "--elevation",
                                     folder_ / "elevation.png",
                                     "--mask",
                                     folder_ / "mask.png"};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }

private:
    TemporaryFolder folder_;
};

TEST(MakeGlobe, OfMapsHasAllPlanesAndSaysWhatItFound) {
    for (const bool white : {true, false}) {
        const MapsInAFolder maps(64, white);
        const Outcome run = run_touchable(maps.words({"--longitude", "0", "--rate", "24", "--bits", "12"}));
        ASSERT_EQ(run.code, 0) << run.err;
        EXPECT_NE(run.out.find("out.mkv: 2 frames of globe, 96x64, 12 bits"), std::string::npos) << run.out;
        EXPECT_NE(run.out.find("sea level 8000 of the elevation map; land is " +
                               std::string(white ? "bright" : "dark") +
                               " in the mask; the two agree on 100.0 % of the globe"),
                  std::string::npos)
            << run.out;
        auto reader = open_clip(maps / "out.mkv");
        ASSERT_TRUE(reader) << reader.error().message;
        EXPECT_EQ((*reader)->scene().rate.num, 24);
        const RawFrame frame = (*reader)->next()->value();
        EXPECT_FALSE(frame.colour.empty());
        EXPECT_FALSE(frame.height.empty());
        EXPECT_EQ(frame.haptic.sample(48, 31), 148);  // land in front: 1.2 N/mm
        EXPECT_EQ(frame.haptic.sample(1, 1), 94);     // nothing there: 0.8 N/mm
        EXPECT_EQ(frame.depth.sample(1, 1), 0);
    }
}

TEST(MakeGlobe, SameMapsGiveTheSameFileByteForByte) {
    const MapsInAFolder maps;
    ASSERT_EQ(run_touchable(maps.words()).code, 0);
    const std::string first = file_contents(maps / "out.mkv");
    ASSERT_EQ(run_touchable(maps.words({"--overwrite"})).code, 0);
    EXPECT_EQ(file_contents(maps / "out.mkv"), first);
}

TEST(MakeGlobe, SeaLevelThatIsToldIsTakenAndSaid) {
    const MapsInAFolder maps;
    const Outcome run = run_touchable(maps.words({"--sea-level", "8123.5"}));
    ASSERT_EQ(run.code, 0) << run.err;
    EXPECT_NE(run.out.find("sea level 8123.5, as told;"), std::string::npos) << run.out;
}

TEST(MakeGlobe, WithoutAMaskSeaIsWhereElevationIsLeast) {
    const MapsInAFolder maps;
    auto words = maps.words();
    words.resize(words.size() - 2);
    ASSERT_EQ(run_touchable(maps.words({"--longitude", "0"})).code, 0);
    const std::string with_mask = file_contents(maps / "out.mkv");
    words.insert(words.end(), {"--longitude", "0", "--overwrite"});
    const Outcome run = run_touchable(words);
    ASSERT_EQ(run.code, 0) << run.err;
    EXPECT_NE(
        run.out.find("sea level 8000, the least of the elevation map (--sea-level VALUE says otherwise)"),
        std::string::npos)
        << run.out;
    EXPECT_EQ(file_contents(maps / "out.mkv"), with_mask);
    words.insert(words.end(), {"--sea-level", "13000"});
    const Outcome told = run_touchable(words);
    ASSERT_EQ(told.code, 0) << told.err;
    EXPECT_NE(told.out.find("sea level 13000, as told"), std::string::npos) << told.out;
    EXPECT_NE(file_contents(maps / "out.mkv"), with_mask);
    words.back() = "7000";
    const Outcome dry = run_touchable(words);
    EXPECT_EQ(dry.code, 3);
    EXPECT_NE(dry.err.find("--sea-level leaves only land"), std::string::npos) << dry.err;
}

TEST(MakeGlobe, HapticMapIsTakenCodeByCode) {
    const MapsInAFolder maps;
    Image touch{32, 16, 1, 3, {}};
    for (int n = 0; n < 32 * 16; ++n)
        for (const int code : {200, 100, 50}) touch.samples.push_back(static_cast<std::uint8_t>(code));
    ASSERT_TRUE(write_png(maps / "touch.png", touch.view()));
    ASSERT_EQ(run_touchable(maps.words({"--haptic", maps / "touch.png"})).code, 0);
    auto reader = open_clip(maps / "out.mkv");
    ASSERT_TRUE(reader);
    const RawFrame frame = (*reader)->next()->value();
    for (const int x : {25, 48, 70}) {
        EXPECT_EQ(frame.haptic.sample(x, 31, 0), 200);
        EXPECT_EQ(frame.haptic.sample(x, 31, 1), 100);
        EXPECT_EQ(frame.haptic.sample(x, 31, 2), 50);
    }
}

TEST(MakeGlobe, EachMapIsReadIntoItsOwnPlaceWhicheverAreThere) {
    const MapsInAFolder maps;
    GlobeMapFiles files;
    files.elevation = maps / "elevation.png";
    files.mask = maps / "mask.png";
    const auto missing = read_globe_maps(files);
    ASSERT_FALSE(missing);
    EXPECT_EQ(missing.error().message, "the colour map is missing");
    files.haptic = files.colour = maps / "colour.png";
    const auto read = read_globe_maps(files);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ((*read)->maps.colour.at(32, 16, 0), 120);
    EXPECT_EQ((*read)->maps.elevation.at(0, 0, 0), 8000);
    EXPECT_EQ((*read)->maps.mask.at(32, 16, 0), 255);
    EXPECT_EQ((*read)->maps.haptic.at(32, 16, 1), 90);
}

TEST(MakeGlobe, WhiteIsTheLargestCodeOfAMapsOwnBits) {
    const MapsInAFolder maps;
    GlobeMapFiles files;
    files.elevation = maps / "elevation.png";
    files.mask = maps / "mask.png";
    for (const auto& [largest, bytes] : {std::pair{15, 1}, {255, 1}, {1023, 2}, {65535, 2}}) {
        files.colour = maps / "colour.pgm";
        std::ofstream(files.colour, std::ios::binary)
            << "P5 64 32 " << largest << "\n"
            << std::string(static_cast<std::size_t>(64 * 32 * bytes), '\0');
        const auto read = read_globe_maps(files);
        ASSERT_TRUE(read) << read.error().message;
        EXPECT_EQ((*read)->maps.colour.largest, largest);
    }
}

/// One line, the right exit code, and nothing is left behind.
void expect_refusal(const MapsInAFolder& maps, const std::vector<std::string>& words, int code,
                    const std::string& said) {
    const Outcome run = run_touchable(words);
    EXPECT_EQ(run.code, code) << run.err;
    EXPECT_TRUE(run.one_line_of_error()) << run.err;
    EXPECT_NE(run.err.find(said), std::string::npos) << run.err;
    for (const std::string& name : names_in(maps.folder().path())) EXPECT_NE(name, "out.mkv");
}

TEST(MakeGlobe, MapsThatWillNotDoAreRefused) {
    const MapsInAFolder maps;
    const auto with = [&](const std::string& option, const std::string& file) {
        std::vector<std::string> words = maps.words();
        *(std::find(words.begin(), words.end(), option) + 1) = maps / file;
        return words;
    };
    expect_refusal(maps, with("--colour", "absent.png"), 3, "absent.png");
    std::ofstream(maps / "text.png") << "no picture\n";
    expect_refusal(maps, with("--mask", "text.png"), 3, "text.png");
    Image square{64, 64, 1, 1, std::vector<std::uint8_t>(64 * 64, 1)};
    ASSERT_TRUE(write_png(maps / "square.png", square.view()));
    expect_refusal(maps, with("--mask", "square.png"), 3, "the mask map is 64x64; must be equirectangular");
    expect_refusal(maps, with("--elevation", "colour.png"), 3, "the elevation map has colours; must be grey");
    Image level{64, 32, 1, 1, std::vector<std::uint8_t>(64 * 32, 7)};
    ASSERT_TRUE(write_png(maps / "level.png", level.view()));
    expect_refusal(maps, with("--mask", "level.png"), 3, "the mask map is the same everywhere");
    // A map that begins at longitude 0.
    auto mask = read_image(maps / "mask.png");
    ASSERT_TRUE(mask);
    for (int y = 0; y < 32; ++y)
        std::rotate(&mask->samples[static_cast<std::size_t>(64 * y)],
                    &mask->samples[static_cast<std::size_t>(64 * y + 32)],
                    mask->samples.data() + 64 * (y + 1));
    ASSERT_TRUE(write_png(maps / "turned.png", mask->view()));
    expect_refusal(maps, with("--mask", "turned.png"), 3, "do not agree where land is");
    std::vector<std::string> grey_touch = maps.words({"--haptic", maps / "mask.png"});
    expect_refusal(maps, grey_touch, 3, "the haptic map is grey");
}

TEST(MakeGlobe, OptionsThatDoNothingOrAreNotAllThereAreRefused) {
    const MapsInAFolder maps;
    const std::string out = maps / "out.mkv", colour = maps / "colour.png";
    expect_refusal(maps, {"make", "globe", out, "--colour", colour}, 2, "--elevation is missing");
    expect_refusal(maps, {"make", "globe", out, "--mask", maps / "mask.png"}, 2, "--colour is missing");
    expect_refusal(maps, {"make", "plane", out, "--colour", colour}, 2, "--colour does nothing for 'plane'");
    expect_refusal(maps, maps.words({"--plain"}), 2, "--colour does nothing for 'globe' --plain");
    expect_refusal(maps, maps.words({"--seed", "3"}), 2, "--seed does nothing");
    for (const char* option : {"--haptic", "--sea-level", "--relief", "--smoothing"})
        expect_refusal(maps, {"make", "globe", out, option, "1"}, 2,
                       std::string(option) + " does nothing for 'globe'");
    for (const char* option : {"--turn", "--axial-tilt", "--longitude"}) {
        expect_refusal(maps, {"make", "bumps", out, option, "1"}, 2,
                       std::string(option) + " does nothing for 'bumps'");
        expect_refusal(maps, {"make", "globe", out, "--plain", option, "1"}, 2, option);
    }
    for (const auto& [option, value] :
         std::vector<std::pair<std::string, std::string>>{{"--relief", "0"},
                                                          {"--relief", "11"},
                                                          {"--relief", "nan"},
                                                          {"--smoothing", "-1"},
                                                          {"--smoothing", "11"},
                                                          {"--turn", "0"},
                                                          {"--axial-tilt", "91"},
                                                          {"--longitude", "181"},
                                                          {"--sea-level", "inf"},
                                                          {"--colour", ""}})
        expect_refusal(maps, maps.words({option, value}), 2, option);
}

TEST(MakeGlobe, NoMapIsOverwritten) {
    const MapsInAFolder maps;
    std::vector<std::string> words = maps.words({"--overwrite"});
    std::ofstream(maps / "map.mkv") << "anything";
    words[2] = words[8] = maps / "map.mkv";
    const Outcome run = run_touchable(words);
    EXPECT_EQ(run.code, 2) << run.err;
    EXPECT_EQ(file_contents(maps / "map.mkv"), "anything");
}

TEST(MakeGlobe, MapsThatMemoryCannotHoldAreCode3) {
#ifdef TOUCHABLE_SANITIZED
    GTEST_SKIP() << "sanitizers take more address space than this test leaves";
#endif
    const MapsInAFolder maps;
    Image large{8192, 4096, 1, 3, std::vector<std::uint8_t>(8192U * 4096 * 3)};
    for (std::size_t n = 0; n < large.samples.size(); n += 97)
        large.samples[n] = static_cast<std::uint8_t>(n);
    ASSERT_TRUE(write_png(maps / "colour.png", large.view()));
    const Outcome run = run_in_memory(maps.words(), 360);
    EXPECT_EQ(run.code, 3) << run.err;
    EXPECT_TRUE(run.one_line_of_error()) << run.err;
    EXPECT_NE(run.err.find("memory"), std::string::npos) << run.err;
}

TEST(MakeGlobe, InterruptedIsCode130AndLeavesNoClip) {
    const MapsInAFolder maps;
    const TemporaryFolder out;
    std::vector<std::string> words = maps.words();
    words[2] = out / "out.mkv";
    words[6] = "100000";
    const Outcome run = run_interrupted(words, out.path());
    EXPECT_EQ(run.code, 130) << run.err;
    EXPECT_TRUE(names_in(out.path()).empty());
}

TEST(MakeGlobe, TheEarthsMapsAgreeAndHaveTheHimalaya) {
    const auto earth = real_data("earth");
    TOUCHABLE_NEEDS_DATA(earth);
    const TemporaryFolder folder;
    struct Mask {
        const char *file, *land;
        double least;
    };
    for (const Mask& mask :
         {Mask{"etopo5_10min_landmask.png", "bright", 99.9}, {"earth-water.png", "dark", 98}}) {
        const Outcome run = run_touchable(
            {"make", "globe", folder / "earth.mkv", "--size", "240x160", "--frames", "1", "--axial-tilt", "0",
             "--longitude", "85", "--overwrite", "--colour", (earth / "earth-blue-marble.jpg").string(),
             "--elevation", (earth / "etopo5_10min_elev_u16.png").string(), "--mask",
             (earth / mask.file).string()});
        ASSERT_EQ(run.code, 0) << run.err;
        EXPECT_NE(run.out.find(std::string("land is ") + mask.land), std::string::npos) << run.out;
        const double level = std::stod(run.out.substr(run.out.find("sea level ") + 10));
        EXPECT_NEAR(level, 11000, 60) << run.out;
        EXPECT_GE(std::stod(run.out.substr(run.out.find("agree on ") + 9)), mask.least) << run.out;
        auto reader = open_clip(folder / "earth.mkv");
        ASSERT_TRUE(reader);
        const Scene& scene = (*reader)->scene();
        const RawFrame frame = (*reader)->next()->value();
        // Straight ahead of the camera, in rows, the sphere's own radius and that of what lies there.
        const double radius = 0.032 / *scene.device_metres_per_unit;
        const auto rise = [&](int x, int y) {
            const glm::dvec3 at = unproject(scene.camera, x, y,
                                            planar_depth(scene.camera, scene.depth.semantics, x, y,
                                                         scene.depth.depth(frame.depth.sample(x, y))));
            return std::sqrt(at.x * at.x + at.y * at.y + (at.z + 110) * (at.z + 110)) / radius - 1;
        };
        EXPECT_NEAR(rise(120, 79), 0, 1e-4);  // the Indian Ocean south of Ceylon, on the equator
        double tibet = 0;                     // 30 to 36 degrees north
        for (int y = 26; y <= 31; ++y) tibet = std::max(tibet, rise(120, y));
        EXPECT_GT(tibet, 0.012);
        EXPECT_LT(tibet, 0.03);
    }
}

}  // namespace
}  // namespace touchable::test
