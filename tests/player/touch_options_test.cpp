// SPDX-License-Identifier: Apache-2.0
// What `touchable touch` refuses, how its options shape forces, and how --replay repeats them.

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <regex>
#include <set>

#include "engine/clip/clip.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/content/scenes.hpp"
#include "engine/picture/image.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "player/run/run_files.hpp"
#include "tests/must.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"

namespace touchable::test {
namespace {

namespace fs = std::filesystem;

/// A clip, and a folder of its own for what a run writes.
class TouchRefusal : public ::testing::Test {
protected:
    TouchRefusal() { fs::create_directory(folder / "out"); }
    void make(const std::string& scene = "plane",
              const Words& more = {"--size", "48x32", "--frames", "3"}) const {
        make_clip(scene, clip(), more);
    }
    std::string clip() const { return folder / "clip.mkv"; }
    std::string out(const std::string& name = "") const { return folder / ("out/" + name); }
    /// With everything that a run can write.
    Words writing(const Words& words) const {
        return plus({"touch", "--json", out("r.json"), "--forces", out("f.csv"), "--record", out("r.rec")},
                    words);
    }

    TemporaryFolder folder;
};

TEST_F(TouchRefusal, OutputNeverReplacesInput) {
    make();
    const std::string before = file_contents(clip());
    for (const char* option : {"--json", "--forces", "--record"})
        expect_failure({"touch", clip(), "--seconds", "0.1", option, clip()}, 2, "also the clip");
    fs::create_symlink(clip(), folder / "clip.png");
    expect_failure({"export", clip(), "--frame", "0", "--picture", folder / "clip.png"}, 2, "also the clip");
    EXPECT_EQ(file_contents(clip()), before);
    succeed({"touch", clip(), "--seconds", "0.1", "--record", out("a.rec")});
    expect_failure({"touch", "--replay", out("a.rec"), "--json", out("a.rec")}, 2, "also --replay");
}

TEST_F(TouchRefusal, RejectsInvalidOptions) {
    make();
    const auto expect = [&](const Words& more, const std::string& fragment) {
        expect_failure(plus(writing({clip()}), more), 2, fragment);
        EXPECT_TRUE(names_in(out()).empty()) << more[0] << ' ' << more[1];
    };
    const std::pair<const char*, Words> named[] = {
        {"--fingers", {"0", "257"}},          {"--seconds", {"0", "-1", "nan", "long"}},
        {"--max-force", {"0", "inf", "nan"}}, {"--max-stiffness", {"-1", "1e308"}},
        {"--temporal", {"-1", "0", "nan"}},   {"--stribeck", {"-1", "nan"}},
        {"--stiffness-slew", {"0", "nan"}},   {"--damping", {"-1", "101", "nan"}},
        {"--passivity", {"-1", "1e9"}},       {"--speed", {"1"}}};
    for (const auto& [option, values] : named)
        for (const std::string& value : values) expect({option, value}, option);
    for (const char* filters : {"blur", "median=4", "terraces=1", "holes=0", "holes=2.5", "flying=0",
                                "flying=-1", "temporal=0", "temporal=1+x", "temporal=-1"})
        expect({"--filters", filters}, std::string(filters) + " is not allowed");
    const std::pair<Words, const char*> told[] = {
        {{"--hand", "grab"}, "wander, stroke, press, poke"},
        {{"--hand", "wander:speed=fast"}, "speed"},
        {{"--hand", "press:x=2"}, "x=2"},
        {{"--hand", "csv:press.csv"}, "columns"},
        {{"--median", "4"}, "--median: 4 is not allowed; must be 0 (off), 3 or 5"},
        {{"--fill-holes", "17"}, "17 is not allowed; must be a whole number from 0 to 16 passes"},
        {{"--terraces", "yes"}, "off, on or auto"},
        {{"--filters", "flyng=1"}, "flyng=1 is not allowed: did you mean flying?"},
        {{"--filters", "off,median"}, "off is not allowed: it stands alone"},
        {{"--filters", "median,median"}, "median is not allowed: median is named twice"},
        {{"--filters", "median=5,"}, "'' is not allowed"},
        {{"--filters", "median=5,terraces,median=3"}, "median=3 is not allowed"},
        {{"--filters", "off", "--detail", "1"}, "--filters states them"},
        {{"--filters", "flying"}, "flying is not allowed: it needs a length above 0"},
        {{"--filters", "temporal"}, "does not say how noisy"},
        {{"--temporal", "on"}, "does not say how noisy"},
        {{"--temporal", "much"}, "off or on"},
        {{"--temporal", "1,"}, "off or on"},
        {{"--temporal", "1,2,3"}, "off or on"},
        {{"--temporal", "1", "--builder", "lazy"}, "lazy cannot filter in time"},
        {{"--picture", "p.png", "--picture-at", "99"},
         "lies beyond the run's end at 3.000 s; --seconds makes"}};
    for (const auto& [more, fragment] : told) expect(more, fragment);
    expect_failure({"touch"}, 2, "CLIP");
}

TEST_F(TouchRefusal, RejectsUnreadableInput) {
    make();
    const std::string text = folder / "text", folder_path = folder.path().string();
    std::ofstream(text) << "no clip\n";
    const std::vector<std::pair<Words, std::string>> wrong{
        {{"no-such-clip.mkv"}, "no-such-clip.mkv"},
        {{text}, text},
        {{folder_path}, folder_path},
        {{clip(), "--scene", "no-such-scene.json"}, "no-such-scene.json"},
        {{clip(), "--scene", text}, text},
        {{clip(), "--hand", "csv:no-such.csv:columns=a"}, "no-such.csv"},
        {{clip(), "--hand", "csv:" + text + ":columns=a"}, text}};
    for (const auto& [more, fragment] : wrong) {
        expect_failure(writing(more), 3, fragment);
        EXPECT_TRUE(names_in(out()).empty()) << more[0];
    }
}

/// It needs even steps of depth, too.
TEST_F(TouchRefusal, PixelMetricRequiresSquarePixels) {
    make();
    const auto scene = scene_of(clip());
    const std::string file = folder / "scene.json";
    for (const char* what : {"inverse", "oblong"}) {
        auto other = scene;
        if (what == std::string("inverse")) other["depth"]["coding"] = "inverse";
        if (what == std::string("oblong")) other["camera"]["fy"] = scene["camera"]["fy"].get<double>() * 1.5;
        std::ofstream(file) << other;
        const Words words{clip(), "--scene", file, "--metric"};
        EXPECT_GT(touch(plus(words, {"world"}))["contact_ticks"], 0) << what;
        for (const char* metric : {"pixel", "scaled"}) {
            expect_failure(writing(plus(words, {metric})), 2, std::string("metric ") + metric);
            EXPECT_TRUE(names_in(out()).empty());
        }
    }
}

TEST_F(TouchRefusal, UnwritableOutputLeavesNothing) {
    make();
    const std::string pipe = folder / "pipe";
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    const std::string kept = out("r.json");
    std::ofstream(kept) << "earlier\n";
    for (const char* option : {"--json", "--forces", "--record"})
        for (const std::string& place :
             {std::string("/no-such-folder/file"), folder.path().string(), out(), pipe}) {
            Words words{"touch", clip(), "--overwrite", "--seconds", "0.1"};
            for (const auto& [name, file] :
                 {std::pair{"--json", kept}, {"--forces", out("f.csv")}, {"--record", out("r.rec")}}) {
                words.emplace_back(name);
                words.push_back(name == std::string(option) ? place : file);
            }
            expect_failure(words, 3, option);
            EXPECT_EQ(names_in(out()), Words{"r.json"}) << option << ' ' << place;
            EXPECT_EQ(file_contents(kept), "earlier\n");
            EXPECT_TRUE(fs::is_fifo(pipe)) << "only a file may be replaced";
        }
}

TEST_F(TouchRefusal, TruncatedClipKeepsWholeFrames) {
    make("globe", {"--size", "144x96", "--frames", "30"});
    const std::string cut = folder / "cut.mkv";
    const auto size = fs::file_size(clip());
    for (const double share : {0.01, 0.3, 0.6, 0.9, 0.999}) {
        fs::copy_file(clip(), cut, fs::copy_options::overwrite_existing);
        fs::resize_file(cut, static_cast<std::uintmax_t>(share * static_cast<double>(size)));
        if (share < 0.5) {
            expect_failure(writing({cut}), 3, cut);
            EXPECT_TRUE(names_in(out()).empty()) << share;
        } else {  // its first half is whole
            succeed({"touch", cut, "--seconds", "0.1"});
        }
    }
}

TEST_F(TouchRefusal, NamesDamagedFrame) {
    make("noise", {"--size", "96x96", "--frames", "30"});
    std::string bytes = file_contents(clip());
    const std::string damaged = folder / "damaged.mkv";
    std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() * 3 / 4), 16, '\0');
    std::ofstream(damaged, std::ios::binary) << bytes;
    expect_failure(writing({damaged}), 3, "frame 15");  // stored anew after half a second
    EXPECT_TRUE(names_in(out()).empty());
    // The frames before the damage are fine.
    for (const char* builder : {"cpu", "vulkan"})  // which begins frames ahead
        EXPECT_EQ(touch({damaged, "--seconds", "0.2", "--builder", builder})["ticks"], 200);
}

