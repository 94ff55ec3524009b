// SPDX-License-Identifier: Apache-2.0
// A study by the program, as an experimenter starts it: participants with scripted hands.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "engine/picture/image.hpp"
#include "tests/window/scripted_window.hpp"

namespace touchable::test {
namespace {

// In a window of 640x400: the button of a page, that of a touch, and the fourth and second of five answers.
constexpr const char *page_button = "540 353", *strip_button = "590 372";
constexpr const char *fourth = "404 175", *second = "235 175";
constexpr PicturePart force_bar{14, 14, 90, 120};

using Row = std::map<std::string, std::string>;

class StudyWindow : public ::testing::Test {
protected:
    void SetUp() override {
        clip_ = (folder_ / "still.mkv").string();
        make_clip(clip_, "globe", 1, "160x120");
    }
    void write_study(const std::string& steps, const std::string& name = "small", double idle_s = 60) {
        std::ofstream(folder_ / "study.json")
            << R"({"touchable_study": 1, "name": ")" << name << R"(", "idle_s": )" << idle_s
            << R"(, "start": {"title": "A study", "text": "Begin"}, )" << steps << "}";
    }
    /// `name`: of the study and its conditions.
    void write_whole_study(const std::string& name = "", const char* question = "rough") {
        write_study(
            R"("before": [{"id": "trial", "kind": "touch", "text": "Try it"}], "conditions": [{"name": ")" +
                name + R"(force-on", "force": "on"}, {"name": ")" + name +
                R"(force-off", "force": "off"}],
               "in_each_condition": [{"id": "globe", "kind": "touch", "text": "Touch it"},
                {"id": "about", "kind": "questions", "questions": [{"id": ")" +
                question + R"(", "text": "It was rough.",
                 "scale": {"least": 1, "most": 5, "low": "no", "high": "yes"}}]}],
               "after": [{"id": "thanks", "kind": "text", "text": "Thank you", "most_s": 60}])",
            name + "small");
    }
    std::vector<std::string> words(const std::string& script, const std::vector<std::string>& more) const {
        std::ofstream(folder_ / "script") << script;
        return plus({"play", clip_, "--kiosk", "--study", folder_ / "study.json", "--results", results(),
                     "--headless", "--painter", painter_, "--size", "640x400", "--kiosk-texts", "en",
                     "--script", folder_ / "script"},
                    more);
    }
    std::filesystem::path results() const { return folder_ / "results"; }
    std::vector<Row> rows_of(const char* file) const {
        std::istringstream in(file_contents(results() / file));
        std::vector<std::string> names;
        std::vector<Row> rows;
        for (std::string line; std::getline(in, line);) {
            std::vector<std::string> fields(1);
            for (const char c : line) c == ',' ? void(fields.emplace_back()) : fields.back().push_back(c);
            if (names.empty()) {
                names = fields;
                continue;
            }
            EXPECT_EQ(fields.size(), names.size()) << line;
            Row& row = rows.emplace_back();
            for (std::size_t k = 0; k < std::min(fields.size(), names.size()); ++k) row[names[k]] = fields[k];
        }
        return rows;
    }
    static double number(const Row& row, const char* name) { return std::atof(row.at(name).c_str()); }

    const TemporaryFolder folder_;
    std::string clip_, painter_ = "cpu";
};

std::string click(const char* at, double time_s) {
    std::ostringstream words;
    words << time_s << " move " << at << "\n"
          << time_s + 0.1 << " press left\n"
          << time_s + 0.2 << " release left\n";
    return words.str();
}

std::string tap(const char* at, double time_s) {
    std::ostringstream words;
    words << time_s << " touch 1 " << at << "\n" << time_s + 0.15 << " touch-end 1\n";
    return words.str();
}

bool has_trial(const std::filesystem::path& file) {
    return std::filesystem::exists(file) && contains(file_contents(file), ",trial,");
}

