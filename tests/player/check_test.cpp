#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "tests/player/program.hpp"

namespace touchable::test {
namespace {

TEST(Check, FindsThisMachineReady) {
    const Outcome run = run_touchable({"check", "--json"});
    EXPECT_EQ(run.code, 0) << run.err;
    const auto facts = nlohmann::json::parse(run.out, nullptr, false);
    ASSERT_TRUE(facts.is_object());
    EXPECT_TRUE(facts["ready"].get<bool>());
    EXPECT_GE(facts["cpu"]["cores"].get<int>(), 1);
    EXPECT_GT(facts["timer"]["clock_resolution_ns"].get<double>(), 0);
    for (const char* encoder : {"ffv1 encoder", "libx264 encoder", "libx264rgb encoder"})
        EXPECT_TRUE(facts["ffmpeg"]["needed"][encoder].get<bool>()) << encoder;
    ASSERT_GE(facts["builders"].size(), 1U);
    for (const auto& builder : facts["builders"]) {
        EXPECT_TRUE(builder["identical"].get<bool>());
        EXPECT_GT(builder["cpu_ms"].get<double>(), 0);
        EXPECT_GT(builder["vulkan_ms"].get<double>(), 0);
    }
}

TEST(Check, ReportsTheVulkanDeviceAndThatItComputes) {
    const auto facts = nlohmann::json::parse(run_touchable({"check", "--json"}).out, nullptr, false);
    ASSERT_TRUE(facts.is_object());
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

TEST(Check, WithoutADriverTheMachineIsReadyForTheCpuAlone) {
    for (const char* name : {"VK_ICD_FILENAMES", "VK_DRIVER_FILES"})
        setenv(name, "/nonexistent/driver.json", 1);
    const Outcome run = run_touchable({"check"});
    for (const char* name : {"VK_ICD_FILENAMES", "VK_DRIVER_FILES"}) unsetenv(name);
    EXPECT_EQ(run.code, 0) << run.err;
    EXPECT_NE(run.out.find("install a driver"), std::string::npos) << run.out;
    EXPECT_NE(run.out.find("verdict   ready, without Vulkan"), std::string::npos) << run.out;
}

TEST(Check, StopsWhenItIsInterrupted) {
    const Outcome run = run_interrupted_once_it_speaks({"check"});
    EXPECT_EQ(run.code, 130) << run.err;
    EXPECT_EQ(run.out.find("verdict"), std::string::npos) << run.out;
    EXPECT_TRUE(run.one_line_of_error()) << run.err;
}

TEST(Check, TellsAPersonTheVerdict) {
    const Outcome run = run_touchable({"check"});
    EXPECT_EQ(run.code, 0);
    for (const char* fact : {"cpu", "SCHED_FIFO", "ffmpeg", "vulkan", "the same bits", "verdict   ready\n"})
        EXPECT_NE(run.out.find(fact), std::string::npos) << fact;
}

TEST(Check, AnswersWhetherTheMachineCan) {
    const Outcome easy = run_touchable({"check", "--size", "64x48", "--fingers", "2", "--rate", "1"});
    EXPECT_EQ(easy.code, 0) << easy.err;
    EXPECT_EQ(easy.out.rfind("yes: 64x48 at 1 frames/s with 2 fingers; ", 0), 0U) << easy.out;
    for (const char* fact : {"decode", "build", "tick", "cpu time", "at most", "SCHED_FIFO"})
        EXPECT_NE(easy.out.find(fact), std::string::npos) << fact;

    const Outcome hard = run_touchable({"check", "--json", "--size", "1920x1080", "--rate", "1000"});
    EXPECT_EQ(hard.code, 6) << hard.out;
    EXPECT_TRUE(hard.one_line_of_error()) << hard.err;
    EXPECT_NE(hard.err.find("1920x1080 at 1000 frames/s with 1 finger is too much for this machine"),
              std::string::npos)
        << hard.err;
    const auto facts = nlohmann::json::parse(hard.out, nullptr, false);
    ASSERT_TRUE(facts.is_object()) << hard.out;
    EXPECT_FALSE(facts["can"].get<bool>());
    EXPECT_LT(facts["most_rate"].get<double>(), 1000);
    EXPECT_EQ(facts["ticks"], 1000);
    for (const char* measured : {"decode_ms", "build_ms", "tick_us"})
        EXPECT_GT(facts[measured]["mean"].get<double>(), 0) << measured;
    EXPECT_GT(facts["cpu_ms_per_second"].get<double>(), 0);
}

TEST(Check, LeavesNoFileOfItsTrialBehind) {
    const TemporaryFolder folder;
    setenv("TMPDIR", folder.path().c_str(), 1);
    const Outcome run = run_touchable({"check", "--size", "64x48", "--rate", "1"});
    const Outcome stopped = run_interrupted({"check", "--size", "1920x1080"}, folder.path());
    unsetenv("TMPDIR");
    EXPECT_EQ(run.code, 0) << run.err;
    EXPECT_EQ(stopped.code, 130) << stopped.err;
    EXPECT_EQ(folder.file_count(), 0U);
}

TEST(Check, QuestionsThatMakeNoSenseAreCode2) {
    for (const std::vector<std::string>& words : {std::vector<std::string>{"--size", "big"},
                                                  {"--size", "8x8"},
                                                  {"--fingers", "0"},
                                                  {"--rate", "0"}}) {
        std::vector<std::string> all{"check"};
        all.insert(all.end(), words.begin(), words.end());
        const Outcome run = run_touchable(all);
        EXPECT_EQ(run.code, 2) << words[1];
        EXPECT_TRUE(run.one_line_of_error()) << run.err;
    }
}

}  // namespace
}  // namespace touchable::test
