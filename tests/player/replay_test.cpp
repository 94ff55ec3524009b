#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "engine/clip/clip.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/content/scenes.hpp"
#include "engine/picture/image.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "player/run/run_files.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"

namespace touchable::test {
namespace {
namespace fs = std::filesystem;

class Replay : public ::testing::Test {
protected:
    std::string clip() const { return folder / "clip.mkv"; }
    std::string file() const { return folder / "run.rec"; }
    /// Makes a clip and records a run over it. Gives the report.
    nlohmann::json record(const std::string& scene, const Words& more) const {
        make_clip(scene, clip(), {"--size", "72x48", "--frames", "12"});
        Words words{clip(), "--record", file(), "--forces", folder / "recorded.csv"};
        words.insert(words.end(), more.begin(), more.end());
        return touch(words);
    }
    Outcome replay(const Words& more = {}) const {
        Words words{"touch", "--replay", file(), "--overwrite"};
        words.insert(words.end(), more.begin(), more.end());
        return run_touchable(words);
    }
    RecordingBytes recording() const { return RecordingBytes(file_contents(file())); }
    void write(const RecordingBytes& raw) const { std::ofstream(file(), std::ios::binary) << raw.bytes(); }
    void expect_ends_with(int code, const std::string& fragment, const Words& more = {}) const {
        const Outcome run = replay(more);
        EXPECT_EQ(run.code, code) << run.err;
        EXPECT_TRUE(run.one_line_of_error()) << run.err;
        EXPECT_NE(run.err.find(fragment), std::string::npos) << fragment << " is missing in: " << run.err;
    }

