// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <malloc.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <set>
#include <vector>

#include "engine/base/same_bits.hpp"
#include "player/commands/reports.hpp"
#include "player/run/run_files.hpp"
#include "player/session/touch_setup.hpp"
#include "tests/must.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"

namespace touchable::test {
namespace {

class Touch : public ::testing::Test {
protected:
    void make(const std::string& scene, const Words& more = {"--size", "72x48", "--frames", "6"}) {
        make_clip(scene, clip(), more);
    }
    std::string clip() const { return folder / "clip.mkv"; }
    Words with(const Words& more) const { return plus({clip()}, more); }
    /// Report and rows of one run.
    std::pair<nlohmann::json, std::vector<ForcesRow>> run(const Words& more) const {
        const std::string csv = folder / "forces.csv";
        auto report = touch(plus(with(more), {"--forces", csv}));
        return {report, read_forces(csv)};
    }

    TemporaryFolder folder;
};

TEST_F(Touch, ReportHasEveryFigure) {
    make("globe");
    const auto report = touch(with({"--fingers", "3", "--seconds", "0.5"}));
    for (const char* name : {"clip", "hand", "builder", "device_name", "force_hash"})
        EXPECT_TRUE(report[name].is_string()) << name;
    for (const char* name :
         {"format", "width", "height", "frames", "fingers", "ticks", "contact_ticks", "hops",
          "proxy_behind_mesh_ticks", "nonfinite_ticks", "capped_ticks", "guarded_ticks", "late_ticks"})
        EXPECT_TRUE(report[name].is_number_integer()) << name;
    for (const char* name : {"skipped_tiles_pct", "finger_contact_pct", "events_mean"})
        EXPECT_TRUE(report[name].is_number()) << name;
    for (const char* name : {"mean", "max"}) EXPECT_TRUE(report["force_n"][name].is_number()) << name;
    for (const char* spread : {"tick_us", "frame_ms"}) {
        for (const char* name : {"mean", "p50", "p99", "p999", "max"})
            EXPECT_GT(report[spread][name].get<double>(), 0) << spread << ' ' << name;
        EXPECT_LE(report[spread]["p50"], report[spread]["p99"]);
        EXPECT_LE(report[spread]["p99"], report[spread]["p999"]);
        EXPECT_LE(report[spread]["p999"], report[spread]["max"]);
        EXPECT_LE(report[spread]["mean"], report[spread]["max"]);
    }
    EXPECT_FALSE(report["stages_ms"].empty());
    for (const auto& stage : report["stages_ms"].items()) EXPECT_TRUE(stage.value().is_number());

    EXPECT_EQ(report["format"], 1);
    EXPECT_EQ(report["clip"], clip());
    EXPECT_EQ(report["hand"], "wander");
    EXPECT_EQ(report["builder"], "cpu");
    EXPECT_EQ(report["width"], 72);
    EXPECT_EQ(report["height"], 48);
    EXPECT_EQ(report["frames"], 6);
    EXPECT_EQ(report["fingers"], 3);
    EXPECT_EQ(report["ticks"], 500);
    EXPECT_EQ(report["late_ticks"], 0);
    EXPECT_GT(report["skipped_tiles_pct"], 0);  // the globe turns, what is around it does not
    EXPECT_LT(report["skipped_tiles_pct"], 100);
    EXPECT_EQ(report["force_hash"].get<std::string>().find_first_not_of("0123456789abcdef"),
              std::string::npos);
    EXPECT_EQ(report["force_hash"].get<std::string>().size(), 16U);
}

TEST_F(Touch, PrintsFourLinesByDefault) {
    make("globe");
    const Outcome run = succeed({"touch", clip(), "--seconds", "0.5", "--forces", folder / "f.csv"});
    EXPECT_EQ(std::count(run.out.begin(), run.out.end(), '\n'), 5) << run.out;  // a note of the clip's end
    for (const std::string& fact :
         {clip() + ", by 1 finger for 0.500 s, ", std::string(" N mean in contact, "),
          std::string("sound: every force is finite"), (folder / "f.csv").string() + "; --verbose"})
        EXPECT_PRED2(says, run.out, fact);
}

/// By default the picture shows a moment of the run, whose length its commands decide.
TEST_F(Touch, CommandedRunHasPicture) {
    make("globe");
    std::ofstream(folder / "commands.txt") << "0.1 rate 0.5\n";
    succeed({"touch", clip(), "--play", folder / "commands.txt", "--picture", folder / "p.png",
             "--picture-size", "64x48", "--painter", "cpu"});
    EXPECT_GT(file_contents(folder / "p.png").size(), 1000U);
}

TEST_F(Touch, VerboseTablePrintsFigures) {
    make("globe");
    const Outcome run = succeed({"touch", clip(), "--seconds", "0.5", "--verbose"});
    for (const std::string& fact :
         {std::string("72x48"), std::string("500 at 1 kHz"), std::string("contact"), std::string(" N mean"),
          std::string("behind the surface"), force_hash(with({"--seconds", "0.5"}))})
        EXPECT_PRED2(says, run.out, fact);
}

TEST_F(Touch, ForcesFileHasEveryRow) {
    make("globe");
    const auto [report, rows] = run({"--fingers", "3", "--seconds", "0.4"});
    ASSERT_EQ(rows.size(), 1200U);
    for (std::size_t k = 0; k < rows.size(); ++k) {
        ASSERT_EQ(rows[k]["tick"], static_cast<double>(k / 3));
        ASSERT_EQ(rows[k]["finger"], static_cast<double>(k % 3));
        ASSERT_EQ(rows[k]["time_s"], static_cast<double>(k / 3) / 1000);
        ASSERT_EQ(rows[k]["S"], rows[0]["S"]);
        // Frame n of 30/s is at n/30 s; the clip's last is number 5.
        const double frame = rows[k]["time_s"] * 30, last = std::min(std::floor(frame + 1e-6), 5.0);
        ASSERT_EQ(rows[k]["frame_prev"], last);
        ASSERT_EQ(rows[k]["frame_next"], std::min(last + 1, 5.0));
        ASSERT_NEAR(rows[k]["blend"], last < 5 ? frame - last : 0, 1e-6);
    }
    EXPECT_GT(rows[0]["S"], 0);
}

TEST_F(Touch, CountsAndMarksHops) {
    make("globe");
    const auto [report, rows] = run({"--fingers", "2", "--seconds", "2", "--hand", "wander:glide=1"});
    int hops = 0;
    for (std::size_t finger = 0; finger < 2; ++finger)
        for (std::size_t at = finger, length = 0; at < rows.size(); at += 2) {
            const bool hop = rows[at]["hop"] == 1;
            if (!hop && length > 0) {
                EXPECT_GE(length, 40U) << "before tick " << rows[at]["tick"];
            }
            hops += hop && length == 0;
            length = hop ? length + 1 : 0;
        }
    EXPECT_GT(hops, 0);
    EXPECT_EQ(report["hops"], hops);
    EXPECT_EQ(touch(with({"--hand", "press", "--seconds", "0.5"}))["hops"], 0);
}

// The report and the forces file come from one run; each can be computed from the other.
TEST_F(Touch, ReportMatchesForcesFile) {
    make("globe");
    const auto [report, rows] = run({"--fingers", "3", "--seconds", "0.6", "--max-force", "2"});
    std::string bytes;
    std::set<double> contact_ticks, guarded_ticks;
    double sum = 0, most = 0;
    int contacts = 0;
    for (const ForcesRow& row : rows) {
        for (const double component : row.vector("force")) {
            const auto bits = std::bit_cast<std::uint64_t>(component == 0 ? 0.0 : component);
            for (int shift = 0; shift < 64; shift += 8) bytes += static_cast<char>(bits >> shift);
        }
        if (row["guard"] != 0) guarded_ticks.insert(row["tick"]);
        if (row["contact"] == 0) continue;
        contact_ticks.insert(row["tick"]);
        ++contacts;
        sum += length(row.vector("force"));
        most = std::max(most, length(row.vector("force")));
    }
    char hash[17];
    std::snprintf(hash, sizeof hash, "%016llx",
                  static_cast<unsigned long long>(XXH64(bytes.data(), bytes.size(), 0)));
    EXPECT_EQ(report["force_hash"], hash);
    EXPECT_EQ(report["contact_ticks"], contact_ticks.size());
    EXPECT_EQ(report["guarded_ticks"], guarded_ticks.size());
    EXPECT_DOUBLE_EQ(report["finger_contact_pct"].get<double>(), 100.0 * contacts / 1800);
    EXPECT_NEAR(report["force_n"]["mean"].get<double>(), sum / contacts, 1e-12);
    EXPECT_DOUBLE_EQ(report["force_n"]["max"].get<double>(), most);
}

TEST_F(Touch, WanderingHandMostlyTouches) {
    for (const char* scene : {"globe", "bumps", "spheres", "moving"}) {
        make(scene);
        const auto report = touch(with({"--fingers", "5"}));
        EXPECT_GT(report["finger_contact_pct"], 50) << scene;
        EXPECT_EQ(report["proxy_behind_mesh_ticks"], 0) << scene;
        EXPECT_EQ(report["nonfinite_ticks"], 0) << scene;
        EXPECT_EQ(report["capped_ticks"], 0) << scene;
        EXPECT_GT(report["force_n"]["mean"], 0.1) << scene;
    }
}

// The paper's law, wherever the guard did not act.
TEST_F(Touch, ForceFollowsSpringLaw) {
    make("globe");
    const auto [report, rows] = run({"--fingers", "2", "--seconds", "1", "--max-force", "1000"});
    int checked = 0;
    for (const ForcesRow& row : rows) {
        if (row["guard"] != 0) continue;
        const auto goal = row.vector("goal"), proxy = row.vector("proxy"), force = row.vector("force");
        for (std::size_t axis = 0; axis < 3; ++axis)
            ASSERT_NEAR(force[axis], row["stiffness"] * row["S"] * (proxy[axis] - goal[axis]), 1e-12);
        if (row["contact"] == 1)
            ++checked;
        else
            ASSERT_EQ(length(force), 0);
    }
    EXPECT_GT(checked, 1000);
}

TEST_F(Touch, ForcesMatchAcrossBuilders) {
    const std::string zigzag = zigzag_hand(folder / "zigzag.csv");
    const std::map<std::string, Words> runs{{"globe", {"--fingers", "3"}},
                                            {"moving", {"--hand", zigzag}},
                                            {"noise", {"--hand", zigzag}},
                                            {"cliffs", {"--hand", zigzag, "--median", "5"}}};
    for (const auto& [scene, more] : runs) {
        make(scene);
        Words words = plus(with(more), {"--seconds", "0.8", "--builder", "cpu"});
        const auto cpu = touch(words);
        EXPECT_GT(cpu["finger_contact_pct"], 20) << scene;
        for (const char* builder : {"lazy", "reference"}) {
            words.back() = builder;
            const auto other = touch(words);
            EXPECT_EQ(other["force_hash"], cpu["force_hash"]) << scene << ' ' << builder;
            EXPECT_EQ(other["builder"], builder);
        }
    }
}

TEST_F(Touch, LazyBuilderSkipsEveryTile) {
    make("globe");
    EXPECT_EQ(touch(with({"--seconds", "0.1", "--builder", "lazy"}))["skipped_tiles_pct"], 100);
}

TEST_F(Touch, SettingsChangeForces) {
    const Words base{"--hand", zigzag_hand(folder / "zigzag.csv")};
    const auto hash = [&](const Words& more) { return force_hash(plus(with(base), more)); };
    make("noise");
    const std::string rough = hash({});
    EXPECT_EQ(hash({}), rough);
    EXPECT_EQ(hash({"--median", "0"}), rough) << "the scene's own";
    EXPECT_EQ(hash({"--interpolation", "hold"}), rough) << "it stands still";
    EXPECT_EQ(hash({"--fill-holes", "3"}), rough) << "it has no holes";
    EXPECT_EQ(hash({"--metric", "world"}), rough) << "the default";
    std::set<std::string> all{rough};
    for (const Words& more :
         {Words{"--median", "3"}, Words{"--median", "5"}, Words{"--metric", "pixel"}, Words{"--fingers", "2"},
          Words{"--max-force", "0.5"}, Words{"--max-stiffness", "0.1"}, Words{"--seconds", "0.7"}})
        EXPECT_TRUE(all.insert(hash(more)).second) << more[0] << ' ' << more[1] << " changed nothing";

    make("moving", {"--size", "72x48", "--frames", "20"});
    EXPECT_EQ(hash({"--interpolation", "linear"}), hash({}));
    EXPECT_NE(hash({"--interpolation", "hold"}), hash({}));
}

TEST_F(Touch, FillsHolesOfScene) {
    make("grain", {"--size", "72x48", "--frames", "1", "--bits", "8"});
    auto scene = scene_of(clip());
    scene["depth"]["invalid"] = {128};  // of the five levels of the grain, the middle one
    const std::string file = folder / "holes.json";
    std::ofstream(file) << scene;
    const std::string zigzag = zigzag_hand(folder / "zigzag.csv");
    const Words base{"--scene", file, "--hand", zigzag};
    const auto hash = [&](const Words& more) { return force_hash(plus(with(base), more)); };
    EXPECT_NE(hash({}), force_hash(with({"--hand", zigzag})));
    EXPECT_NE(hash({"--fill-holes", "1"}), hash({}));
    EXPECT_EQ(hash({"--fill-holes", "2", "--builder", "lazy"}), hash({"--fill-holes", "2"}));
    EXPECT_EQ(hash({"--fill-holes", "2", "--median", "5", "--builder", "reference"}),
              hash({"--fill-holes", "2", "--median", "5"}));
}

TEST_F(Touch, TerraceRemovalMatchesAcrossBuilders) {
    make("globe", {"--size", "144x96", "--frames", "1", "--bits", "8"});
    const Words base{"--hand", zigzag_hand(folder / "zigzag.csv")};
    const auto hash = [&](const Words& more) { return force_hash(plus(with(base), more)); };
    const std::string removed = hash({"--terraces", "on"});
    EXPECT_EQ(removed, hash({})) << "steps of 8 bits are steep";
    EXPECT_EQ(removed, hash({"--terraces", "auto"}));
    EXPECT_NE(removed, hash({"--terraces", "off"}));
    EXPECT_EQ(hash({"--terraces", "off"}), hash({"--filters", "off"}));
    for (const char* builder : {"lazy", "reference", "vulkan"})
        EXPECT_EQ(hash({"--terraces", "on", "--builder", builder}), removed) << builder;
    make("globe", {"--size", "144x96", "--frames", "1"});
    EXPECT_EQ(hash({"--terraces", "auto"}), hash({})) << "16 bits";
}

TEST_F(Touch, RunLastsRequestedSeconds) {
    make("plane", {"--size", "16x12", "--frames", "2"});
    for (const auto& [seconds, ticks] :
         std::vector<std::pair<std::string, int>>{{"0.001", 1}, {"0.0254", 25}, {"0.25", 250}, {"2", 2000}})
        EXPECT_EQ(touch(with({"--seconds", seconds}))["ticks"], ticks);
}

TEST_F(Touch, ScriptedHandTouchesWholeClip) {
    make("plane", {"--size", "16x12", "--frames", "2"});
    EXPECT_EQ(touch(with({}))["ticks"], 3000);
    make("plane", {"--size", "16x12", "--frames", "105"});
    const auto report = touch(with({}));
    EXPECT_EQ(report["ticks"], 3500);
    EXPECT_EQ(report["frames"], 105);
}

TEST_F(Touch, FollowsRecordedHandToEnd) {
    make("plane", {"--size", "72x48", "--frames", "2"});
    const std::string file = folder / "press.csv";
    std::ofstream(file) << "t_s,angle\n0,0\n0.1,0.2\n0.25,0.05\n";
    const std::string hand = "csv:" + file + ":columns=angle,scale=0.075";
    const auto report = touch(with({"--hand", hand}));
    EXPECT_EQ(report["ticks"], 251);
    EXPECT_EQ(report["hand"], hand);
    EXPECT_NEAR(report["finger_contact_pct"].get<double>(), 60, 5);
    EXPECT_EQ(touch(with({"--hand", hand, "--seconds", "0.4"}))["ticks"], 400);
}

TEST_F(Touch, FingersSpreadAroundHand) {
    make("plane", {"--size", "144x96", "--frames", "1"});
    const auto [report, rows] = run({"--fingers", "4", "--seconds", "0.3", "--hand", "press"});
    ASSERT_EQ(report["fingers"], 4);
    // On the plane's picture of 0.16 m, the circle of 0.02 m is an eighth of the width.
    for (std::size_t k = 4 * 250; k < rows.size(); ++k) {
        const double dx = rows[k]["goal_x"] * rows[k]["S"], dy = rows[k]["goal_y"] * rows[k]["S"];
        ASSERT_NEAR(std::sqrt(dx * dx + dy * dy), 0.02, 0.006) << k;
    }
}

TEST_F(Touch, ForceStaysBelowDeviceLimit) {
    make("globe");
    const auto [report, rows] = run({"--fingers", "2", "--seconds", "1", "--max-force", "0.7"});
    int limited = 0;
    for (const ForcesRow& row : rows) {
        ASSERT_LE(length(row.vector("force")), 0.7 * (1 + 1e-12));
        const bool by_force = (static_cast<int>(row["guard"]) & 2) != 0;
        if (!by_force || row["tick"] < 100) continue;
        ++limited;
        ASSERT_NEAR(length(row.vector("force")), 0.7, 1e-12);
    }
    EXPECT_GT(limited, 100);
    EXPECT_LE(report["force_n"]["max"], 0.7 * (1 + 1e-12));
}

TEST_F(Touch, StiffnessStaysBelowDeviceLimit) {
    make("bumps");
    const auto [report, rows] = run({"--seconds", "0.6", "--max-stiffness", "0.05", "--max-force", "100"});
    int limited = 0;
    for (const ForcesRow& row : rows) {
        if (row["contact"] == 0 || row["tick"] < 100) continue;
        ++limited;
        ASSERT_EQ(row["guard"], 1);
        const auto goal = row.vector("goal"), proxy = row.vector("proxy"), force = row.vector("force");
        for (std::size_t axis = 0; axis < 3; ++axis)
            ASSERT_NEAR(force[axis], 50 * row["S"] * (proxy[axis] - goal[axis]), 1e-12);
    }
    EXPECT_GT(limited, 200);
}

TEST_F(Touch, ForcesRampIn) {
    make("plane");
    const std::string file = folder / "in.csv";
    std::ofstream(file) << "t_s,in\n0,0\n0.3,0\n";  // under the surface from the first tick
    const std::string hand = "csv:" + file + ":columns=in,contact=0.99";
    const auto [report, rows] = run({"--hand", hand});
    for (const ForcesRow& row : rows) ASSERT_EQ((static_cast<int>(row["guard"]) & 4) != 0, row["tick"] < 100);
    EXPECT_EQ(length(rows[0].vector("force")), 0);
}

TEST_F(Touch, DepthAloneUsesDefaultProperties) {
    make("bumps");
    succeed({"export", clip(), "--frames", "all", "--out", folder / "out"});
    for (const std::string n : {"0", "1", "2", "3", "4", "5"})
        std::filesystem::copy_file(folder / ("out/" + n + "/depth.png"), folder / ("d" + n + ".png"));
    const std::string scene = folder / "scene.json", csv = folder / "forces.csv";
    std::ofstream(scene) << R"({"touchable_scene": 1, "width": 72, "height": 48,
        "camera": {"fx": 355, "fy": 355, "cx": 35.5, "cy": 23.5},
        "depth": {"coding": "linear", "near": 980, "far": 1020, "bits": 16, "semantics": "planar"},
        "folder": {"depth": "d%d.png"}})";
    const auto report = touch({scene, "--forces", csv, "--seconds", "1"});
    EXPECT_EQ(report["frames"], 6);
    EXPECT_GT(report["finger_contact_pct"], 50);
    for (const ForcesRow& row : read_forces(csv)) {
        if (row["contact"] == 0) continue;
        ASSERT_DOUBLE_EQ(row["stiffness"], 600);
        ASSERT_DOUBLE_EQ(row["mu_static"], 0.4);
        ASSERT_DOUBLE_EQ(row["mu_dynamic"], 0.3);
    }
}

