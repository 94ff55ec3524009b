// SPDX-License-Identifier: Apache-2.0
// Participants of a study, by scripted hands in virtual time.

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <future>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "device/hand.hpp"
#include "player/window/study.hpp"
#include "tests/must.hpp"
#include "tests/window/scripted_window.hpp"

namespace touchable::test {
namespace {

using namespace std::chrono_literals;

constexpr const char* header =
    "study,participant,language,hand,time,condition,place,step,question,answer,seconds,contact_s,touches,"
    "mean_force_n,max_force_n\n";
constexpr const char* small_study =
    R"({"touchable_study": 1, "name": "small", "start": {"title": "a", "text": "b"},
 "before": [{"id": "trial", "kind": "touch", "text": "try", "least_s": 2, "most_s": 60}],
 "conditions": [{"name": "on", "force": "on"}, {"name": "off", "force": "off", "clip": 2}],
 "in_each_condition": [
  {"id": "globe", "kind": "touch", "text": "touch"},
  {"id": "about", "kind": "questions", "questions": [
   {"id": "rough", "text": "rough?", "scale": {"least": 1, "most": 7, "low": "no", "high": "yes"}}]}],
 "after": [{"id": "thanks", "kind": "text", "text": "thanks", "most_s": 10}]})";

class Participant : public testing::Test {
protected:
    void SetUp() override { open(); }
    void open() {
        auto run = must(open_in(folder_ / "results"));
        run_ = std::move(run);
    }
    Result<std::unique_ptr<StudyRun>> open_in(const std::filesystem::path& results) {
        auto study = parse_study(small_study, "small.json");
        EXPECT_TRUE(study) << study.error().message;
        auto writer = std::make_unique<BackgroundWriter>("study", "results");
        writer_ = writer.get();
        return StudyRun::open(std::move(*study), results, "de", "mouse", std::move(writer));
    }
    /// 2026-11-24 10:00:00 and so many seconds, universal time.
    StudyRun::Time time() const { return StudyRun::Time(std::chrono::milliseconds(1795514400000 + ms_)); }
    double now_s() const { return ms_ / 1000.0; }
    void wait(int ms) {
        ms_ += ms;
        run_->pass(now_s(), time());
    }
    void go_on_after(int ms) {
        wait(ms);
        go_on();
    }
    /// Past the start screen and the trial.
    void begin() {
        go_on_after(1000);
        go_on_after(3000);
    }
    /// And what is written then.
    void go_on() {
        run_->go_on(now_s(), time());
        settle();
    }
    void leave() {
        run_->leave(now_s(), time());
        settle();
    }
    void settle() {
        ASSERT_TRUE(run_->wait_for_disk(60s));
        run_->pass(now_s(), time());
    }
    /// A finger feels so many newtons for so many ticks, after a tick in the air. Half of it reaches a hand.
    void touch(double newtons, int ticks) {
        std::array<Contact, 2> contacts{};
        std::array<GuardedForce, 2> forces{};
        const std::array<double, 2> shares{0.5, 1};
        TouchTick tick;
        tick.contacts = contacts;
        tick.forces = forces;
        tick.shares = shares;
        ASSERT_TRUE(run_->meter()->consume(tick));
        contacts[0].touching = true;
        forces[0].force = {0, newtons * 0.6, newtons * 0.8};
        for (int k = 0; k < ticks; ++k) ASSERT_TRUE(run_->meter()->consume(tick));
        ms_ += ticks;
    }
    /// From the start screen to the end, with these answers.
    void take_part(const char* first, const char* second) {
        begin();
        for (const char* const answer : {first, second}) {
            touch(2, 500);
            touch(4, 500);
            go_on_after(1000);
            wait(1500);
            run_->choose(static_cast<std::size_t>(answer[0] - '1'));
            go_on();
        }
        go_on_after(2000);
    }
    std::string text_of(const char* file) const { return file_contents(folder_ / "results" / file); }
    std::vector<std::string> files() const { return names_in(folder_ / "results"); }
    using Names = std::vector<std::string>;

    const TemporaryFolder folder_;
    std::unique_ptr<StudyRun> run_;
    BackgroundWriter* writer_ = nullptr;  // its own
    int ms_ = 0;
};

