// SPDX-License-Identifier: Apache-2.0
// `touchable materials`, as a person calls it.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include "engine/base/same_bits.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/picture/image.hpp"
#include "tests/limits.hpp"
#include "tests/must.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"
#include "tests/real_data.hpp"
#include "tests/video/remuxed_clip.hpp"

namespace touchable::test {
namespace {

namespace fs = std::filesystem;
constexpr int wide = 96, high = 64;

/// A wall at 1000 mm, brown to the left and blue to the right, with a hole in its upper left corner. In a
/// folder of pictures, and as a clip.
class Materials : public ::testing::Test {
protected:
    Materials() {
        Image depth{wide, high, 2, 1, {}}, colour{wide, high, 1, 3, {}};
        for (int y = 0; y < high; ++y)
            for (int x = 0; x < wide; ++x) {
                const std::uint16_t mm = x < 10 && y < 10 ? 0 : 1000;
                depth.samples.push_back(static_cast<std::uint8_t>(mm & 255));
                depth.samples.push_back(static_cast<std::uint8_t>(mm >> 8));
                const std::array<std::uint8_t, 3> paint = x < wide / 2
                                                              ? std::array<std::uint8_t, 3>{150, 100, 60}
                                                              : std::array<std::uint8_t, 3>{60, 70, 150};
                colour.samples.insert(colour.samples.end(), paint.begin(), paint.end());
            }
        fs::create_directory(at("wall"));
        for (int n = 0; n < frames; ++n) {
            const std::string number = std::to_string(n) + ".png";
            EXPECT_TRUE(write_png(at("wall/depth_" + number), depth.view()));
            EXPECT_TRUE(write_png(at("wall/colour_" + number), colour.view()));
        }
        std::ofstream(at("wall/scene.json")) << R"({"touchable_scene": 1, "width": 96, "height": 64,
            "camera": {"fx": 400, "fy": 400, "cx": 47.5, "cy": 31.5}, "device_metres_per_unit": 0.0005,
            "depth": {"coding": "metric", "scale": 1, "near": 10, "far": 1500, "invalid": [0]},
            "folder": {"depth": "depth_%d.png", "colour": "colour_%d.png", "count": 12}})";
        succeed({"convert", at("wall"), at("wall.mkv"), "--exact-colour"});
    }
    std::string at(const std::string& name) const { return folder_ / name; }
    Words words(const std::string& out, const Words& more = {}) const {
        return plus({"materials", at("wall.mkv"), at(out)}, more);
    }
    Outcome run(const std::string& out, const Words& more = {}) const {
        const Outcome done = succeed(words(out, more));
        return done;
    }
    /// A hash of the file's bytes: a failure prints two numbers and not two files.
    std::uint64_t bytes(const std::string& name) const {
        const std::string all = file_contents(at(name));
        EXPECT_FALSE(all.empty()) << name;
        ByteHash hash;
        hash.add(all.data(), all.size());
        return hash.value();
    }
    std::array<int, 3> haptic_at(const std::string& name, int x, int y) const {
        auto clip = open_clip(at(name));
        EXPECT_TRUE(clip) << name;
        const auto first = (*clip)->next();
        const PlaneView& haptic = (*first)->haptic;
        return {haptic.sample(x, y, 0), haptic.sample(x, y, 1), haptic.sample(x, y, 2)};
    }
    /// Both named.
    const Words wood_and_foam{"--material", "table=wood", "--at", "20,40",
                              "--material", "mat=foam",   "--at", "80,20,3"};

    static constexpr int frames = 12;
    TemporaryFolder folder_;
};

TEST_F(Materials, WriteSeveralClipsToFolder) {
    fs::copy_file(at("wall.mkv"), at("other.mkv"));
    const Words several{"materials", at("wall.mkv"), at("other.mkv"), at("out") + "/"};
    succeed(several);
    EXPECT_TRUE(fs::exists(at("out/wall.mkv")) && fs::exists(at("out/other.mkv")));
    Words saved = plus(several, {"--save", at("names.json")});
    expect_failure(saved, 2, "--save is one file");
    // A clip that is there already would be left out, and nothing saved.
    expect_failure({"materials", at("wall.mkv"), at("out") + "/", "--save", at("names.json")}, 2,
                   "--save is one file");
}