TEST_F(Touch, WarnsAboutSkippedTicks) {
    make("plane");
    SessionOptions options;
    options.clip.file = clip();
    const auto setup = must(setup_from_options(options));
    LiveFacts live;
    live.loop.skipped = 5;
    const auto has_warning = [&](std::int64_t ticks, const char* warning) {
        live.loop.ticks = ticks;
        const auto report = make_report(*setup, {}, &live, nullptr);
        return report["warnings"].dump().find(warning) != std::string::npos;
    };
    EXPECT_TRUE(has_warning(95, "5.0 % of the ticks were skipped"));
    EXPECT_FALSE(has_warning(995, "of the ticks were skipped")) << "bearable";
}

// The figures of a report, tick by tick, against ones that are counted by hand.

/// A tick of two fingers, both free; each in contact has 600 N/m.
class TwoFingers {
public:
    /// A finger in contact.
    void press(std::size_t finger, double newtons, std::uint32_t reasons = guard_none) {
        contacts[finger].touching = true;
        contacts[finger].properties.stiffness = 600;
        forces[finger].force = {0, newtons, 0};
        forces[finger].reasons = reasons;
    }
    TouchTick tick() {
        TouchTick made;
        made.contacts = contacts;
        made.forces = forces;
        return made;
    }

    std::array<Contact, 2> contacts;
    std::array<GuardedForce, 2> forces;
};