/// Filters are chosen by the clip's first frames, though the run may never come to them.
TEST_F(TouchRefusal, ReportsDamageDuringFilterChoice) {
    make("moving", {"--size", "96x96", "--frames", "10"});
    std::string bytes = file_contents(clip());
    const std::string damaged = folder / "damaged.mkv";
    std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() / 4), 16, '\0');
    std::ofstream(damaged, std::ios::binary) << bytes;
    const auto report = touch({damaged, "--start", "0.3", "--seconds", "0.1"});
    const auto words = report["filters"]["in_words"].get<std::string>();
    EXPECT_PRED2(says, words, "chosen by the frames before damage: ");
}

TEST_F(TouchRefusal, NamesDamagedPicture) {
    make();
    succeed({"export", clip(), "--frames", "all", "--out", folder / "exported"});
    for (const std::string n : {"0", "1", "2"})
        fs::copy_file(folder / ("exported/" + n + "/depth.png"), folder / ("d" + n + ".png"));
    auto scene = json_in(folder / "exported/0/scene.json");
    scene["folder"]["depth"] = "d%d.png";
    std::ofstream(folder / "scene.json") << scene;
    EXPECT_EQ(touch({folder / "scene.json"})["frames"], 3);
    fs::resize_file(folder / "d1.png", fs::file_size(folder / "d1.png") / 2);
    expect_failure(writing({folder / "scene.json"}), 3, "d1.png");
    EXPECT_TRUE(names_in(out()).empty());
}