TEST_F(Participant, WritesAnonymousTable) {
    EXPECT_EQ(run_->screen(), nullptr);
    take_part("6", "2");
    EXPECT_EQ(run_->screen(), nullptr) << "the next one's start screen";
    EXPECT_FALSE(run_->fault());
    EXPECT_EQ(files(), Names{"participant-001.csv"});
    // Touching took a second: half of it 2 N, half of it 4 N. With force half of that reached the hand.
    EXPECT_EQ(text_of("participant-001.csv"),
              std::string(header) +
                  "small,1,de,mouse,2026-11-24T10:00:04Z,,,trial,,,3.00,0.000,0,0.0000,0.0000\n"
                  "small,1,de,mouse,2026-11-24T10:00:06Z,on,1,globe,,,2.00,1.000,2,1.5000,2.0000\n"
                  "small,1,de,mouse,2026-11-24T10:00:07Z,on,1,about,rough,6,1.50,,,,\n"
                  "small,1,de,mouse,2026-11-24T10:00:09Z,off,2,globe,,,2.00,1.000,2,3.0000,4.0000\n"
                  "small,1,de,mouse,2026-11-24T10:00:11Z,off,2,about,rough,2,1.50,,,,\n"
                  "small,1,de,mouse,2026-11-24T10:00:13Z,,,thanks,,,2.00,,,,\n"
                  "small,1,de,mouse,2026-11-24T10:00:13Z,,,end,,finished,12.00,,,,\n");
}

TEST_F(Participant, NextHasOtherOrder) {
    take_part("6", "2");
    take_part("1", "7");
    EXPECT_EQ(files(), (Names{"participant-001.csv", "participant-002.csv"}));
    const std::string second = text_of("participant-002.csv");
    EXPECT_TRUE(contains(second, ",off,1,about,rough,1,"));
    EXPECT_TRUE(contains(second, ",on,2,about,rough,7,"));
    // The next program goes on with the numbers, and writes over nothing.
    const std::string first = text_of("participant-001.csv");
    open();
    take_part("3", "3");
    EXPECT_EQ(files(), (Names{"participant-001.csv", "participant-002.csv", "participant-003.csv"}));
    EXPECT_EQ(text_of("participant-001.csv"), first);
}

TEST_F(Participant, ContinuesWhenTimedAndAnswered) {
    go_on_after(100);
    EXPECT_FALSE(run_->screen()) << "a click that was one too many";
    go_on_after(400);
    ASSERT_TRUE(run_->screen());
    wait(1900);
    EXPECT_FALSE(run_->may_go_on(now_s())) << "least_s";
    EXPECT_NEAR(run_->wait_s(now_s()), 0.1, 1e-9);
    go_on();
    EXPECT_EQ(run_->screen()->step->id, "trial");
    wait(58100);
    EXPECT_EQ(run_->screen()->step->id, "globe") << "most_s";
    EXPECT_TRUE(run_->gives_force());
    EXPECT_EQ(run_->clip(), 0U);
    go_on_after(1000);
    wait(5000);
    EXPECT_FALSE(run_->gives_force()) << "no force while a question is read";
    EXPECT_FALSE(run_->may_go_on(now_s())) << "no answer";
    EXPECT_EQ(run_->wait_s(now_s()), 0) << "it is not time that is waited for";
    EXPECT_EQ(run_->clip(), 1U) << "it is opened meanwhile";
    run_->choose(7);
    EXPECT_FALSE(run_->chosen()) << "there are seven";
    run_->choose_by(-1);
    EXPECT_EQ(run_->chosen(), 6U);
    run_->choose_by(1);
    EXPECT_EQ(run_->chosen(), 0U);
    go_on();
    EXPECT_EQ(run_->screen()->step->id, "globe");
    EXPECT_FALSE(run_->gives_force()) << "the other condition";
    EXPECT_FALSE(run_->chosen());
    wait(3000);
    run_->wait(now_s());
    go_on();
    EXPECT_EQ(run_->screen()->step->id, "globe") << "its clip was not there";
}

TEST_F(Participant, LeavingIsRecordedUnlessAnswered) {
    begin();
    wait(1000);
    leave();
    EXPECT_FALSE(run_->screen());
    EXPECT_EQ(files(), Names{"participant-001.left.csv"});
    const std::string left = text_of("participant-001.left.csv");
    EXPECT_TRUE(contains(left, ",on,1,globe,,,1.00,"));
    EXPECT_TRUE(contains(left, ",end,,left,4.00,"));
    leave();
    EXPECT_EQ(files().size(), 1U) << "without a participant";
    begin();
    for (int k = 0; k < 2; ++k) {
        go_on_after(1000);
        wait(1000);
        run_->choose(0);
        go_on();
    }
    ASSERT_EQ(run_->screen()->step->id, "thanks");
    leave();
    EXPECT_EQ(files(), (Names{"participant-001.left.csv", "participant-002.csv"}));
}