nlohmann::ordered_json figures_of(std::vector<TwoFingers> ticks) {
    TouchFigures figures;
    for (TwoFingers& one : ticks) EXPECT_TRUE(figures.consume(one.tick()));
    return figures.to_json();
}

TEST(TouchFigures, AreZeroWithoutContact) {
    const auto report = figures_of({TwoFingers{}});
    EXPECT_EQ(report["ticks"], 1);
    for (const char* count : {"contact_ticks", "proxy_behind_mesh_ticks", "nonfinite_ticks", "capped_ticks",
                              "guarded_ticks", "waiting_ticks", "late_ticks"})
        EXPECT_EQ(report[count], 0) << count;
    for (const char* figure : {"finger_contact_pct", "events_mean"}) EXPECT_EQ(report[figure], 0.0) << figure;
    EXPECT_EQ(report["force_n"]["max"], 0.0);
    EXPECT_TRUE(report["force_n"]["max_jnd"].is_null()) << "not measured below 2.5 N";
    EXPECT_EQ(report["stiffness_limited"]["smallest_n_mm"], 0.0);
}

TEST(TouchFigures, CountEachTickOnce) {
    TwoFingers nothing, both, one;
    both.press(0, 3);
    both.press(1, 5);
    one.press(1, 1);
    for (Contact& contact : both.contacts) contact.counts = {6, 0, true};
    one.contacts[1].counts = {3, 0, false};
    for (GuardedForce& force : both.forces)
        force.reasons = guard_stiffness | guard_force | guard_waiting | guard_jump;
    const auto report = figures_of({nothing, both, one, nothing, nothing});
    EXPECT_EQ(report["ticks"], 5);
    EXPECT_EQ(report["contact_ticks"], 2);
    EXPECT_EQ(report["finger_contact_pct"], 30.0) << "3 of 10";
    EXPECT_EQ(report["capped_ticks"], 1);
    EXPECT_EQ(report["guarded_ticks"], 1);
    EXPECT_EQ(report["waiting_ticks"], 1);
    EXPECT_EQ(report["stiffness_limited"]["ticks"], 1);
    EXPECT_EQ(report["force_limited"]["finger_ticks"], 2);
    EXPECT_EQ(report["events_mean"], 5.0) << "6, 6 and 3";
    EXPECT_EQ(report["force_n"]["mean"], 3.0) << "3, 5 and 1";
    EXPECT_EQ(report["force_n"]["max"], 5.0);
    EXPECT_DOUBLE_EQ(report["force_n"]["max_jnd"], 0.35) << "7 %";
}