/// A wall that is cut across, and of which two parts are one thing again.
TEST_F(Materials, SaveCutsAndJoins) {
    std::ofstream(at("cut.json")) << R"({"touchable_segments": 1,
        "cuts": [{"frame": 3, "stroke": [[4, 30], [40, 30]]}, {"frame": 0, "stroke": [[60, 40], [90, 40]]}],
        "segments": [
        {"name": "shelf", "material": "felt", "at": [[20, 50, 2], [80, 60]]},
        {"name": "rest", "material": "glass", "at": [[20, 20], [80, 20]]}]})";
    run("cut.mkv", {"--segments", at("cut.json"), "--save", at("saved.json")});
    EXPECT_EQ(haptic_at("cut.mkv", 5, 60), haptic_at("cut.mkv", 90, 50));
    EXPECT_EQ(haptic_at("cut.mkv", 20, 20), haptic_at("cut.mkv", 90, 30));
    EXPECT_NE(haptic_at("cut.mkv", 5, 60), haptic_at("cut.mkv", 20, 20));
    run("again.mkv", {"--segments", at("saved.json"), "--save", at("saved_again.json")});
    EXPECT_EQ(bytes("again.mkv"), bytes("cut.mkv"));
    EXPECT_EQ(bytes("saved_again.json"), bytes("saved.json"));
    std::ofstream(at("beside.json")) << R"({"touchable_segments": 1, "segments": [],
        "cuts": [{"frame": 0, "stroke": [[2, 2], [8, 8]]}]})";
    expect_failure(words("no.mkv", {"--segments", at("beside.json")}), 3,
                   "beside.json: cuts[0]: the stroke crosses no segment");
}

TEST_F(Materials, WarnAboutTwiceScaledHeights) {
    succeed({"relief", at("wall.mkv"), at("rough.mkv")});
    const auto scaled = [&](const std::string& clip, const std::string& out) {
        const Outcome done = succeed({"materials", at(clip), at(out), "--scale-relief"});
        return done.out.find("are scaled twice") != std::string::npos;
    };
    EXPECT_FALSE(scaled("rough.mkv", "once.mkv"));
    EXPECT_TRUE(scaled("once.mkv", "twice.mkv"));
}

/// Dragged over both, a finger slides with the friction of each: the force leans by it.
TEST_F(Materials, AreFeltByDraggedFinger) {
    run("felt.mkv", wood_and_foam);
    std::ofstream(at("hand.csv")) << "t_s,x,y,z\n0,-80,0,-950\n0.3,-80,0,-1004\n1.9,80,0,-1004\n";
    touch({at("felt.mkv"), "--hand", "csv:" + at("hand.csv") + ":columns=x+y+z,space=scene", "--forces",
           at("forces.csv"), "--seconds", "1.9"});
    struct Felt {
        double stiffness, static_friction, dynamic_friction;
        int slides = 0;
    };
    Felt wood{2000, 0.29, 0.216}, foam{220, 1.21, 0.911};
    for (const ForcesRow& row : read_forces(at("forces.csv"))) {
        const double column = row["pixel_x"];
        if (row["contact"] != 1 || row["time_s"] < 0.6 || (column > 46 && column < 49)) continue;
        Felt& felt = column < 48 ? wood : foam;
        EXPECT_NEAR(row["stiffness"], felt.stiffness, 4);
        EXPECT_NEAR(row["mu_static"], felt.static_friction, 0.003);
        EXPECT_NEAR(row["mu_dynamic"], felt.dynamic_friction, 0.003);
        const auto force = row.vector("force");
        const double leans = std::hypot(force[0], force[1]) / std::abs(force[2]);
        EXPECT_LE(leans, felt.static_friction + 0.004);
        felt.slides += std::abs(leans - felt.dynamic_friction) < 0.01;
    }
    EXPECT_GT(wood.slides, 100);
    EXPECT_GT(foam.slides, 100);
}

