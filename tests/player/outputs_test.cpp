// SPDX-License-Identifier: Apache-2.0
// Outputs of a run: never over its input, never two in one, whole or not at all.

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cstdlib>
#include <fstream>

#include "engine/base/files.hpp"
#include "engine/picture/image.hpp"
#include "tests/must.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"
#include "tests/temporary_files.hpp"

namespace touchable::test {
namespace {

namespace fs = std::filesystem;

class Outputs : public ::testing::Test {
protected:
    Outputs() {
        make_clip("globe", clip(), {"--size", "48x32", "--frames", "2"});
        fs::create_directory(folder / "out");
    }
    std::string clip() const { return folder / "clip.mkv"; }
    std::string out(const std::string& name = "") const { return folder / ("out/" + name); }
    void expect_refused(const Outcome& run, const std::string& words) const { expect_failure(run, 2, words); }

    TemporaryFolder folder;
};

/// A folder of pictures that is a clip; its files stay as they are.
class FolderOutputs : public Outputs {
protected:
    FolderOutputs() {
        succeed({"export", clip(), "--frame", "0", "--out", pictures()});
        for (const std::string& name : names_in(pictures())) before.push_back(read(name));
    }
    ~FolderOutputs() override {
        std::size_t k = 0;
        for (const std::string& name : names_in(pictures())) EXPECT_EQ(read(name), before.at(k++)) << name;
        EXPECT_EQ(k, before.size());
    }
    std::string pictures() const { return folder / "pictures"; }
    std::string read(const std::string& name) const { return file_contents(pictures() + "/" + name); }
    std::vector<std::string> before;
};

TEST_F(FolderOutputs, NeverReplaceClipFiles) {
    for (const std::string& input : {pictures(), pictures() + "/scene.json"})
        for (const char* name : {"scene.json", "depth.png", "colour.png", "haptic.png", "height.png"})
            expect_refused(run_touchable({"touch", input, "--seconds", "0.1", "--overwrite", "--json",
                                          pictures() + "/" + name}),
                           "which it would replace");
    expect_refused(run_touchable({"touch", pictures(), "--seconds", "0.1", "--overwrite", "--picture",
                                  pictures() + "/depth.png"}),
                   "is also a file of the clip");
    expect_refused(run_touchable({"export", pictures(), "--frame", "0", "--overwrite", "--out", pictures()}),
                   "is also a file of the clip");
    fs::create_directory_symlink(pictures(), folder / "elsewhere");
    expect_refused(
        run_touchable({"export", pictures(), "--frame", "0", "--overwrite", "--out", folder / "elsewhere"}),
        "is also a file of the clip");
}

TEST_F(FolderOutputs, NeverReplaceLinkedInput) {
    fs::create_hard_link(pictures() + "/depth.png", folder / "hard.png");
    fs::create_symlink(pictures() + "/depth.png", folder / "soft.png");
    for (const char* name : {"hard.png", "soft.png"})
        expect_refused(
            run_touchable({"touch", pictures(), "--seconds", "0.1", "--overwrite", "--json", folder / name}),
            "is also a file of the clip");
}

TEST_F(Outputs, NeverReplaceOddlyNamedHand) {
    for (const char* name : {"x=1.csv", "a:b=2.csv"}) {
        const std::string file = folder / name;
        std::ofstream(file) << "t_s,z\n0,0\n1,0.01\n";
        const std::string before = file_contents(file);
        expect_refused(run_touchable({"touch", clip(), "--hand", "csv:" + file + ":columns=z", "--forces",
                                      file, "--overwrite"}),
                       "is also the hand's file");
        EXPECT_EQ(file_contents(file), before);
    }
}

TEST_F(Outputs, RejectTwoNamesOfFile) {
    fs::create_directory_symlink(folder / "out", folder / "link");
    std::ofstream(out("there.csv")) << "earlier\n";
    fs::create_hard_link(out("there.csv"), out("also.csv"));
    for (const auto& [one, other] : {std::pair{"a.csv", "./a.csv"},
                                     {"out/a.csv", "link/a.csv"},
                                     {"a.csv", "out/../a.csv"},
                                     {"out/there.csv", "link/there.csv"},
                                     {"out/there.csv", "out/also.csv"}}) {
        expect_refused(run_in_folder({"touch", "clip.mkv", "--seconds", "0.1", "--overwrite", "--json", one,
                                      "--forces", other},
                                     folder.path()),
                       "is also --forces");
        EXPECT_FALSE(fs::exists(folder / "a.csv"));
        EXPECT_EQ(file_contents(out("there.csv")), "earlier\n");
    }
}

TEST_F(Outputs, TreatDanglingLinkAsFile) {
    fs::create_symlink(folder / "nowhere", out("r.json"));
    const Words words{"touch", clip(), "--seconds", "0.1", "--json", out("r.json")};
    expect_refused(run_touchable(words), "--overwrite");
    succeed(plus(words, {"--overwrite"}));
    EXPECT_FALSE(fs::exists(folder / "nowhere")) << "a link is replaced, not followed";
    EXPECT_TRUE(nlohmann::json::accept(file_contents(out("r.json"))));
}

TEST_F(Outputs, SurviveClosedStandardOutput) {
    const Outcome run = run_unheard({"touch", clip(), "--seconds", "0.1", "--json", out("r.json"), "--forces",
                                     out("f.csv"), "--picture", out("p.png")});
    EXPECT_EQ(run.code, 0) << run.err;
    EXPECT_EQ(run.err, "");
    EXPECT_EQ(names_in(out()), (Words{"f.csv", "p.png", "r.json"}));
    EXPECT_EQ(json_in(out("r.json"))["ticks"], 100);
    for (const Words& words :
         {Words{"info", clip()}, {"touch", clip(), "--seconds", "0.1", "--forces", "-"}, {}})
        EXPECT_EQ(run_unheard(words).code, 0);
}

TEST_F(Outputs, ClosedPipeEndsRunWithoutOtherUse) {
    const Words forces{"touch", clip(), "--seconds", "20", "--forces", "-"};
    const auto unheard_with = [&](const Words& more) { return run_unheard(plus(forces, more)); };
    const Outcome alone = run_unheard(forces);
    EXPECT_EQ(alone.code, 0);
    EXPECT_EQ(alone.err, "") << "a run to its end tells what was touched";
    const Outcome live = run_unheard({"touch", clip(), "--live", "--seconds", "1000", "--forces", "-"});
    EXPECT_EQ(live.code, 0) << live.err;
    EXPECT_EQ(unheard_with({"--json", out("r.json")}).code, 0);
    EXPECT_EQ(json_in(out("r.json"))["ticks"], 20'000);
    EXPECT_NE(unheard_with({"--strict"}).err, "") << "its warnings are asked for";
}

TEST_F(Outputs, MatchFilesOnStandardOutput) {
    const Words run{"touch", clip(), "--seconds", "0.1", "--fingers", "2"};
    const auto with = [&](const Words& more) { return run_touchable(plus(run, more)); };
    ASSERT_EQ(with({"--forces", out("f.csv")}).code, 0);
    const Outcome forces = with({"--forces", "-"}), json = with({"--json", "-"});
    EXPECT_EQ(forces.code, 0);
    EXPECT_EQ(forces.out, file_contents(out("f.csv")));
    EXPECT_EQ(json.code, 0);
    EXPECT_EQ(nlohmann::json::parse(json.out)["ticks"], 100);
    for (const Outcome* outcome : {&forces, &json})
        EXPECT_PRED2(says, outcome->err, "  verdict  ") << "the table stands on the other stream";
    expect_refused(with({"--forces", "-", "--json", "-"}), "one of them can go to standard output");
    expect_refused(with({"--record", "-"}), "--record -");
    expect_refused(with({"--picture", "-"}), "does not end in .png");
    const Outcome of_that_name =
        run_in_folder({"touch", "clip.mkv", "--seconds", "0.1", "--json", "./-"}, folder.path());
    EXPECT_EQ(of_that_name.code, 0);
    EXPECT_TRUE(fs::exists(folder / "-"));
}

TEST_F(Outputs, PictureNameMustBePng) {
    for (const char* name : {"p.jpg", "p", ".png"})
        expect_refused(run_touchable({"touch", clip(), "--picture", out(name)}), "does not end in .png");
    succeed({"export", clip(), "--frame", "0", "--picture", out("P.PNG")});
}

TEST_F(Outputs, AreWholeWithoutUnnamedFiles) {
    ASSERT_EQ(run_with_named_files({"make", "plane", out("c.mkv"), "--size", "16x12", "--frames", "1"}).code,
              0);
    ASSERT_EQ(run_with_named_files({"touch", clip(), "--seconds", "0.1", "--json", out("r.json")}).code, 0);
    ASSERT_EQ(run_with_named_files({"export", clip(), "--frame", "0", "--out", out("frame")}).code, 0);
    EXPECT_EQ(names_in(out()), (Words{"c.mkv", "frame", "r.json"}));
    EXPECT_EQ(run_with_named_files({"touch", out("frame"), "--seconds", "0.1"}).code, 0);
    const Words endless{"touch", clip(), "--seconds", "100000", "--json", out("e.json")};
    EXPECT_EQ(run_interrupted(endless, out(), SIGINT, Unfinished::named).code, 130);
    EXPECT_EQ(names_in(out()), (Words{"c.mkv", "frame", "r.json"}));
}

TEST_F(Outputs, NameHasOneWriter) {
    for (const Words& words : {Words{"make", "plane", out("a.mkv")},
                               {"convert", clip(), out("a.mp4")},
                               {"play", clip(), "--headless", "--seconds", "0.1", "--video", out("f.mkv")},
                               {"touch", clip(), "--seconds", "0.1", "--record", out("r.rec")},
                               {"touch", clip(), "--seconds", "0.1", "--picture", out("p.png")},
                               {"info", clip(), "--verify", "--picture", out("p.png")},
                               {"materials", clip(), "--otherwise", "wood", "--save", out("s.json")}}) {
        NewFile first(words.back());
        ASSERT_TRUE(first.hold());
        expect_failure(words, 3, fs::path(words.back()).filename().string() + ": another run writes it");
    }
}

TEST_F(Outputs, FailedReplacementKeepsFolder) {
    const std::string frame = out("frame");
    succeed({"export", clip(), "--frame", "0", "--out", frame});
    fs::remove(frame + "/codes.png");
    fs::create_directories(frame + "/codes.png/mine");
    const Words before = names_in(frame);
    const std::string depth = file_contents(frame + "/depth.png"),
                      scene = file_contents(frame + "/scene.json");
    make_clip("noise", clip(), {"--size", "48x32", "--frames", "1"});
    expect_failure({"export", clip(), "--frame", "0", "--out", frame, "--overwrite"}, 3, "codes.png");
    EXPECT_EQ(names_in(frame), before);
    EXPECT_EQ(file_contents(frame + "/depth.png"), depth);
    EXPECT_EQ(file_contents(frame + "/scene.json"), scene);
    EXPECT_TRUE(fs::exists(frame + "/codes.png/mine"));
}

TEST(NewFile, KeepsFileCreatedMeanwhile) {
    const TemporaryFolder folder;
    NewFile file(folder / "a", Existing::keep);
    std::ofstream(file.path()) << "ours";
    EXPECT_TRUE(names_in(folder.path()).empty());
    std::ofstream(folder / "a") << "theirs";
    const auto refused = file.commit();
    ASSERT_FALSE(refused);
    EXPECT_PRED2(says, refused.error().message, "is there by now");
    EXPECT_EQ(file_contents(folder / "a"), "theirs");
    EXPECT_EQ(names_in(folder.path()), Words{"a"});
}

TEST(NewFile, ReplacesLinkNotItsTarget) {
    const TemporaryFolder folder;
    std::ofstream(folder / "theirs") << "theirs";
    fs::create_symlink(folder / "theirs", folder / "a");
    NewFile file(folder / "a");
    std::ofstream(file.path()) << "ours";
    ASSERT_TRUE(file.commit());
    EXPECT_EQ(file_contents(folder / "theirs"), "theirs");
    EXPECT_EQ(file_contents(folder / "a"), "ours");
    EXPECT_FALSE(fs::is_symlink(folder / "a"));
    EXPECT_EQ(names_in(folder.path()), (Words{"a", "theirs"}));
}

TEST(NewFile, HiddenNamesDiffer) {
    EXPECT_NE(hidden_name("folder"), hidden_name("folder"));
    EXPECT_EQ(hidden_name("folder").parent_path(), "folder");
}

TEST(CheckCommand, FindsMachineReady) {
    const auto facts = json_of({"check", "--json"});
    EXPECT_TRUE(facts["ready"].get<bool>());
    EXPECT_GE(facts["cpu"]["cores"].get<int>(), 1);
    if (!facts["timer"]["realtime_permitted"].get<bool>()) {
        EXPECT_PRED2(says, facts["ways_to_realtime"].dump(), "LimitRTPRIO=80");
    }
    EXPECT_GT(facts["timer"]["clock_resolution_ns"].get<double>(), 0);
    for (const char* encoder : {"ffv1 encoder", "h264 encoder"})
        EXPECT_TRUE(facts["ffmpeg"]["needed"][encoder].get<bool>()) << encoder;
    ASSERT_GE(facts["builders"].size(), 1U);
    for (const auto& builder : facts["builders"]) {
        EXPECT_TRUE(builder["identical"].get<bool>());
        EXPECT_GT(builder["cpu_ms"].get<double>(), 0);
        EXPECT_GT(builder["vulkan_ms"].get<double>(), 0);
    }
    const auto& vulkan = facts["vulkan"];
    EXPECT_TRUE(vulkan["usable"].get<bool>()) << vulkan;
    EXPECT_TRUE(vulkan["kernel"]["same_bits"].get<bool>());
    EXPECT_GT(vulkan["kernel"]["least_ms"].get<double>(), 0);
    const auto& device = vulkan["devices"][vulkan["used"].get<std::size_t>()];
    EXPECT_FALSE(device["driver"].get<std::string>().empty());
    EXPECT_EQ(device["software"].get<bool>(), device["kind"] == "software");
    EXPECT_TRUE(device["missing"].empty());
    EXPECT_GT(device["limits"]["max_storage_buffer_range"].get<std::uint64_t>(), 0U);
}

TEST(CheckCommand, IsReadyWithoutVulkanDriver) {
    for (const char* name : {"VK_ICD_FILENAMES", "VK_DRIVER_FILES"})
        setenv(name, "/nonexistent/driver.json", 1);
    const Outcome run = run_touchable({"check"});
    for (const char* name : {"VK_ICD_FILENAMES", "VK_DRIVER_FILES"}) unsetenv(name);
    EXPECT_EQ(run.code, 0) << run.err;
    EXPECT_PRED2(says, run.out, "install a driver");
    EXPECT_PRED2(says, run.out, "verdict   ready, without Vulkan");
}

TEST(CheckCommand, StopsWhenInterrupted) {
    const Outcome run = run_interrupted_once_it_speaks({"check"});
    EXPECT_EQ(run.code, 130) << run.err;
    EXPECT_EQ(run.out.find("verdict"), std::string::npos) << run.out;
    EXPECT_TRUE(run.one_line_of_error()) << run.err;
}

TEST(CheckCommand, PrintsVerdict) {
    const Outcome run = succeed({"check"});
    for (const char* fact : {"cpu", "SCHED_FIFO", "ffmpeg", "vulkan", "the same bits", "verdict   ready\n"})
        EXPECT_PRED2(says, run.out, fact);
}

TEST(CheckCommand, JudgesRequestedLoad) {
    const Outcome easy = succeed({"check", "--size", "64x48", "--fingers", "2", "--rate", "1"});
    EXPECT_EQ(easy.out.rfind("yes: 64x48 at 1 frames/s with 2 fingers; ", 0), 0U) << easy.out;
    for (const char* fact : {"decode", "build", "tick", "cpu time", "at most", "SCHED_FIFO"})
        EXPECT_PRED2(says, easy.out, fact);

    const Outcome hard =
        expect_failure({"check", "--json", "--size", "1920x1080", "--rate", "1000"}, 6,
                       "1920x1080 at 1000 frames/s with 1 finger is too much for this machine");
    const auto facts = nlohmann::json::parse(hard.out, nullptr, false);
    ASSERT_TRUE(facts.is_object()) << hard.out;
    EXPECT_FALSE(facts["can"].get<bool>());
    EXPECT_LT(facts["most_rate"].get<double>(), 1000);
    EXPECT_EQ(facts["ticks"], 1000);
    for (const char* measured : {"decode_ms", "build_ms", "tick_us"})
        EXPECT_GT(facts[measured]["mean"].get<double>(), 0) << measured;
    EXPECT_GT(facts["cpu_ms_per_second"].get<double>(), 0);
}

TEST(CheckCommand, RemovesTrialFiles) {
    const TemporaryFolder folder;
    setenv("TMPDIR", folder.path().c_str(), 1);
    const Outcome run = run_touchable({"check", "--size", "64x48", "--rate", "1"});
    const Outcome stopped = run_interrupted({"check", "--size", "1920x1080"}, folder.path());
    unsetenv("TMPDIR");
    // A busy machine with sanitizers may be too slow, which is said.
    const bool is_slow = run.err.find("is too much for this machine") != std::string::npos;
    EXPECT_EQ(run.code, is_slow ? 6 : 0) << run.err;
    EXPECT_EQ(stopped.code, 130) << stopped.err;
    EXPECT_EQ(folder.file_count(), 0U);
}

TEST(CheckCommand, RejectsInvalidOptions) {
    for (const std::vector<std::string>& words : {std::vector<std::string>{"--size", "big"},
                                                  {"--size", "8x8"},
                                                  {"--fingers", "0"},
                                                  {"--rate", "0"}}) {
        expect_failure(plus({"check"}, words), 2);
    }
}

TEST(CompareCommand, RejectsInvalidForcesFile) {
    const TemporaryFolder folder;
    const std::string good = folder / "a.csv", bad = folder / "b.csv";
    const std::string header = "tick,finger,goal_x,goal_y,goal_z,force_x,force_y,force_z,contact\n";
    std::ofstream(good) << header << "0,0,1,2,3,0,0,1,1\n1,0,1,2,3,0,0,1,1\n";
    for (const auto& [rows, word] :
         {std::pair<std::string, const char*>{"tick,finger\n0,0\n", "goal_x"},
          {header + "0,0,1,2,3,0,0,1,1\n2,0,1,2,3,0,0,1,1\n",
           "line 3: must have tick 1 and finger 0: every finger"},
          {header + "0,0,1,2,3,0,0,x,1\n", "line 2"},
          {header + "0,0,1,2,3,0,0,1,1\n0,1,1,2,3,0,0,1,1\n1,0,1,2,3,0,0,1,1\n", "lacks"}}) {
        std::ofstream(bad) << rows;
        expect_failure({"compare", good, bad}, 3, word);
    }
    EXPECT_EQ(run_touchable({"compare", good}).code, 2);
    succeed({"compare", good, good});
}

/// Two fingers over a globe of few bits, and the same goals with a filter and without.
TEST(CompareCommand, ComparesFiltersOnRecordedGoals) {
    const TemporaryFolder folder;
    const std::string clip = folder / "globe.mkv", rec = "rec:" + (folder / "a.rec").string();
    const std::string a = folder / "a.csv", b = folder / "b.csv", again = folder / "again.csv";
    make_clip("globe", clip, {"--size", "160x120", "--frames", "12", "--bits", "8"});
    const auto first = touch({clip, "--fingers", "2", "--seconds", "0.6", "--median", "0", "--record",
                              folder / "a.rec", "--forces", a});
    const auto same = touch({clip, "--hand", rec, "--median", "0", "--forces", again});
    EXPECT_EQ(same["force_hash"], first["force_hash"]);
    EXPECT_EQ(same["fingers"], 2);
    EXPECT_EQ(same["ticks"], 600);
    const auto filtered = touch({clip, "--hand", rec, "--median", "5", "--forces", b});
    EXPECT_NE(filtered["force_hash"], first["force_hash"]);

    EXPECT_PRED2(says, run_touchable({"compare", a, again}).out, "every force is the same");
    const auto report = json_of({"compare", a, b, "--json"});
    EXPECT_EQ(report["other_goals"], 0);
    EXPECT_EQ(report["fingers"], 2);
    EXPECT_GT(report["contact"]["both"], 300);
    EXPECT_GT(report["difference_n"]["max"], 0);
    const Outcome table = run_touchable({"compare", a, b});
    for (const char* word : {"contact ", "difference ", "direction ", "noise ", "worst "})
        EXPECT_PRED2(says, table.out, word);
    const auto& worst = report["worst"][0];  // data count fingers from 0, people from 1
    const std::string number = std::to_string(worst["finger"].get<int>() + 1);
    const std::string told = "tick " + worst["tick"].dump() + ", finger " + number + ":";
    EXPECT_PRED2(says, table.out, told);
}

TEST(CompareCommand, RejectsInvalidRecordedHand) {
    const TemporaryFolder folder;
    const std::string clip = folder / "globe.mkv", rec = "rec:" + (folder / "a.rec").string();
    make_clip("globe", clip, {"--size", "80x60", "--frames", "3"});
    touch({clip, "--fingers", "2", "--seconds", "0.1", "--record", folder / "a.rec"});
    for (const auto& [words, code, say] : {std::tuple{Words{"--hand", "rec:"}, 2, "--record"},
                                           {Words{"--hand", "rec:no.rec"}, 3, "no.rec"},
                                           {Words{"--hand", rec + ":speed=2"}, 2, "depth"},
                                           {Words{"--hand", rec, "--fingers", "3"}, 2, "has 2"},
                                           {Words{"--hand", "rec:" + clip}, 3, "globe.mkv"}}) {
        expect_failure(plus({"touch", clip}, words), code, say);
    }
    // An input is never replaced, a hand's file neither.
    const Outcome kept =
        run_touchable({"touch", clip, "--hand", rec, "--record", folder / "a.rec", "--overwrite"});
    EXPECT_EQ(kept.code, 2) << kept.err;
}

// `touchable plot`.

class Plot : public ::testing::Test {
protected:
    void SetUp() override {
        if (std::system("/usr/bin/python3 -c 'import matplotlib' 2>/dev/null") != 0)
            GTEST_SKIP() << "needs Python with matplotlib (Debian: python3-matplotlib)";
        succeed({"make", "globe", clip(), "--size", "72x48", "--frames", "6"});
        succeed({"touch", clip(), "--fingers", "3", "--seconds", "0.3", "--forces", forces()});
    }
    std::string clip() const { return folder / "clip.mkv"; }
    std::string forces() const { return folder / "forces.csv"; }
    std::string picture() const { return folder / "plot.png"; }
    /// Nothing was drawn, and one line says why.
    void expect_refused(const Words& words, int code, const std::string& why) const {
        const auto before = names_in(folder.path());
        expect_failure(words, code, why);
        EXPECT_EQ(names_in(folder.path()), before);
    }

    TemporaryFolder folder;
};

TEST_F(Plot, DrawsForcesAndPaths) {
    succeed({"plot", forces(), picture()});
    const auto over_time = must(read_image(picture()));
    EXPECT_GT(over_time.width, 800);
    succeed({"export", clip(), "--frame", "2", "--out", folder / "frame"});
    succeed({"plot", forces(), picture(), "--over", folder / "frame", "--overwrite"});
    const auto over_depth = must(read_image(picture()));
    EXPECT_NE(over_depth.samples, over_time.samples);
}

/// As a window records them: five fingers, of which one was led.
TEST_F(Plot, LeavesOutIdleFingers) {
    const auto write = [&](const std::string& file, int fingers) {
        std::ofstream out(folder / file);
        out << "tick,time_s,finger,goal_x,goal_y,goal_z,force_x,force_y,force_z,contact,pixel_x,pixel_y,"
               "guard\n";
        for (int tick = 0; tick < 20; ++tick)
            for (int finger = 0; finger < fingers; ++finger) {
                out << tick << ',' << 0.001 * tick << ',' << finger << ',' << (finger == 0 ? tick : 0)
                    << ",0,0,0," << (finger == 0 ? 0.1 * tick : 0) << ",0,"
                    << (finger == 0 && tick > 9 ? 1 : 0) << ",3,4,0\n";
            }
    };
    write("one.csv", 1);
    write("five.csv", 5);
    succeed({"plot", folder / "one.csv", folder / "one.png"});
    succeed({"plot", folder / "five.csv", folder / "five.png"});
    const auto one = read_image(folder / "one.png"), five = read_image(folder / "five.png");
    ASSERT_TRUE(one && five);
    EXPECT_EQ(one->samples, five->samples);
}

TEST_F(Plot, CountsFingersFromOne) {
    const std::string script =
        "import sys; sys.path.insert(0, sys.argv[1]); import touch\n"
        "strips = touch.draw_forces(sys.argv[2]).axes\n"
        "assert [strip.texts[0].get_text().splitlines()[0] for strip in strips] == "
        "['finger 1', 'finger 2', 'finger 3']\n";
    const TemporaryFile file("names.py", script);
    const std::string run = "PYTHONDONTWRITEBYTECODE=1 /usr/bin/python3 '" + file.path() + "' '" +
                            std::string(TOUCHABLE_SOURCE_DIR) + "/player/plot' '" + forces() + "'";
    EXPECT_EQ(std::system(run.c_str()), 0);
}

TEST_F(Plot, KeepsExistingFile) {
    std::ofstream(picture()) << "mine";
    expect_refused({"plot", forces(), picture()}, 2, "--overwrite");
    EXPECT_EQ(file_contents(picture()), "mine");
    expect_refused({"plot", forces(), forces(), "--overwrite"}, 2, ".png");
}

TEST_F(Plot, ReportsInvalidInput) {
    expect_refused({"plot", folder / "none.csv", picture()}, 3, "none.csv");
    expect_refused({"plot", clip(), picture()}, 3, "clip.mkv: holds bytes that are no text");
    std::ofstream(folder / "other.csv") << "t,force_x\n0,1\n";
    expect_refused({"plot", folder / "other.csv", picture()}, 3,
                   "other.csv: is not a forces file (touchable touch --forces): no column time_s");
    std::ofstream(folder / "half.csv") << file_contents(forces()).substr(0, 700);
    expect_refused({"plot", folder / "half.csv", picture()}, 3, "half.csv: line");
    expect_refused({"plot", forces(), picture(), "--over", folder / "nothing"}, 3, "scene.json");
}

// Warnings stand first in the table, and with --strict in the exit code. Those of live runs: live_test.cpp.

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
    /// The warnings of an offline run, as the report has them; the table begins with them, and --strict minds
    /// them.
    Words warnings(Words words) const {
        words.insert(words.begin(), {"touch", "--overwrite", "--json", folder / "r.json"});
        const Outcome run = succeed(words);
        const Words told = json_in(folder / "r.json")["warnings"];
        std::string first;
        for (const std::string& warning : told) first += "  warning               " + warning + '\n';
        EXPECT_TRUE(run.out.starts_with(first + "  touched ")) << run.out;
        words.emplace_back("--strict");
        const Outcome strict = run_touchable(words);
        EXPECT_EQ(strict.code, told.empty() ? 0 : 6) << strict.err;
        if (!told.empty()) {
            EXPECT_TRUE(strict.one_line_of_error()) << strict.err;
        }
        for (const std::string& warning : told) EXPECT_PRED2(says, strict.err, warning);
        EXPECT_EQ(json_in(folder / "r.json")["warnings"], told);
        return told;
    }

    TemporaryFolder folder;
};

TEST_F(Warnings, AreAbsentFromGoodRun) {
    EXPECT_EQ(warnings({flat_still({0}), "--hand", "press", "--seconds", "0.8"}), Words());
}

TEST_F(Warnings, ReportHandWithoutContact) {
    const Words told = warnings({flat_still({0}), "--hand", "press", "--seconds", "0.05"});
    ASSERT_EQ(told.size(), 1U);
    EXPECT_EQ(told[0], "no finger touched anything");
}

TEST_F(Warnings, ReportClipWithoutSurface) {
    const std::string scene = flat_still({7});
    for (const char* builder : {"cpu", "lazy", "reference"}) {
        const Words told = warnings({scene, "--builder", builder, "--seconds", "0.05"});
        ASSERT_EQ(told.size(), 2U) << builder;
        EXPECT_PRED2(says, told[0], "100 % of the pixels are invalid");
    }
}

TEST_F(Warnings, AppearInReplay) {
    const std::string scene = flat_still({0}), record = folder / "run.rec";
    touch({scene, "--hand", "press", "--seconds", "0.05", "--record", record});
    EXPECT_EQ(warnings({"--replay", record}).size(), 1U);
}

}  // namespace
}  // namespace touchable::test