/// A window's pointer has five fingers, most of which stay away.
TEST(TouchFigures, CountLedFingers) {
    TouchFigures figures;
    const auto take = [&](double goal, bool pressed) {
        TwoFingers two;
        two.contacts[0].goal = {0, 0, goal};
        two.contacts[1].goal = {1, 2, 3};
        if (pressed) two.press(0, 1);
        EXPECT_TRUE(figures.consume(two.tick()));
        return figures.to_json();
    };
    EXPECT_EQ(take(1, false)["fingers_led"], 0);
    const auto led = take(2, true);
    EXPECT_EQ(led["fingers_led"], 1);
    EXPECT_EQ(led["finger_contact_pct"], 50.0) << "of the one finger's time";
    figures.end_part();  // whose scene may lie elsewhere
    TwoFingers two;
    two.contacts[1].goal = {4, 5, 6};
    EXPECT_TRUE(figures.consume(two.tick()));
    EXPECT_EQ(figures.to_json()["fingers_led"], 1);
}

TEST(TouchFigures, CountFaultyTicks) {
    const double nan = std::nan("");
    for (const double bad : {nan, HUGE_VAL, -HUGE_VAL}) {
        std::vector<TwoFingers> ticks(7);
        for (glm::length_t axis = 0; axis < 3; ++axis) {
            ticks[static_cast<std::size_t>(axis)].contacts[1].proxy[axis] = bad;
            ticks[static_cast<std::size_t>(axis) + 3].forces[0].force[axis] = bad;
        }
        EXPECT_EQ(figures_of(ticks)["nonfinite_ticks"], 6) << bad;
    }
    TouchFigures figures;
    for (const bool behind : {true, false, true}) {
        TwoFingers two;
        TouchTick tick = two.tick();
        tick.behind = behind;
        EXPECT_TRUE(figures.consume(tick));
    }
    EXPECT_EQ(figures.to_json()["proxy_behind_mesh_ticks"], 2);
}