TEST_F(TouchRefusal, AcceptsNonUtf8Name) {
    make();
    const std::string odd = folder / "l\xe9ger.mkv";
    fs::copy_file(clip(), odd);
    succeed(writing({odd, "--seconds", "0.1"}));
    EXPECT_TRUE(nlohmann::json::accept(file_contents(out("r.json"))));
    succeed({"touch", odd, "--replay", out("r.rec")});
}

// Options that shape forces on their way to the hand, and the report's figures of their energy.

class TouchShaping : public ::testing::Test {
protected:
    void make(const std::string& scene) const {
        make_clip(scene, clip(), {"--size", "72x48", "--frames", "6"});
    }
    std::string clip() const { return folder / "clip.mkv"; }
    Words with(const Words& more) const { return plus({clip(), "--seconds", "2", "--hand", hand}, more); }
    /// Rows of a run in which a bit of the guard is set.
    int rows_with(int bit, const Words& more) const {
        touch(plus(with(more), {"--forces", folder / "forces.csv"}));
        int rows = 0;
        for (const ForcesRow& row : read_forces(folder / "forces.csv"))
            rows += (static_cast<int>(row["guard"]) & bit) != 0;
        return rows;
    }

    TemporaryFolder folder;
    std::string hand = "stroke:speed=0.3";  // from land to water and back
};

const std::vector<Words> shapings{{"--stribeck", "0.05"},
                                  {"--stiffness", "passive"},
                                  {"--stiffness-slew", "5"},
                                  {"--damping", "3"},
                                  {"--passivity", "20"}};

