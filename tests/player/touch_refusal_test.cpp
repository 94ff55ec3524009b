#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <set>

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
        Words all{"touch", "--json", out("r.json"), "--forces", out("f.csv"), "--record", out("r.rec")};
        all.insert(all.end(), words.begin(), words.end());
        return all;
    }
    void expect_refused(const Words& words, int code, const std::string& fragment) const {
        const Outcome run = run_touchable(words);
        EXPECT_EQ(run.code, code) << words.back() << ": " << run.err;
        EXPECT_TRUE(run.one_line_of_error()) << run.err;
        EXPECT_NE(run.err.find(fragment), std::string::npos) << fragment << " is missing in: " << run.err;
    }

    TemporaryFolder folder;
};

TEST_F(TouchRefusal, OutputNeverReplacesInput) {
    make();
    const std::string before = file_contents(clip());
    for (const char* option : {"--json", "--forces", "--record"})
        expect_refused({"touch", clip(), "--seconds", "0.1", option, clip()}, 2, "also the clip");
    fs::create_symlink(clip(), folder / "clip.png");
    expect_refused({"touch", clip(), "--seconds", "0.1", "--picture", folder / "clip.png"}, 2,
                   "also the clip");
    EXPECT_EQ(file_contents(clip()), before);
    expect_refused({"touch", clip(), "--seconds", "0.1", "--json", out("x"), "--forces", out("../out/x")}, 2,
                   "also --forces");
    std::ofstream(folder / "h.csv") << "t_s,z\n0,0\n1,0.01\n";
    expect_refused({"touch", clip(), "--hand", "csv:" + (folder / "h.csv").string() + ":columns=z",
                    "--forces", folder / "h.csv"},
                   2, "the hand's file");
    EXPECT_EQ(run_touchable({"touch", clip(), "--seconds", "0.1", "--record", out("a.rec")}).code, 0);
    expect_refused({"touch", "--replay", out("a.rec"), "--json", out("a.rec")}, 2, "also --replay");
    expect_refused({"export", clip(), "--frame", "0", "--picture", folder / "clip.png"}, 2, "also the clip");
    expect_refused({"touch", clip(), "--seconds", "0.1", "--picture", out("p.png"), "--picture-at", "5"}, 2,
                   "--picture-at");
}

TEST_F(TouchRefusal, RejectsInvalidOptions) {
    make();
    const std::vector<std::pair<Words, std::string>> wrong{
        {{"--hand", "grab"}, "wander, stroke, press, poke"},
        {{"--hand", "wander:speed=fast"}, "speed"},
        {{"--hand", "press:x=2"}, "x=2"},
        {{"--hand", "csv:press.csv"}, "columns"},
        {{"--fingers", "0"}, "--fingers"},
        {{"--fingers", "257"}, "--fingers"},
        {{"--seconds", "0"}, "--seconds"},
        {{"--seconds", "-1"}, "--seconds"},
        {{"--seconds", "nan"}, "--seconds"},
        {{"--seconds", "long"}, "--seconds"},
        {{"--builder", "gpu"}, "--builder"},
        {{"--metric", "feet"}, "--metric"},
        {{"--interpolation", "cubic"}, "--interpolation"},
        {{"--median", "4"}, "--median: 4 is not allowed; must be 0 (off), 3 or 5"},
        {{"--fill-holes", "17"},
         "--fill-holes: 17 is not allowed; must be a whole number from 0 to 16 passes"},
        {{"--terraces", "yes"}, "off, on or auto"},
        {{"--filters", "blur"}, "blur is not allowed"},
        {{"--filters", "flyng=1"}, "flyng=1 is not allowed: did you mean flying?"},
        {{"--filters", "off,median"}, "off is not allowed: it stands alone"},
        {{"--filters", "median,median"}, "median is not allowed: median is named twice"},
        {{"--filters", "median=4"}, "median=4 is not allowed"},
        {{"--filters", "median=5,"}, "'' is not allowed"},
        {{"--filters", "terraces=1"}, "terraces=1 is not allowed"},
        {{"--filters", "holes=0"}, "holes=0 is not allowed"},
        {{"--filters", "holes=2.5"}, "holes=2.5 is not allowed"},
        {{"--filters", "median=5,terraces,median=3"}, "median=3 is not allowed"},
        {{"--filters", "flying"}, "flying is not allowed: it needs a length above 0"},
        {{"--filters", "flying=0"}, "flying=0 is not allowed"},
        {{"--filters", "flying=-1"}, "flying=-1 is not allowed"},
        {{"--filters", "temporal=0"}, "temporal=0 is not allowed"},
        {{"--filters", "temporal=1+x"}, "temporal=1+x is not allowed"},
        {{"--filters", "temporal=-1"}, "temporal=-1 is not allowed"},
        {{"--filters", "temporal"}, "does not say how noisy"},
        {{"--temporal", "on"}, "does not say how noisy"},
        {{"--temporal", "much"}, "off or on"},
        {{"--temporal", "1,"}, "off or on"},
        {{"--temporal", "1,2,3"}, "off or on"},
        {{"--temporal", "-1"}, "--temporal: -1 is not allowed"},
        {{"--temporal", "0"}, "--temporal: 0 is not allowed"},
        {{"--temporal", "nan"}, "--temporal: nan is not allowed"},
        {{"--picture", "p.png", "--picture-at", "99"},
         "lies beyond the run's end at 3.000 s; --seconds makes"},
        {{"--temporal", "1", "--builder", "lazy"}, "lazy cannot filter in time"},
        {{"--max-force", "0"}, "--max-force"},
        {{"--max-force", "inf"}, "--max-force"},
        {{"--max-force", "nan"}, "--max-force"},
        {{"--max-stiffness", "-1"}, "--max-stiffness"},
        {{"--max-stiffness", "1e308"}, "from 1e-6 to 1e9 N/mm"},
        {{"--speed", "1"}, "--speed"}};
    for (const auto& [more, fragment] : wrong) {
        Words words = writing({clip()});
        words.insert(words.end(), more.begin(), more.end());
        expect_refused(words, 2, fragment);
        EXPECT_TRUE(names_in(out()).empty()) << more[0] << ' ' << more[1];
    }
    expect_refused({"touch"}, 2, "CLIP");
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
        expect_refused(writing(more), 3, fragment);
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
        Words world = words;
        world.emplace_back("world");
        EXPECT_GT(touch(world)["contact_ticks"], 0) << what;
        for (const char* metric : {"pixel", "scaled"}) {
            Words refused = words;
            refused.emplace_back(metric);
            expect_refused(writing(refused), 2, std::string("metric ") + metric);
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
            expect_refused(words, 3, option);
            EXPECT_EQ(names_in(out()), Words{"r.json"}) << option << ' ' << place;
            EXPECT_EQ(file_contents(kept), "earlier\n");
            EXPECT_TRUE(fs::is_fifo(pipe)) << "only a file may be replaced";
        }
}