    TemporaryFolder folder;
};

TEST_F(Replay, RepeatsEveryBit) {
    const std::string zigzag = zigzag_hand(folder / "zigzag.csv");
    const std::vector<std::pair<std::string, Words>> runs{
        {"globe", {"--fingers", "3", "--seconds", "0.6"}},
        {"moving", {"--interpolation", "hold", "--hand", "stroke:speed=0.3", "--seconds", "0.7"}},
        {"noise", {"--median", "5", "--metric", "pixel", "--hand", zigzag, "--max-force", "0.9"}},
        {"bumps", {"--fingers", "2", "--seconds", "0.5", "--max-stiffness", "0.2", "--metric", "scaled"}}};
    for (const auto& [scene, words] : runs) {
        const auto recorded = record(scene, words);
        ASSERT_GT(recorded["contact_ticks"], 100) << scene;
        const std::string again = folder / "again.csv", json = folder / "again.json";
        const Outcome run = replay({"--forces", again, "--json", json});
        EXPECT_EQ(run.code, 0) << scene << ": " << run.err;
        EXPECT_NE(run.out.find("every force is as recorded"), std::string::npos) << run.out;
        EXPECT_NE(run.out.find(recorded["force_hash"].get<std::string>()), std::string::npos) << run.out;
        EXPECT_EQ(file_contents(again), file_contents(folder / "recorded.csv")) << scene;
        const auto report = nlohmann::json::parse(file_contents(json));
        for (const char* fact : {"clip", "hand", "fingers", "ticks", "frames", "contact_ticks", "force_hash"})
            EXPECT_EQ(report[fact], recorded[fact]) << scene << ' ' << fact;
    }
}

TEST_F(Replay, FindsFramesOfVariableRate) {
    SceneOptions options;
    options.width = 72;
    options.height = 48;
    const auto source = make_scene("moving", options);
    Scene scene = (*source)->scene();
    std::vector<std::int64_t> times_ns;
    for (std::int64_t n = 0; n < 12; ++n) times_ns.push_back(n * n * 3'500'000 + n * 1'000'000);
    scene.rate = *rate_of_own_times(times_ns);
    auto writer = create_clip(clip(), scene);
    for (int n = 0; n < 12; ++n) ASSERT_TRUE((*writer)->write((*source)->frame(n)));
    ASSERT_TRUE((*writer)->finish());
    const std::vector<Words> runs{{clip(), "--seconds", "0.4"},
                                  {clip(), "--live", "--seconds", "0.4", "--loop", "0.05", "0.2"},
                                  {"--live", "--camera", "replay:" + clip(), "--seconds", "0.4"}};
    for (const Words& run : runs) {
        Words words = run;
        words.insert(words.end(), {"--record", file(), "--overwrite"});
        const auto recorded = touch(words);
        EXPECT_GT(recorded["contact_ticks"], 0);
        const Outcome again = replay();
        EXPECT_EQ(again.code, 0) << again.err;
        EXPECT_NE(again.out.find("every force is as recorded"), std::string::npos) << again.out;
        const auto part = read_recording(file());
        ASSERT_TRUE(part);
        if (run[0] != clip() || run.size() > 3) continue;
        for (const RecordedPart::Tick& tick : part->front().ticks)
            ASSERT_EQ(tick.frame_prev, std::min<std::int64_t>(scene.rate.frame_at(tick.time_ns), 11));
    }
}

TEST_F(Replay, MatchesWithEveryBuilder) {
    record("noise", {"--median", "3", "--hand", zigzag_hand(folder / "zigzag.csv")});
    for (const char* builder : {"cpu", "lazy", "reference", "vulkan"})
        EXPECT_EQ(replay({"--builder", builder}).code, 0) << builder;
}

TEST_F(Replay, NeedsNoHand) {
    const std::string hand = folder / "hand.csv";
    std::ofstream(hand) << "t_s,in\n0,0\n0.3,0.02\n";
    record("globe", {"--hand", "csv:" + hand + ":columns=in"});
    fs::remove(hand);
    EXPECT_EQ(replay().code, 0);
}

TEST_F(Replay, FindsMovedClip) {
    record("globe", {"--seconds", "0.4"});
    fs::rename(clip(), folder / "moved.mkv");
    expect_ends_with(3, clip());
    expect_ends_with(3, "; say where it is now (CLIP)");
    EXPECT_EQ(replay({folder / "moved.mkv"}).code, 0);
}

TEST_F(Replay, NamesFirstDifferingFinger) {
    record("globe", {"--seconds", "0.5", "--fingers", "2"});
    const std::string other = folder / "other.mkv", csv = folder / "other.csv";
    make_clip("bumps", other, {"--size", "72x48", "--frames", "12"});
    const Outcome run = replay({other, "--forces", csv});
    EXPECT_EQ(run.code, 6);
    EXPECT_TRUE(run.one_line_of_error()) << run.err;
    EXPECT_NE(run.err.find("the clip's frames are not the recorded ones"), std::string::npos) << run.err;
    // Which one it is, from the two forces files.
    const auto recorded = read_forces(folder / "recorded.csv"), felt = read_forces(csv);
    ASSERT_EQ(recorded.size(), felt.size());
    std::size_t first = 0;
    while (first < felt.size() && felt[first].vector("force") == recorded[first].vector("force") &&
           felt[first]["guard"] == recorded[first]["guard"])
        ++first;
    ASSERT_LT(first, felt.size());
    const std::string where =
        "tick " + std::to_string(first / 2) + ", finger " + std::to_string(first % 2) + ":";
    EXPECT_NE(run.err.find(where), std::string::npos) << where << " is missing in: " << run.err;

    make_clip("globe", other, {"--size", "64x48", "--frames", "12"});
    expect_ends_with(3, "64x48", {other});
}

// A corner of the last frame, where no finger ever was.
TEST_F(Replay, NotesChangeInUntouchedPixels) {
    make_clip("bumps", clip(), {"--size", "72x48", "--frames", "3"});
    ASSERT_EQ(run_touchable({"export", clip(), "--frames", "all", "--out", folder / "images"}).code, 0);
    auto scene = nlohmann::json::parse(file_contents(folder / "images/0/scene.json"));
    scene["folder"] = {{"depth", "%d/depth.png"}};
    const std::string described = folder / "images/clip.json";
    std::ofstream(described) << scene;
    for (const Words& clock : {Words{}, Words{"--live"}}) {
        Words words{described, "--record", file(), "--hand", "press", "--seconds", "0.4"};
        words.insert(words.end(), clock.begin(), clock.end());
        ASSERT_GT(touch(words)["contact_ticks"], 50);
        const std::string note = "the clip's frames are not the recorded ones";
        EXPECT_EQ(replay().out.find(note), std::string::npos);
        const std::string last = folder / "images/2/depth.png", kept = file_contents(last);
        auto image = read_image(last);
        ASSERT_TRUE(image);
        image->samples.back() ^= 1;
        fs::remove(last);
        ASSERT_TRUE(write_png(last, image->view()));
        const Outcome changed = replay();
        EXPECT_EQ(changed.code, 0) << changed.err;
        EXPECT_NE(changed.out.find("every force is as recorded"), std::string::npos) << changed.out;
        EXPECT_NE(changed.out.find(note), std::string::npos) << changed.out;
        std::ofstream(last, std::ios::binary) << kept;
    }
}

TEST_F(Replay, NamesLeastDifference) {
    record("globe", {"--seconds", "0.4", "--fingers", "3"});
    const RecordingBytes original = recording();
    RecordingBytes raw = original;
    raw.set_integer(raw.force_at(317, 2) + 16, 8, raw.integer(raw.force_at(317, 2) + 16, 8) ^ 1);
    write(raw);
    expect_ends_with(6, "first at tick 317, finger 2:");
    raw = original;
    raw.set_integer(raw.guard_at(215, 1), 4, 2);
    write(raw);
    expect_ends_with(6, "first at tick 215, finger 1:");
    raw = original;
    raw.set_real(raw.blend_at(123), 0.123);
    write(raw);
    expect_ends_with(6, "first at tick 123: between frames");
    raw = original;
    raw.set_integer(raw.time_at(123) + 8, 8, 77);
    write(raw);
    expect_ends_with(6, "first at tick 123: between frames");
    raw = original;
    auto facts = raw.facts();
    facts["force_hash"] = "0123456789abcdef";
    raw.set_facts(facts.dump());
    write(raw);
    expect_ends_with(6, "recorded 0123456789abcdef");
}

// Faulty goals of a broken device are given again: the goal is held, the guard takes the force away.
TEST_F(Replay, RepeatsNonFiniteGoals) {
    record("globe", {"--seconds", "0.6"});
    RecordingBytes raw = recording();
    raw.set_real(raw.goal_at(450, 0) + 8, std::numeric_limits<double>::quiet_NaN());
    write(raw);
    const std::string csv = folder / "again.csv";
    expect_ends_with(6, "first at tick 450, finger 0:", {"--forces", csv});
    const auto rows = read_forces(csv);
    ASSERT_EQ(rows.size(), 600U);
    EXPECT_EQ(rows[449]["guard"], 0);
    EXPECT_EQ(rows[450]["guard"], 8);
    EXPECT_EQ(rows[450].vector("goal"), rows[449].vector("goal"));
    EXPECT_LT(length(rows[450].vector("force")), length(rows[449].vector("force")));
}

TEST_F(Replay, RejectsOptionsFixedByRecording) {
    record("plane", {"--seconds", "0.1"});
    for (const Words& fixed :
         {Words{"--hand", "wander"}, Words{"--fingers", "1"}, Words{"--seconds", "0.1"},
          Words{"--metric", "world"}, Words{"--median", "0"}, Words{"--fill-holes", "0"},
          Words{"--interpolation", "linear"}, Words{"--max-force", "10"}, Words{"--max-stiffness", "10"},
          Words{"--filters", "off"}, Words{"--temporal", "off"}, Words{"--damping", "0"}, Words{"--live"},
          Words{"--fov", "60"}, Words{"--start", "0"}, Words{"--device", "simulated"}})
        expect_ends_with(2, fixed[0], fixed);
    const std::string other = folder / "other.rec";
    expect_ends_with(2, "--record", {"--record", other});
    EXPECT_FALSE(fs::exists(other));
}

TEST_F(Replay, RejectsInvalidRecording) {
    record("plane", {"--seconds", "0.05"});
    const std::string whole = file_contents(file());
    for (std::size_t k = 0; k < 8; ++k) {
        std::string damaged = whole;
        const std::size_t at = k * (whole.size() - 1) / 7;
        damaged[at] = static_cast<char>(damaged[at] ^ 4);
        std::ofstream(file(), std::ios::binary) << damaged;
        expect_ends_with(3, file());
        std::ofstream(file(), std::ios::binary) << whole.substr(0, at);
        expect_ends_with(3, file());
    }
    for (const std::string& other : {clip(), folder.path().string(), (folder / "nothing.rec").string()}) {
        const Outcome run = run_touchable({"touch", "--replay", other});
        EXPECT_EQ(run.code, 3) << other;
        EXPECT_TRUE(run.one_line_of_error()) << run.err;
    }
}

TEST_F(Replay, RejectsDeeplyNestedFacts) {
    record("plane", {"--seconds", "0.01"});
    constexpr std::size_t levels = 105'000;
    std::string text;
    for (std::size_t level = 0; level < levels; ++level) text += "{\"a\":";
    RecordingBytes deep = recording();
    deep.set_facts(text + "1" + std::string(levels, '}'));
    write(deep);
    expect_ends_with(3, "nested too deeply");
}

TEST_F(Replay, RejectsNewerFormat) {
    record("plane", {"--seconds", "0.05"});
    RecordingBytes raw = recording();
    raw.set_integer(8, 4, 3);
    write(raw);
    expect_ends_with(3, "format version 3");
}

// Made once by `make moving moving.mkv --size 32x24 --frames 3` and `touch moving.mkv --seconds 0.05 --hand
// csv:sweep.csv:columns=x+y+z,contact=0.95 --record ...`, and kept: what a version has written, every later
// one reads. It is of a time before recordings named their rules.
TEST_F(Replay, ReadsVersion1Recording) {
    const std::string kept = TOUCHABLE_SOURCE_DIR "/tests/data/recording_v1.rec";
    make_clip("moving", clip(), {"--size", "32x24", "--frames", "3"});
    const RecordingBytes raw(file_contents(kept));
    EXPECT_EQ(raw.integer(8, 4), 1U);
    const std::string csv = folder / "again.csv";
    const Outcome run = run_touchable({"touch", clip(), "--replay", kept, "--forces", csv});
    EXPECT_EQ(run.code, 3) << run.err;
    EXPECT_NE(run.err.find("not comparable: made under rules 1 "), std::string::npos) << run.err;
    const auto rows = read_forces(csv);
    ASSERT_EQ(rows.size(), raw.ticks());
    for (std::size_t tick = 0; tick < rows.size(); ++tick)
        ASSERT_EQ(rows[tick]["goal_z"], raw.real(raw.goal_at(tick, 0) + 16)) << tick;
}

TEST_F(Replay, RejectsOtherForceRules) {
    record("globe", {"--seconds", "0.3"});
    RecordingBytes raw = recording();
    auto facts = raw.facts();
    EXPECT_EQ(facts["rules"], force_rules);
    // A force that differs as well is no matter: nothing is compared.
    raw.set_integer(raw.force_at(290, 0), 8, raw.integer(raw.force_at(290, 0), 8) ^ 1);
    for (const int rules : {force_rules - 1, force_rules + 1}) {
        facts["rules"] = rules;
        raw.set_facts(facts.dump());
        write(raw);
        expect_ends_with(3, "not comparable: made under rules " + std::to_string(rules) +
                                " of force, this program has rules " + std::to_string(force_rules));
    }
    facts.erase("rules");
    raw.set_facts(facts.dump());
    write(raw);
    expect_ends_with(3, "not comparable: made under rules 1 ");
    facts["rules"] = force_rules;
    raw.set_facts(facts.dump());
    write(raw);
    expect_ends_with(6, "first at tick 290, finger 0:");
}

TEST_F(Replay, OpensFolderWithRecordedScene) {
    make_clip("plane", clip(), {"--size", "48x32", "--frames", "1"});
    ASSERT_EQ(run_touchable({"export", clip(), "--frame", "0", "--out", folder / "images"}).code, 0);
    auto scene = nlohmann::json::parse(file_contents(folder / "images/scene.json"));
    scene["filter"]["median"] = 3;
    scene["default_properties"]["stiffness"] = 0.1 + 0.2;
    scene["folder"]["depth"] = "depth%d.png";
    fs::rename(folder / "images/depth.png", folder / "images/depth0.png");
    std::ofstream(folder / "described.json") << scene;
    touch({folder / "images", "--scene", folder / "described.json", "--seconds", "0.4", "--record", file()});
    EXPECT_EQ(replay().code, 0);
    fs::rename(folder / "described.json", folder / "moved.json");
    expect_ends_with(3, "described.json");
    expect_ends_with(3, "; say where it is now (--scene FILE)");
    EXPECT_EQ(replay({"--scene", folder / "moved.json"}).code, 0);
}

TEST_F(Replay, NamesInvalidFact) {
    record("plane", {"--seconds", "0.05"});
    const RecordingBytes original = recording();
    const auto facts = original.facts();
    const auto refuse = [&](const nlohmann::ordered_json& changed, const std::string& fragment) {
        RecordingBytes raw = original;
        raw.set_facts(changed.dump());
        write(raw);
        expect_ends_with(3, fragment);
    };
    for (const char* name :
         {"clip", "scene", "hand", "metric", "S", "event_limit", "guard", "planes_hash", "force_hash"}) {
        auto changed = facts;
        changed.erase(name);
        refuse(changed, std::string(name) + " is missing");
        changed[name] = nullptr;
        refuse(changed, std::string(name) + " must be");
    }
    for (const auto& [name, value] :
         std::vector<std::pair<const char*, nlohmann::json>>{{"rules", 0},
                                                             {"rules", "all"},
                                                             {"rules", 1.5},
                                                             {"frames", 0},
                                                             {"frames", "all"},
                                                             {"metric", "feet"},
                                                             {"S", 0},
                                                             {"S", -1},
                                                             {"S", "1"},
                                                             {"event_limit", 0},
                                                             {"event_limit", 2.5},
                                                             {"event_limit", 1e300},
                                                             {"guard", 3},
                                                             {"scene", 3}}) {
        auto changed = facts;
        changed[name] = value;
        refuse(changed, file());
    }
    for (const auto& [name, value] :
         std::vector<std::pair<const char*, nlohmann::json>>{{"max_force", 0},
                                                             {"max_force", nullptr},
                                                             {"max_stiffness", -1},
                                                             {"ramp_in_ticks", -1},
                                                             {"ramp_out_ticks", 1e12}}) {
        auto changed = facts;
        changed["guard"][name] = value;
        refuse(changed, file());
    }
    auto changed = facts;
    changed["scene"]["camera"]["fx"] = 0;
    refuse(changed, "fx");
    // As it was, and with a member that this version does not know, it is read.
    changed = facts;
    changed["weather"] = "fair";
    RecordingBytes raw = original;
    raw.set_facts(changed.dump());
    write(raw);
    EXPECT_EQ(replay().code, 0);
}

}  // namespace
}  // namespace touchable::test