TEST(TouchFigures, TrackLongestLimitAndHole) {
    TouchFigures figures;
    const auto take = [&](bool limited, bool in_hole, int ticks) {
        for (int k = 0; k < ticks; ++k) {
            TwoFingers two;
            two.press(0, 1);
            two.press(1, 10, limited ? guard_force : guard_none);
            two.contacts[1].in_hole = in_hole;
            EXPECT_TRUE(figures.consume(two.tick()));
        }
    };
    take(true, false, 3);
    take(false, true, 2);
    take(true, true, 4);
    EXPECT_TRUE(figures.force_limited_in_holes());
    take(false, false, 1);
    take(true, true, 2);
    figures.end_part();  // nothing goes on in a row
    take(true, true, 5);
    const auto report = figures.to_json();
    EXPECT_EQ(report["force_limited"]["finger_ticks"], 14);
    EXPECT_EQ(report["force_limited"]["longest_ticks"], 5);
    EXPECT_EQ(report["hole_contact"]["finger_ticks"], 13);
    EXPECT_DOUBLE_EQ(report["hole_contact"]["contact_pct"].get<double>(), 100 * 13.0 / 34);
    EXPECT_EQ(report["hole_contact"]["longest_ticks"], 6);
    EXPECT_EQ(report["hole_contact"]["force_limited_ticks"], 11);
}