TEST_F(TouchShaping, ReportsForceLimitTime) {
    make("globe");
    const auto free = touch(with({"--max-force", "1000"}));
    EXPECT_EQ(free["force_limited"]["finger_ticks"], 0);
    const Words weak{"--max-force", "0.4", "--fingers", "3"};
    const int rows = rows_with(2, weak);
    ASSERT_GT(rows, 100);
    const auto report = touch(with(weak));
    EXPECT_EQ(report["force_limited"]["finger_ticks"], rows);
    const int longest = report["force_limited"]["longest_ticks"];
    EXPECT_GT(longest, 10);
    EXPECT_LE(longest, rows);
    EXPECT_PRED2(says, run_touchable(plus({"touch"}, with(weak))).out, "at the device's limit for");
}

TEST_F(TouchShaping, EachOptionReplaysExactly) {
    make("globe");  // land and water differ in stiffness and friction
    const std::string plain = force_hash(with({}));
    EXPECT_EQ(
        force_hash(with({"--stribeck", "0", "--stiffness", "map", "--damping", "0", "--passivity", "0"})),
        plain)
        << "the defaults";
    std::set<std::string> all{plain};
    const std::string recording = folder / "run.rec";
    for (const Words& shaping : shapings) {
        Words words = with(shaping);
        if (shaping[0] == "--passivity") words.insert(words.end(), {"--metric", "pixel"});
        words.insert(words.end(), {"--record", recording});
        EXPECT_TRUE(all.insert(force_hash(words)).second) << shaping[0] << " changed nothing";
        succeed({"touch", "--replay", recording});
    }
}

TEST_F(TouchShaping, GuardMarksChangedForces) {
    make("globe");
    EXPECT_EQ(rows_with(16 | 32 | 64, {"--stiffness-slew", "1e9"}), 0);
    EXPECT_GT(rows_with(16, {"--stiffness", "passive"}), 5);
    EXPECT_GT(rows_with(16, {}), 5);
    EXPECT_GT(rows_with(32, {"--damping", "3"}), 100);
}

TEST_F(TouchShaping, PassivityBrakesInPixelMetric) {
    make_clip("globe", clip(), {"--plain", "--size", "72x48", "--frames", "2"});
    hand = "press:x=0.6,y=0.4,depth=4";
    EXPECT_EQ(rows_with(64, {"--passivity", "20"}), 0);
    EXPECT_GT(rows_with(64, {"--passivity", "20", "--metric", "pixel"}), 100);
}

TEST_F(TouchShaping, ReportsEnergy) {
    make_clip("globe", clip(), {"--plain", "--size", "72x48", "--frames", "2"});
    hand = "press:x=0.6,y=0.4,depth=4";
    const auto world = touch(with({}))["energy_mj"], pixel = touch(with({"--metric", "pixel"}))["energy_mj"];
    for (const char* name : {"created", "zoh_bound", "surface", "on_hand"})
        EXPECT_TRUE(world[name].is_number()) << name;
    EXPECT_GT(world["zoh_bound"], 0);
    EXPECT_LE(world["created"], world["zoh_bound"]);
    EXPECT_GT(pixel["created"], 10 * pixel["zoh_bound"].get<double>());
    const Outcome told = run_touchable({"touch", clip(), "--seconds", "0.3", "--verbose"});
    EXPECT_PRED2(says, told.out, "energy from nowhere");
}

TEST_F(TouchShaping, AttributesEnergyToStiffnessMap) {
    make_clip("globe", clip(), {"--size", "72x48", "--frames", "60"});
    hand = "press:x=0.4,y=0.4,depth=8";  // it rests, and water and land turn below it
    const auto report = touch(with({}));
    ASSERT_LT(report["stiffness_limited"]["smallest_n_mm"], report["stiffness_limited"]["largest_n_mm"]);
    ASSERT_GT(report["energy_mj"]["created"], report["energy_mj"]["zoh_bound"]) << "this hand shows nothing";
    EXPECT_TRUE(report["energy_mj"]["of_the_map"].get<bool>());
    const auto passive = touch(with({"--stiffness", "passive"}))["energy_mj"];
    EXPECT_LE(passive["created"], passive["zoh_bound"]);
    EXPECT_FALSE(passive["of_the_map"].get<bool>());
}

