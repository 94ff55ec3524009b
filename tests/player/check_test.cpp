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
    EXPECT_TRUE(facts["ffmpeg"]["needed"]["ffv1 encoder"].get<bool>());
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

}  // namespace
}  // namespace touchable::test