TEST(TouchFigures, TrackStiffnessRangeInContact) {
    TwoFingers two;
    two.press(0, 1);
    two.press(1, 1);
    two.contacts[0].properties.stiffness = 250;
    two.contacts[1].properties.stiffness = 4000;
    TwoFingers free;
    free.contacts[0].properties.stiffness = 1;
    const auto stiffness = figures_of({free, two})["stiffness_limited"];
    EXPECT_EQ(stiffness["smallest_n_mm"], 0.25);
    EXPECT_EQ(stiffness["largest_n_mm"], 4.0);
}

// In joules of each finger up to the newest tick; of all parts of a run.
TEST(TouchFigures, SumEnergyOverParts) {
    TouchFigures figures;
    const auto take = [&](double times) {
        TwoFingers two;
        for (GuardedForce& force : two.forces) {
            force.energy.created = 0.001 * times;
            force.energy.bound = 0.002 * times;
            force.energy.surface = 0.003 * times;
            force.energy.work = 0.004 * times;
        }
        EXPECT_TRUE(figures.consume(two.tick()));
    };
    take(7);
    take(1);
    figures.end_part();
    take(2);
    const auto energy = figures.to_json()["energy_mj"];
    EXPECT_NEAR(energy["created"].get<double>(), 6, 1e-12);
    EXPECT_NEAR(energy["zoh_bound"].get<double>(), 12, 1e-12);
    EXPECT_NEAR(energy["surface"].get<double>(), 18, 1e-12);
    EXPECT_NEAR(energy["on_hand"].get<double>(), 24, 1e-12);
}