TEST_F(Materials, KeepOtherPlanesUnchanged) {
    const Outcome done = run("felt.mkv", wood_and_foam);
    for (const char* said : {"colour  every value kept", "haptic  every value kept", "table: 2 N/mm",
                             "mat: 0.22 N/mm", "steady   0.000 %", "frames/s"})
        EXPECT_PRED2(says, done.out, said);
    const auto before = packets(at("wall.mkv")), after = packets(at("felt.mkv"));
    EXPECT_FALSE(before.empty());
    for (const std::string& packet : before)
        EXPECT_NE(std::find(after.begin(), after.end(), packet), after.end());
    EXPECT_GT(after.size(), before.size());

    succeed({"convert", at("felt.mkv"), at("again.mkv")});
    succeed({"convert", at("felt.mkv"), at("felt.mp4")});
    const std::string hash = force_hash({at("felt.mkv"), "--seconds", "0.5"});
    EXPECT_EQ(force_hash({at("again.mkv"), "--seconds", "0.5"}), hash);
    EXPECT_EQ(force_hash({at("felt.mp4"), "--seconds", "0.5"}), hash);
    EXPECT_NE(force_hash({at("wall.mkv"), "--seconds", "0.5"}), hash);
    succeed({"play", at("felt.mkv"), "--headless", "--seconds", "0.1", "--size", "160x120"});
    // Its haptic pictures give way to others.
    succeed({"materials", at("felt.mkv"), at("other.mkv"), "--otherwise", "stone"});
    EXPECT_EQ(packets(at("other.mkv")).size(), after.size());
}

TEST_F(Materials, ReproduceSameBytes) {
    run("once.mkv", wood_and_foam);
    run("twice.mkv", wood_and_foam);
    EXPECT_EQ(bytes("once.mkv"), bytes("twice.mkv"));
    run("saved.mkv", {"--save", at("names.json"), "--material", "table=wood", "--at", "20,40"});
    run("read.mkv", {"--segments", at("names.json")});
    EXPECT_EQ(bytes("saved.mkv"), bytes("read.mkv"));
    EXPECT_NE(bytes("saved.mkv"), bytes("once.mkv"));
    // The command line may replace the saved guesses.
    run("said.mkv", {"--segments", at("names.json"), "--material", "mat=foam", "--at", "80,20"});
    EXPECT_EQ(bytes("said.mkv"), bytes("once.mkv"));
    // The same by a map: values of grey here, a palette's indices elsewhere.
    Image map{wide, high, 1, 1, {}};
    for (int k = 0; k < wide * high; ++k) map.samples.push_back(k % wide < 40 ? 1 : 2);
    ASSERT_TRUE(write_png(at("map.png"), map.view()));
    std::ofstream(at("map.json")) << R"({"touchable_segments": 1, "segments": [
        {"name": "table", "material": "wood", "index": 1}, {"name": "mat", "material": "foam", "index": 2}]})";
    run("mapped.mkv", {"--segments", at("map.json"), "--map", at("map.png"), "--save", at("found.json")});
    for (const auto& [x, y] : {std::pair{20, 40}, {80, 20}})
        EXPECT_EQ(haptic_at("mapped.mkv", x, y), haptic_at("once.mkv", x, y)) << x;
    run("found.mkv", {"--segments", at("found.json")});
    EXPECT_EQ(bytes("found.mkv"), bytes("mapped.mkv"));
}

