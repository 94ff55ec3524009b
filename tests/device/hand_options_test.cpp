#include <gtest/gtest.h>

#include <array>

#include "device/hand.hpp"
#include "tests/device/fake_probe.hpp"

namespace touchable {
namespace {

constexpr std::array keys{
    HandOptions::Key{"speed", "m/s", 0.001, 2, 0.1},
    HandOptions::Key{"seed", "", 0, 0x1p53, 1, HandOptions::Key::Kind::whole},
    HandOptions::Key{.name = "columns", .unit = "names joined by '+'", .kind = HandOptions::Key::Kind::words},
};

std::string refusal_of(const std::string& text) {
    const Result<HandOptions> options = HandOptions::parse("hand 'test'", text, keys);
    if (options) return {};
    EXPECT_EQ(options.error().kind, ErrorKind::usage);
    return options.error().message;
}

TEST(HandOptions, ReadsNumbersAndWordsAndFallsBackToDefaults) {
    const Result<HandOptions> options = HandOptions::parse("hand 'test'", "columns=a+b,seed=7", keys);
    ASSERT_TRUE(options);
    EXPECT_EQ(options->number("seed"), 7);
    EXPECT_EQ(options->number("speed"), 0.1);
    EXPECT_EQ(options->words("columns"), "a+b");
    EXPECT_TRUE(options->given("seed"));
    EXPECT_FALSE(options->given("speed"));
}

TEST(HandOptions, RefusalNamesTheLegalKeys) {
    EXPECT_EQ(refusal_of("sped=1"),
              "hand 'test': unknown key 'sped'; keys are speed (0.001 to 2 m/s), seed (a whole number, 0 to "
              "9007199254740992), columns (names joined by '+')");
    EXPECT_EQ(refusal_of("speed=3"), "hand 'test': speed=3 is not allowed; speed takes 0.001 to 2 m/s");
}

TEST(HandOptions, RefusesWhatIsNoNumberOrOutOfRange) {
    for (const std::string text :
         {"speed=", "speed=abc", "speed=0.1x", "speed=nan", "speed=inf", "speed=-1", "speed=0", "speed= 1",
          "seed=1.5", "seed=-1", "seed=1e300", "columns=", "speed", "=1", ",", "speed=1,", "speed=1,,seed=1",
          "speed=1,speed=1", "Speed=1"}) {
        EXPECT_FALSE(refusal_of(text).empty()) << text;
    }
}

TEST(MakeHand, RefusesUnknownHandsKeysAndCounts) {
    const FakeProbe probe = flat_view();
    const Workspace workspace = default_workspace(640, 500, 800);
    const auto refusal = [&](const std::string& description, int fingers) {
        const auto hand = make_hand(description, fingers, workspace, probe);
        if (hand) return std::string("accepted");
        EXPECT_EQ(hand.error().kind, ErrorKind::usage) << description;
        EXPECT_EQ(hand.error().message.find('\n'), std::string::npos);
        return hand.error().message;
    };
    EXPECT_EQ(refusal("wave", 1),
              "unknown hand 'wave'; must be one of wander, stroke, press, poke, csv:FILE, rec:FILE");
    EXPECT_EQ(refusal("", 1),
              "unknown hand ''; must be one of wander, stroke, press, poke, csv:FILE, rec:FILE");
    EXPECT_EQ(refusal("wander", 0), "a hand has 1 to 256 fingers, not 0");
    EXPECT_EQ(refusal("wander:speed=1.5,max_speed=1", 1),
              "hand 'wander': max_speed is below speed; raise it to at least speed");
    for (const std::string description :
         {"wander:angle=3", "stroke:seed=3", "press:speed=0.1", "press:extent=0.5", "poke:angle=3",
          "wander:depth=51", "press:x=1.01", "csv", "csv:", "csv::columns=a", "csv:f.csv:colums=a",
          "csv:f.csv", "csv:f.csv:columns=a+b", "csv:f.csv:columns=a,extent=0.05",
          "csv:f.csv:columns=a+b+c,extent=0.05,scale=2", "csv:f.csv:columns=a,rate=5,time=t",
          "csv:f.csv:columns=a,contact=1", "csv:f.csv:columns=a,scale=0"}) {
        EXPECT_NE(refusal(description, 1), "accepted") << description;
    }
}

}  // namespace
}  // namespace touchable