TEST_F(Participant, KeepsRowsWhenKilled) {
    begin();
    // Nothing is closed: so it is on the disk at any moment.
    EXPECT_EQ(files(), Names{"participant-001.partial.csv"});
    EXPECT_EQ(
        text_of("participant-001.partial.csv"),
        std::string(header) + "small,1,de,mouse,2026-11-24T10:00:04Z,,,trial,,,3.00,0.000,0,0.0000,0.0000\n");
    // The next program leaves it alone.
    open();
    take_part("4", "4");
    EXPECT_EQ(files(), (Names{"participant-001.partial.csv", "participant-002.csv"}));
}

TEST_F(Participant, StaysPartialWhenProgramEnds) {
    go_on_after(1000);
    wait(3000);
    EXPECT_TRUE(run_->end(now_s(), time(), 60s));
    EXPECT_EQ(files(), Names{"participant-001.partial.csv"});
    EXPECT_TRUE(contains(text_of("participant-001.partial.csv"), ",end,,ended,3.00,"));
}

/// A file that another program has put there meanwhile.
TEST_F(Participant, NeverOverwritesAnotherTable) {
    go_on_after(1000);
    std::ofstream(folder_ / "results/participant-001.csv") << "mine\n";
    wait(1000);
    leave();
    EXPECT_FALSE(run_->fault()) << "it is another name";
    open();
    go_on_after(1000);
    std::ofstream(folder_ / "results/participant-002.left.csv") << "mine, too\n";
    wait(1000);
    leave();
    ASSERT_TRUE(run_->fault());
    EXPECT_TRUE(contains(run_->fault()->message, "participant-002.left.csv"));
    EXPECT_EQ(text_of("participant-001.csv"), "mine\n");
    EXPECT_EQ(text_of("participant-002.left.csv"), "mine, too\n");
    EXPECT_TRUE(contains(text_of("participant-002.partial.csv"), ",end,,left,"));
    EXPECT_FALSE(run_->end(now_s(), time(), 60s));
}

TEST_F(Participant, NeedsWritableFolder) {
    std::filesystem::remove_all(folder_ / "results");
    go_on_after(1000);
    EXPECT_FALSE(run_->screen());
    ASSERT_TRUE(run_->fault());
    EXPECT_TRUE(contains(run_->fault()->message, "results"));
    std::filesystem::create_directory(folder_ / "results");
    go_on_after(1000);
    EXPECT_TRUE(run_->screen());
    EXPECT_FALSE(run_->fault());
    std::ofstream(folder_ / "file") << "x";
    EXPECT_FALSE(open_in(folder_ / "file"));
}

/// A disk that hangs: the participant goes on, and no other begins.
TEST_F(Participant, NeverWaitsForDisk) {
    const auto hang = [&](std::promise<void>& answer) {
        writer_->give({.write = [answers = answer.get_future().share()](const auto&) -> Result<void> {
            answers.wait();
            return {};
        }});
    };
    std::promise<void> first, second;
    hang(first);
    wait(1000);
    run_->go_on(now_s(), time());
    wait(1000);
    EXPECT_FALSE(run_->screen()) << "there is no file yet";
    EXPECT_FALSE(run_->may_go_on(now_s())) << "once is enough";
    EXPECT_FALSE(run_->fault());
    wait(5000);
    ASSERT_TRUE(run_->fault());
    EXPECT_TRUE(contains(run_->fault()->message,
                         "results: not written in time: the disk hangs, or this machine is busy; the last"));
    first.set_value();
    settle();
    EXPECT_FALSE(run_->fault());
    ASSERT_TRUE(run_->screen());
    EXPECT_EQ(files(), Names{"participant-001.partial.csv"});

    hang(second);
    wait(3000);
    run_->go_on(now_s(), time());
    EXPECT_EQ(run_->screen()->step->id, "globe");
    wait(1000);
    const auto ended = run_->end(now_s(), time(), 20ms);
    ASSERT_FALSE(ended);
    EXPECT_TRUE(contains(ended.error().message, "not written in time"));
    EXPECT_EQ(text_of("participant-001.partial.csv"), header);
    second.set_value();
    EXPECT_TRUE(comes_true([&] {
        return bool(contains(text_of("participant-001.partial.csv"), ",ended,4.00,"));
    })) << "it was only slow";
}