/// Starts the program, and kills it as nothing can be minded.
void kill_once(const std::vector<std::string>& words, const std::function<bool()>& is_enough) {
    const pid_t child = start_touchable(words);
    ASSERT_GE(child, 0);
    comes_true(is_enough, 60'000);
    kill(child, SIGKILL);
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFSIGNALED(status)) << "it had ended by itself";
}

TEST_F(StudyWindow, GuidesParticipantToTheEnd) {
    write_whole_study();
    painter_ = "raster";  // so that what is written is in the pictures
    const auto shot = [&](const char* name) { return " screenshot " + (folder_ / name).string() + "\n"; };
    const std::string script =
        "0.4" + shot("first.png") + click(page_button, 0.6) +
        "1.8 key enter\n"                                       // begins; the trial
        "2.4 move 320 170\n2.6 press left\n3.2 move 326 170\n"  // with force
        "3.6" +
        shot("on.png") + "4 release left\n" + click(strip_button, 4.4) + "5.2 key 1\n" + click(fourth, 5.4) +
        "6" + shot("question.png") + "6.2 key enter\n" +
        "6.8 key f\n7 move 320 170\n7.2 press left\n7.8 move 326 170\n"  // without
        "8.2" +
        shot("off.png") + "8.6 release left\n9 key enter\n" + tap(second, 9.6) + tap(page_button, 10.2) +
        "11 key space\n11.8" + shot("start.png") + "12 quit\n";
    const auto played = run_touchable(words(script, {}));
    ASSERT_EQ(played.code, 0) << played.err;
    EXPECT_EQ(played.err, "");
    ASSERT_EQ(names_in(results()), std::vector<std::string>{"participant-001.csv"});
    const auto rows = rows_of("participant-001.csv");
    ASSERT_EQ(rows.size(), 7U) << file_contents(results() / "participant-001.csv");
    const struct {
        const char *condition, *place, *step, *question, *answer;
    } done[] = {{"", "", "trial", "", ""},
                {"force-on", "1", "globe", "", ""},
                {"force-on", "1", "about", "rough", "4"},
                {"force-off", "2", "globe", "", ""},
                {"force-off", "2", "about", "rough", "2"},
                {"", "", "thanks", "", ""},
                {"", "", "end", "", "finished"}};
    for (std::size_t k = 0; k < rows.size(); ++k) {
        EXPECT_EQ(rows[k].at("study"), "small");
        EXPECT_EQ(rows[k].at("participant"), "1");
        EXPECT_EQ(rows[k].at("language"), "en");
        EXPECT_EQ(rows[k].at("time").size(), 20U);
        EXPECT_EQ(rows[k].at("condition"), done[k].condition) << k;
        EXPECT_EQ(rows[k].at("place"), done[k].place) << k;
        EXPECT_EQ(rows[k].at("step"), done[k].step) << k;
        EXPECT_EQ(rows[k].at("question"), done[k].question) << k;
        EXPECT_EQ(rows[k].at("answer"), done[k].answer) << k;
        EXPECT_GT(number(rows[k], "seconds"), 0.3) << k;
    }
    EXPECT_EQ(rows[0].at("touches"), "0") << "no touch in the trial";
    for (const std::size_t k : {1U, 3U}) {
        EXPECT_GT(number(rows[k], "contact_s"), 0.3) << k;
        EXPECT_LT(number(rows[k], "contact_s"), number(rows[k], "seconds")) << k;
        EXPECT_GE(number(rows[k], "touches"), 1) << k;
        EXPECT_GT(number(rows[k], "mean_force_n"), 0.1) << "also where it is not shown";
        EXPECT_GE(number(rows[k], "max_force_n"), number(rows[k], "mean_force_n")) << k;
    }
    const auto image = [&](const char* name) { return *read_image(folder_ / name); };
    EXPECT_GT(differences(image("on.png"), image("off.png"), force_bar), 200)
        << "a force is shown, or none is";
    constexpr PicturePart page{40, 30, 600, 330};
    EXPECT_LT(differences(image("first.png"), image("start.png"), page), 100)
        << "the next participant does not find the start page";
    EXPECT_GT(differences(image("question.png"), image("start.png"), page), 2000) << "no question is shown";
}

