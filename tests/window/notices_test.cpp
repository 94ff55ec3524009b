#include "player/window/panel_facts.hpp"

#include <gtest/gtest.h>

namespace touchable::test {
namespace {

TEST(Notices, RemarksGoByThemselvesAndFaultsWhenTheyWereRead) {
    Notices notices;
    notices.say("no such clip", Tone::fault, 0);
    notices.say("volume 80 %", Tone::remark, 1);
    notices.pass(4.9);
    EXPECT_EQ(notices.passing(), "volume 80 %");
    EXPECT_FALSE(notices.is_refusal());
    notices.pass(5.1);
    EXPECT_EQ(notices.passing(), "");
    notices.pass(1e6);
    ASSERT_EQ(notices.faults().size(), 1U);
    EXPECT_EQ(notices.faults().front(), "no such clip");
    EXPECT_TRUE(notices.dismiss());
    EXPECT_TRUE(notices.faults().empty());
    EXPECT_FALSE(notices.dismiss()) << "Escape is free for something else";
}

TEST(Notices, FaultsWaitForEachOtherOnceEach) {
    Notices notices;
    for (const char* words : {"a", "b", "a", "c", "d", "e"}) notices.say(words, Tone::fault, 0);
    EXPECT_EQ(notices.faults(), (std::deque<std::string>{"a", "b", "c", "d", "e"}));
    notices.say("f", Tone::fault, 0);
    EXPECT_EQ(notices.faults(), (std::deque<std::string>{"b", "c", "d", "e", "f"})) << "five wait at most";
    notices.say("no brush here", Tone::refusal, 0);
    EXPECT_TRUE(notices.is_refusal());
    notices.clear_passing();
    EXPECT_EQ(notices.passing(), "");
    EXPECT_EQ(notices.faults().size(), 5U);
}

TEST(Notices, GoWithTheirClip) {
    Notices notices;
    notices.say("a.mkv: breaks off", Tone::fault, 0, About::clip);
    notices.say("the disk is full", Tone::fault, 0);
    notices.say("camera and unit are guessed", Tone::remark, 0);
    notices.leave_clip();
    EXPECT_EQ(notices.passing(), "");
    EXPECT_EQ(notices.faults(), (std::deque<std::string>{"the disk is full"}));
    notices.say("a.mkv: breaks off", Tone::fault, 1);
    notices.leave_clip();
    EXPECT_EQ(notices.faults().size(), 2U) << "this time it is about no clip";
}

}  // namespace
}  // namespace touchable::test
