// Where two runs part is found to the tick, the finger and the field.
#include <gtest/gtest.h>

#include <sstream>

#include "tests/stress/golden_runs.hpp"
#include "tests/stress/tick_states.hpp"

namespace touchable::stress {
namespace {

std::string states_of(const GoldenRun& golden, GoldenBuilder builder, std::int64_t ticks) {
    std::ostringstream out;
    StateWriter writer(out);
    watch(*golden.make(builder), {ticks, 0, 0}, &writer);
    return out.str();
}

std::optional<std::string> difference_from(const std::string& recorded, const GoldenRun& golden,
                                           std::int64_t ticks) {
    std::istringstream in(recorded);
    StateComparison comparison(in);
    watch(*golden.make(GoldenBuilder::cpu), {ticks, 0, 0}, &comparison);
    return comparison.difference();
}

class TickStates : public testing::Test {
protected:
    const GoldenRun& golden = *find_golden_run("globe-planet");
    static constexpr std::int64_t ticks = 300;

    /// The recorded text with one character of a cell changed.
    std::string changed(std::string text, std::size_t row, const std::string& field) const {
        const auto& fields = state_fields();
        const auto column =
            static_cast<std::size_t>(std::find(fields.begin(), fields.end(), field) - fields.begin());
        std::size_t at = 0;
        for (std::size_t k = 0; k <= row; ++k) at = text.find('\n', at) + 1;
        for (std::size_t k = 0; k < column; ++k) at = text.find(',', at) + 1;
        const std::size_t end = text.find_first_of(",\n", at);
        text[end - 1] = text[end - 1] == '1' ? '2' : '1';
        return text;
    }
};

TEST_F(TickStates, AreTheSameAgainAndWithTheLazyBuilder) {
    EXPECT_EQ(difference_from(states_of(golden, GoldenBuilder::cpu, ticks), golden, ticks), std::nullopt);
    EXPECT_EQ(difference_from(states_of(golden, GoldenBuilder::lazy, ticks), golden, ticks), std::nullopt);
}

TEST_F(TickStates, NameTheFirstTickFingerAndFieldThatDiffer) {
    const std::string text = states_of(golden, GoldenBuilder::cpu, ticks);
    for (const auto& [row, field] : {std::pair{5 * 217 + 3, "a"},
                                     {5 * 100 + 0, "proxy_z"},
                                     {4, "guard"},
                                     {5 * 299 + 4, "force_x"},
                                     {5 * 8 + 1, "frame_next"}}) {
        const auto difference =
            difference_from(changed(text, static_cast<std::size_t>(row), field), golden, ticks);
        ASSERT_TRUE(difference);
        const std::string where = "tick " + std::to_string(row / 5) + ", finger " + std::to_string(row % 5) +
                                  ", field " + field + ":";
        EXPECT_EQ(difference->substr(0, where.size()), where) << *difference;
    }
}

TEST_F(TickStates, ARunThatEndsSoonerOrLaterDiffers) {
    const std::string text = states_of(golden, GoldenBuilder::cpu, ticks);
    EXPECT_NE(difference_from(text, golden, ticks - 1)->find("goes on"), std::string::npos);
    EXPECT_NE(
        difference_from(text, golden, ticks + 1)->find("tick 300, finger 0: the recorded run has ended"),
        std::string::npos);
    EXPECT_TRUE(difference_from("", golden, 1));
    EXPECT_TRUE(difference_from("tick,finger\n0,0\n", golden, 1));
}

}  // namespace
}  // namespace touchable::stress