TEST_F(StudyWindow, IsSilentWithoutForce) {
    const auto loudest = [&](const char* force) {
        write_study(std::string(R"("before": [{"id": "trial", "kind": "touch", "text": "Try", "force": ")") +
                    force + "\"}]");
        const std::string sound = (folder_ / (std::string(force) + ".wav")).string();
        const auto played =
            run_touchable(words("0.6 continue\n1.2 move 320 170\n1.4 press left\n1.6 move 380 170\n"
                                "1.8 move 300 170\n2 move 380 190\n2.2 move 300 170\n3 quit\n",
                                {"--sound", sound}));
        EXPECT_EQ(played.code, 0) << played.err;
        const std::string bytes = file_contents(sound);
        int most = 0;
        for (std::size_t k = 44; k + 1 < bytes.size(); k += 2) {
            std::int16_t sample = 0;
            std::memcpy(&sample, bytes.data() + k, sizeof sample);
            most = std::max(most, std::abs(int{sample}));
        }
        const bool is_on = std::string(force) == "on";
        const auto rows = rows_of(is_on ? "participant-001.partial.csv" : "participant-002.partial.csv");
        EXPECT_GE(number(rows.at(0), "touches"), 1);
        return most;
    };
    EXPECT_GT(loudest("on"), 100);
    EXPECT_LE(loudest("off"), 1);
}

TEST_F(StudyWindow, ReturnsToStartAfterIdle) {
    write_study(R"("before": [{"id": "trial", "kind": "touch", "text": "Try it"},
                              {"id": "more", "kind": "text", "text": "More"}])",
                "small", 1);
    const auto played = run_touchable(words("0.6 key enter\n6 key enter\n6 quit\n", {}));
    ASSERT_EQ(played.code, 0) << played.err;
    ASSERT_EQ(names_in(results()),
              (std::vector<std::string>{"participant-001.left.csv", "participant-002.partial.csv"}));
    const auto left = rows_of("participant-001.left.csv");
    ASSERT_EQ(left.size(), 2U);
    EXPECT_EQ(left[1].at("answer"), "left");
    const auto next = rows_of("participant-002.partial.csv");
    ASSERT_GE(next.size(), 2U);
    EXPECT_EQ(next.back().at("answer"), "ended") << "by the experimenter";
}

TEST_F(StudyWindow, LeavesPartialTableWhenStopped) {
    write_whole_study();
    std::filesystem::create_directory(results());
    const std::string script = "0.6 key enter\n1.4 key enter\n";
    const auto killed = results() / "participant-001.partial.csv";
    kill_once(words(script, {"--seconds", "600"}), [&] { return has_trial(killed); });
    EXPECT_EQ(names_in(results()), std::vector<std::string>{"participant-001.partial.csv"});
    EXPECT_EQ(rows_of("participant-001.partial.csv").size(), 1U);
    const auto ended = run_in_folder_until(words(script, {"--seconds", "600"}), folder_.path(), [&] {
        return has_trial(results() / "participant-002.partial.csv");
    });
    EXPECT_EQ(ended.code, 130) << ended.err;
    const auto rows = rows_of("participant-002.partial.csv");
    ASSERT_GE(rows.size(), 3U);
    EXPECT_EQ(rows.back().at("answer"), "ended");
}

