// A window that nobody watches over.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "player/control/kiosk.hpp"
#include "player/control/window_command.hpp"
#include "tests/player/program.hpp"

namespace touchable::test {
namespace {

using Kind = InputEvent::Kind;

TEST(Kiosk, InvitesWhereNobodyIsAndForgetsAVisitOnce) {
    KioskWatch watch({20, 60});
    EXPECT_FALSE(watch.invites(19.9));
    EXPECT_DOUBLE_EQ(watch.invites(22).value_or(-1), 2);
    EXPECT_FALSE(watch.begins_anew(100)) << "nobody has changed anything yet";
    watch.came(100);
    EXPECT_FALSE(watch.invites(119));
    EXPECT_TRUE(watch.invites(121));
    EXPECT_FALSE(watch.begins_anew(159));
    EXPECT_TRUE(watch.begins_anew(160));
    EXPECT_FALSE(watch.begins_anew(161)) << "once";
    EXPECT_TRUE(watch.invites(161)) << "until somebody comes";
    watch.came(36000);
    EXPECT_FALSE(watch.invites(36001));
    EXPECT_TRUE(watch.begins_anew(36060));
}

TEST(Kiosk, VisitorsNeitherEndItNorOpenNorLeaveFiles) {
    const auto may = [](Kind kind, const char* word, bool shift = false) {
        InputEvent event;
        event.kind = kind;
        event.word = word;
        event.shift = shift;
        return is_for_visitors(event);
    };
    for (const char* key : {"escape", "f12", "f11", "tab", "?", "f1", "b", "l", "j", "k"})
        EXPECT_FALSE(may(Kind::key, key)) << key;
    EXPECT_FALSE(may(Kind::key, "backspace", true));
    EXPECT_FALSE(may(Kind::close, ""));
    EXPECT_FALSE(may(Kind::dropped, "other.mkv"));
    const InputEvent arrow{.kind = Kind::key, .word = "left", .control = true};
    EXPECT_TRUE(is_for_visitors(arrow));
    for (const char* key : {"space", "left", "f", "1", "5", "w", "home", "m", "c", "r"})
        EXPECT_TRUE(may(Kind::key, key)) << key;
    EXPECT_TRUE(may(Kind::pressed, "left"));
    EXPECT_TRUE(may(Kind::resized, ""));
}

TEST(Kiosk, FingerThatShowsHowStaysInThePictureAndComesBack) {
    int pressed = 0;
    for (int k = 0; k < 1000; ++k) {
        const ShownStroke stroke = stroke_at(k * 0.037);
        EXPECT_LT(std::abs(stroke.off.x), 0.3);
        EXPECT_LT(std::abs(stroke.off.y), 0.2) << "below are words";
        pressed += stroke.pressed;
    }
    EXPECT_GT(pressed, 500);
    EXPECT_LT(pressed, 900) << "it never leaves the surface";
}

}  // namespace
}  // namespace touchable::test
