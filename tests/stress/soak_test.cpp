// The soak goes on where it ended, and trusts no state that is not its own.
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <sstream>

#include "tests/stress/soak.hpp"

namespace touchable::stress {
namespace {
namespace fs = std::filesystem;

class Soak : public testing::Test {
protected:
    Soak() : folder(fs::temp_directory_path() / ("touchable-soak-" + std::to_string(getpid()))) {
        settings.plan.unit_ticks = 300;
        settings.plan.replay_every = 5;
        settings.state = folder / "deep" / "state.json";
        settings.ticks = 300 * 66;
    }
    ~Soak() override { fs::remove_all(folder); }
    std::string contents() const {
        std::ostringstream text;
        text << std::ifstream(settings.state).rdbuf();
        return text.str();
    }
    Result<SoakState> run() { return soak(settings, progress); }

    fs::path folder;
    SoakSettings settings;
    std::ostringstream progress;
};

TEST_F(Soak, IsTheSameInOneGoAndInTwoAndOnAnyNumberOfThreads) {
    settings.threads = 1;
    const auto whole = run();
    ASSERT_TRUE(whole);
    EXPECT_EQ(whole->ticks(), settings.ticks);
    EXPECT_EQ(whole->violations, std::vector<std::string>());
    EXPECT_EQ(whole->coverage.size(), suites().size());
    const std::string one_go = contents();
    fs::remove(settings.state);
    settings.threads = 3;
    settings.ticks = 300 * 29;
    ASSERT_TRUE(run());
    settings.ticks = 300 * 66;
    ASSERT_TRUE(run());
    EXPECT_EQ(contents(), one_go);
    EXPECT_NE(progress.str().find("0 violations"), std::string::npos);
}

TEST_F(Soak, RefusesTheStateOfAnotherSolverOrPlanUntilToldToBeginAnew) {
    ASSERT_TRUE(run());
    std::string text = contents();
    const std::size_t at = text.find("\"solver\": \"") + 11;
    text[at] = text[at] == '0' ? '1' : '0';
    std::ofstream(settings.state) << text;
    auto refused = run();
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, ErrorKind::usage);
    EXPECT_NE(refused.error().message.find("another solver"), std::string::npos);
    settings.fresh = true;
    EXPECT_TRUE(run());
    settings.fresh = false;
    EXPECT_TRUE(run());
    settings.plan.certify_every = 3;
    EXPECT_FALSE(run());
}

TEST_F(Soak, RefusesAStateThatIsNone) {
    fs::create_directories(settings.state.parent_path());
    for (const char* text :
         {"", "{}", "[1]", "{\"soak\": 2}", "{\"soak\": 1, \"solver\": 3}", "violations"}) {
        std::ofstream(settings.state) << text;
        const auto refused = run();
        ASSERT_FALSE(refused) << text;
        EXPECT_EQ(refused.error().kind, ErrorKind::input);
        EXPECT_NE(refused.error().message.find("state.json"), std::string::npos);
    }
}

TEST_F(Soak, SaysSoWhereItCannotKeepItsState) {
    fs::create_directories(folder);
    std::ofstream(folder / "deep") << "a file";
    const auto refused = run();
    ASSERT_FALSE(refused);
}

TEST(SoakState, AViolationSaysWhatReproducesIt) {
    SoakState state;
    Watched watched;
    watched.violation_count = 2;
    watched.violations = {"tick 7, finger 0: S1"};
    state.add(*find_suite("plateau"), 12, watched);
    EXPECT_EQ(state.violation_count, 2);
    EXPECT_EQ(state.violations.front(), "--suite plateau --seed 12 --ticks 20000: tick 7, finger 0: S1");
    ASSERT_EQ(state.empty_suites().size(), 1U);
    EXPECT_NE(state.empty_suites().front().find("plateau: contact"), std::string::npos);
}

}  // namespace
}  // namespace touchable::stress