TEST_F(Materials, WriteMapOfOneFrame) {
    const Outcome done =
        run("map.png", {"--frame", "1", "--material", "mat=carpet", "--at", "80,20", "--otherwise", "stone"});
    EXPECT_PRED2(says, done.out, "static friction 1.34 becomes 1");
    EXPECT_EQ(done.out.find("guess"), std::string::npos) << done.out;
    auto clip = must(open_clip(at("wall.mkv")));
    const auto& ranges = clip->scene().haptic;
    const auto map = must(read_image(at("map.png")));
    const auto felt = [&](int x, int y) {
        const PlaneView view = map.view();
        return ranges.at(static_cast<std::uint8_t>(view.sample(x, y, 0)),
                         static_cast<std::uint8_t>(view.sample(x, y, 1)),
                         static_cast<std::uint8_t>(view.sample(x, y, 2)));
    };
    EXPECT_NEAR(felt(90, 5).stiffness, 400, 20);
    EXPECT_EQ(felt(90, 5).static_friction, 1);
    EXPECT_NEAR(felt(5, 60).stiffness, 2000, 20);
    EXPECT_NEAR(felt(5, 5).static_friction, 0.93, 0.002);
    EXPECT_NE(force_hash({at("wall.mkv"), "--haptic", at("map.png"), "--seconds", "0.5"}),
              force_hash({at("wall.mkv"), "--seconds", "0.5"}));
}

TEST_F(Materials, ListWithoutWriting) {
    const auto before = names_in(at(""));
    const Outcome told = succeed({"materials", at("wall.mkv")});
    EXPECT_PRED2(says, told.out, "wood       guess");
    EXPECT_PRED2(says, told.out, "Guesses are by colour and roughness alone");
    const Outcome list = succeed({"materials", "--list"});
    for (const char* said : {"wood ", "water ", "as stiff as the device can", "HaTT", "estimate"})
        EXPECT_PRED2(says, list.out, said);
    const auto json = json_of({"materials", "--list", "--json"});
    for (const auto& material : json["materials"])
        EXPECT_PRED2(says, list.out, material["name"].get<std::string>() + ' ') << material;
    EXPECT_EQ(std::ranges::count(list.out, '\n'), std::ssize(json["materials"]) + 4) << list.out;
    EXPECT_EQ(run_touchable({"materials", at("wall.mkv"), "--json"}).code, 2) << "--save writes the segments";
    EXPECT_EQ(names_in(at("")), before);
}

TEST_F(Materials, NeedColourOnlyForGuesses) {
    make_clip("bumps", at("grey.mkv"), {"--size", "48x32", "--frames", "2"});
    expect_failure({"materials", at("grey.mkv"), at("out.mkv")}, 3, "has no colour");
    succeed({"materials", at("grey.mkv"), at("out.mkv"), "--otherwise", "cork"});
    const auto cork = haptic_at("out.mkv", 1, 1);
    EXPECT_EQ(cork, haptic_at("out.mkv", 47, 31));
    EXPECT_NEAR(cork[0], (1.5 - 0.05) / 1.95 * 255, 0.5);
}

/// A finger rests while what it rests on changes from foam to wood and back with every frame: neither its
/// stiffness nor its force jumps.
TEST_F(Materials, ChangeWithoutKickingRestingFinger) {
    run("wood.png", {"--otherwise", "wood", "--frame", "0"});
    run("foam.png", {"--otherwise", "foam", "--frame", "0"});
    for (int n = 0; n < frames; ++n)
        fs::copy_file(at(n % 2 == 0 ? "wood.png" : "foam.png"),
                      at("wall/haptic_" + std::to_string(n) + ".png"));
    std::string scene = file_contents(at("wall/scene.json"));
    scene.insert(scene.find("\"count\""), "\"haptic\": \"haptic_%d.png\", ");
    std::ofstream(at("hand.csv")) << "t_s,x,y,z\n0,0,0,-950\n0.05,0,0,-1004\n1,0,0,-1004\n";
    for (const bool held : {false, true}) {
        if (held) scene.insert(scene.find("\"folder\""), "\"interpolation\": \"hold\", ");
        std::ofstream(at("wall/scene.json")) << scene;
        touch({at("wall"), "--hand", "csv:" + at("hand.csv") + ":columns=x+y+z,space=scene", "--forces",
               at("forces.csv"), "--seconds", "0.36"});
        double before = 0, rise = 0, fall = 0, least = 1e9, most = 0;
        for (const ForcesRow& row : read_forces(at("forces.csv"))) {
            const double force = length(row.vector("force"));
            if (row["time_s"] > 0.18) {
                rise = std::max(rise, force - before);
                fall = std::max(fall, before - force);
                least = std::min(least, force);
                most = std::max(most, force);
            }
            before = force;
        }
        // The force is 0.44 N on foam and 4 N on wood; a tick may add no more than its share of a frame.
        EXPECT_GT(most, least + 0.1);
        EXPECT_LT(rise, 3.6 / 33 + 0.02);
        EXPECT_LT(held ? 0 : fall, 3.6 / 33 + 0.02);  // what becomes soft at once may fall at once
    }
}

