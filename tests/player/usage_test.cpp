// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <initializer_list>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <thread>
#include <vector>

#include "device/point_motion.hpp"
#include "engine/content/scenes.hpp"
#include "player/commands/convert_command.hpp"
#include "player/commands/machine_check.hpp"
#include "player/commands/option_types.hpp"
#include "player/run/terminal.hpp"
#include "player/run/touch_session.hpp"
#include "player/session/touch_setup.hpp"
#include "tests/content/exact_touch.hpp"
#include "tests/must.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"
#include "tests/temporary_files.hpp"

namespace touchable::test {
namespace {

TEST(Usage, NoArgumentsPrintShortHelp) {
    const Outcome run = succeed({});
    for (const char* command : {"make", "info", "export", "check"}) EXPECT_PRED2(says, run.out, command);
    EXPECT_LE(std::count(run.out.begin(), run.out.end(), '\n'), 16);
    EXPECT_PRED2(says, run.out, "touchable FILE opens a window");
    EXPECT_LT(run.out.find("\n  touch "), run.out.find("\n  cameras, devices ")) << run.out;
    EXPECT_LT(run.out.find("\n  cameras, devices "), run.out.find("\n  info ")) << run.out;
    EXPECT_EQ(run.err, "");
}

TEST(Usage, HelpAndVersionSucceed) {
    const Outcome help = succeed({"--help"}), version = succeed({"-V"});
    EXPECT_PRED2(says, help.out, "touchable FILE opens a window");
    EXPECT_LT(help.out.find("\n  cameras "), help.out.find("\n  serve ")) << help.out;
    EXPECT_EQ(run_touchable({"-h"}).out, help.out);
    EXPECT_TRUE(version.out.starts_with("touchable ")) << version.out;
    EXPECT_EQ(run_touchable({"--version"}).out, version.out);
    EXPECT_EQ(run_touchable({"help"}).out, run_touchable({}).out);
}

TEST(Usage, WholeNumbersAreDecimal) {
    const TemporaryFolder folder;
    const std::string clip = folder / "plane.mkv";
    succeed({"make", "plane", clip, "--size", "16x12", "--frames", "1", "--bits", "010"});
    EXPECT_PRED2(says, run_touchable({"info", clip, "--json"}).out, "1023") << "ten bits";
    const Outcome ten = succeed({"touch", clip, "--seconds", "0.01", "--fingers", "010", "--json", "-"});
    EXPECT_PRED2(says, ten.out, "\"fingers\": 10");
    for (const char* option : {"--fingers", "--median", "--fill-holes"})
        for (const char* number : {"0x3", "3.0", "3 ", ""}) {
            expect_failure({"touch", clip, "--seconds", "0.01", option, number}, 2);
        }
}

TEST(Usage, RejectsNonFiniteNumbers) {
    const std::vector<std::vector<std::string>> options{
        {"info", "--fov", "179"},     {"info", "--depth-unit", "1e+06"}, {"touch", "--rate", "8"},
        {"touch", "--seconds", "1e"}, {"touch", "--damping", "number"},  {"touch", "--start", "1e+06"},
        {"play", "--at", "1e+06"},    {"play", "--hand-scale", "100"},   {"touch", "--max-force", "number"}};
    for (const auto& option : options)
        for (const char* number : {"nan", "-nan", "inf", "1e999", "1x"}) {
            const Outcome run =
                expect_failure({option[0], "clip.mkv", option[1] + '=' + number}, 2,
                               option[1] + ": " + number + " is not allowed; must be a number");
            EXPECT_PRED2(says, run.err, option[2]);
        }
}

TEST(Usage, DashedFileNameGetsHint) {
    const TemporaryFolder folder;
    std::ofstream(folder / "-x.png") << "?";
    EXPECT_PRED2(says, run_in_folder({"info", "-x.png"}, folder.path()).err, "type ./-x.png");
}

/// Each kind of mistake once, in one line that names it; no file is made.
TEST(Usage, RefusalNamesMistake) {
    const TemporaryFolder folder;
    const std::pair<Words, const char*> wrong[] = {
        {{"tuoch", "a.mkv"}, "unknown command or file 'tuoch' (did you mean touch?); see touchable -h"},
        {{"PLAY", "a.mkv"}, "unknown command or file 'PLAY' (did you mean play?); see touchable -h"},
        {{"touch", "a.mkv", "--", "--seconds", "1"}, "unexpected word '--seconds'; see"},
        {{"touch", "a.mkv", "--FINGERS", "3"}, "did you mean --fingers?"},
        {{"touch", "a.mkv", "--fs"}, "unknown option '--fs'; see"},
        {{"paint", "--much"}, "unknown command or file 'paint'; see"},
        {{"--nothing"}, "unknown option '--nothing'"},
        {{"touch", "a.mkv", "--figners", "3"}, "did you mean --fingers?"},
        {{"help", "paint"}, "must be one of make, play, touch, cameras, devices, info"},
        {{"help", "touch", "hand", "too"}, "help takes a command and a topic, no more words"},
        {{"info"}, ""},
        {{"make", "globe"}, ""},
        {{"make", "globe", "out.mkv", "--frames", "many"}, "many"},
        {{"export", "a.mkv", "--frame", "1x", "--out", "out"}, "1x"},
        {{"info", "--", "a", "b"}, "unexpected word 'b'; see"},
        {{"touch", "--", "a.mkv", "--seconds", "1"}, "unexpected word '--seconds'; see"},
        {{"info", "a.mkv", "--json", "out.json"},
         "unexpected word 'out.json'; for a file type --json=out.json"},
        {{"touch", "a.mkv", "--intrinsics", "525", "525", "320", "240"},
         "--intrinsics takes FX,FY[,CX,CY]|FILE with commas: 525,525,320,240"},
        {{"materials", "a.mkv", "--at", "20", "40"}, "--at takes X,Y[,FRAME] with commas: 20,40"},
        // Values that are missing: an option is none.
        {{"touch", "a.mkv", "--median"}, "--median needs a value: 0|3|5"},
        {{"touch", "a.mkv", "--loop", "1", "--live"}, "--loop needs 2 values: FROM TO"},
        {{"touch", "a.mkv", "--record", "--live"}, "--record needs a value: FILE; see touchable touch -h"},
        {{"touch", "a.mkv", "--record", "--seconds=1"}, "--record needs a value: FILE"},
        {{"touch", "--record", "--", "a.mkv"}, "--record needs a value: FILE"},
        {{"touch", "a.mkv", "--record=", "--live"}, "--record needs a value: FILE"},
        {{"touch", "a.mkv", "--forces", "--typo"}, "--forces needs a value: FILE"},
        {{"touch", "a.mkv", "--json", ""}, "--json needs a value: [FILE]"},
        {{"a.mkv", "--script", "--headless"}, "--script needs a value: FILE; see touchable play -h"},
        {{"make", "globe", "--seed", "--overwrite", "a.mkv"}, "--seed needs a value: N"},
        {{"info", ""}, "names no file"},
        {{"info", "a.mkv", "--scene", ""}, "names no file"},
        {{"make", "plane", ""}, "names no file"},
        {{"touch", ""}, "names no file"},
        {{"touch", "a.mkv", "--forces", ""}, "names no file"},
        {{"touch", "a.mkv", "--record", ""}, "names no file"},
        {{"touch", "a.mkv", "--picture", ""}, "names no file"},
        {{"touch", "--replay", ""}, "names no file"},
        {{"export", "", "--frame", "0", "--out", "out"}, "names no file"},
        {{"export", "a.mkv", "--frame", "0", "--out", ""}, "names no file"},
        // Options that go with others, and words that are allowed.
        {{"make", "globe", "g.mkv", "--size", "8x8", "--size", "9x9"}, "--size is given more than once;"},
        {{"play", "a.mkv", "--at", "5"}, "--at needs --screenshot"},
        {{"info", "a.mkv", "--fov", "60", "--intrinsics", "500,500"}, "does not go with"},
        {{"info", "a.mkv", "--preset", "tun"}, "tun is not allowed: did you mean tum?"},
        // Ranges and units.
        {{"info", "a.mkv", "--fov", "62,5"}, "with a decimal point in place of the comma"},
        {{"touch", "a.mkv", "--max-force", "5N"}, "5N is not allowed; must be a number of N, 0.001 to 1000;"},
        {{"touch", "a.mkv", "--max-stiffness", "600"},
         "must be a number of N/mm, 0.001 to 50, such as 0.6 for 600 N/m;"},
        {{"touch", "a.mkv", "--depth-unit", "mm"},
         "must be a number of metres, 1e-09 to 1e+06, such as 0.001 for mm;"},
        {{"touch", "a.mkv", "--seconds", "5s"}, "must be a number of seconds, 0.001 to 1e+06;"},
        {{"touch", "a.mkv", "--passivity", "much"}, "must be a number of N s/m;"}};
    for (const auto& [words, message] : wrong) {
        EXPECT_EQ(expect_failure(run_in_folder(words, folder.path()), 2, message).out, "");
        EXPECT_EQ(names_in(folder.path()), Words{});
    }
    for (const Words& words :
         {Words{"--", "a.mkv"}, {"--", "--seconds", "0.2"}})  // no word behind -- is an option
        expect_failure(run_in_folder(words, folder.path()), 3, words[1] + ": does not exist");
    for (const Words& words : {Words{"make", "--quiet"}, {"formats", "nope"}})
        EXPECT_FALSE(says(run_touchable(words).err, "did you mean")) << words[1];
    for (const char* number : {",5", "1,", "1,2,3", "one"})
        EXPECT_FALSE(says(run_touchable({"info", "a.mkv", "--fov", number}).err, "comma")) << number;
}

TEST(Usage, DashedValueFollowsEqualsSign) {
    const TemporaryFolder folder;
    const std::string clip = folder / "a.mkv";
    make_clip("plane", clip, {"--size", "16x12", "--frames", "1"});
    for (const char* named : {"--record=--live", "--record=-x"})
        EXPECT_EQ(run_in_folder({"touch", clip, "--seconds", "0.01", named}, folder.path()).code, 0);
    EXPECT_EQ(names_in(folder.path()), (Words{"--live", "-x", "a.mkv"}));
    EXPECT_PRED2(says, run_touchable({"info", clip, "--fov", "-5"}).err, "-5 is not allowed");
}

TEST(Usage, JsonAloneOrIntoFile) {
    const TemporaryFolder folder;
    const std::string clip = folder / "a.mkv", file = folder / "a.json", forces = folder / "a.csv";
    make_clip("plane", clip, {"--size", "16x12", "--frames", "1"});
    succeed({"touch", clip, "--seconds", "0.1", "--forces", forces});
    const std::pair<Words, const char*> commands[] = {{{"info", clip}, "  verdict  "},
                                                      {{"compare", forces, forces}, "  compared  "},
                                                      {{"devices"}, "What --device takes"},
                                                      {{"cameras"}, "amera"},
                                                      {{"formats"}, "  bop\n"},
                                                      {{"formats", "tum"}, "tum: "},
                                                      {{"materials", "--list"}, "wood "},
                                                      {{"touch", clip, "--seconds", "0.1"}, "verdict"}};
    for (const auto& [command, human] : commands) {
        const auto with = [&words = command](const Words& more) { return run_touchable(plus(words, more)); };
        const Outcome alone = with({"--json"}), both = with({"--json=" + file});
        EXPECT_EQ(alone.code, 0) << alone.err;
        ASSERT_TRUE(nlohmann::json::accept(alone.out)) << alone.out;
        const auto json = nlohmann::ordered_json::parse(alone.out);
        const std::string version = json.begin().key();
        EXPECT_TRUE(version == "format" || version.starts_with("touchable_")) << version;
        EXPECT_EQ(json.front(), 1) << version;
        EXPECT_EQ(both.code, 0) << both.err;
        EXPECT_PRED2(says, both.out, human);
        EXPECT_TRUE(nlohmann::json::accept(file_contents(file)));
        EXPECT_EQ(with({"--json=" + file}).code, 2) << "it is there";
        EXPECT_EQ(with({"--json=" + file, "--overwrite"}).code, 0);
        EXPECT_PRED2(says, with({"--json="}).err, "--json needs a value");
        std::filesystem::remove(file);
    }
    succeed({"touch", clip, "--seconds", "0.1", "--json", file});
    EXPECT_TRUE(nlohmann::json::accept(file_contents(file))) << "the word behind it is its file";
    const Outcome option = run_touchable({"touch", clip, "--seconds", "0.1", "--json", "--overwrite"});
    EXPECT_TRUE(nlohmann::json::accept(option.out)) << option.out;
    EXPECT_PRED2(says, run_touchable({"info", clip, "--json=" + clip, "--overwrite"}).err, "also the clip");
}

/// Each member's name stands on the page; what FFmpeg and Vulkan name does not.
void expect_documented(const nlohmann::json& json, const std::string& page) {
    for (const auto& [name, value] : json.items()) {
        EXPECT_TRUE(json.is_array() || says(page, '`' + name + '`')) << name;
        if (name != "needed" && name != "features" && name != "limits" && value.is_structured())
            expect_documented(value, page);
    }
}

TEST(Usage, JsonMembersAreDocumented) {
    const TemporaryFolder folder;
    const std::string clip = folder / "a.mkv", forces = folder / "a.csv",
                      page = file_contents(TOUCHABLE_SOURCE_DIR "/docs/forces.md");
    make_clip("globe", clip, {"--size", "96x64", "--frames", "3"});
    succeed({"touch", clip, "--seconds", "0.4", "--forces", forces});
    for (const Words& words : {Words{"info", clip, "--verify"},
                               {"compare", forces, forces},
                               {"check"},
                               {"check", "--size", "96x64"},
                               {"touch", clip, "--seconds", "0.1"}})
        expect_documented(nlohmann::json::parse(run_touchable(plus(words, {"--json"})).out), page);
}

TEST(Usage, WrapsReportOnTerminal) {
    const TemporaryFolder folder;
    const std::string clip = folder / "a.mkv";
    make_clip("plane", clip, {"--size", "16x12", "--frames", "1"});
    const std::string whole = run_touchable({"info", clip}).out;
    const std::string shown = run_on_screen({"info", clip}, 70).out;
    const auto words_of = [](const std::string& text) {
        std::istringstream in(text);
        return Words{std::istream_iterator<std::string>(in), {}};
    };
    EXPECT_EQ(words_of(shown), words_of(whole)) << "no word is broken";
    EXPECT_PRED2(says, whole, "  camera       fx ");
    std::size_t longest = 0, below = 0;
    std::istringstream lines(shown);
    for (std::string line; std::getline(lines, line);) {
        if (line.starts_with("  ")) longest = std::max(longest, line.size());
        below += line.starts_with("               ") && line[15] != ' ' ? 1 : 0;
    }
    EXPECT_LE(longest, 70U);
    EXPECT_GT(below, 3U) << "lines that go on do so below their value";
}

TEST(Usage, DumbTerminalIsNotRedrawn) {
    const TemporaryFolder folder;
    make_clip("plane", folder / "a.mkv", {"--size", "16x12", "--frames", "1"});
    for (const char* kind : {"xterm", "dumb"}) {
        setenv("TERM", kind, 1);
        const Outcome run = run_on_screen({"touch", folder / "a.mkv", "--live", "--seconds", "0.3"}, 80);
        EXPECT_EQ(run.err.find("\033[K") == std::string::npos, kind == std::string("dumb")) << run.err;
    }
    unsetenv("TERM");
}

TEST(Usage, FormatsDescribesEverySource) {
    EXPECT_EQ(succeed({"formats", "iPhone"}).out, succeed({"formats", "iphone"}).out);
    const Outcome all = succeed({"formats"});
    EXPECT_PRED2(says, all.out, "\n  bop\n      BOP: depth/000000.png");
    EXPECT_PRED2(says, all.out, "      touchable play clip.mkv\n");
    const Outcome one = succeed({"formats", "stray"});
    EXPECT_PRED2(says, one.out, "Stray Scanner");
    EXPECT_PRED2(says, one.out, "camera_matrix.csv");
    EXPECT_PRED2(says, one.out, "unit: metres that a stored 1 stands for (--depth-unit METRES)");
    for (const std::string& out : {all.out, one.out}) {
        std::istringstream lines(out);
        for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80U) << line;
    }
    EXPECT_EQ(
        run_touchable({"formats", "relative-inverse"}).out,
        "  --preset relative-inverse\n      guessed from one picture (MiDaS and the like): 1/depth without a "
        "scale\n");
    const auto json = [](const Words& words) { return json_of(words); };
    const auto listed = json({"formats", "--json"});
    auto bop = json({"formats", "bop", "--json"});
    EXPECT_EQ(bop.erase("touchable_source"), 1U);
    EXPECT_EQ(bop["files"], "depth/000000.png, rgb/, scene_camera.json");
    EXPECT_TRUE(std::ranges::count(listed["sources"], bop)) << listed;
    EXPECT_EQ(json({"formats", "relative-inverse", "--json"})["name"], "relative-inverse");
    const Outcome near = run_touchable({"formats", "tun"});
    EXPECT_EQ(near.code, 2);
    EXPECT_EQ(near.err, "touchable: formats: no source is called \"tun\"; did you mean tum?\n");
    expect_failure({"formats", "nothing like it"}, 2, "touchable formats lists them");
}

/// Whether text has nothing that a terminal acts on: control characters, overrides of direction, other bytes
/// than UTF-8's; and no line that a name has begun.
bool is_clean(const std::string& text) {
    if (std::ranges::any_of(
            text, [](unsigned char c) { return (c < 0x20 && c != '\n') || c == 0x7f || c >= 0xf8; }))
        return false;
    for (const char* bad : {"\u009b", "\u202e", "\nfaked"})
        if (text.find(bad) != std::string::npos) return false;
    return true;
}

TEST(Usage, EscapesNamesForTerminal) {
    const TemporaryFolder folder;
    const std::string odd = "a\x1b[31m\u009b2J\u202e\nfaked \xff";
    const std::string clip = odd + ".mkv", forces = odd + ".csv", web = odd + ".web", pictures = odd + ".png";
    const auto run = [&](const std::vector<std::string>& words, int code, bool names = true) {
        const Outcome outcome = run_in_folder(words, folder.path());
        EXPECT_EQ(outcome.code, code) << words[0] << ": " << outcome.err;
        const std::string said = outcome.out + outcome.err;
        EXPECT_TRUE(is_clean(outcome.out) && is_clean(outcome.err)) << words[0] << ": " << said;
        EXPECT_EQ(said.find("a\\x1b[31m\\u009b2J\\u202e\\nfaked \\xff") != std::string::npos, names)
            << words[0] << ": " << said;
        return outcome.out;
    };
    run({"make", "globe", clip, "--size", "32x24", "--frames", "3"}, 0);
    run({"info", clip}, 0);
    run({"info", clip, "--verify"}, 0);
    run({"touch", clip, "--seconds", "0.01", "--forces", forces}, 0);
    run({"touch", clip, "--seconds", "0.01", "--verbose", "--picture", odd + ".p.png", "--overwrite"}, 0);
    run({"export", clip, "--frame", "0", "--out", odd}, 0);
    run({"convert", clip, odd + ".mp4"}, 0);
    for (int again = 0; again < 2; ++again)  // then they are there
        run({"relief", clip, odd + ".out/"}, 0);
    run({"convert", clip, pictures}, 3);
    run({"init-scene", odd + "/codes.png", "--out", odd + ".json", "--fov", "60"}, 0);
    run({"serve", clip, "--hls", web}, 0);
    run({"compare", forces, forces}, 0, false);
    run({"play", clip, "--headless", "--seconds", "0.1", "--size", "160x120", "--screenshot", pictures}, 0,
        false);
    const auto json = nlohmann::json::parse(run({"info", clip, "--json"}, 0, false));
    EXPECT_EQ(json["clip"], "a\x1b[31m\u009b2J\u202e\nfaked \ufffd.mkv");
    EXPECT_TRUE(nlohmann::json::accept(run({"compare", forces, forces, "--json"}, 0, false)));
    const std::string missing = odd + ".missing";
    for (const std::vector<std::string>& words :
         std::vector<std::vector<std::string>>{{"play", missing},
                                               {missing + "/"},
                                               {"touch", missing},
                                               {"info", missing},
                                               {"export", missing},
                                               {"convert", missing, "out.mkv"},
                                               {"relief", missing, "out.mkv"},
                                               {"materials", missing},
                                               {"serve", missing, "tcp://127.0.0.1:0"},
                                               {"init-scene", missing},
                                               {"compare", missing, forces},
                                               {"plot", missing, "out.png"},
                                               {"info", clip, "--scene", missing},
                                               {odd + "/x"},
                                               {"touch", clip, odd},
                                               {"touch", clip, "--" + odd},
                                               {"help", odd}}) {
        const Outcome outcome = run_in_folder(words, folder.path());
        EXPECT_TRUE(outcome.code == 2 || outcome.code == 3) << words[0] << ": " << outcome.err;
        EXPECT_TRUE(is_clean(outcome.out) && is_clean(outcome.err)) << words[0] << ": " << outcome.err;
        EXPECT_TRUE(outcome.one_line_of_error()) << words[0] << ": " << outcome.err;
    }
}

TEST(Usage, DeviceCheckLastsRequestedSeconds) {
    const TemporaryFolder folder;
    const std::string log = folder / "log.csv";
    std::ofstream(log) << "time_s,finger,x,y,z,buttons,age_ms,fx,fy,fz,force_on\n"
                          "0,0,0,0,0,0,0,0,0,0,0\n900,0,0,0,0,0,0,0,0,0,0\n";
    const auto json = json_of({"check", "--device", "recorded:" + log, "--seconds", "1", "--json"});
    EXPECT_EQ(json["readings"], 1000);
    EXPECT_GE(json["seconds"].get<double>(), 0.999) << "a reading is a millisecond, or late";
}

TEST(Usage, FailsOnFullStandardOutput) {
    const TemporaryFolder folder;
    const std::string clip = folder / "plane.mkv";
    succeed({"make", "plane", clip, "--size", "16x12", "--frames", "1"});
    succeed({"info", clip});
    for (const std::string& words : {"info " + clip, std::string("--version"), std::string("touch --help")}) {
        const std::string full = std::string(TOUCHABLE_PROGRAM) + ' ' + words + " >/dev/full 2>/dev/null";
        EXPECT_EQ(WEXITSTATUS(std::system(full.c_str())), 3) << words;
    }
}

BuilderChoice::Load load_of(int width, int height, int median, FrameRate rate = {}) {
    BuilderChoice::Load load;
    load.scene = must(make_scene("moving", {.width = width, .height = height, .rate = rate}))->scene();
    load.scene.filter.median = median;
    return load;
}

/// A GPU is asked for where frames cost a fifth of a core, and sooner where they are drawn there.
TEST(BuilderPick, FitsLoad) {
    const BuilderChoice::Load uhd = load_of(3840, 2160, 5, {60, 1});
    BuilderChoice::Load drawn = load_of(1920, 1080, 3), still = drawn;
    drawn.drawn = still.drawn = true;
    still.moves = false;
    for (const BuilderChoice::Load& load : {uhd, drawn}) {
        EXPECT_EQ(pick_builder(load, [] { return true; }).name, "vulkan");
        EXPECT_EQ(pick_builder(load, [] { return false; }).name, "cpu");
    }
    for (const BuilderChoice::Load& load :
         {still, load_of(1920, 1080, 3), load_of(320, 240, 5), load_of(3840, 2160, 5, {30, 1})})
        EXPECT_EQ(pick_builder(load,
                               [] {
                                   ADD_FAILURE() << "a GPU was asked for";
                                   return false;
                               })
                      .name,
                  "cpu");
}

TEST(BuilderPick, MeasurementDecidesGpuSpeed) {
    GpuFacts facts;
    facts.kind = GpuKind::discrete;
    EXPECT_TRUE(is_fast_builder(facts)) << "not measured";
    facts.measured = {.cpu_ms = 1, .vulkan_ms = 2};
    EXPECT_TRUE(is_fast_builder(facts));
    facts.measured.vulkan_ms = 2.1;
    EXPECT_FALSE(is_fast_builder(facts));
    facts.measured.vulkan_ms = HUGE_VAL;
    EXPECT_FALSE(is_fast_builder(facts)) << "wrong bits";
    facts.measured = {.cpu_ms = 1, .vulkan_ms = 0.1};
    facts.kind = GpuKind::software;
    EXPECT_FALSE(is_fast_builder(facts));
}

TEST(BuilderPick, ReportsChoiceAndKeepsForces) {
    const TemporaryFolder folder;
    make_clip("moving", folder / "clip.mkv", {"--size", "1280x720", "--frames", "2"});
    const auto run = [&](std::vector<std::string> words) {
        words.insert(words.begin(), {folder / "clip.mkv", "--seconds", "0.1", "--median", "5"});
        return touch(words);
    };
    const auto by_choice = run({}), cpu = run({"--builder", "cpu"});
    EXPECT_EQ(by_choice["builder"], "cpu");
    EXPECT_PRED2(says, by_choice["builder_why"].get<std::string>(), "of CPU time a second");
    EXPECT_EQ(cpu["builder_why"], "");
    EXPECT_EQ(by_choice["force_hash"], cpu["force_hash"]);
}

// The verdict of `touchable check` on its measurements.

/// Everywhere alike, and easily fast enough: 10 + 2 ms of 33.3, 20 us of 1000, and of 2000 ms of CPU time a
/// second 30 x 24 + 30.
TrialFigures easy() {
    TrialFigures figures;
    figures.builder = "cpu";
    figures.decode_ms = {10, 10, 10, 10, 10};
    figures.build_ms = {2, 2, 2, 2, 2};
    figures.tick_us = {20, 20, 20, 20, 20};
    figures.frame_cpu_ms = 24;
    figures.tick_cpu_us = 30;
    figures.frames = 10;
    figures.ticks = 1000;
    return figures;
}
const TouchDemand demand{1920, 1080, 5, 30};

std::string refusal(const TrialFigures& figures, const TouchDemand& asked = demand, int cores = 2) {
    const TrialVerdict verdict = judge(asked, figures, cores);
    EXPECT_FALSE(verdict.can);
    EXPECT_LT(verdict.most_rate, asked.rate);
    return verdict.why;
}

TEST(TrialVerdict, IsYesWhenAllFits) {
    const TrialVerdict verdict = judge(demand, easy(), 2);
    EXPECT_TRUE(verdict.can) << verdict.why;
    EXPECT_EQ(verdict.why, "all of it takes 750 of the 1800 ms of CPU time a second it may");
    // 1800 ms less those of 1000 ticks, by 24 a frame; decoding alone would reach 90.
    EXPECT_EQ(verdict.most_rate, 73);
    EXPECT_EQ(judge({1920, 1080, 5, 73}, easy(), 2).can, true);
    EXPECT_EQ(judge({1920, 1080, 5, 74}, easy(), 2).can, false);
}

TEST(TrialVerdict, NamesSlowPart) {
    TrialFigures slow = easy();
    slow.decode_ms.mean = 31;
    EXPECT_EQ(refusal(slow), "decoding a frame takes 31 of the 30 ms it may");
    slow = easy();
    slow.build_ms.mean = 45;
    EXPECT_EQ(refusal(slow), "building a frame takes 45 of the 30 ms it may");
    slow = easy();
    slow.tick_us.p99 = 950;
    EXPECT_EQ(refusal(slow), "a tick takes 950 of the 900 us it may");
    EXPECT_EQ(judge(demand, slow, 2).most_rate, 0) << "slower frames do not help";
    EXPECT_EQ(refusal(easy(), {1920, 1080, 5, 80}).rfind("all of it takes 1950 of the 1800", 0), 0U);
    // The same work on more cores is bound by the one that decodes.
    EXPECT_TRUE(judge({1920, 1080, 5, 80}, easy(), 4).can);
    EXPECT_EQ(judge(demand, easy(), 4).most_rate, 90);
}

TEST(TrialVerdict, PrecedesFigures) {
    const auto text = [](const TrialFigures& figures) {
        return trial_to_text(demand, figures, judge(demand, figures, 2), 2);
    };
    EXPECT_EQ(text(easy()).rfind("yes: 1920x1080 at 30 frames/s with 5 fingers; ", 0), 0U) << text(easy());
    TrialFigures slow = easy();
    slow.decode_ms.mean = 61;
    EXPECT_EQ(
        text(slow).rfind("no: 1920x1080 at 30 frames/s with 5 fingers is too much here; decoding a frame "
                         "takes 61 of the 30 ms it may\n",
                         0),
        0U)
        << text(slow);
    EXPECT_PRED2(says, text(slow), "at most   14 frames/s");
    EXPECT_PRED2(says, text(slow), "other programs kept the cores busy") << "61 ms for 24";
    EXPECT_FALSE(says(text(easy()), "other programs"));
}

TEST(RealtimeAdvice, NamesUserAndProgram) {
    const auto ways = ways_to_realtime("ada", "/usr/bin/touchable");
    for (const char* part : {"ada - rtprio 80", "setcap cap_sys_nice,cap_ipc_lock=ep /usr/bin/touchable",
                             "LimitRTPRIO=80", "--cap-add=SYS_NICE"})
        EXPECT_TRUE(std::any_of(ways.begin(), ways.end(), [part](const std::string& way) {
            return says(way, part);
        })) << part;
}

TEST(KernelFacts, UseRunsWithTimes) {
    const KernelRun timed{2, 0.5, true}, untimed{1, std::nullopt, true};
    EXPECT_EQ(facts_of(untimed, std::array{untimed, timed, untimed}).least_device_ms, 0.5)
        << "the first has none";
    EXPECT_EQ(facts_of(timed, std::array{untimed}).least_device_ms, 0.5);
    EXPECT_EQ(facts_of(untimed, std::array{untimed}).least_device_ms, std::nullopt);
    const KernelFacts facts = facts_of({9, 3, true}, std::array{timed, untimed, KernelRun{7, 0.25, false}});
    EXPECT_EQ(facts.first_ms, 9);
    EXPECT_EQ(facts.least_ms, 1);
    EXPECT_EQ(facts.p50_ms, 2);
    EXPECT_EQ(facts.least_device_ms, 0.25);
    EXPECT_FALSE(facts.same_bits);
}

// The reported losses, against numbers worked out by hand.

PlaneView row_of(const std::vector<std::uint8_t>& samples) {
    return {samples.data(), std::ssize(samples), static_cast<int>(samples.size()), 1, 1, 1};
}

TEST(PlaneLoss, MeasuresLargestAndMeanSquare) {
    Scene scene;
    scene.width = 4;
    scene.height = 1;
    scene.metres_per_unit = 0.01;
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.scale = 2;
    scene.depth.far = 2 * 200;
    scene.depth.invalid_code_count = 1;  // 0
    derive_valid_range(scene.depth);
    const std::vector<std::uint8_t> before{10, 20, 0, 40}, now{13, 20, 7, 36}, gone{10, 0, 0, 40};
    RawFrame a, b, c;
    a.depth = row_of(before);
    b.depth = row_of(now);
    c.depth = row_of(gone);
    PlaneLosses losses{};
    add_loss(a, a, scene, losses);
    EXPECT_EQ(losses[0].samples, 4);
    EXPECT_EQ(losses[0].changed, 0);
    add_loss(a, b, scene, losses);
    EXPECT_EQ(losses[0].samples, 8);
    EXPECT_EQ(losses[0].changed, 3);
    EXPECT_EQ(losses[0].largest, 7);
    EXPECT_DOUBLE_EQ(losses[0].squares, 9 + 49 + 16);
    EXPECT_EQ(losses[0].pixels, 3);
    EXPECT_DOUBLE_EQ(losses[0].largest_metres, 4 * 2 * 0.01);
    EXPECT_DOUBLE_EQ(losses[0].squares_metres, (36 + 64) * 1e-4);
    EXPECT_EQ(losses[0].appeared, 1);
    EXPECT_EQ(losses[0].disappeared, 0);
    add_loss(a, c, scene, losses);
    EXPECT_EQ(losses[0].disappeared, 1);

    // A pixel 3 right of the middle with f = 4: depth along the axis is 4/5 of that along the ray.
    scene.camera = {4, 4, 0, 0};
    scene.depth.semantics = DepthSemantics::range;
    Scene planar = scene;
    planar.depth.semantics = DepthSemantics::planar;
    const std::vector<std::uint8_t> ray{0, 0, 0, 50}, axis{0, 0, 0, 41};
    a.depth = row_of(ray);
    b.depth = row_of(axis);
    PlaneLosses turned{};
    add_recoded_loss(a, scene, b, planar, turned);
    EXPECT_NEAR(turned[0].largest_metres, (41 - 50 * 0.8) * 2 * 0.01, 1e-12);
}

TEST(PlaneLoss, ComparesSmallerPictureByPixel) {
    Scene scene;
    scene.depth.near = 1;
    scene.depth.far = 2;
    const std::vector<std::uint8_t> before{10, 20, 30, 44}, now{20, 44};
    RawFrame a, b;
    a.depth = row_of(before);
    b.depth = row_of(now);
    PlaneLosses losses{};
    add_loss(a, b, scene, losses);
    EXPECT_EQ(losses[0].changed, 2);
    EXPECT_EQ(losses[0].largest, 14);
    EXPECT_DOUBLE_EQ(losses[0].rms(), std::sqrt((100 + 196) / 4.0));
}

TEST(Pace, PrintsRateAndTimeLeft) {
    EXPECT_EQ(pace_in_words(50, 100, 0.9), "");
    EXPECT_EQ(pace_in_words(0, 100, 2), "");
    EXPECT_EQ(pace_in_words(50, 100, 2), ", 25/s, 2 s left");
    EXPECT_EQ(pace_in_words(10, 100, 4), ", 2.5/s, 36 s left");
    EXPECT_EQ(pace_in_words(10, 1000, 10), ", 1.0/s, 17 min left");
    EXPECT_EQ(pace_in_words(10, 100'000, 10), ", 1.0/s, 28 h left");
    EXPECT_EQ(pace_in_words(50, 0, 2), ", 25/s");
    EXPECT_EQ(pace_in_words(100, 100, 2), ", 50/s");
}

// How the program names the settings that the rooms below it speak of.

TEST(SettingWords, ReplaceNameWithOption) {
    const std::pair<Error, const char*> cases[] = {
        {usage_error("a.mkv: is empty"), "a.mkv: is empty"},
        {usage_error("damping must be 0 to 100 N s/m", {{Setting::damping}}),
         "--damping must be 0 to 100 N s/m"},
        {usage_error("a.png: damping must be 0 to 100 N s/m", {{Setting::damping}}),
         "a.png: damping must be 0 to 100 N s/m (--damping)"},
        {usage_error("dampings differ", {{Setting::damping}}), "dampings differ (--damping)"},
        {usage_error("CLIP is gone", {{Setting::clip}}), "CLIP is gone (CLIP)"},
        {usage_error("camera needs a live run", {{Setting::camera}, {Setting::live}}),
         "--camera needs a live run (--live)"},
        {usage_error("say how long a stored 1 is", {{Setting::depth_unit, "0.001"}, {Setting::preset}}),
         "say how long a stored 1 is (--depth-unit 0.001, --preset)"}};
    for (const auto& [error, words] : cases) EXPECT_EQ(message_with_options(error), words);
    const Error at_place = error_at("a.mkv", input_error("is empty", {{Setting::scene_file, "FILE"}}));
    EXPECT_EQ(at_place.kind, ErrorKind::input);
    EXPECT_EQ(message_with_options(at_place), "a.mkv: is empty (--scene FILE)");
    const auto knows_none = [](const std::string&) { return false; };
    EXPECT_EQ(message_with_options(at_place, knows_none), "a.mkv: is empty") << "a command without --scene";
    EXPECT_EQ(message_with_options(usage_error("CLIP is gone", {{Setting::clip}}), knows_none),
              "CLIP is gone (CLIP)");
    const Error in_brackets = usage_error("none (there are 2)", {{Setting::scene_file, "FILE"}});
    EXPECT_EQ(message_with_options(in_brackets), "none (there are 2; --scene FILE)");
}

TEST(SettingWords, NameOptionsThatOverrideGuess) {
    const std::pair<Remark, const char*> cases[] = {
        {{"wide", true, "", {{Setting::field_of_view}, {Setting::intrinsics}}},
         "guessed: wide (--fov DEGREES or --intrinsics FX,FY,CX,CY says otherwise)"},
        {{"a code is 1 mm", true, "0.0001 m of a D405", {{Setting::depth_unit}}},
         "guessed: a code is 1 mm (0.0001 m of a D405: --depth-unit METRES)"},
        {{"wide", true, "a scene file's camera says otherwise"},
         "guessed: wide (a scene file's camera says otherwise)"},
        {{"wide", true}, "guessed: wide (--scene FILE says otherwise)"},
        {{"as camera.json says", false, "", {{Setting::intrinsics}}},
         "as camera.json says (--intrinsics FX,FY,CX,CY says otherwise)"},
        {{"recorded by hand"}, "recorded by hand"}};
    for (const auto& [remark, words] : cases) EXPECT_EQ(remark_with_options(remark), words);
    EXPECT_EQ(remark_in_words(cases[0].first), "guessed: wide (a scene file says otherwise)");
    EXPECT_EQ(remark_text(cases[0].first), "guessed: wide") << "as a scene file keeps it";
}

TEST(SettingWords, PrintOptionsAsTyped) {
    EXPECT_EQ(typed_options({{Setting::intrinsics, "525,525"}, {Setting::headless}}),
              " --intrinsics 525,525 --headless");
    EXPECT_EQ(typed_options({}), "");
}

TEST(SettingWords, NoiseNeedsThreeFrames) {
    MeasuredDepth measured;
    measured.frames = 2;
    EXPECT_TRUE(noise_in_words(measured, 1).starts_with("not known of fewer than 3 frames; "));
    measured.frames = 3;
    EXPECT_TRUE(noise_in_words(measured, 1).starts_with("none found; "));
}

TEST(SettingWords, StiffnessRisesPerSecond) {
    const auto slew = std::ranges::find(run_settings(), "stiffness-slew", &SessionSetting::name);
    ASSERT_NE(slew, run_settings().end());
    SessionOptions options;
    slew->set(5, options);
    EXPECT_DOUBLE_EQ(options.guard.rise.per_tick, 5) << "5 N/mm per second are 5 N/m per millisecond";
}

/// A program that is asked to stop by each of `signals`, the last one so much after the others.
[[noreturn]] void be_asked(std::initializer_list<int> signals, std::chrono::milliseconds last_after) {
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, SIG_DFL);
    catch_interrupts();
    if (stop_requested()) std::_Exit(1);
    int left = static_cast<int>(signals.size());
    for (const int signal : signals) {
        if (--left == 0) std::this_thread::sleep_for(last_after);
        std::raise(signal);
    }
    std::_Exit(stop_requested() ? 0 : 1);
}

using std::chrono::milliseconds;

TEST(InterruptDeathTest, SimultaneousSignalsCountOnce) {
    EXPECT_EXIT(be_asked({SIGINT}, milliseconds(0)), ::testing::ExitedWithCode(0), "");
    EXPECT_EXIT(be_asked({SIGINT, SIGINT, SIGINT}, milliseconds(0)), ::testing::ExitedWithCode(0), "");
    EXPECT_EXIT(be_asked({SIGINT, SIGTERM, SIGHUP}, milliseconds(0)), ::testing::ExitedWithCode(0), "");
}

TEST(InterruptDeathTest, LaterSignalEndsProgram) {
    EXPECT_EXIT(be_asked({SIGINT, SIGINT}, same_wish), ::testing::KilledBySignal(SIGINT), "");
    EXPECT_EXIT(be_asked({SIGINT, SIGTERM}, same_wish), ::testing::KilledBySignal(SIGTERM), "");
}

// A hand that holds a device: where its goals are once forces push back. No clock takes part.

/// Means its fingers to be 10 units apart, moved along by one unit at tick 100.
class StillHand final : public Hand {
public:
    int fingers() const override { return 2; }
    void goals_at(std::int64_t tick, const SurfaceProbe&, std::span<glm::dvec3> goals) override {
        const double along = tick < 100 ? 0 : 1;
        goals[0] = {along, 0, -1000};
        goals[1] = {along + 10, 0, -1000};
    }
};

class HeldDevice : public ::testing::Test {
protected:
    HeldDevice() : content_(std::move(make_scene("plane", {.width = 16, .height = 12})).value()) {
        exact_frame(*content_, 0, frame_);
        pair_.prev = pair_.next = {0, 0, &frame_};
        EXPECT_TRUE(device_.open());
    }
    bool read(std::int64_t tick) { return port_->read_goals(tick, {content_->scene(), pair_}, goals_); }

    std::unique_ptr<AnalyticScene> content_;
    SurfaceFrame frame_;
    FramePair pair_;
    StillHand hand_;
    SimulatedDevice device_{
        2, {.max_force = 8, .max_stiffness = 2000}, {.damping = 20, .hand_stiffness = 250}};
    std::unique_ptr<HapticPort> port_ = make_port(hand_, device_, {0.001, {0, 0, -1000}});
    std::array<glm::dvec3, 2> goals_{};
};

TEST_F(HeldDevice, FollowsHand) {
    ASSERT_TRUE(read(0));
    EXPECT_EQ(goals_[0], glm::dvec3(0, 0, -1000));
    EXPECT_EQ(goals_[1], glm::dvec3(10, 0, -1000));
    for (int tick = 1; tick <= 101; ++tick) ASSERT_TRUE(read(tick));
    EXPECT_GT(goals_[0].x, 0) << "on its way";
    EXPECT_LT(goals_[0].x, 0.1) << "but not there at once";
    for (int tick = 102; tick <= 1500; ++tick) ASSERT_TRUE(read(tick));
    EXPECT_NEAR(goals_[0].x, 1, 1e-6);
    EXPECT_NEAR(goals_[1].x, 11, 1e-6);
}

TEST_F(HeldDevice, YieldsToItsFingersForce) {
    const std::array forces{glm::dvec3(0, 0, 0.5), glm::dvec3(0)};
    for (int tick = 0; tick < 90; ++tick) {
        ASSERT_TRUE(read(tick));
        ASSERT_TRUE(port_->write_forces(forces));
    }
    // 2 mm in the end, of a hand of 250 N/m; on the way there.
    EXPECT_GT(goals_[0].z, -999);
    EXPECT_LT(goals_[0].z, -998);
    EXPECT_EQ(goals_[1], glm::dvec3(10, 0, -1000));
}

TEST_F(HeldDevice, SkippedTicksAdvanceHandle) {
    const std::array forces{glm::dvec3(0, 0, 0.5), glm::dvec3(0)};
    ASSERT_TRUE(read(0));
    ASSERT_TRUE(port_->write_forces(forces));
    ASSERT_TRUE(read(30));
    const double once = goals_[0].z;
    SimulatedDevice other(2, device_.limits(), {.damping = 20, .hand_stiffness = 250});
    ASSERT_TRUE(other.open());
    const auto port = make_port(hand_, other, {0.001, {0, 0, -1000}});
    for (int tick = 0; tick <= 30; ++tick) {
        ASSERT_TRUE(port->read_goals(tick, {content_->scene(), pair_}, goals_));
        ASSERT_TRUE(port->write_forces(forces));
    }
    EXPECT_EQ(goals_[0].z, once);
}

TEST_F(HeldDevice, ReportsFailure) {
    ASSERT_TRUE(read(0));
    device_.fail("was unplugged");
    EXPECT_FALSE(read(1));
    EXPECT_FALSE(port_->write_forces(goals_));
}

std::vector<std::string> split(const std::string& text, char between) {
    std::vector<std::string> parts;
    std::istringstream in(text);
    for (std::string part; std::getline(in, part, between);) parts.push_back(part);
    return parts;
}

/// A line of `touchable --list-options`.
struct Option {
    std::string topic, names, value;
    std::vector<std::string> words;
};
struct Table {
    std::map<std::string, std::vector<Option>> options;  ///< of each command; "": of the program
    std::map<std::string, std::vector<std::string>> examples;
};

const Table& table() {
    static const Table read = [] {
        Table all;
        for (const std::string& line : split(run_touchable({"--list-options"}).out, '\n')) {
            const auto fields = split(line, '\t');
            if (fields[0] == "option")
                all.options[fields.at(1)].push_back(
                    {fields.at(2), fields.at(3), fields.at(4), split(fields.at(5), ',')});
            if (fields[0] == "example") all.examples[fields.at(1)].push_back(fields.at(2));
        }
        all.options.erase("touchable");
        return all;
    }();
    return read;
}

std::vector<std::string> lines_of(const std::vector<std::string>& words) {
    const Outcome run = succeed(words);
    return split(run.out, '\n');
}

/// The heads of the entries: "-h, --help", "--scene FILE".
std::vector<std::string> heads_of(const std::vector<std::string>& lines) {
    std::vector<std::string> heads;
    for (const std::string& line : lines)
        if (line.starts_with("  ") && line.size() > 2 && line[2] != ' ')
            heads.push_back(line.substr(2, line.find("  ", 2) - 2));
    return heads;
}

TEST(Help, IsShort) {
    ASSERT_GT(table().options.size(), 10U);
    for (const char* command :
         {"play", "touch", "export", "convert", "info", "make", "serve", "init-scene", "relief", "materials"})
        EXPECT_EQ(table().examples.at(command).size(), 2U) << command;
    for (const auto& [command, options] : table().options) {
        const auto lines = lines_of({command, "-h"});
        EXPECT_LE(lines.size(), 25U) << command;
        for (const std::string& line : lines) EXPECT_LE(line.size(), 80U) << command << ": " << line;
        EXPECT_EQ(lines, lines_of({"help", command}));
    }
}

TEST(Help, ExamplesParse) {
    for (const auto& [command, examples] : table().examples)
        for (const std::string& example : examples) {
            const TemporaryFolder folder;  // without the files that the example reads
            std::istringstream in(example.substr(0, example.find('#')));
            std::vector<std::string> words;
            for (std::string word; in >> word;) words.push_back(word);
            ASSERT_EQ(words.at(0), "touchable") << example;
            ASSERT_EQ(words.at(1), command) << example;
            words.erase(words.begin());
            if (command == "make") words.insert(words.end(), {"--size", "16x12", "--frames", "1"});
            // The camera of an example may be plugged in.
            if (command == "play") words.insert(words.end(), {"--headless", "--seconds", "1"});
            if (command == "serve") words.insert(words.end(), {"--seconds", "1"});
            const Outcome run = run_in_folder(words, folder.path());
            EXPECT_NE(run.code, 2) << example << ": " << run.err;
            EXPECT_TRUE(run.code == 0 || run.one_line_of_error()) << example << ": " << run.err;
        }
}

TEST(Help, AllListsEveryOptionOnce) {
    for (const auto& [command, options] : table().options) {
        const auto lines = lines_of({command, "--help-all"});
        EXPECT_EQ(lines, lines_of({"help", command, "all"}));
        const auto heads = heads_of(lines);
        std::set<std::string> topics;
        for (const Option& option : options) {
            const std::string head = option.names + (option.value.empty() ? "" : " " + option.value);
            EXPECT_EQ(std::ranges::count(heads, head), 1) << command << ' ' << head;
            topics.insert(option.topic);
        }
        EXPECT_EQ(heads.size(), options.size()) << command;
        std::size_t found = 0;
        for (const std::string& topic : topics)
            found += heads_of(lines_of({command, "--help", topic})).size();
        EXPECT_EQ(found, options.size()) << command;
        for (const std::string& line : lines) {
            EXPECT_LE(line.size(), 80U) << command << ": " << line;
            for (const char* noise :
                 {"Excludes:", "Needs:", "TEXT", "FLOAT", "REQUIRED", "{", "->", "ENUM", "VALUE IN"})
                EXPECT_EQ(line.find(noise), std::string::npos) << command << ": " << line;
        }
    }
    const auto& play = table().options.at("play");
    EXPECT_GT(play.size(), 50U);
    EXPECT_EQ(std::ranges::find(play, "--screenshot", &Option::names)->topic, "Files");
    EXPECT_PRED2(says, run_touchable({"play", "--help-all"}).out, "after so many seconds\n");
    EXPECT_GT(table().options.at("touch").size(), 50U);
}

TEST(Help, FitsTerminal) {
    const auto widest = [](const std::string& text) {
        std::size_t most = 0;
        for (const std::string& line : split(text, '\n')) most = std::max(most, line.size());
        return most;
    };
    const std::string wide = run_on_screen({"touch", "--help-all"}, 120).out;
    EXPECT_GT(widest(wide), 100U);
    EXPECT_LE(widest(wide), 120U);
    EXPECT_LE(widest(run_on_screen({"touch", "-h"}, 70).out), 70U);
    setenv("COLUMNS", "100", 1);
    const std::string heard = run_touchable({"touch", "--help-all"}).out;
    unsetenv("COLUMNS");
    EXPECT_GT(widest(heard), 80U);
    EXPECT_LE(widest(heard), 100U);
}

TEST(Help, UnknownTopicListsTopics) {
    for (const std::vector<std::string>& words :
         {std::vector<std::string>{"play", "--help", "weather"}, {"help", "play", "weather"}}) {
        const Outcome run = expect_failure(words, 2);
        for (const char* right : {"weather", "camera", "kiosk", "all"}) EXPECT_PRED2(says, run.err, right);
    }
    EXPECT_EQ(run_touchable({"play", "--help", "Camera"}).out, run_touchable({"help", "play", "camera"}).out);
    EXPECT_PRED2(says, run_touchable({"cameras", "--help", "x"}).err, "must be one of options, all\n");
    EXPECT_EQ(run_touchable({"touch", "--help", "--live"}).out, run_touchable({"touch", "--help"}).out);
}

TEST(Help, ListsAllowedWords) {
    const TemporaryFolder folder;
    const std::string clip = folder / "plane.mkv";
    succeed({"make", "plane", clip, "--size", "16x12", "--frames", "1"});
    std::size_t lists = 0;
    for (const auto& [command, options] : table().options)
        for (const Option& option : options) {
            std::string shown;
            for (const std::string& word : option.words) shown += (shown.empty() ? "" : "|") + word;
            const bool has_only_words = option.value == "WORD" || option.value == shown;
            if (option.words.empty() || (!has_only_words && option.names != "--preset")) continue;
            const Outcome run = expect_failure({command, clip, option.names, "nonsense"}, 2, "nonsense");
            for (const std::string& word : option.words)
                EXPECT_PRED2(says, run.err, word) << option.names << ": " << run.err;
            ++lists;
        }
    EXPECT_GT(lists, 20U);
    for (const Option& option : table().options.at("touch"))
        if (option.names == "--hand" || option.names == "--device")
            for (const std::string& word : option.words) {
                const Outcome run = run_touchable({"touch", clip, "--live", option.names, "nonsense"});
                EXPECT_PRED2(says, run.err, word.substr(0, word.find(':')));
                if (option.names == "--hand" && word.find(':') == std::string::npos) {
                    succeed({"touch", clip, "--seconds", "0.01", "--hand", word});
                }
            }
}

}  // namespace
}  // namespace touchable::test
