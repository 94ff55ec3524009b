// What a kiosk keeps of its use.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <fstream>
#include <future>
#include <regex>
#include <string>
#include <thread>

#include "player/window/kiosk.hpp"
#include "tests/player/program.hpp"

namespace touchable::test {
namespace {

using namespace std::chrono_literals;

class KioskLog : public ::testing::Test {
protected:
    /// 2026-11-24 10:00:00 and so many seconds, universal time.
    static UseLog::Time at(int seconds) { return UseLog::Time(std::chrono::seconds(1795514400 + seconds)); }
    std::string text() const { return file_contents(file_); }
    const TemporaryFolder folder_;
    const std::filesystem::path file_ = folder_ / "use.csv";
};

TEST_F(KioskLog, HasARowForEachVisitAndFaultAndNothingOfPersons) {
    {
        auto log = UseLog::open(file_);
        ASSERT_TRUE(log) << log.error().message;
        (*log)->start(at(0));
        (*log)->visit(at(5), 42.26);
        (*log)->fault(at(60), "globe.mkv: \"cut\", short\nor so");
        (*log)->visit(at(70), 3);
        (*log)->end(at(90));
        EXPECT_FALSE((*log)->missing());
    }
    EXPECT_EQ(text(), std::string(UseLog::header) +
                          "2026-11-24T10:00:00Z,start,,,\n"
                          "2026-11-24T10:00:05Z,visit,1,42.3,\n"
                          "2026-11-24T10:01:00Z,fault,,,\"globe.mkv: \"\"cut\"\", short\\nor so\"\n"
                          "2026-11-24T10:01:10Z,visit,2,3.0,\n"
                          "2026-11-24T10:01:30Z,end,,,\n");
}

TEST_F(KioskLog, IsOnTheDiskBeforeTheProgramEndsHoweverItDoes) {
    auto log = UseLog::open(file_);
    ASSERT_TRUE(log);
    (*log)->visit(at(0), 1);
    for (int k = 0; k < 20'000 && text().find(",visit,1,1.0,\n") == std::string::npos; ++k)
        std::this_thread::sleep_for(1ms);
    EXPECT_NE(text().find(",visit,1,1.0,\n"), std::string::npos);
    EXPECT_FALSE(UseLog::open(file_)) << "two programs would write between each other's rows";
}

TEST_F(KioskLog, GoesOnBehindARowThatWasCutOff) {
    std::ofstream(file_) << UseLog::header << "2026-11-24T09:00:00Z,vis";
    {
        auto log = UseLog::open(file_);
        ASSERT_TRUE(log) << log.error().message;
        (*log)->start(at(0));
    }
    EXPECT_EQ(text(),
              std::string(UseLog::header) + "2026-11-24T09:00:00Z,vis\n2026-11-24T10:00:00Z,start,,,\n");
}

TEST_F(KioskLog, StandsInPlaceOfNothingElse) {
    std::ofstream(file_) << "my diary\n";
    const auto refused = UseLog::open(file_);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("no log of use"), std::string::npos);
    EXPECT_EQ(text(), "my diary\n");
    EXPECT_FALSE(UseLog::open(folder_.path()));
    EXPECT_FALSE(UseLog::open(folder_ / "nowhere" / "use.csv"));
    EXPECT_FALSE(UseLog::open("/dev/full"));
}

/// A pipe takes all that is written to it, and has no disk.
TEST(DurableAppend, TellsOfARowThatIsWrittenAndNotSafe) {
    int ends[2] = {};
    ASSERT_EQ(pipe(ends), 0);
    EXPECT_EQ(append_durably(ends[1], "row\n"), EINVAL);
    close(ends[0]);
    close(ends[1]);
}

TEST_F(KioskLog, DoesNotWaitForEverForADiskThatHangs) {
    std::promise<void> answer;
    const std::shared_future<void> answers = answer.get_future().share();
    auto log = UseLog::open(file_, [answers](int out, std::string_view row) {
        answers.wait();
        return append_durably(out, row);
    });
    ASSERT_TRUE(log) << log.error().message;
    (*log)->start(at(0));
    (*log)->end(at(1));
    const auto missing = (*log)->finish(20ms);
    ASSERT_FALSE(missing);
    EXPECT_NE(missing.error().message.find("does not answer"), std::string::npos) << missing.error().message;
    EXPECT_EQ(text(), UseLog::header);
    answer.set_value();
    EXPECT_TRUE((*log)->finish(60s)) << "it was only slow";
    EXPECT_NE(text().find(",end,,,\n"), std::string::npos);
}

TEST_F(KioskLog, HasAKioskWhoseClipCannotBeOpened) {
    std::ofstream(folder_ / "broken.mkv") << "no clip";
    const auto ended = run_touchable({"play", (folder_ / "broken.mkv").string(),
                                      (folder_ / "broken.mkv").string(), "--headless", "--painter", "cpu",
                                      "--kiosk", "--use-log", file_.string(), "--seconds", "1"});
    EXPECT_EQ(ended.code, 3) << ended.err;
    EXPECT_TRUE(std::regex_search(text(), std::regex("start,,,\n.*fault,,,\".*broken.mkv.*\n.*end,,,\n$")))
        << text();
}

TEST_F(KioskLog, OfAProgramCountsWhoCameAndSaysOnceThatItsDiskIsFull) {
    const std::string clip = (folder_ / "globe.mkv").string();
    ASSERT_EQ(run_touchable({"make", "globe", clip, "--size", "64x48", "--frames", "2"}).code, 0);
    std::string script;  // three visitors
    for (const double come_s : {0.1, 2.3, 4.5})
        script += std::to_string(come_s) + " move 80 60\n" + std::to_string(come_s + 0.2) + " move 90 60\n";
    std::ofstream(folder_ / "script") << script;
    const std::vector<std::string> words{
        "play",      clip,        "--headless",   "--painter", "cpu",
        "--size",    "160x120",   "--kiosk",      "--idle",    "1.4",
        "1.5",       "--use-log", file_.string(), "--script",  (folder_ / "script").string(),
        "--seconds", "6.4"};
    const auto played = run_touchable(words);
    ASSERT_EQ(played.code, 0) << played.err;
    EXPECT_EQ(played.err, "");
    EXPECT_TRUE(std::regex_search(
        text(),
        std::regex(
            "start,,,\n.*visit,1,0\\.[0-9],\n.*visit,2,0\\.[0-9],\n.*visit,3,0\\.[0-9],\n.*end,,,\n$")))
        << text();
    std::string long_log = UseLog::header;
    while (long_log.size() < 4050) long_log += "2026-11-24T10:00:05Z,visit,1,42.3,\n";
    std::ofstream(file_) << long_log;
    const auto full = run_on_full_disk(words, 4);
    EXPECT_EQ(full.code, 0) << full.err;
    EXPECT_NE(full.err.find("rows of the log of use are lost"), std::string::npos) << full.err;
    EXPECT_EQ(std::count(full.err.begin(), full.err.end(), '\n'), 1) << full.err;
    EXPECT_EQ(text().back(), '\n') << "only whole rows";
}

}  // namespace
}  // namespace touchable::test
