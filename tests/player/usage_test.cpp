#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "tests/player/program.hpp"

namespace touchable::test {
namespace {

TEST(Usage, WithoutArgumentsSaysWhatItCanDoOnHalfAScreen) {
    const Outcome run = run_touchable({});
    EXPECT_EQ(run.code, 0);
    for (const char* command : {"make", "info", "export", "check"})
        EXPECT_NE(run.out.find(command), std::string::npos) << command;
    EXPECT_LE(std::count(run.out.begin(), run.out.end(), '\n'), 16);
    EXPECT_NE(run.out.find("touchable FILE opens a window"), std::string::npos) << run.out;
    EXPECT_LT(run.out.find("\n  touch "), run.out.find("\n  cameras, devices ")) << run.out;
    EXPECT_LT(run.out.find("\n  cameras, devices "), run.out.find("\n  info ")) << run.out;
    EXPECT_EQ(run.err, "");
}

TEST(Usage, HelpAndVersionAreNoErrors) {
    const Outcome help = run_touchable({"--help"});
    EXPECT_EQ(help.code, 0);
    EXPECT_NE(help.out.find("touchable FILE opens a window"), std::string::npos) << help.out;
    EXPECT_LT(help.out.find("\n  cameras "), help.out.find("\n  serve ")) << help.out;
    EXPECT_EQ(run_touchable({"-h"}).out, help.out);
    EXPECT_EQ(run_touchable({"--version"}).code, 0);
    for (const char* command : {"make", "info", "export", "check"}) {
        const Outcome run = run_touchable({command, "-h"});
        EXPECT_EQ(run.code, 0) << command;
        EXPECT_NE(run.out.find(command), std::string::npos);
    }
}

TEST(Usage, HelpIsACommandToo) {
    EXPECT_EQ(run_touchable({"help"}).out, run_touchable({}).out);
    for (const char* command :
         {"make", "play", "touch", "info", "export", "convert", "compare", "plot", "check"}) {
        const Outcome run = run_touchable({"help", command});
        EXPECT_EQ(run.code, 0) << run.err;
        EXPECT_EQ(run.out, run_touchable({command, "-h"}).out);
    }
    for (const std::vector<std::string>& words :
         {std::vector<std::string>{"help", "paint"}, {"help", "touch", "hand", "too"}}) {
        const Outcome run = run_touchable(words);
        EXPECT_EQ(run.code, 2);
        EXPECT_TRUE(run.one_line_of_error()) << run.err;
        EXPECT_NE(run.err.find("must be one of make, play, touch, cameras, devices, info"), std::string::npos)
            << run.err;
    }
}

TEST(Usage, VersionIsSaidUnderBothNames) {
    const Outcome run = run_touchable({"-V"});
    EXPECT_EQ(run.code, 0);
    EXPECT_EQ(run.out.rfind("touchable ", 0), 0U) << run.out;
    EXPECT_EQ(run.out, run_touchable({"--version"}).out);
}

TEST(Usage, WholeNumbersAreDecimal) {
    const TemporaryFolder folder;
    const std::string clip = folder / "plane.mkv";
    ASSERT_EQ(
        run_touchable({"make", "plane", clip, "--size", "16x12", "--frames", "1", "--bits", "010"}).code, 0);
    EXPECT_NE(run_touchable({"info", clip, "--json"}).out.find("1023"), std::string::npos) << "ten bits";
    const Outcome ten =
        run_touchable({"touch", clip, "--seconds", "0.01", "--fingers", "010", "--json", "-"});
    EXPECT_EQ(ten.code, 0) << ten.err;
    EXPECT_NE(ten.out.find("\"fingers\": 10"), std::string::npos) << ten.out;
    for (const char* option : {"--fingers", "--median", "--fill-holes"})
        for (const char* number : {"0x3", "3.0", "3 ", ""}) {
            const Outcome run = run_touchable({"touch", clip, "--seconds", "0.01", option, number});
            EXPECT_EQ(run.code, 2) << option << ' ' << number;
            EXPECT_TRUE(run.one_line_of_error()) << run.err;
        }
}

TEST(Usage, NumbersAreFiniteAndInTheirRange) {
    const std::vector<std::vector<std::string>> options{
        {"info", "--fov", "179"},     {"info", "--depth-unit", "1e+06"}, {"touch", "--rate", "8"},
        {"touch", "--seconds", "1e"}, {"touch", "--damping", "number"},  {"touch", "--start", "1e+06"},
        {"play", "--at", "1e+06"},    {"play", "--hand-scale", "100"},   {"touch", "--max-force", "number"}};
    for (const auto& option : options)
        for (const char* number : {"nan", "-nan", "inf", "1e999", "1x"}) {
            const Outcome run = run_touchable({option[0], "clip.mkv", option[1] + '=' + number});
            EXPECT_EQ(run.code, 2) << option[1] << ' ' << number;
            EXPECT_NE(run.err.find(option[1] + ": " + number + " is not allowed; must be a number"),
                      std::string::npos)
                << run.err;
            EXPECT_NE(run.err.find(option[2]), std::string::npos) << run.err;
        }
}

TEST(Usage, ACommaInANumberIsToldThatAPointIsWanted) {
    const std::string wanted = "with a decimal point in place of the comma";
    EXPECT_NE(run_touchable({"info", "clip.mkv", "--fov", "62,5"}).err.find(wanted), std::string::npos);
    for (const char* number : {",5", "1,", "1,2,3", "one"})
        EXPECT_EQ(run_touchable({"info", "clip.mkv", "--fov", number}).err.find(wanted), std::string::npos)
            << number;
}

TEST(Usage, AFileWhoseNameBeginsLikeAnOptionIsToldHowToBeTyped) {
    const TemporaryFolder folder;
    std::ofstream(folder / "-x.png") << "?";
    EXPECT_NE(run_in_folder({"info", "-x.png"}, folder.path()).err.find("type ./-x.png"), std::string::npos);
}

TEST(Usage, HelpSpeaksOfWordsNotOfWhatTheyBecome) {
    for (const char* command : {"make", "info", "touch", "export", "check"}) {
        const std::string help = run_touchable({command, "--help-all"}).out;
        for (const char* internal : {"->", "ENUM", "VALUE IN", "{0"})
            EXPECT_EQ(help.find(internal), std::string::npos) << command << ": " << internal;
    }
}

TEST(Usage, EmptyNamesAreCode2) {
    const std::vector<std::vector<std::string>> wrong{{"info", ""},
                                                      {"info", "clip.mkv", "--scene", ""},
                                                      {"make", "plane", ""},
                                                      {"touch", ""},
                                                      {"touch", "clip.mkv", "--json", ""},
                                                      {"touch", "clip.mkv", "--forces", ""},
                                                      {"touch", "clip.mkv", "--record", ""},
                                                      {"touch", "clip.mkv", "--picture", ""},
                                                      {"touch", "--replay", ""},
                                                      {"export", "", "--frame", "0", "--out", "out"},
                                                      {"export", "clip.mkv", "--frame", "0", "--out", ""}};
    for (const auto& words : wrong) {
        const Outcome run = run_touchable(words);
        EXPECT_EQ(run.code, 2) << words[0] << ": " << run.err;
        EXPECT_TRUE(run.one_line_of_error()) << run.err;
        EXPECT_NE(run.err.find("names no file"), std::string::npos) << run.err;
    }
}

TEST(Usage, WrongWordsAreCode2AndOneLineThatNamesThem) {
    const std::vector<std::vector<std::string>> wrong{{"paint"},
                                                      {"info"},
                                                      {"info", "clip.mkv", "--colour"},
                                                      {"make", "globe"},
                                                      {"make", "globe", "out.mkv", "--frames", "many"},
                                                      {"export", "clip.mkv", "--out", "out"},
                                                      {"export", "clip.mkv", "--frame", "-1", "--out", "out"},
                                                      {"--nothing"}};
    for (const auto& words : wrong) {
        const Outcome run = run_touchable(words);
        EXPECT_EQ(run.code, 2) << words[0] << ": " << run.err;
        EXPECT_TRUE(run.one_line_of_error()) << run.err;
        EXPECT_EQ(run.out, "");
    }
    EXPECT_NE(run_touchable({"paint"}).err.find("paint"), std::string::npos);
}

TEST(Usage, MistypedWordsNameTheNearest) {
    EXPECT_NE(run_touchable({"tuoch", "clip.mkv"})
                  .err.find("unknown command or file 'tuoch' (did you mean touch?); see touchable -h"),
              std::string::npos);
    EXPECT_NE(run_touchable({"touch", "clip.mkv", "--figners", "3"}).err.find("did you mean --fingers?"),
              std::string::npos);
    EXPECT_NE(run_touchable({"paint", "--much"}).err.find("unknown command or file 'paint'; see"),
              std::string::npos);
    EXPECT_NE(run_touchable({"--nothing"}).err.find("unknown option '--nothing'"), std::string::npos);
    EXPECT_NE(run_touchable({"info", "clip.mkv", "more.mkv"}).err.find("unexpected word 'more.mkv'"),
              std::string::npos);
}

TEST(Usage, MissingValuesAndPartnersAreNamed) {
    const auto expect = [](const std::vector<std::string>& words, const std::string& message) {
        const Outcome run = run_touchable(words);
        EXPECT_EQ(run.code, 2);
        EXPECT_TRUE(run.one_line_of_error()) << run.err;
        EXPECT_NE(run.err.find(message), std::string::npos) << run.err;
    };
    expect({"touch", "clip.mkv", "--median"}, "--median needs a value: 0|3|5");
    expect({"touch", "clip.mkv", "--loop", "1"}, "--loop needs a value: FROM TO");
    expect({"play", "clip.mkv", "--at", "5"}, "--at needs --screenshot");
    expect({"info", "clip.mkv", "--fov", "60", "--intrinsics", "500,500"}, "does not go with");
}

TEST(Usage, FormatsTellsWhatToTypeFor) {
    const Outcome all = run_touchable({"formats"});
    EXPECT_EQ(all.code, 0);
    EXPECT_NE(all.out.find("\n  bop\n      BOP: depth/000000.png"), std::string::npos) << all.out;
    EXPECT_NE(all.out.find("      touchable play clip.mkv\n"), std::string::npos) << all.out;
    const Outcome one = run_touchable({"formats", "stray"});
    EXPECT_EQ(one.code, 0);
    EXPECT_NE(one.out.find("Stray Scanner"), std::string::npos) << one.out;
    EXPECT_NE(one.out.find("camera_matrix.csv"), std::string::npos) << one.out;
    EXPECT_NE(one.out.find("unit: metres that a stored 1 stands for (--depth-unit METRES)"),
              std::string::npos)
        << one.out;
    for (const std::string& out : {all.out, one.out}) {
        std::istringstream lines(out);
        for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80U) << line;
    }
    EXPECT_EQ(
        run_touchable({"formats", "relative-inverse"}).out,
        "  --preset relative-inverse\n      guessed from one picture (MiDaS and the like): 1/depth without a "
        "scale\n");
    const Outcome near = run_touchable({"formats", "tun"});
    EXPECT_EQ(near.code, 2);
    EXPECT_EQ(near.err, "touchable: formats: no source is called \"tun\"; did you mean tum?\n");
    const Outcome none = run_touchable({"formats", "nothing like it"});
    EXPECT_EQ(none.code, 2);
    EXPECT_NE(none.err.find("touchable formats lists them"), std::string::npos) << none.err;
}

TEST(Usage, MissingFileIsCode3AndNamesTheFile) {
    for (const std::vector<std::string>& words :
         {std::vector<std::string>{"info", "no-such-clip.mkv"},
          std::vector<std::string>{"export", "no-such-clip.mkv", "--frame", "0", "--out", "never"}}) {
        const Outcome run = run_touchable(words);
        EXPECT_EQ(run.code, 3);
        EXPECT_TRUE(run.one_line_of_error()) << run.err;
        EXPECT_NE(run.err.find("no-such-clip.mkv"), std::string::npos) << run.err;
    }
}

TEST(Usage, OutputThatCannotBeWrittenIsNoSuccess) {
    const TemporaryFolder folder;
    const std::string clip = folder / "plane.mkv";
    ASSERT_EQ(run_touchable({"make", "plane", clip, "--size", "16x12", "--frames", "1"}).code, 0);
    EXPECT_EQ(run_touchable({"info", clip}).code, 0);
    const std::string full = std::string(TOUCHABLE_PROGRAM) + " info " + clip + " >/dev/full 2>/dev/null";
    EXPECT_NE(std::system(full.c_str()), 0);
}

}  // namespace
}  // namespace touchable::test