/// Ticks that took and were late by so many microseconds.
struct Timed {
    explicit Timed(const std::vector<double>& us);
    TouchFigures figures;
};
Timed::Timed(const std::vector<double>& us) {
    TwoFingers two;
    for (const double time : us) {
        TouchTick tick = two.tick();
        tick.solve_us = time;
        tick.late_us = 2 * time;
        EXPECT_TRUE(figures.consume(tick));
    }
}

TEST(TouchFigures, BinLateTicks) {
    const Timed timed({0, 4.99, 5, 9, 10, 24.9, 25, 49, 50, 99, 100, 249, 250, 499.9, 500, 1e6, 1e6});
    const auto histogram = timed.figures.late_histogram();
    const std::vector<std::pair<int, int>> expected{{10, 2},  {20, 2},  {50, 2},  {100, 2},
                                                    {200, 2}, {500, 2}, {1000, 2}};
    ASSERT_EQ(histogram.size(), expected.size() + 1);
    for (std::size_t k = 0; k < expected.size(); ++k) {
        EXPECT_EQ(histogram[k]["below_us"], expected[k].first);
        EXPECT_EQ(histogram[k]["ticks"], expected[k].second) << expected[k].first;
    }
    EXPECT_EQ(histogram.back(), nlohmann::ordered_json({{"ticks", 3}}));
}

void expect_within_a_percent(const Spread& found, std::vector<double> us) {
    std::sort(us.begin(), us.end());
    double sum = 0;
    for (const double time : us) sum += time;
    const auto ranked = [&](double share) {
        return us[static_cast<std::size_t>(share * static_cast<double>(us.size()))];
    };
    EXPECT_NEAR(found.mean, sum / static_cast<double>(us.size()), 1e-9 * found.mean);
    EXPECT_EQ(found.max, us.back());
    EXPECT_NEAR(found.p50, ranked(0.5), 0.01 * ranked(0.5));
    EXPECT_NEAR(found.p99, ranked(0.99), 0.01 * ranked(0.99));
    EXPECT_NEAR(found.p999, ranked(0.999), 0.01 * ranked(0.999));
}