/// For a key as for the device's own button.
TEST(StudyHand, HasNoForceWhenDisallowed) {
    HandControl control{1, {Workspace{1e-4, {0, 0, -500}}, glm::dmat3(1)}};
    const auto tick = [&](std::uint32_t buttons, double newtons) {
        glm::dvec3 place(0), felt(0);
        const glm::dvec3 guarded(0, 0, newtons);
        control.to_goals(std::span(&place, 1), buttons);
        control.to_device(std::span(&guarded, 1), 1, std::span(&felt, 1));
        return felt.z;
    };
    control.allow_force(false);
    tick(0, 0);
    for (int k = 0; k < 1000; ++k) {
        control.ask_force(k == 100);
        EXPECT_EQ(tick(k % 200 < 100 ? 1 : 0, k < 10 ? 0 : 3), 0);
    }
    EXPECT_EQ(control.take_presses(0), 5);
    EXPECT_EQ(control.take_presses(0), 0) << "once";
    control.allow_force(true);
    tick(0, 0);
    EXPECT_EQ(tick(0, 3), 0) << "not asked for since";
    tick(1, 0);
    double most = 0;
    for (int k = 0; k < 400; ++k) most = tick(0, 3);
    EXPECT_EQ(most, 3);
    control.allow_force(false);
    EXPECT_EQ(tick(0, 3), 0) << "off is at once";
}

// The file of a study, and the order in which its conditions come.

const std::filesystem::path own_study =
    std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "share/study/paper-4.2.json";

TEST(StudyFile, BundledPaperStudyIsBilingual) {
    const auto study = must(parse_study(file_contents(own_study), "paper-4.2.json"));
    EXPECT_EQ(study.name, "paper-4.2");
    ASSERT_EQ(study.conditions.size(), 2U);
    EXPECT_EQ(study.conditions[0].force, StudyForce::on);
    EXPECT_EQ(study.conditions[1].force, StudyForce::off);
    EXPECT_EQ(study.clips(), 1U);
    EXPECT_EQ(study.before.back().id, "trial");
    // What the paper reports of its questionnaire.
    std::set<std::string> asked;
    for (const StudyStep& step : study.after)
        for (const StudyQuestion& question : step.questions) asked.insert(question.id);
    for (const char* id :
         {"useful", "helped-details", "disable", "realistic-roughness", "realistic-heights", "tiring"})
        EXPECT_TRUE(asked.contains(id)) << id;
    // Every text is there in both languages, and in no third one.
    const auto check = [](const auto& self, const nlohmann::json& node) -> void {
        if (node.is_object() && node.contains("en")) {
            EXPECT_EQ(node.size(), 2U) << node;
            EXPECT_TRUE(node.contains("de")) << node;
        }
        for (const auto& [name, value] : node.items()) {
            if (name == "title" || name == "text" || name == "low" || name == "high") {
                EXPECT_TRUE(value.is_object()) << value;
            }
            if (value.is_structured()) self(self, value);
        }
    };
    check(check, nlohmann::json::parse(file_contents(own_study)));
    EXPECT_TRUE(contains(study.all_words("de"), "ü"));
    EXPECT_FALSE(contains(study.all_words("en"), "ü"));
}

std::string message_of(const std::string& json) {
    const auto study = parse_study(json, "s.json");
    return study ? "" : study.error().message;
}

/// A study that is right, but for what replaces one of its parts.
std::string with(const std::string& part, const std::string& instead) {
    std::string json =
        R"({"touchable_study": 1, "name": "s", "start": {"title": "Hello", "text": "Begin"},)"
        R"( "before": [{"id": "trial", "kind": "touch", "text": "Try", "force": "on", "most_s": 60}],)"
        R"( "conditions": [{"name": "a", "force": "on"}, {"name": "b", "force": "off"}],)"
        R"( "in_each_condition": [{"id": "globe", "kind": "touch", "text": "Touch"},)"
        R"( {"id": "about", "kind": "questions", "questions": [)"
        R"({"id": "rough", "text": "Rough?", "scale": {"least": 1, "most": 5, "low": "no", "high": "yes"}},)"
        R"({"id": "liked", "text": "Liked?", "choices": [{"value": "y", "text": "Yes"}, {"value": "n", "text": "No"}]}]}]})";
    const std::size_t at = json.find(part);
    EXPECT_NE(at, std::string::npos) << part;
    return json.replace(at, part.size(), instead);
}