TEST_F(TouchRefusal, OverwritesOnlyWithPermission) {
    make();
    for (const char* name : {"r.json", "f.csv", "r.rec"}) {
        std::ofstream(out(name)) << "earlier\n";
        expect_refused(writing({clip(), "--seconds", "0.1"}), 2, "--overwrite");
        EXPECT_EQ(names_in(out()), Words{name});
        EXPECT_EQ(file_contents(out(name)), "earlier\n");
        fs::remove(out(name));
    }
    for (const char* name : {"r.json", "f.csv", "r.rec"}) std::ofstream(out(name)) << "earlier\n";
    ASSERT_EQ(run_touchable(writing({clip(), "--seconds", "0.1", "--overwrite"})).code, 0);
    EXPECT_EQ(names_in(out()), (Words{"f.csv", "r.json", "r.rec"}));
    EXPECT_EQ(read_forces(out("f.csv")).size(), 100U);
    for (const char* name : {"r.json", "r.rec"}) EXPECT_NE(file_contents(out(name)), "earlier\n");
}

// A limit on the size of files stands in for a full disk: writing fails half-way, or at the very end, for
// files so small that nothing is written before they are closed.
TEST_F(TouchRefusal, FullDiskLeavesNothing) {
    make();
    const auto expect_nothing = [&](int kibibytes, const char* option, const char* seconds) {
        const Outcome run =
            run_on_full_disk({"touch", clip(), "--seconds", seconds, option, out("file")}, kibibytes);
        EXPECT_EQ(run.code, 3) << option << ": " << run.err;
        EXPECT_TRUE(run.one_line_of_error()) << run.err;
        EXPECT_NE(run.err.find(option), std::string::npos) << run.err;
        EXPECT_EQ(run.out.find("--forces FILE"), std::string::npos) << run.out;
        EXPECT_TRUE(names_in(out()).empty()) << option;
    };
    for (const char* option : {"--forces", "--record"}) expect_nothing(64, option, "3");
    for (const char* option : {"--forces", "--record", "--json"}) expect_nothing(0, option, "0.002");
    const Outcome drawn =
        run_on_full_disk({"touch", clip(), "--seconds", "0.1", "--picture", out("file.png")}, 0);
    EXPECT_EQ(drawn.code, 3) << drawn.err;
    EXPECT_TRUE(drawn.one_line_of_error()) << drawn.err;
    EXPECT_TRUE(names_in(out()).empty());
}

TEST_F(TouchRefusal, InterruptLeavesNothing) {
    make();
    const Outcome run = run_interrupted(writing({clip(), "--seconds", "100000"}), out());
    EXPECT_EQ(run.code, 130) << run.err;
    EXPECT_TRUE(names_in(out()).empty());
}

TEST_F(TouchRefusal, TruncatedClipKeepsWholeFrames) {
    make("globe", {"--size", "144x96", "--frames", "30"});
    const std::string cut = folder / "cut.mkv";
    const auto size = fs::file_size(clip());
    for (const double share : {0.01, 0.3, 0.6, 0.9, 0.999}) {
        fs::copy_file(clip(), cut, fs::copy_options::overwrite_existing);
        fs::resize_file(cut, static_cast<std::uintmax_t>(share * static_cast<double>(size)));
        if (share < 0.5) {
            expect_refused(writing({cut}), 3, cut);
            EXPECT_TRUE(names_in(out()).empty()) << share;
        } else {  // its first half is whole
            const Outcome run = run_touchable({"touch", cut, "--seconds", "0.1"});
            EXPECT_EQ(run.code, 0) << share << ": " << run.err;
        }
    }
}

