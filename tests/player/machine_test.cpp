#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "player/commands/machine_check.hpp"

// What `touchable check` makes of what it has measured.
namespace touchable::test {
namespace {

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

TEST(TrialVerdict, YesWhereEverythingFits) {
    const TrialVerdict verdict = judge(demand, easy(), 2);
    EXPECT_TRUE(verdict.can) << verdict.why;
    EXPECT_EQ(verdict.why, "all of it takes 750 of the 1800 ms of CPU time a second it may");
    // 1800 ms less those of 1000 ticks, by 24 a frame; decoding alone would reach 90.
    EXPECT_EQ(verdict.most_rate, 73);
    EXPECT_EQ(judge({1920, 1080, 5, 73}, easy(), 2).can, true);
    EXPECT_EQ(judge({1920, 1080, 5, 74}, easy(), 2).can, false);
}

TEST(TrialVerdict, NoNamesWhatIsTooSlow) {
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

TEST(TrialVerdict, StandsOnAPlainLineBeforeTheFigures) {
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
    EXPECT_NE(text(slow).find("at most   14 frames/s"), std::string::npos) << text(slow);
    EXPECT_NE(text(slow).find("other programs kept the cores busy"), std::string::npos) << "61 ms for 24";
    EXPECT_EQ(text(easy()).find("other programs"), std::string::npos);
}

TEST(Realtime, IsPermittedInWaysThatNameThePersonAndTheProgram) {
    const auto ways = ways_to_realtime("ada", "/usr/bin/touchable");
    for (const char* part : {"ada - rtprio 80", "setcap cap_sys_nice,cap_ipc_lock=ep /usr/bin/touchable",
                             "LimitRTPRIO=80", "--cap-add=SYS_NICE"})
        EXPECT_TRUE(std::any_of(ways.begin(), ways.end(), [part](const std::string& way) {
            return way.find(part) != std::string::npos;
        })) << part;
}

TEST(KernelFacts, AreOfTheRunsThatHaveTimes) {
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

}  // namespace
}  // namespace touchable::test