TEST(StudyFile, RejectsInvalidInOneLine) {
    EXPECT_EQ(message_of(with("Hello", "Hello")), "");
    const struct {
        const char *part, *instead, *where, *right;
    } faults[] = {{R"("touchable_study": 1)", R"("touchable_study": 2)", "touchable_study", "1"},
                  {R"("name": "s")", R"("name": "a, b")", "name", "letters, digits"},
                  {R"("name": "s",)", "", "name", ""},
                  {R"("Hello")", R"({"Deutsch": "Hallo"})", "start.title", "languages"},
                  {R"("Hello")", "{}", "start.title", "a text"},
                  {R"("Hello")", "[]", "start.title", "a line"},
                  {R"("Hello")", R"("")", "start.title", "a line"},
                  {R"("kind": "touch")", R"("kind": "dance")", "before[0].kind", "questions"},
                  {R"("force": "on", "most_s")", R"("force": true, "most_s")", "before[0].force", "off"},
                  {R"("most_s": 60)", R"("most_s": 0)", "before[0].most_s", "more than 0"},
                  {R"("most_s": 60)", R"("most_s": 5, "least_s": 9)", "before[0].most_s", "least_s"},
                  {R"("most_s": 60)", R"("most_s": -1)", "before[0].most_s", "a day"},
                  {R"("most_s": 60)", R"("clip": 0)", "before[0].clip", "1"},
                  {R"("most_s": 60)", R"("seconds": 6)", "seconds", "most_s"},
                  {R"("text": "Touch")", R"("text": "Touch", "force": "on")", "in_each_condition[0].force",
                   "condition"},
                  {R"("id": "globe")", R"("id": "trial")", "in_each_condition[0].id", "of its own"},
                  {R"("id": "liked")", R"("id": "globe")", "questions[1].id", "of its own"},
                  {R"("id": "globe")", R"("id": "end")", "in_each_condition[0].id", "of its own"},
                  {R"("name": "b")", R"("name": "a")", "conditions[1].name", "of its own"},
                  {R"("force": "off")", R"("force": "half")", "conditions[1].force", "off"},
                  {R"("most": 5)", R"("most": 1)", "scale", "more"},
                  {R"("most": 5)", R"("most": 100)", "most", "10"},
                  {R"("value": "n")", R"("value": "y")", "choices[1].value", "of its own"},
                  {R"(, {"value": "n", "text": "No"})", "", "choices", "2 to 6"},
                  {R"("choices")", R"("chioces")", "chioces", "choices"},
                  {R"("conditions": [{"name": "a", "force": "on"}, {"name": "b", "force": "off"}],)", "",
                   "in_each_condition", "both"},
                  {R"("start")", R"("start)", "s.json: ", ""}};
    for (const auto& fault : faults) {
        const std::string message = message_of(with(fault.part, fault.instead));
        EXPECT_EQ(message.find("s.json: "), 0U) << fault.instead << ": " << message;
        EXPECT_TRUE(contains(message, fault.where)) << fault.instead;
        EXPECT_TRUE(contains(message, fault.right)) << fault.instead;
        EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    }
    EXPECT_NE(message_of(R"({"touchable_study": 1, "name": "s", "start": {"title": "a", "text": "b"}})"), "");
    EXPECT_NE(message_of("[]"), "");
}

/// Two take turns; of more each has each place, and each other before it, equally often.
TEST(StudyOrder, IsBalancedBetweenParticipants) {
    using Order = std::vector<std::size_t>;
    EXPECT_EQ(order_of_conditions(2, 1), (Order{0, 1}));
    EXPECT_EQ(order_of_conditions(2, 2), (Order{1, 0}));
    EXPECT_EQ(order_of_conditions(2, 3), (Order{0, 1}));
    EXPECT_EQ(order_of_conditions(0, 5), Order{});
    for (std::size_t count = 1; count <= most_study_conditions; ++count) {
        const std::size_t rows = count % 2 == 0 ? count : 2 * count;
        std::map<std::pair<std::size_t, std::size_t>, std::size_t> places, followers;
        for (std::size_t number = 1; number <= rows; ++number) {
            const Order order = order_of_conditions(count, number);
            EXPECT_EQ(std::set<std::size_t>(order.begin(), order.end()).size(), count);
            EXPECT_EQ(order, order_of_conditions(count, number + rows));
            for (std::size_t k = 0; k < count; ++k) ++places[{k, order[k]}];
            for (std::size_t k = 1; k < count; ++k) ++followers[{order[k - 1], order[k]}];
        }
        EXPECT_EQ(places.size(), count * count);
        for (const auto& [place, times] : places) EXPECT_EQ(times, rows / count) << count;
        EXPECT_EQ(followers.size(), count * (count - 1));
        for (const auto& [pair, times] : followers) EXPECT_EQ(times, rows / count) << count;
    }
}

}  // namespace
}  // namespace touchable::test