TEST_F(TouchShaping, ReportsLimitedStiffness) {
    make("bumps");
    const auto soft = touch(with({}))["stiffness_limited"];
    EXPECT_EQ(soft["ticks"], 0);
    EXPECT_DOUBLE_EQ(soft["largest_n_mm"].get<double>(), 0.6);
    const auto report = touch(with({"--max-stiffness", "0.2"}));
    EXPECT_EQ(report["stiffness_limited"]["ticks"], report["contact_ticks"]);
    EXPECT_DOUBLE_EQ(report["stiffness_limited"]["largest_n_mm"].get<double>(), 0.6);
}

class Replay : public ::testing::Test {
protected:
    std::string clip() const { return folder / "clip.mkv"; }
    std::string file() const { return folder / "run.rec"; }
    /// Makes a clip and records a run over it. Gives the report.
    nlohmann::json record(const std::string& scene, const Words& more) const {
        make_clip(scene, clip(), {"--size", "72x48", "--frames", "12"});
        return touch(plus({clip(), "--record", file(), "--forces", folder / "recorded.csv"}, more));
    }
    Outcome replay(const Words& more = {}) const {
        return run_touchable(plus({"touch", "--replay", file(), "--overwrite"}, more));
    }
    RecordingBytes recording() const { return RecordingBytes(file_contents(file())); }
    void write(const RecordingBytes& raw) const { std::ofstream(file(), std::ios::binary) << raw.bytes(); }
    void expect_ends_with(int code, const std::string& fragment, const Words& more = {}) const {
        const Outcome run = replay(more);
        EXPECT_EQ(run.code, code) << run.err;
        EXPECT_TRUE(run.one_line_of_error()) << run.err;
        EXPECT_PRED2(says, run.err, fragment);
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
        EXPECT_PRED2(says, run.out, "every force is as recorded");
        EXPECT_PRED2(says, run.out, recorded["force_hash"].get<std::string>());
        // A recording has no hops (docs/forces.md): two columns follow theirs.
        const std::regex hop(",(hop|[01])(,[^,\n]*,[^,\n]*\n)");
        EXPECT_EQ(std::regex_replace(file_contents(again), hop, "$2"),
                  std::regex_replace(file_contents(folder / "recorded.csv"), hop, "$2"))
            << scene;
        const auto report = json_in(json);
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
        const auto recorded = touch(plus(run, {"--record", file(), "--overwrite"}));
        EXPECT_GT(recorded["contact_ticks"], 0);
        const Outcome again = replay();
        EXPECT_EQ(again.code, 0) << again.err;
        EXPECT_PRED2(says, again.out, "every force is as recorded");
        const auto part = must(read_recording(file()));
        if (run[0] != clip() || run.size() > 3) continue;
        for (const RecordedPart::Tick& tick : part.front().ticks)
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
    EXPECT_PRED2(says, run.err, "the clip's frames are not the recorded ones");
    // Which one it is, from the two forces files.
    const auto recorded = read_forces(folder / "recorded.csv"), felt = read_forces(csv);
    ASSERT_EQ(recorded.size(), felt.size());
    std::size_t first = 0;
    while (first < felt.size() && felt[first].vector("force") == recorded[first].vector("force") &&
           felt[first]["guard"] == recorded[first]["guard"])
        ++first;
    ASSERT_LT(first, felt.size());
    const std::string where =
        "tick " + std::to_string(first / 2) + ", finger " + std::to_string(first % 2 + 1) + ":";
    EXPECT_PRED2(says, run.err, where);

    make_clip("globe", other, {"--size", "64x48", "--frames", "12"});
    expect_ends_with(3, "64x48", {other});
}

// A corner of the last frame, where no finger ever was.
TEST_F(Replay, NotesChangeInUntouchedPixels) {
    make_clip("bumps", clip(), {"--size", "72x48", "--frames", "3"});
    succeed({"export", clip(), "--frames", "all", "--out", folder / "images"});
    auto scene = json_in(folder / "images/0/scene.json");
    scene["folder"] = {{"depth", "%d/depth.png"}};
    const std::string described = folder / "images/clip.json";
    std::ofstream(described) << scene;
    for (const Words& clock : {Words{}, Words{"--live"}}) {
        ASSERT_GT(touch(plus({described, "--record", file(), "--hand", "press", "--seconds", "0.4"},
                             clock))["contact_ticks"],
                  50);
        const std::string note = "the clip's frames are not the recorded ones";
        EXPECT_EQ(replay().out.find(note), std::string::npos);
        const std::string last = folder / "images/2/depth.png", kept = file_contents(last);
        auto image = must(read_image(last));
        image.samples.back() ^= 1;
        fs::remove(last);
        ASSERT_TRUE(write_png(last, image.view()));
        const Outcome changed = replay();
        EXPECT_EQ(changed.code, 0) << changed.err;
        EXPECT_PRED2(says, changed.out, "every force is as recorded");
        EXPECT_PRED2(says, changed.out, note);
        std::ofstream(last, std::ios::binary) << kept;
    }
}

TEST_F(Replay, NamesLeastDifference) {
    record("globe", {"--seconds", "0.4", "--fingers", "3"});
    const RecordingBytes original = recording();
    RecordingBytes raw = original;
    raw.set_integer(raw.force_at(317, 2) + 16, 8, raw.integer(raw.force_at(317, 2) + 16, 8) ^ 1);
    write(raw);
    expect_ends_with(6, "first at tick 317, finger 3:");
    raw = original;
    raw.set_integer(raw.guard_at(215, 1), 4, 2);
    write(raw);
    expect_ends_with(6, "first at tick 215, finger 2:");
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
    expect_ends_with(6, "first at tick 450, finger 1:", {"--forces", csv});
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
    std::ofstream(file(), std::ios::binary) << whole.substr(0, whole.size() / 2);
    expect_ends_with(3, file());
    for (const std::string& other : {clip(), folder.path().string(), (folder / "nothing.rec").string()})
        expect_failure({"touch", "--replay", other}, 3, other);
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

// Made once by `make moving moving.mkv --size 32x24 --frames 3` and `touch moving.mkv --seconds 0.05 --hand
// csv:sweep.csv:columns=x+y+z,contact=0.95 --record ...`, and kept: what a version has written, every later
// one reads. It is of a time before recordings named their rules.
TEST_F(Replay, ReadsVersion1Recording) {
    const std::string kept = TOUCHABLE_SOURCE_DIR "/tests/data/recording_v1.rec";
    make_clip("moving", clip(), {"--size", "32x24", "--frames", "3"});
    const RecordingBytes raw(file_contents(kept));
    EXPECT_EQ(raw.integer(8, 4), 1U);
    const std::string csv = folder / "again.csv";
    expect_failure({"touch", clip(), "--replay", kept, "--forces", csv}, 3,
                   "not comparable: made under rules 1 ");
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
    expect_ends_with(6, "first at tick 290, finger 1:");
}

TEST_F(Replay, OpensFolderWithRecordedScene) {
    make_clip("plane", clip(), {"--size", "48x32", "--frames", "1"});
    succeed({"export", clip(), "--frame", "0", "--out", folder / "images"});
    auto scene = json_in(folder / "images/scene.json");
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
        refuse(changed, std::string(name) + " is null: must be");
    }
    const auto with = [&](const char* path, const nlohmann::json& value) {
        auto changed = facts;
        changed[nlohmann::ordered_json::json_pointer(path)] = value;
        return changed;
    };
    const std::pair<const char*, std::vector<nlohmann::json>> wrong[] = {{"/rules", {0, "all", 1.5}},
                                                                         {"/frames", {0, "all"}},
                                                                         {"/metric", {"feet"}},
                                                                         {"/S", {0, -1, "1"}},
                                                                         {"/event_limit", {0, 2.5, 1e300}},
                                                                         {"/guard", {3}},
                                                                         {"/scene", {3}},
                                                                         {"/guard/max_force", {0, nullptr}},
                                                                         {"/guard/max_stiffness", {-1}},
                                                                         {"/guard/ramp_in_ticks", {-1}},
                                                                         {"/guard/ramp_out_ticks", {1e12}}};
    for (const auto& [path, values] : wrong)
        for (const nlohmann::json& value : values) refuse(with(path, value), file());
    refuse(with("/scene/camera/fx", 0), "fx");
    // As it was, and with a member that this version does not know, it is read.
    RecordingBytes raw = original;
    raw.set_facts(with("/weather", "fair").dump());
    write(raw);
    EXPECT_EQ(replay().code, 0);
}

}  // namespace
}  // namespace touchable::test