TEST_F(Materials, RejectInvalidOptions) {
    std::ofstream(at("bad.json")) << R"({"touchable_segments": 1, "segments": [
        {"name": "a", "material": "gold", "at": [20, 40]}]})";
    std::ofstream(at("hole.json")) << R"({"touchable_segments": 1, "segments": [
        {"name": "a", "material": "wood", "at": [5, 5]}]})";
    const auto before = names_in(at(""));
    const auto expect = [&](const Words& more, int code, const std::string& why,
                            const std::string& out = "out.mkv") {
        expect_failure(words(out, more), code, why);
        EXPECT_EQ(names_in(at("")), before) << why;
    };
    const auto named = [](const std::string& material, const std::string& place) {
        return Words{"--material", material, "--at", place};
    };
    expect(named("table=gold", "20,40"), 2, "\"gold\" is no material");
    expect(named("wood", "20,40"), 2, "must be NAME=MATERIAL");
    expect(named("table=wood", "20"), 2, "must be X,Y or X,Y,FRAME");
    expect(named("table=wood", "20,40,-1"), 2, "must be X,Y or X,Y,FRAME");
    expect(named("table=wood", "5,5"), 2, "no surface at pixel 5,5 of frame 0");
    expect(named("table=wood", "96,5"), 2, "outside of the picture, which has 96x64");
    expect(named("table=wood", "20,40,12"), 2, "frame 12 is beyond the clip, whose last one is 11");
    expect({"--material", "table=wood"}, 2,
           "each --material needs its --at, X,Y of a pixel of the segment; given: 1 material, 0 places");
    expect({"--material", "wood"}, 2, "--material \"wood\" is not allowed; must be NAME=MATERIAL");
    expect({"--material", "a=wood", "--at", "20,40", "--material", "b=foam", "--at", "21,41"}, 2,
           "a segment is of one material");
    expect({"--otherwise", "gold"}, 2, "\"gold\" is no material");
    expect({"--segments", at("bad.json")}, 3, "bad.json: segments[0].material is \"gold\"");
    expect({"--segments", at("hole.json")}, 3, "hole.json: segments[0]: there is no surface");
    expect({"--segments", at("none.json")}, 3, "none.json");
    expect({"--map", at("wall/depth_0.png")}, 3, "must be a PNG of indices");
    expect({"--save", at("wall.mkv")}, 2, "which it would replace");
    expect({"--save", at("hole.json")}, 2, "is there already");
    expect({"--scale-relief"}, 3, "has no heights to be scaled");
    expect({"--scale-relief"}, 2, "--scale-relief is for NAME.mkv", "out.png");
    expect({}, 2, "--frame says which one", "out.png");
    expect({"--frame", "12"}, 2, "--frame 12 is beyond the clip, which has 12 frames", "out.png");
    expect({"--frame", "1"}, 2, "--frame is for NAME.png");
    expect({"--haptic", at("wall/colour_0.png")}, 2, "--haptic does nothing here");
    expect({}, 2, "does not end in .mkv", "out.mp4");
    EXPECT_EQ(run_touchable({"materials"}).code, 2);
    EXPECT_EQ(run_touchable({"materials", at("none.mkv")}).code, 3);
}

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
        return plus({"make", "globe", folder_ / "out.mkv", "--size", "96x64", "--frames", "2", "--colour",
                     folder_ / "colour.png", "--elevation", folder_ / "elevation.png", "--mask",
                     folder_ / "mask.png"},
                    more);
    }

