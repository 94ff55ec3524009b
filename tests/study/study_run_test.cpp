// Participants of a study, by scripted hands in virtual time.
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <fstream>
#include <future>
#include <string>
#include <thread>
#include <vector>

#include "device/hand.hpp"
#include "player/window/study.hpp"
#include "tests/player/program.hpp"

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
        auto run = open_in(folder_ / "results");
        ASSERT_TRUE(run) << run.error().message;
        run_ = std::move(*run);
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
        ASSERT_TRUE(run_->meter()->take(tick));
        contacts[0].touching = true;
        forces[0].force = {0, newtons * 0.6, newtons * 0.8};
        for (int k = 0; k < ticks; ++k) ASSERT_TRUE(run_->meter()->take(tick));
        ms_ += ticks;
    }
    /// From the start screen to the end, with these answers.
    void take_part(const char* first, const char* second) {
        wait(1000);
        go_on();
        wait(3000);
        go_on();
        for (const char* const answer : {first, second}) {
            touch(2, 500);
            touch(4, 500);
            wait(1000);
            go_on();
            wait(1500);
            run_->choose(static_cast<std::size_t>(answer[0] - '1'));
            go_on();
        }
        wait(2000);
        go_on();
    }
    std::string text_of(const char* file) const { return file_contents(folder_ / "results" / file); }
    std::vector<std::string> files() const { return names_in(folder_ / "results"); }
    using Names = std::vector<std::string>;

    const TemporaryFolder folder_;
    std::unique_ptr<StudyRun> run_;
    BackgroundWriter* writer_ = nullptr;  // its own
    int ms_ = 0;
};

TEST_F(Participant, HasATableOfAllThatWasDoneAndNothingOfTheirPerson) {
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

TEST_F(Participant, IsFollowedByTheNextWhoHasTheOtherOrder) {
    take_part("6", "2");
    take_part("1", "7");
    EXPECT_EQ(files(), (Names{"participant-001.csv", "participant-002.csv"}));
    const std::string second = text_of("participant-002.csv");
    EXPECT_NE(second.find(",off,1,about,rough,1,"), std::string::npos) << second;
    EXPECT_NE(second.find(",on,2,about,rough,7,"), std::string::npos) << second;
    // Whoever starts the program again goes on with the numbers, and writes over nothing.
    const std::string first = text_of("participant-001.csv");
    open();
    take_part("3", "3");
    EXPECT_EQ(files(), (Names{"participant-001.csv", "participant-002.csv", "participant-003.csv"}));
    EXPECT_EQ(text_of("participant-001.csv"), first);
}

TEST_F(Participant, GoesOnOnlyOnceItIsTimeAndTheQuestionIsAnswered) {
    wait(100);
    go_on();
    EXPECT_FALSE(run_->screen()) << "a click that was one too many";
    wait(400);
    go_on();
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
    wait(1000);
    go_on();
    wait(5000);
    EXPECT_FALSE(run_->gives_force()) << "nobody pushes whoever reads a question";
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

TEST_F(Participant, WhoGoesAwayHasLeftUnlessAllIsAnswered) {
    wait(1000);
    go_on();
    wait(3000);
    go_on();
    wait(1000);
    leave();
    EXPECT_FALSE(run_->screen());
    EXPECT_EQ(files(), Names{"participant-001.left.csv"});
    const std::string left = text_of("participant-001.left.csv");
    EXPECT_NE(left.find(",on,1,globe,,,1.00,"), std::string::npos) << left;
    EXPECT_NE(left.find(",end,,left,4.00,"), std::string::npos) << left;
    leave();
    EXPECT_EQ(files().size(), 1U) << "nobody is there";
    wait(1000);
    go_on();
    wait(3000);
    go_on();
    for (int k = 0; k < 2; ++k) {
        wait(1000);
        go_on();
        wait(1000);
        run_->choose(0);
        go_on();
    }
    ASSERT_EQ(run_->screen()->step->id, "thanks");
    leave();
    EXPECT_EQ(files(), (Names{"participant-001.left.csv", "participant-002.csv"}));
}

TEST_F(Participant, OfAProgramThatIsKilledHasWhatWasDoneUntilThen) {
    wait(1000);
    go_on();
    wait(3000);
    go_on();
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

TEST_F(Participant, OfAProgramThatIsEndedStaysPartial) {
    wait(1000);
    go_on();
    wait(3000);
    EXPECT_TRUE(run_->end(now_s(), time(), 60s));
    EXPECT_EQ(files(), Names{"participant-001.partial.csv"});
    EXPECT_NE(text_of("participant-001.partial.csv").find(",end,,ended,3.00,"), std::string::npos);
}

/// As where somebody else has put it there meanwhile.
TEST_F(Participant, IsNeverWrittenOverAnother) {
    wait(1000);
    go_on();
    std::ofstream(folder_ / "results/participant-001.csv") << "mine\n";
    wait(1000);
    leave();
    EXPECT_FALSE(run_->fault()) << "it is another name";
    open();
    wait(1000);
    go_on();
    std::ofstream(folder_ / "results/participant-002.left.csv") << "mine, too\n";
    wait(1000);
    leave();
    ASSERT_TRUE(run_->fault());
    EXPECT_NE(run_->fault()->message.find("participant-002.left.csv"), std::string::npos);
    EXPECT_EQ(text_of("participant-001.csv"), "mine\n");
    EXPECT_EQ(text_of("participant-002.left.csv"), "mine, too\n");
    EXPECT_NE(text_of("participant-002.partial.csv").find(",end,,left,"), std::string::npos);
    EXPECT_FALSE(run_->end(now_s(), time(), 60s));
}

TEST_F(Participant, DoesNotBeginWhereNothingCanBeKept) {
    std::filesystem::remove_all(folder_ / "results");
    wait(1000);
    go_on();
    EXPECT_FALSE(run_->screen());
    ASSERT_TRUE(run_->fault());
    EXPECT_NE(run_->fault()->message.find("results"), std::string::npos);
    std::filesystem::create_directory(folder_ / "results");
    wait(1000);
    go_on();
    EXPECT_TRUE(run_->screen());
    EXPECT_FALSE(run_->fault());
    std::ofstream(folder_ / "file") << "x";
    EXPECT_FALSE(open_in(folder_ / "file"));
}

/// A disk that hangs: who is at it goes on, and nobody else begins.
TEST_F(Participant, WaitsForNoDisk) {
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
    EXPECT_NE(run_->fault()->message.find("results: its disk does not answer"), std::string::npos);
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
    EXPECT_NE(ended.error().message.find("does not answer"), std::string::npos);
    EXPECT_EQ(text_of("participant-001.partial.csv"), header);
    second.set_value();
    const auto has_all = [&] {
        return text_of("participant-001.partial.csv").find(",ended,4.00,") != std::string::npos;
    };
    for (int k = 0; k < 20'000 && !has_all(); ++k) std::this_thread::sleep_for(1ms);
    EXPECT_TRUE(has_all()) << "it was only slow";
}

/// Whoever asks, by a key or the device's own button.
TEST(HandOfAStudy, FeelsNothingWhereForcesAreNotAllowed) {
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
    EXPECT_EQ(tick(0, 3), 0) << "nobody has asked since";
    tick(1, 0);
    double most = 0;
    for (int k = 0; k < 400; ++k) most = tick(0, 3);
    EXPECT_EQ(most, 3);
    control.allow_force(false);
    EXPECT_EQ(tick(0, 3), 0) << "off is at once";
}

}  // namespace
}  // namespace touchable::test
