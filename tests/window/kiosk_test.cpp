// An unattended window.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>

#include "player/window/kiosk.hpp"
#include "player/window/window_command.hpp"
#include "tests/window/scripted_window.hpp"

namespace touchable::test {
namespace {

using Kind = InputEvent::Kind;

TEST(Kiosk, InvitesAndResetsOnce) {
    KioskWatch watch({20, 60});
    EXPECT_FALSE(watch.invites(19.9));
    EXPECT_DOUBLE_EQ(watch.invites(22).value_or(-1), 2);
    EXPECT_FALSE(watch.begins_anew(100)) << "nothing was changed yet";
    watch.came(100);
    EXPECT_FALSE(watch.invites(119));
    EXPECT_TRUE(watch.invites(121));
    EXPECT_FALSE(watch.begins_anew(159));
    EXPECT_TRUE(watch.begins_anew(160));
    EXPECT_FALSE(watch.begins_anew(161)) << "once";
    EXPECT_TRUE(watch.invites(161)) << "until a visitor comes";
    watch.came(36000);
    EXPECT_FALSE(watch.invites(36001));
    EXPECT_TRUE(watch.begins_anew(36060));
}

TEST(Kiosk, HeldFingerCountsForMinute) {
    KioskWatch watch({20, 60});
    watch.holds(50);
    EXPECT_TRUE(watch.invites(50)) << "without a visitor";
    watch.came(100);
    for (double at = 100; at < 400; ++at) watch.holds(at);
    EXPECT_FALSE(watch.invites(178));
    EXPECT_TRUE(watch.invites(180)) << "a button may be stuck";
    EXPECT_EQ(watch.ended(400)->seconds, 59);
    EXPECT_TRUE(watch.begins_anew(400));
}

TEST(Kiosk, MeasuresVisitByActions) {
    KioskWatch watch({20, 60});
    EXPECT_FALSE(watch.ended(100)) << "without a visitor";
    watch.came(100);
    EXPECT_TRUE(watch.is_there());
    watch.came(119);
    EXPECT_FALSE(watch.ended(138.9));
    const auto visit = watch.ended(139);
    ASSERT_TRUE(visit);
    EXPECT_DOUBLE_EQ(visit->came_s, 100);
    EXPECT_DOUBLE_EQ(visit->seconds, 19);
    EXPECT_FALSE(watch.is_there());
    EXPECT_FALSE(watch.ended(140)) << "once";
    watch.came(141);
    EXPECT_EQ(watch.end()->seconds, 0);
    EXPECT_FALSE(watch.end());
}

std::string texts_of(const char* language) {
    return file_contents(std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "share/kiosk" /
                         (std::string(language) + ".json"));
}

/// So translators see all of them.
TEST(KioskTexts, BundledTextsAreComplete) {
    const auto english = parse_kiosk_texts(texts_of("en"), "en.json"),
               german = parse_kiosk_texts(texts_of("de"), "de.json");
    ASSERT_TRUE(english) << english.error().message;
    ASSERT_TRUE(german) << german.error().message;
    EXPECT_EQ(*english, KioskTexts()) << "a program without its files says the same";
    EXPECT_EQ(german->language, "de");
    const std::string all = texts_of("en"), all_german = texts_of("de");
    EXPECT_EQ(std::count(all.begin(), all.end(), '\n'),
              std::count(all_german.begin(), all_german.end(), '\n'));
    for (const TouchedBy by : {TouchedBy::mouse, TouchedBy::touch_screen, TouchedBy::device}) {
        EXPECT_NE(english->how(by), german->how(by));
        EXPECT_NE(english->again(by), german->again(by));
    }
    EXPECT_FALSE(contains(german->how(TouchedBy::touch_screen), "Taste")) << "a touch screen has no button";
}

TEST(KioskTexts, DefaultToEnglish) {
    const auto message = [](const std::string& json) {
        const auto parsed = parse_kiosk_texts(json, "t.json");
        return parsed ? "" : parsed.error().message;
    };
    const std::string begin = R"({"touchable_kiosk_texts": 1, "language": "sv")";
    const auto some = parse_kiosk_texts(begin + R"(, "invitation": "Rör bilden"})", "t.json");
    ASSERT_TRUE(some) << some.error().message;
    EXPECT_EQ(some->invitation, "Rör bilden");
    EXPECT_EQ(some->force_is_off, KioskTexts().force_is_off);
    EXPECT_TRUE(contains(message(begin + R"(, "invitatoin": "x"})"), "invitation"))
        << "no word of what is right";
    EXPECT_TRUE(contains(message(begin + R"(, "invitation": ""})"), "invitation"));
    EXPECT_TRUE(contains(message(begin + R"(, "invitation": "a\nb"})"), "a line"));
    EXPECT_TRUE(contains(message(R"({"touchable_kiosk_texts": 1, "language": "Svenska"})"), "de"));
    EXPECT_TRUE(contains(message(R"({"touchable_kiosk_texts": 2, "language": "sv"})"), "must be 1"));
    EXPECT_EQ(message("x").find("t.json: "), 0U);
}

/// Folders as the Linux kernel describes its inputs.
TEST(TouchScreens, AreDirectMultitouchInputs) {
    const TemporaryFolder inputs;
    const auto add = [&](const char* name, const char* properties, const char* abs) {
        std::filesystem::create_directories(inputs / name / "capabilities");
        std::ofstream(inputs / name / "properties") << properties << "\n";
        std::ofstream(inputs / name / "capabilities/abs") << abs << "\n";
    };
    EXPECT_FALSE(has_touch_screen(inputs / "none"));
    add("input1", "0", "0");                // a keyboard
    add("input2", "5", "260800000000003");  // a touch pad: places of fingers, not on a display
    add("input3", "2", "1000d000003");      // a pen on a display
    EXPECT_FALSE(has_touch_screen(inputs.path()));
    add("input4", "2", "260800000000003");
    EXPECT_TRUE(has_touch_screen(inputs.path()));
}

TEST(Kiosk, VisitorsCannotQuitOrOpen) {
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

TEST(Kiosk, DemonstrationStaysInPicture) {
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