private:
    TemporaryFolder folder_;
};

TEST(GlobeMaps, GiveAllPlanes) {
    for (const bool white : {true, false}) {
        const MapsInAFolder maps(64, white);
        const Outcome run = succeed(maps.words({"--longitude", "0", "--rate", "24", "--bits", "12"}));
        EXPECT_PRED2(says, run.out, "out.mkv: 2 frames of globe, 96x64, 12 bits");
        EXPECT_PRED2(says, run.out,
                     "sea level 8000 of the elevation map; land is " +
                         std::string(white ? "bright" : "dark") +
                         " in the mask; the two agree on 100.0 % of the globe");
        auto reader = must(open_clip(maps / "out.mkv"));
        EXPECT_EQ(reader->scene().rate.num, 24);
        const RawFrame frame = reader->next()->value();
        EXPECT_FALSE(frame.colour.empty());
        EXPECT_FALSE(frame.height.empty());
        EXPECT_EQ(frame.haptic.sample(48, 31), 148);  // land in front: 1.2 N/mm
        EXPECT_EQ(frame.haptic.sample(1, 1), 94);     // nothing there: 0.8 N/mm
        EXPECT_EQ(frame.depth.sample(1, 1), 0);
    }
}

TEST(GlobeMaps, GiveSameBytesAgain) {
    const MapsInAFolder maps;
    succeed(maps.words());
    const std::string first = file_contents(maps / "out.mkv");
    succeed(maps.words({"--overwrite"}));
    EXPECT_EQ(file_contents(maps / "out.mkv"), first);
}

TEST(GlobeMaps, UseLeastElevationWithoutMask) {
    const MapsInAFolder maps;
    auto words = maps.words();
    words.resize(words.size() - 2);
    succeed(maps.words({"--longitude", "0"}));
    const std::string with_mask = file_contents(maps / "out.mkv");
    words.insert(words.end(), {"--longitude", "0", "--overwrite"});
    const Outcome run = succeed(words);
    EXPECT_PRED2(says, run.out,
                 "sea level 8000, the least of the elevation map (--sea-level VALUE says otherwise)");
    EXPECT_EQ(file_contents(maps / "out.mkv"), with_mask);
    words.insert(words.end(), {"--sea-level", "13000"});
    const Outcome told = succeed(words);
    EXPECT_PRED2(says, told.out, "sea level 13000, as told");
    EXPECT_NE(file_contents(maps / "out.mkv"), with_mask);
    words.back() = "7000";
    expect_failure(words, 3, "--sea-level leaves only land");
}

TEST(GlobeMaps, KeepHapticMapCodes) {
    const MapsInAFolder maps;
    Image touch{32, 16, 1, 3, {}};
    for (int n = 0; n < 32 * 16; ++n)
        for (const int code : {200, 100, 50}) touch.samples.push_back(static_cast<std::uint8_t>(code));
    ASSERT_TRUE(write_png(maps / "touch.png", touch.view()));
    succeed(maps.words({"--haptic", maps / "touch.png"}));
    auto reader = must(open_clip(maps / "out.mkv"));
    const RawFrame frame = reader->next()->value();
    for (const int x : {25, 48, 70}) {
        EXPECT_EQ(frame.haptic.sample(x, 31, 0), 200);
        EXPECT_EQ(frame.haptic.sample(x, 31, 1), 100);
        EXPECT_EQ(frame.haptic.sample(x, 31, 2), 50);
    }
}

