#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/player/program.hpp"

namespace touchable::testing {
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
    }
}

TEST(Check, TellsAPersonTheVerdict) {
    const Outcome run = run_touchable({"check"});
    EXPECT_EQ(run.code, 0);
    for (const char* fact : {"cpu", "SCHED_FIFO", "ffmpeg", "the same bits", "verdict   ready"})
        EXPECT_NE(run.out.find(fact), std::string::npos) << fact;
}

}  // namespace
}  // namespace touchable::testing
