// What a run writes: never over what it reads, never two in one, whole or not at all.
#include <gtest/gtest.h>

#include <fstream>

#include "engine/base/files.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"

namespace touchable::test {
namespace {
namespace fs = std::filesystem;

using Words = std::vector<std::string>;

class Outputs : public ::testing::Test {
protected:
    Outputs() {
        make_clip("globe", clip(), {"--size", "48x32", "--frames", "2"});
        fs::create_directory(folder / "out");
    }
    std::string clip() const { return folder / "clip.mkv"; }
    std::string out(const std::string& name = "") const { return folder / ("out/" + name); }
    void expect_refused(const Outcome& run, const std::string& fragment) const {
        EXPECT_EQ(run.code, 2) << run.err;
        EXPECT_TRUE(run.one_line_of_error()) << run.err;
        EXPECT_NE(run.err.find(fragment), std::string::npos) << fragment << " is missing in: " << run.err;
    }

    TemporaryFolder folder;
};

/// A folder of pictures that is a clip; its files stay as they are.
class OutputsOfAFolder : public Outputs {
protected:
    OutputsOfAFolder() {
        EXPECT_EQ(run_touchable({"export", clip(), "--frame", "0", "--out", pictures()}).code, 0);
        for (const std::string& name : names_in(pictures())) before.push_back(read(name));
    }
    ~OutputsOfAFolder() override {
        std::size_t k = 0;
        for (const std::string& name : names_in(pictures())) EXPECT_EQ(read(name), before.at(k++)) << name;
        EXPECT_EQ(k, before.size());
    }
    std::string pictures() const { return folder / "pictures"; }
    std::string read(const std::string& name) const { return file_contents(pictures() + "/" + name); }
    std::vector<std::string> before;
};

TEST_F(OutputsOfAFolder, NeverReplaceAFileOfTheClip) {
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

TEST_F(OutputsOfAFolder, NeverReplaceAnInputByAnotherName) {
    fs::create_hard_link(pictures() + "/depth.png", folder / "hard.png");
    fs::create_symlink(pictures() + "/depth.png", folder / "soft.png");
    for (const char* name : {"hard.png", "soft.png"})
        expect_refused(
            run_touchable({"touch", pictures(), "--seconds", "0.1", "--overwrite", "--json", folder / name}),
            "is also a file of the clip");
}

TEST_F(Outputs, NeverReplaceAHandWhoseNameHoldsWhatBeginsItsKeys) {
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

TEST_F(Outputs, TwoNamesOfOneFileAreRefused) {
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

TEST_F(Outputs, ALinkToNowhereIsAFileThatIsThereAlready) {
    fs::create_symlink(folder / "nowhere", out("r.json"));
    const Words words{"touch", clip(), "--seconds", "0.1", "--json", out("r.json")};
    expect_refused(run_touchable(words), "--overwrite");
    Words replacing = words;
    replacing.emplace_back("--overwrite");
    ASSERT_EQ(run_touchable(replacing).code, 0);
    EXPECT_FALSE(fs::exists(folder / "nowhere")) << "a link is replaced, not followed";
    EXPECT_TRUE(nlohmann::json::accept(file_contents(out("r.json"))));
}

TEST_F(Outputs, AReaderThatGoesAwayTakesNoFileWithIt) {
    const Outcome run = run_unheard({"touch", clip(), "--seconds", "0.1", "--json", out("r.json"), "--forces",
                                     out("f.csv"), "--picture", out("p.png")});
    EXPECT_EQ(run.code, 0) << run.err;
    EXPECT_EQ(run.err, "");
    EXPECT_EQ(names_in(out()), (Words{"f.csv", "p.png", "r.json"}));
    EXPECT_EQ(nlohmann::json::parse(file_contents(out("r.json")))["ticks"], 100);
    for (const Words& words :
         {Words{"info", clip()}, {"touch", clip(), "--seconds", "0.1", "--forces", "-"}, {}})
        EXPECT_EQ(run_unheard(words).code, 0);
}

TEST_F(Outputs, StandardOutputGetsWhatAFileWould) {
    const Words run{"touch", clip(), "--seconds", "0.1", "--fingers", "2"};
    const auto with = [&](const Words& more) {
        Words words = run;
        words.insert(words.end(), more.begin(), more.end());
        return run_touchable(words);
    };
    ASSERT_EQ(with({"--forces", out("f.csv")}).code, 0);
    const Outcome forces = with({"--forces", "-"}), json = with({"--json", "-"});
    EXPECT_EQ(forces.code, 0);
    EXPECT_EQ(forces.out, file_contents(out("f.csv")));
    EXPECT_EQ(json.code, 0);
    EXPECT_EQ(nlohmann::json::parse(json.out)["ticks"], 100);
    for (const Outcome* outcome : {&forces, &json})
        EXPECT_NE(outcome->err.find("  verdict  "), std::string::npos)
            << "the table stands on the other stream";
    expect_refused(with({"--forces", "-", "--json", "-"}), "one of them can go to standard output");
    expect_refused(with({"--record", "-"}), "--record -");
    expect_refused(with({"--picture", "-"}), "does not end in .png");
    const Outcome of_that_name =
        run_in_folder({"touch", "clip.mkv", "--seconds", "0.1", "--json", "./-"}, folder.path());
    EXPECT_EQ(of_that_name.code, 0);
    EXPECT_TRUE(fs::exists(folder / "-"));
}

TEST_F(Outputs, APictureIsAPngByItsNameToo) {
    for (const char* name : {"p.jpg", "p", ".png"})
        expect_refused(run_touchable({"touch", clip(), "--picture", out(name)}), "does not end in .png");
    EXPECT_EQ(run_touchable({"export", clip(), "--frame", "0", "--picture", out("P.PNG")}).code, 0);
}

// What is not complete has no name, so that not even a kill leaves anything.
TEST_F(Outputs, AKilledRunLeavesNothing) {
    const Words runs[] = {{"touch", clip(), "--seconds", "100000", "--json", out("r.json"), "--forces",
                           out("f.csv"), "--record", out("r.rec"), "--picture", out("p.png")},
                          {"make", "noise", out("clip.mkv"), "--size", "640x480", "--frames", "100000"}};
    for (const Words& words : runs) {
        EXPECT_EQ(run_interrupted(words, out(), SIGKILL).code, -SIGKILL);
        EXPECT_EQ(names_in(out()), Words{}) << words[0];
    }
}

TEST_F(Outputs, AreWholeOnFileSystemsThatNameEveryFile) {
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

TEST_F(Outputs, AFolderThatCannotBeReplacedWholeStaysAsItWas) {
    const std::string frame = out("frame");
    ASSERT_EQ(run_touchable({"export", clip(), "--frame", "0", "--out", frame}).code, 0);
    fs::remove(frame + "/codes.png");
    fs::create_directories(frame + "/codes.png/mine");
    const Words before = names_in(frame);
    const std::string depth = file_contents(frame + "/depth.png"),
                      scene = file_contents(frame + "/scene.json");
    make_clip("noise", clip(), {"--size", "48x32", "--frames", "1"});
    const Outcome run = run_touchable({"export", clip(), "--frame", "0", "--out", frame, "--overwrite"});
    EXPECT_EQ(run.code, 3);
    EXPECT_TRUE(run.one_line_of_error()) << run.err;
    EXPECT_NE(run.err.find("codes.png"), std::string::npos) << run.err;
    EXPECT_EQ(names_in(frame), before);
    EXPECT_EQ(file_contents(frame + "/depth.png"), depth);
    EXPECT_EQ(file_contents(frame + "/scene.json"), scene);
    EXPECT_TRUE(fs::exists(frame + "/codes.png/mine"));
}

TEST(NewFile, KeepsAFileThatCameMeanwhile) {
    const TemporaryFolder folder;
    NewFile file(folder / "a", Existing::keep);
    std::ofstream(file.path()) << "ours";
    EXPECT_TRUE(names_in(folder.path()).empty());
    std::ofstream(folder / "a") << "theirs";
    const auto refused = file.commit();
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("is there by now"), std::string::npos);
    EXPECT_EQ(file_contents(folder / "a"), "theirs");
    EXPECT_EQ(names_in(folder.path()), Words{"a"});
}

TEST(NewFile, ReplacesALinkAndNotWhatItLeadsTo) {
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

TEST(NewFile, HiddenNamesAreNotForeseen) {
    EXPECT_NE(hidden_name("folder"), hidden_name("folder"));
    EXPECT_EQ(hidden_name("folder").parent_path(), "folder");
}

}  // namespace
}  // namespace touchable::test
