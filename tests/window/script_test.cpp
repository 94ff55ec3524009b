#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "player/window/window_command.hpp"
#include "tests/temporary_folder.hpp"

namespace touchable::test {
namespace {

Result<std::vector<ScriptedInput>> read_words(const std::string& words) {
    const TemporaryFolder folder;
    std::ofstream(folder / "script") << words;
    return read_window_script(folder / "script");
}

TEST(ScriptClock, GoesOnWhereItWasAfterAStandstill) {
    ScriptClock clock;
    EXPECT_DOUBLE_EQ(clock.at(0), 0);
    EXPECT_DOUBLE_EQ(clock.at(0.03), 0.03);
    EXPECT_NEAR(clock.at(5.03), 0.13, 1e-12) << "0.1 s of it";
    EXPECT_NEAR(clock.at(5.05), 0.15, 1e-12);
    EXPECT_NEAR(clock.at(5.15, true), 0.15, 1e-12) << "while a brush works it stands";
    EXPECT_NEAR(clock.at(5.2), 0.2, 1e-12);
}

TEST(WindowScript, InputsAndCommandsComeInTheirOrder) {
    const auto read = read_words(
        "# what a visitor does\n\n0.5 move 10 20.5\n1 press left\r\n1 key f12\n  2 seek 0.25\n3 drop a "
        "b.mkv\n");
    ASSERT_TRUE(read) << read.error().message;
    ASSERT_EQ(read->size(), 5U);
    const auto& moved = std::get<InputEvent>((*read)[0].what);
    EXPECT_EQ((*read)[0].seconds, 0.5);
    EXPECT_EQ(moved.kind, InputEvent::Kind::moved);
    EXPECT_EQ(moved.x, 10);
    EXPECT_EQ(moved.y, 20.5);
    EXPECT_EQ(std::get<InputEvent>((*read)[1].what).word, "left");
    EXPECT_EQ(std::get<InputEvent>((*read)[2].what).word, "f12");
    EXPECT_EQ(std::get<WindowCommand>((*read)[3].what).number, 0.25);
    EXPECT_EQ(std::get<InputEvent>((*read)[4].what).word, "a b.mkv");
}

TEST(WindowScript, FingersOnATouchScreenHaveNumbersAndTimes) {
    const auto read = read_words("0.5 touch 2 10 20.5\n0.75 touch-move 2 11 21\n1 touch-end 2\n1 leave\n");
    ASSERT_TRUE(read) << read.error().message;
    ASSERT_EQ(read->size(), 4U);
    const auto event = [&](std::size_t k) { return std::get<InputEvent>((*read)[k].what); };
    EXPECT_EQ(event(0).kind, InputEvent::Kind::touch_began);
    EXPECT_EQ(event(0).touch, 2);
    EXPECT_EQ(event(0).y, 20.5);
    EXPECT_EQ(event(0).seconds, 0.5);
    EXPECT_EQ(event(1).kind, InputEvent::Kind::touch_moved);
    EXPECT_EQ(event(1).seconds, 0.75);
    EXPECT_EQ(event(2).kind, InputEvent::Kind::touch_ended);
    EXPECT_EQ(event(3).kind, InputEvent::Kind::left_window);
}

TEST(WindowScript, FaultIsNamedWithItsLine) {
    const struct {
        const char *words, *where, *what;
    } faults[] = {{"0 move 1\n", "line 1", "two numbers"},
                  {"0 move 1 2\nx key a\n", "line 2", "a time"},
                  {"2 key a\n1 key b\n", "line 2", "before that of the line above"},
                  {"0 press up\n", "line 1", "left, right or middle"},
                  {"0 wheel\n", "line 1", "notches"},
                  {"0 dance\n", "line 1", "no command"},
                  {"nan key a\n", "line 1", "a time"},
                  {"-1 key a\n", "line 1", "a time"},
                  {"0 key esc\n", "line 1", "escape"},
                  {"0 key up\n", "line 1", "no key up"},  // without Ctrl
                  {"0 overlay heat\n", "line 1", "stiffness"},
                  {"0 speed fast\n", "line 1", "needs a number"},
                  {"0 touch 1 20\n", "line 1", "the number of a finger"},
                  {"0 touch 0 20 30\n", "line 1", "from 1 to 10"},
                  {"0 touch-move 1 20 30 40\n", "line 1", "two numbers"},
                  {"0 touch-end\n", "line 1", "the number of a finger"},
                  {"0 touch-end 1 2 3\n", "line 1", "the number of a finger"},
                  {"0 leave now\n", "line 1", "nothing else"},
                  {"0 drop\n", "line 1", "a file or folder"}};
    for (const auto& fault : faults) {
        const auto read = read_words(fault.words);
        ASSERT_FALSE(read) << fault.words;
        EXPECT_EQ(read.error().kind, ErrorKind::input);
        EXPECT_NE(read.error().message.find(fault.where), std::string::npos) << read.error().message;
        EXPECT_NE(read.error().message.find(fault.what), std::string::npos) << read.error().message;
        EXPECT_EQ(read.error().message.find("or an input:") != std::string::npos,
                  std::string_view(fault.what) == "no command")
            << read.error().message;
    }
    EXPECT_FALSE(read_window_script("nowhere/at/all"));
}

}  // namespace
}  // namespace touchable::test
