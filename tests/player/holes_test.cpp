#include <gtest/gtest.h>

#include <fstream>

#include "engine/picture/image.hpp"
#include "tests/player/program.hpp"
#include "tests/player/recording_bytes.hpp"
#include "tests/player/touched.hpp"

namespace touchable::test {
namespace {

using Words = std::vector<std::string>;

/// A wall at 1000 mm as a depth camera sees it, with a hole in it, and a finger that goes into the hole,
/// behind its left side, up and out again.
class Holes : public ::testing::Test {
protected:
    static constexpr int width = 96, height = 64, first = 40, last = 63;  // columns of the hole

    Holes() {
        std::vector<std::uint16_t> depths(width * height, 1000);
        for (int y = 20; y < 44; ++y)
            for (int x = first; x <= last; ++x) depths[static_cast<std::size_t>(y * width + x)] = 0;
        PlaneView view;
        view.data = reinterpret_cast<const std::uint8_t*>(depths.data());
        view.width = width;
        view.height = height;
        view.bytes_per_sample = 2;
        view.stride = 2 * width;
        EXPECT_TRUE(write_png(folder / "depth.png", view));
        std::ofstream(hand_file()) << "t_s,x,y,z\n0,20,0,-950\n0.2,20,0,-1030\n0.7,-80,0,-1030\n"
                                      "1.5,-80,10,-1030\n2,20,10,-1030\n2.2,20,10,-950\n";
    }
    /// `stiffness`: the scene's member, as it is written there.
    std::string scene(const std::string& stiffness = "") const {
        const std::string file = folder / ("scene" + stiffness + ".json");
        std::ofstream(file) << R"({"touchable_scene": 1, "width": 96, "height": 64,
            "camera": {"fx": 400, "fy": 400, "cx": 47.5, "cy": 31.5}, "device_metres_per_unit": 0.0005,
            "depth": {"coding": "metric", "scale": 1, "far": 1500, "invalid": [0]},)"
                            << (stiffness.empty() ? "" : "\"hole_stiffness\": " + stiffness + ",")
                            << R"("folder": {"depth": "depth.png"}})";
        return file;
    }
    std::string hand_file() const { return folder / "hand.csv"; }
    Words words(const std::string& scene_file, const Words& more = {}) const {
        Words all{scene_file, "--hand", "csv:" + hand_file() + ":columns=x+y+z,space=scene", "--forces",
                  csv()};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }
    std::string csv() const { return folder / "forces.csv"; }

    TemporaryFolder folder;
};

TEST_F(Holes, TheReportSaysHowLongFingersWereCaughtInThem) {
    const auto report = touch(words(scene()));
    // On the wall's triangles, between the last valid column and the first invalid one, or deeper in.
    std::int64_t caught = 0, limited = 0, contact = 0, row_length = 0, longest = 0;
    for (const ForcesRow& row : read_forces(csv())) {
        const bool in_hole = row["contact"] == 1 && row["pixel_x"] > first - 1 && row["pixel_x"] < last + 1;
        caught += in_hole;
        limited += in_hole && (static_cast<int>(row["guard"]) & 2) != 0;
        contact += row["contact"] == 1;
        row_length = in_hole ? row_length + 1 : 0;
        longest = std::max(longest, row_length);
    }
    ASSERT_GT(caught, 1000);
    ASSERT_GT(limited, 500);
    const auto& holes = report["hole_contact"];
    EXPECT_EQ(holes["finger_ticks"], caught);
    EXPECT_EQ(holes["longest_ticks"], longest);
    EXPECT_EQ(holes["force_limited_ticks"], limited);
    EXPECT_DOUBLE_EQ(holes["contact_pct"],
                     100.0 * static_cast<double>(caught) / static_cast<double>(contact));

    Words said = words(scene(), {"--overwrite", "--verbose"});
    said.insert(said.begin(), "touch");
    const std::string table = run_touchable(said).out;
    EXPECT_NE(table.find("s behind walls of missing depth ("), std::string::npos) << table;
    EXPECT_NE(table.find("hole_stiffness in the scene file makes them soft"), std::string::npos) << table;
}

TEST_F(Holes, WithTheirOwnStiffnessNoLongerPushAsHardAsTheDeviceCan) {
    const auto hard = touch(words(scene())), soft = touch(words(scene("0.1")));
    EXPECT_NEAR(hard["force_n"]["max"], 10, 1e-9);
    EXPECT_LT(soft["force_n"]["max"], 0.1 * 50);  // 100 units behind the wall are 50 mm
    EXPECT_EQ(soft["hole_contact"]["force_limited_ticks"], 0);
    EXPECT_EQ(soft["hole_contact"]["finger_ticks"], hard["hole_contact"]["finger_ticks"]);
    for (const auto& note : soft["notes"])
        EXPECT_EQ(note.get<std::string>().find("hole_stiffness"), std::string::npos) << note;
}

TEST_F(Holes, AClipWithoutThemIsSilentAboutThem) {
    const std::string clip = folder / "bumps.mkv";
    make_clip("bumps", clip, {"--size", "72x48", "--frames", "2"});
    const auto holes = touch({clip, "--seconds", "0.6"})["hole_contact"];
    for (const char* figure : {"finger_ticks", "contact_pct", "longest_ticks", "force_limited_ticks"})
        EXPECT_EQ(holes[figure], 0) << figure;
    EXPECT_EQ(run_touchable({"touch", clip, "--seconds", "0.6"}).out.find("caught in holes"),
              std::string::npos);
}

TEST_F(Holes, InfoSaysHowStiffTheyAre) {
    const Outcome said = run_touchable({"info", scene("0.1")}),
                  json = run_touchable({"info", scene("0.1"), "--json"});
    EXPECT_NE(said.out.find("walls of missing depth have 0.1 N/mm"), std::string::npos) << said.out;
    EXPECT_EQ(nlohmann::json::parse(json.out)["hole_stiffness_n_per_mm"], 0.1);
    EXPECT_EQ(run_touchable({"info", scene()}).out.find("missing depth"), std::string::npos);
}

TEST_F(Holes, ARecordingKeepsTheirStiffness) {
    const std::string file = folder / "run.rec";
    const auto recorded = touch(words(scene("0.1"), {"--record", file}));
    RecordingBytes raw(file_contents(file));
    auto facts = raw.facts();
    EXPECT_EQ(facts["scene"]["hole_stiffness"], 0.1);
    // It is the recording's, whatever the scene file says by now.
    scene();
    std::filesystem::rename(folder / "scene.json", folder / "scene0.1.json");
    const Outcome same = run_touchable({"touch", "--replay", file});
    EXPECT_EQ(same.code, 0) << same.err;
    EXPECT_NE(same.out.find(recorded["force_hash"].get<std::string>()), std::string::npos) << same.out;
    facts["scene"].erase("hole_stiffness");
    raw.set_facts(facts.dump());
    std::ofstream(file, std::ios::binary) << raw.bytes();
    EXPECT_EQ(run_touchable({"touch", "--replay", file}).code, 6);
}

}  // namespace
}  // namespace touchable::test