TEST(TouchFigures, PercentilesHoldWithinOnePercent) {
    SplitMix64 random(5);
    std::vector<double> even, uneven, two_kinds;
    for (int k = 0; k < 20'000; ++k) {
        even.push_back(k + 1);
        uneven.push_back(std::exp(random.within(-6, 14)));  // 2 ns to 1 s
        two_kinds.push_back(random.next() % 60 == 0 ? random.within(800, 900) : random.within(0.2, 0.4));
    }
    for (const auto& us :
         {even, uneven, two_kinds, std::vector<double>{3.7}, std::vector<double>{1, 2, 4e12}}) {
        const Timed timed(us);
        expect_within_a_percent(timed.figures.tick_us(), us);
        std::vector<double> late;
        for (const double time : us) late.push_back(2 * time);
        expect_within_a_percent(timed.figures.late_us(), late);
    }
    const auto spread = Timed(even).figures.to_json()["tick_us"];
    EXPECT_NEAR(spread["p50"].get<double>(), 10'000, 100);
    EXPECT_NEAR(spread["p99"].get<double>(), 19'800, 198);
    EXPECT_NEAR(spread["p999"].get<double>(), 19'980, 199.8);
    EXPECT_EQ(spread["max"], 20'000.0);
    EXPECT_NEAR(spread["mean"].get<double>(), 10'000.5, 1e-6);
    for (const Spread& none :
         {Timed(std::vector<double>(1000, 0.0)).figures.late_us(), TouchFigures().tick_us()})
        for (const double each : {none.mean, none.p50, none.p99, none.p999, none.max}) EXPECT_EQ(each, 0);
}

// An hour has 3.6 million ticks.
TEST(TouchFigures, MemoryStaysConstant) {
    TouchFigures figures;
    TwoFingers two;
    two.press(0, 1);
    const auto take = [&](int ticks) {
        for (int k = 0; k < ticks; ++k) {
            TouchTick tick = two.tick();
            tick.solve_us = 0.1 + k % 1000;
            tick.late_us = k % 777;
            EXPECT_TRUE(figures.consume(tick));
        }
    };
    take(10);
    const auto before = mallinfo2().uordblks;
    take(100'000);
    EXPECT_EQ(mallinfo2().uordblks, before);
    EXPECT_EQ(figures.ticks(), 100'010);
}

// Differences between two runs of the same hand.

/// A finger that presses with this force in every tick.
template <class ForceAt>
ForceTable pressing(std::size_t ticks, ForceAt force_at) {
    ForceTable table;
    table.fingers = 1;
    for (std::size_t tick = 0; tick < ticks; ++tick)
        table.samples.push_back(
            {{1, 2, -static_cast<double>(tick)}, force_at(0.001 * static_cast<double>(tick)), true});
    return table;
}

TEST(ForceComparison, FindsNoDifferenceToItself) {
    const ForceTable a = pressing(600, [](double t) { return glm::dvec3(0, t, 1); });
    const auto same = must(compare_forces(a, a));
    EXPECT_EQ(same.both, 600);
    EXPECT_EQ(same.difference_n.max, 0);
    EXPECT_EQ(same.direction_degrees.max, 0);
    EXPECT_EQ(same.noise_a_n, same.noise_b_n);
    EXPECT_TRUE(same.worst.empty());
}

TEST(ForceComparison, SeparatesDirectionFromLength) {
    const double turned = 10 * std::numbers::pi / 180;
    const ForceTable a = pressing(300, [](double) { return glm::dvec3(0, 0, 2); });
    const ForceTable b =
        pressing(300, [&](double) { return 1.5 * glm::dvec3(std::sin(turned), 0, std::cos(turned)); });
    const auto c = must(compare_forces(a, b));
    EXPECT_NEAR(c.direction_degrees.mean, 10, 1e-9);
    EXPECT_NEAR(c.longer_n, 0.5, 1e-12);
    const double apart = std::sqrt(4 + 2.25 - 2 * 2 * 1.5 * std::cos(turned));
    EXPECT_NEAR(c.difference_n.p95, apart, 1e-12);
    ASSERT_EQ(c.worst.size(), 5U) << "of each 50 ms one";
    EXPECT_EQ(c.worst[0].tick, 0);
    EXPECT_EQ(c.worst[1].tick, 50);
}

TEST(ForceComparison, FindsHumInItsBand) {
    const ForceTable quiet = pressing(1024, [](double) { return glm::dvec3(0, 0, 1); });
    for (const auto& [hz, band] : {std::pair{12.0, 0U}, {50.0, 1U}, {150.0, 2U}, {400.0, 3U}}) {
        const ForceTable humming = pressing(1024, [hz = hz](double t) {
            return glm::dvec3(0, 0.1 * std::sin(2 * std::numbers::pi * hz * t), 1);
        });
        const auto c = must(compare_forces(humming, quiet));
        EXPECT_EQ(c.noise_windows, 4);
        for (std::size_t k = 0; k < ForceComparison::noise_bands.size(); ++k) {
            const double rms = 0.1 / std::numbers::sqrt2;
            EXPECT_NEAR(c.noise_a_n[k], k == band ? rms : 0, 0.05 * rms) << hz << " Hz, band " << k;
            EXPECT_NEAR(c.noise_b_n[k], 0, 1e-12);
        }
    }
}

TEST(ForceComparison, CountsContactOfEachRun) {
    ForceTable a = pressing(4, [](double) { return glm::dvec3(0, 0, 1); }), b = a;
    a.samples[1] = b.samples[2] = {{1, 2, -1}, {}, false};
    a.samples[2].goal = b.samples[2].goal;
    b.samples[1].goal = a.samples[1].goal;
    a.samples[3].goal.x += 1e-9;
    const auto c = must(compare_forces(a, b));
    EXPECT_EQ(c.both, 1);
    EXPECT_EQ(c.only_b, 1);
    EXPECT_EQ(c.only_a, 1);
    EXPECT_EQ(c.other_goals, 1);
    EXPECT_EQ(c.noise_windows, 0);
}

TEST(ForceComparison, RejectsUnrelatedRuns) {
    const ForceTable a = pressing(3, [](double) { return glm::dvec3(0, 0, 1); });
    ForceTable other = a, two = a;
    for (ForceTable::Sample& sample : other.samples) sample.goal.x = 7;
    EXPECT_EQ(compare_forces(a, other).error().kind, ErrorKind::usage);
    two.fingers = 3;
    EXPECT_EQ(compare_forces(a, two).error().kind, ErrorKind::usage);
}

}  // namespace
}  // namespace touchable::test
