#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <tuple>

#include "player/session/touch_setup.hpp"
#include "player/window/command_table.hpp"
#include "player/window/window_command.hpp"

namespace touchable::test {
namespace {

TEST(WindowCommand, EveryKeyDoesOneThing) {
    std::set<std::tuple<std::string, bool, bool>> keys;
    bool first = true;
    for (const KeyBinding& binding : key_bindings()) {
        EXPECT_TRUE(keys.insert({binding.key, binding.shift, binding.control}).second) << binding.key;
        EXPECT_TRUE(!first || binding.what) << "nothing is above it";
        first = false;
    }
}

TEST(CommandTable, HasOneRowForEachVerb) {
    for (int verb = 0; verb <= static_cast<int>(WindowVerb::quit); ++verb)
        EXPECT_EQ(std::ranges::count(command_rows(), static_cast<WindowVerb>(verb), &CommandRow::verb), 1)
            << verb;
    std::set<std::string> names;
    for (const CommandRow& row : command_rows()) {
        EXPECT_TRUE(row.handler);
        if (!row.name) continue;
        EXPECT_TRUE(names.insert(row.name).second) << row.name;
        EXPECT_EQ(command_named(row.name), &row);
        EXPECT_FALSE(session_setting(row.name)) << row.name << ": would set that, and never be done";
    }
    EXPECT_EQ(command_named("jump"), nullptr);
}

TEST(CommandTable, LetsParticipantsDoNothingThatVisitorsMayNot) {
    int visitors = 0, participants = 0;
    for (const CommandRow& row : command_rows()) {
        visitors += row.has(CommandRow::for_visitors);
        participants += row.has(CommandRow::for_participants);
        EXPECT_TRUE(row.has(CommandRow::for_visitors) || !row.has(CommandRow::for_participants));
    }
    EXPECT_EQ(visitors, 17);
    EXPECT_EQ(participants, 9);
}

TEST(CommandTable, AlternatesKeysThatBelongTogether) {
    std::string keys;
    for (const KeyBinding& binding : key_bindings())
        if (binding.verb == WindowVerb::point_down || binding.verb == WindowVerb::point_right)
            keys += binding.key;
    EXPECT_EQ(keys, "wasd");
}

TEST(CommandTable, SaysWhatIsRight) {
    const struct {
        const char *words, *right;
    } faults[] = {{"home 3", "home needs nothing else"}, {"clutch", "clutch needs on or off"},
                  {"size 10x10", "such as 1280x720"},    {"fingers 2.5", "a whole number from 1 to 5"},
                  {"screenshot a.mkv", "ends in .png"},  {"open", "open needs a name"}};
    for (const auto& fault : faults)
        EXPECT_NE(parse_window_command(fault.words).error().message.find(fault.right), std::string::npos)
            << parse_window_command(fault.words).error().message;
}

TEST(WindowCommand, ArrowsTurnTheViewWithControlAndSeekWithout) {
    ASSERT_TRUE(binding_of("left", true, false) && binding_of("left", false, false));
    EXPECT_EQ(binding_of("left", true, false)->verb, WindowVerb::turn);
    EXPECT_EQ(binding_of("up", true, false)->verb, WindowVerb::tilt);
    EXPECT_EQ(binding_of("left", false, false)->verb, WindowVerb::seek_by);
    EXPECT_EQ(binding_of("up", false, false), nullptr);
    for (const bool control : {false, true})
        for (const bool shift : {false, true}) {
            ASSERT_TRUE(binding_of("f", control, shift)) << "the stop, by whoever holds another key";
            EXPECT_EQ(binding_of("f", control, shift)->verb, WindowVerb::force);
        }
    EXPECT_TRUE(goes_by_steps(WindowVerb::turn) && goes_by_steps(WindowVerb::tilt));
}

TEST(WindowCommand, IsReadWithItsNumber) {
    const auto seek = parse_window_command("seek 1.5");
    ASSERT_TRUE(seek);
    EXPECT_EQ(seek->verb, WindowVerb::seek_to);
    EXPECT_EQ(seek->number, 1.5);
    const auto overlay = parse_window_command("overlay dynamic-friction");
    ASSERT_TRUE(overlay);
    EXPECT_EQ(overlay->word, "dynamic-friction");
    const auto next = parse_window_command("overlay");
    ASSERT_TRUE(next);
    EXPECT_EQ(next->word, "");
}

TEST(WindowCommand, HoldsAndLetsGoOfTheClutch) {
    for (const char* words : {"clutch on", "clutch off"}) {
        const auto clutch = parse_window_command(words);
        ASSERT_TRUE(clutch) << words;
        EXPECT_EQ(clutch->verb, WindowVerb::clutch);
        EXPECT_EQ(clutch->number, std::string(words) == "clutch on" ? 1 : 0);
    }
    EXPECT_TRUE(parse_window_command("recentre"));
    EXPECT_EQ(parse_window_command("hand-scale 0.5").value().verb, WindowVerb::feel);
}

TEST(WindowCommand, ThatIsNoneIsRefusedWithTheRightOnes) {
    for (const char* words :
         {"jump 3",     "",         "seek",           "seek x",      "seek nan", "seek -1",
          "speed 5",    "step 2",   "fingers 6",      "fingers 2.5", "step 0.5", "screenshot a.mkv",
          "size 10x10", "size 640", "size 640x480x2", "home 3",      "clutch",   "clutch 1",
          "recentre 2", "open",     "deeper 1 2"}) {
        const auto read = parse_window_command(words);
        ASSERT_FALSE(read) << words;
        EXPECT_EQ(read.error().kind, ErrorKind::usage);
    }
    EXPECT_NE(parse_window_command("jump 3").error().message.find("seek"), std::string::npos);
    EXPECT_NE(parse_window_command("speed 5").error().message.find("0.1 to 4"), std::string::npos);
}

TEST(WindowCommand, MeasuresBetweenTwoPixelsOfWhatIsSeen) {
    const auto measure = parse_window_command("measure 20,32 70,31");
    ASSERT_TRUE(measure) << measure.error().message;
    EXPECT_EQ(measure->verb, WindowVerb::measure);
    EXPECT_EQ(measure->places, (std::vector<PixelOfFrame>{{20, 32, -1}, {70, 31, -1}}));
    for (const char* words : {"measure", "measure off"}) {
        const auto tool = parse_window_command(words);
        ASSERT_TRUE(tool) << words;
        EXPECT_TRUE(tool->places.empty());
    }
    for (const char* words : {"measure 20,32", "measure 20,32 70", "measure 20,32 70,-1", "measure on",
                              "measure 20,32 70,31,2", "measure 1,2 3,4 5,6"}) {
        const auto read = parse_window_command(words);
        ASSERT_FALSE(read) << words;
        EXPECT_NE(read.error().message.find("two pixels"), std::string::npos) << read.error().message;
    }
    ASSERT_TRUE(binding_of("t", false, false));
    EXPECT_EQ(binding_of("t", false, false)->verb, WindowVerb::measure);
}

TEST(WindowCommand, SetsWhatIsFelt) {
    const auto median = parse_window_command("median 5");
    ASSERT_TRUE(median);
    EXPECT_EQ(median->verb, WindowVerb::feel);
    EXPECT_EQ(median->word, "median 5");
    for (const char* words :
         {"terraces auto", "temporal on", "interpolation hold", "metric pixel", "max-force 5",
          "max-stiffness 2", "fill-holes 16", "filters off", "settings", "settings b", "reset"})
        EXPECT_TRUE(parse_window_command(words)) << words;
    const struct {
        const char *words, *right;
    } faults[] = {{"median 4", "0, 3 or 5"},
                  {"median", "0, 3 or 5"},
                  {"metric metre", "world, pixel or scaled"},
                  {"max-force 21", "0.1 to 20 N"},
                  {"max-force nan", "to 20"},
                  {"max-stiffness 0", "0.1 to 10 N/mm"},
                  {"fill-holes 1.5", "whole"},
                  {"temporal 5", "off or on"},
                  {"hand-scale 0", "0.01 to 100"},
                  {"settings c", "a and b"},
                  {"reset 1", "nothing"}};
    for (const auto& fault : faults) {
        const auto read = parse_window_command(fault.words);
        ASSERT_FALSE(read) << fault.words;
        EXPECT_EQ(read.error().kind, ErrorKind::usage);
        EXPECT_NE(read.error().message.find(fault.right), std::string::npos) << read.error().message;
    }
    EXPECT_NE(parse_window_command("jump").error().message.find("median"), std::string::npos);
}

}  // namespace
}  // namespace touchable::test