TEST(GlobeMaps, ScaleWhiteByBitDepth) {
    const MapsInAFolder maps;
    std::vector<std::string> words = maps.words({"--exact-colour", "--overwrite"});
    *(std::ranges::find(words, "--colour") + 1) = maps / "white.pgm";
    std::set<int> lit;
    for (const auto& [largest, white] :
         {std::pair<int, std::string>{15, "\x0f"}, {255, "\xff"}, {1023, "\x03\xff"}, {65535, "\xff\xff"}}) {
        std::ofstream file(maps / "white.pgm", std::ios::binary);
        file << "P5 64 32 " << largest << "\n";
        for (int pixel = 0; pixel < 64 * 32; ++pixel) file << white;
        file.close();
        succeed(words);
        auto reader = must(open_clip(maps / "out.mkv"));
        lit.insert(reader->next()->value().colour.sample(48, 31));
    }
    EXPECT_EQ(lit.size(), 1U);
    EXPECT_GT(*lit.begin(), 200);
}

/// One line, the right exit code, and nothing is left behind.
void expect_refusal(const MapsInAFolder& maps, const std::vector<std::string>& words, int code,
                    const std::string& said) {
    expect_failure(words, code, said);
    for (const std::string& name : names_in(maps.folder().path())) EXPECT_NE(name, "out.mkv");
}

TEST(GlobeMaps, RejectInvalidMaps) {
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

TEST(GlobeMaps, RejectUselessOrIncompleteOptions) {
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

TEST(GlobeMaps, AreNeverOverwritten) {
    const MapsInAFolder maps;
    std::vector<std::string> words = maps.words({"--overwrite"});
    std::ofstream(maps / "map.mkv") << "anything";
    words[2] = words[8] = maps / "map.mkv";
    const Outcome run = run_touchable(words);
    EXPECT_EQ(run.code, 2) << run.err;
    EXPECT_EQ(file_contents(maps / "map.mkv"), "anything");
}

TEST(GlobeMaps, ReportInsufficientMemory) {
#ifdef TOUCHABLE_SANITIZED
    GTEST_SKIP() << "sanitizers take more address space than this test leaves";
#endif
    const MapsInAFolder maps;
    Image large{8192, 4096, 1, 3, std::vector<std::uint8_t>(8192U * 4096 * 3)};
    for (std::size_t n = 0; n < large.samples.size(); n += 97)
        large.samples[n] = static_cast<std::uint8_t>(n);
    ASSERT_TRUE(write_png(maps / "colour.png", large.view()));
    expect_failure(run_in_memory(maps.words(), 360), 3, "memory");
}

TEST(GlobeMaps, ShowHimalayaOfRealEarth) {
    const auto earth = real_data("earth");
    TOUCHABLE_NEEDS_DATA(earth);
    const TemporaryFolder folder;
    struct Mask {
        const char *file, *land;
        double least;
    };
    for (const Mask& mask :
         {Mask{"etopo5_10min_landmask.png", "bright", 99.9}, {"earth-water.png", "dark", 98}}) {
        const Outcome run =
            succeed({"make", "globe", folder / "earth.mkv", "--size", "240x160", "--frames", "1",
                     "--axial-tilt", "0", "--longitude", "85", "--overwrite", "--colour",
                     (earth / "earth-blue-marble.jpg").string(), "--elevation",
                     (earth / "etopo5_10min_elev_u16.png").string(), "--mask", (earth / mask.file).string()});
        EXPECT_PRED2(says, run.out, std::string("land is ") + mask.land);
        const double level = std::stod(run.out.substr(run.out.find("sea level ") + 10));
        EXPECT_NEAR(level, 11000, 60) << run.out;
        EXPECT_GE(std::stod(run.out.substr(run.out.find("agree on ") + 9)), mask.least) << run.out;
        auto reader = must(open_clip(folder / "earth.mkv"));
        const Scene& scene = reader->scene();
        const RawFrame frame = reader->next()->value();
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