TEST_F(StudyWindow, FailsOnFullDisk) {
    write_whole_study("a-name-that-takes-much-of-disk-", "and-so-does-this-name-of-a-question");
    const std::string script =
        "0.6 continue\n1.4 continue\n2.2 continue\n2.8 answer 3\n3 continue\n"
        "3.8 continue\n4.4 answer 1\n4.6 continue\n5.4 continue\n6.2 continue\n7 quit\n";
    const auto full = run_on_full_disk(words(script, {}), 1);
    EXPECT_EQ(full.code, 3) << full.err;
    EXPECT_TRUE(contains(full.err, "participant-001.partial.csv: answers are not kept: "));
    EXPECT_EQ(names_in(results()), std::vector<std::string>{"participant-001.partial.csv"})
        << "no other may begin";
    EXPECT_EQ(file_contents(results() / "participant-001.partial.csv").back(), '\n') << "whole rows alone";
}

TEST_F(StudyWindow, RejectsInvalidOptionsAtStart) {
    write_whole_study();
    const auto refuse = [&](std::vector<std::string> typed, int code, const char* part) {
        typed.insert(typed.begin(), {"play", clip_, "--headless", "--seconds", "1"});
        expect_refused(typed, code, part);
    };
    const std::string study = (folder_ / "study.json").string(), kept = results().string();
    refuse({"--study", study, "--results", kept}, 2, "--kiosk");
    refuse({"--kiosk", "--study", study}, 2, "--results");
    refuse({"--kiosk", "--study", "paper-42", "--results", kept}, 2, "paper-4.2");
    refuse({"--kiosk", "--study", clip_, "--results", kept}, 3, "still.mkv");
    refuse({"--kiosk", "--study", study, "--results", clip_}, 3, "folder");
    write_study(R"("before": [{"id": "trial", "kind": "touch", "text": "Try it", "clip": 2}])");
    refuse({"--kiosk", "--study", study, "--results", kept}, 2, "clip 2");
    EXPECT_FALSE(std::filesystem::exists(results()));
}

/// The study that comes with the program begins where it was built, and the analysis of docs/exhibit.md
/// reads what it leaves.
TEST_F(StudyWindow, BundledStudyResultsAreAnalysed) {
    auto typed = words("0.6 continue\n1.2 quit\n", {});
    typed[4] = "paper-4.2";
    const auto played = run_touchable(typed);
    ASSERT_EQ(played.code, 0) << played.err;
    EXPECT_EQ(names_in(results()), std::vector<std::string>{"participant-001.partial.csv"});
    if (std::system("python3 --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "there is no python3";
    const std::string header =
        "study,participant,language,hand,time,condition,place,step,question,answer,"
        "seconds,contact_s,touches,mean_force_n,max_force_n\n";
    const auto person = [&](int number, const char* on, const char* off, const char* useful) {
        const std::string who = "paper-4.2," + std::to_string(number) + ",en,mouse,2026-11-24T10:00:00Z,";
        std::ofstream(results() / ("participant-00" + std::to_string(number) + ".csv"))
            << header << who << "force-on,1,globe,,,30.00,20.000,4,1.0000,3.0000\n"
            << who << "force-on,1,about-globe,details," << on << ",4.00,,,,\n"
            << who << "force-off,2,about-globe,details," << off << ",4.00,,,,\n"
            << who << ",,feedback,useful," << useful << ",4.00,,,,\n";
    };
    person(2, "6", "3", "yes");
    person(3, "5", "4", "yes");
    person(4, "7", "2", "no");
    const std::string printed = (folder_ / "means.txt").string();
    const std::string command = std::string("python3 '") + TOUCHABLE_SOURCE_DIR +
                                "/examples/study/means.py' '" + results().string() + "' > '" + printed + "'";
    ASSERT_EQ(std::system(command.c_str()), 0);
    const std::string said = file_contents(printed);
    EXPECT_TRUE(contains(said, "participants finished: 3"));
    std::istringstream lines(said.substr(said.find("details ")));
    std::string name, on, off, difference, sd, n;
    lines >> name >> on >> off >> difference >> sd >> n;
    EXPECT_EQ(on + " " + off + " " + difference + " " + sd + " " + n, "6.00 3.00 3.00 2.00 3") << said;
    EXPECT_TRUE(contains(said, "yes 2 of 3"));
}

}  // namespace
}  // namespace touchable::test