TEST_F(TouchRefusal, NamesDamagedFrame) {
    make("noise", {"--size", "96x96", "--frames", "30"});
    std::string bytes = file_contents(clip());
    const std::string damaged = folder / "damaged.mkv";
    std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() * 3 / 4), 16, '\0');
    std::ofstream(damaged, std::ios::binary) << bytes;
    expect_refused(writing({damaged}), 3, "frame 15");  // stored anew after half a second
    EXPECT_TRUE(names_in(out()).empty());
    // The frames before the damage are fine.
    EXPECT_EQ(touch({damaged, "--seconds", "0.2"})["ticks"], 200);
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
    EXPECT_NE(words.find("chosen by the frames before damage: "), std::string::npos) << words;
}

TEST_F(TouchRefusal, NamesDamagedPicture) {
    make();
    ASSERT_EQ(run_touchable({"export", clip(), "--frames", "all", "--out", folder / "exported"}).code, 0);
    for (const std::string n : {"0", "1", "2"})
        fs::copy_file(folder / ("exported/" + n + "/depth.png"), folder / ("d" + n + ".png"));
    auto scene = nlohmann::json::parse(file_contents(folder / "exported/0/scene.json"));
    scene["folder"]["depth"] = "d%d.png";
    std::ofstream(folder / "scene.json") << scene;
    EXPECT_EQ(touch({folder / "scene.json"})["frames"], 3);
    fs::resize_file(folder / "d1.png", fs::file_size(folder / "d1.png") / 2);
    expect_refused(writing({folder / "scene.json"}), 3, "d1.png");
    EXPECT_TRUE(names_in(out()).empty());
}

TEST_F(TouchRefusal, AcceptsNonUtf8Name) {
    make();
    const std::string odd = folder / "l\xe9ger.mkv";
    fs::copy_file(clip(), odd);
    ASSERT_EQ(run_touchable(writing({odd, "--seconds", "0.1"})).code, 0);
    EXPECT_TRUE(nlohmann::json::accept(file_contents(out("r.json"))));
    EXPECT_EQ(run_touchable({"touch", odd, "--replay", out("r.rec")}).code, 0);
}

// Options that shape forces on their way to the hand, and the report's figures of their energy.

class TouchShaping : public ::testing::Test {
protected:
    void make(const std::string& scene) const {
        make_clip(scene, clip(), {"--size", "72x48", "--frames", "6"});
    }
    std::string clip() const { return folder / "clip.mkv"; }
    Words with(const Words& more) const {
        Words words{clip(), "--seconds", "2", "--hand", hand};
        words.insert(words.end(), more.begin(), more.end());
        return words;
    }
    /// Rows of a run in which a bit of the guard is set.
    int rows_with(int bit, const Words& more) const {
        Words words = with(more);
        words.insert(words.end(), {"--forces", folder / "forces.csv"});
        touch(words);
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
    Words words = with(weak);
    words.insert(words.begin(), "touch");
    EXPECT_NE(run_touchable(words).out.find("at the device's limit for"), std::string::npos);
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
        const Outcome again = run_touchable({"touch", "--replay", recording});
        EXPECT_EQ(again.code, 0) << shaping[0] << ": " << again.err;
    }
}

TEST_F(TouchShaping, GuardMarksChangedForces) {
    make("globe");
    EXPECT_EQ(rows_with(16 | 32 | 64, {}), 0);
    EXPECT_GT(rows_with(16, {"--stiffness", "passive"}), 5);
    EXPECT_GT(rows_with(16, {"--stiffness-slew", "5"}), 5);
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
    EXPECT_NE(told.out.find("energy from nowhere"), std::string::npos) << told.out;
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

TEST_F(TouchShaping, RejectsInvalidOptions) {
    make("plane");
    for (const Words& wrong : std::vector<Words>{{"--stribeck", "-1"},
                                                 {"--stribeck", "nan"},
                                                 {"--stiffness", "hard"},
                                                 {"--stiffness-slew", "0"},
                                                 {"--stiffness-slew", "nan"},
                                                 {"--damping", "-1"},
                                                 {"--damping", "101"},
                                                 {"--damping", "nan"},
                                                 {"--passivity", "-1"},
                                                 {"--passivity", "1e9"}}) {
        Words words = with(wrong);
        words.insert(words.begin(), "touch");
        const Outcome run = run_touchable(words);
        EXPECT_EQ(run.code, 2) << wrong[0] << ' ' << wrong[1];
        EXPECT_TRUE(run.one_line_of_error()) << run.err;
        EXPECT_NE(run.err.find(wrong[0]), std::string::npos) << run.err;
    }
}

}  // namespace
}  // namespace touchable::test
