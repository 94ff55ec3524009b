// SPDX-License-Identifier: Apache-2.0
// What keys are called on keyboards of many languages. GLFW's numbers of letters and digits are those of
// ASCII.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "player/window/clip_picture.hpp"
#include "player/window/command_table.hpp"
#include "player/window/kiosk.hpp"
#include "player/window/panel_facts.hpp"
#include "player/window/panel_parts.hpp"
#include "player/window/play_window.hpp"
#include "player/window/screen.hpp"
#include "player/window/user_files.hpp"
#include "player/window/window_command.hpp"
#include "player/window/window_input.hpp"
#include "tests/temporary_files.hpp"
#include "tests/window/scripted_window.hpp"

namespace touchable::test {
namespace {

TEST(Keys, LettersFollowLayout) {
    EXPECT_EQ(name_of_key('Q', "q"), "q");
    EXPECT_EQ(name_of_key('Q', "a"), "a") << "French";
    EXPECT_EQ(name_of_key('Y', "z"), "z") << "German";
    EXPECT_EQ(name_of_key(59, "m"), "m") << "French, where others have a semicolon";
    EXPECT_EQ(name_of_key('I', "\u0131"), "") << "Turkish, which has an i elsewhere";
    EXPECT_EQ(name_of_key('M', ","), "") << "French: comes as a sign";
}

TEST(Keys, NonLatinLayoutsUsePosition) {
    EXPECT_EQ(name_of_key('F', "\u0430"), "f") << "Russian";
    EXPECT_EQ(name_of_key('F', "\u03c6"), "f") << "Greek";
    EXPECT_EQ(name_of_key('F', "\u05db"), "f") << "Hebrew";
    EXPECT_EQ(name_of_key('F', nullptr), "f");
    EXPECT_EQ(name_of_key(59, "\u0436"), "") << "Russian, where no letter is";
}

TEST(Keys, DigitsIgnoreLayout) {
    EXPECT_EQ(name_of_key('2', "2"), "2");
    EXPECT_EQ(name_of_key('2', "\u00e9"), "2") << "French";
    EXPECT_EQ(name_of_key('1', "&"), "1") << "French";
    EXPECT_EQ(name_of_key('1', "+"), "") << "Czech: the sign does something itself";
    EXPECT_EQ(name_of_key(321, "1"), "1") << "of the block of digits";
}

TEST(Keys, SignsFollowTypedText) {
    for (const KeyBinding& binding : key_bindings()) {
        const std::string key = binding.key;
        const bool is_sign = key.size() == 1 && !std::isalnum(static_cast<unsigned char>(key[0]));
        if (!is_sign) continue;
        EXPECT_EQ(name_of_sign(static_cast<unsigned char>(key[0])), key);
        EXPECT_EQ(name_of_key(key[0], binding.key), "") << key << " would count twice";
        EXPECT_FALSE(binding.shift) << key << " is typed with it or without";
    }
    EXPECT_EQ(name_of_sign(0x61F), "?") << "Arabic";
    for (const unsigned other :
         {unsigned{'a'}, unsigned{'Z'}, unsigned{'7'}, unsigned{' '}, 0x7FU, 0xDFU, 0x430U, 0x1F600U})
        EXPECT_EQ(name_of_sign(other), "");
}

// The list of keys: what is in it, and that all of it can be read in windows from 640x400 on.

PanelFacts facts_of(bool is_held) {
    PanelFacts facts;
    if (is_held) facts.hand.emplace().buttons = 2;
    return facts;
}

/// Rows of all groups that say so.
int rows_that_say(const std::vector<HelpGroup>& groups, const std::string& what) {
    int count = 0;
    for (const HelpGroup& group : groups)
        count += static_cast<int>(std::count_if(group.rows.begin(), group.rows.end(),
                                                [&](const HelpGroup::Row& row) { return row.what == what; }));
    return count;
}

TEST(Help, ListsEachKeyOnce) {
    const auto by_pointer = help_groups(facts_of(false)), by_hand = help_groups(facts_of(true));
    for (const KeyBinding& binding : key_bindings()) {
        if (!binding.what) continue;
        const int of_pointer = rows_that_say(by_pointer, binding.what),
                  of_hand = rows_that_say(by_hand, binding.what);
        EXPECT_EQ(std::max(of_pointer, of_hand), 1) << binding.what;
        const bool leads_a_device = binding.verb == WindowVerb::clutch ||
                                    binding.verb == WindowVerb::recentre ||
                                    binding.verb == WindowVerb::coarser;
        EXPECT_EQ(of_pointer, leads_a_device ? 0 : 1) << binding.what;
    }
    for (const char* const what : {"number of fingers", "loop on or off", "pick up or put away the brush",
                                   "show or hide this list", "quieter or louder"})
        EXPECT_EQ(rows_that_say(by_pointer, what), 1) << what;
    EXPECT_EQ(rows_that_say(by_hand, "number of fingers"), 0);
}

TEST(Help, StartsWithTheBasics) {
    const std::vector<HelpGroup> groups = help_groups(facts_of(false));
    ASSERT_FALSE(groups.empty());
    std::string keys;
    for (const HelpGroup::Row& row : groups[0].rows) keys += row.keys + "; ";
    EXPECT_EQ(keys, "Left button; Right button; Ctrl and drag; Home; PageUp  PageDown  <  >; T; ");
    EXPECT_TRUE(contains(groups[0].rows[1].what, "presses deeper")) << "it is no habit of other players";
}

TEST(Help, MergesShiftVariants) {
    for (const HelpGroup& group : help_groups(facts_of(false)))
        for (const HelpGroup::Row& row : group.rows)
            if (row.what.find("Shift ten") != std::string::npos) {
                EXPECT_EQ(row.keys, "Left  Right");
            } else if (row.what.find("redo") != std::string::npos) {
                EXPECT_EQ(row.keys, "Ctrl Z  Y  Ctrl Shift Z") << "which does something else";
            }
}

/// The box of the help before the picture, and after the wheel was turned over it.
std::pair<Image, Image> turned_at(const std::string& size, const std::string& middle) {
    const std::string open = "0.1 key ?\n0.2 move " + middle + "\n";
    const std::string clip = made_clip("globe", 1).string();
    return {played_by({clip}, open, "1", size).image,
            played_by({clip}, open + "0.3 wheel -50\n", "1", size).image};
}

TEST(Help, ScrollsToItsEnd) {
    const auto [top, end] = turned_at("640x400", "300 150");
    EXPECT_GT(differences(top, end, {90, 30, 540, 300}), 4000) << "it did not move";
    // The ground of what says that there is more, in the box's last line beside the words.
    const auto blue_at = [](const Image& image) {
        return image.samples[static_cast<std::size_t>(image.channels * (318 * image.width + 120) + 2)];
    };
    EXPECT_GT(blue_at(top), 45) << "nothing says that there is more";
    EXPECT_LT(blue_at(end), 45) << "there is no more";
}

TEST(Help, FitsInLargeWindow) {
    const auto [top, end] = turned_at("1280x720", "640 300");
    EXPECT_EQ(differences(top, end, {140, 110, 1140, 550}), 0) << "something was scrolled to";
}

TEST(Notices, RemarksExpireBeforeFaults) {
    Notices notices;
    notices.say("no such clip", Tone::fault, 0);
    notices.say("volume 80 %", Tone::remark, 1);
    notices.pass(4.9);
    EXPECT_EQ(notices.passing(), "volume 80 %");
    EXPECT_FALSE(notices.is_refusal());
    notices.pass(5.1);
    EXPECT_EQ(notices.passing(), "");
    notices.say("the disk is full", Tone::fault, 20);
    notices.pass(34.8);
    ASSERT_EQ(notices.faults().size(), 2U);
    EXPECT_EQ(notices.faults().front(), "no such clip");
    notices.pass(35);
    notices.pass(36);
    notices.pass(65.9);
    ASSERT_EQ(notices.faults().size(), 1U) << "each is shown for 30 s";
    EXPECT_EQ(notices.faults().front(), "the disk is full");
    EXPECT_TRUE(notices.dismiss());
    EXPECT_TRUE(notices.faults().empty());
    EXPECT_FALSE(notices.dismiss()) << "Escape is free for something else";
}

TEST(Notices, FaultsQueueWithoutRepeats) {
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

TEST(Notices, LeaveWithTheirClip) {
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

namespace fs = std::filesystem;

Playlist list_of(const std::vector<std::string>& names, bool wraps = false) {
    std::vector<ClipChoice> clips;
    for (const std::string& name : names) clips.emplace_back().file = name;
    return Playlist(std::move(clips), wraps);
}

TEST(Playlist, StopsAtBothEnds) {
    Playlist list = list_of({"a", "b"});
    EXPECT_EQ(list.go(-1), nullptr);
    EXPECT_EQ(list.now().file, "a");
    ASSERT_NE(list.go(1), nullptr);
    EXPECT_EQ(list.now().file, "b");
    EXPECT_EQ(list.go(1), nullptr);
    EXPECT_EQ(list.place(), 1U);
    ASSERT_NE(list.go(-1), nullptr);
    EXPECT_EQ(list.now().file, "a");
}

TEST(Playlist, WrapsAround) {
    Playlist list = list_of({"a", "b", "c"}, true);
    EXPECT_EQ(list.go(-1)->file, "c");
    EXPECT_EQ(list.go(1)->file, "a");
    Playlist alone = list_of({"a"}, true);
    EXPECT_EQ(alone.go(1), nullptr) << "it would be opened again and again";
    EXPECT_EQ(alone.go(-1), nullptr);
}

TEST(Playlist, FolderIsSortedByName) {
    const TemporaryFolder folder;
    for (const char* name : {"clip10.mkv", "clip2.MKV", "b.webm", ".hidden.mkv", "notes.txt"})
        std::ofstream(folder / name) << "x";
    fs::create_directories(folder / "pictures");
    std::ofstream(folder / "pictures/scene.json") << "{}";
    fs::create_directories(folder / "others");
    const std::vector<fs::path> clips{folder / "b.webm", folder / "clip2.MKV", folder / "clip10.mkv",
                                      folder / "pictures"};
    EXPECT_EQ(clips_of(folder.path()), clips);
    // A folder that is a clip, or has none, stands for itself.
    EXPECT_EQ(clips_of(folder / "pictures"), std::vector<fs::path>{folder / "pictures"});
    EXPECT_EQ(clips_of(folder / "others"), std::vector<fs::path>{folder / "others"});
    EXPECT_EQ(clips_of(folder / "b.webm"), std::vector<fs::path>{folder / "b.webm"});
    EXPECT_EQ(clips_of("nowhere"), std::vector<fs::path>{"nowhere"});
    std::ofstream(folder / "scene.json") << "{}";
    EXPECT_EQ(clips_of(folder.path()), std::vector<fs::path>{folder.path()});
}

TEST(FileList, HasFoldersClipsAndRecent) {
    const TemporaryFolder folder;
    for (const char* name : {"clip10.mkv", "clip2.MKV", ".hidden.mkv", "notes.txt"})
        std::ofstream(folder / name) << "x";
    fs::create_directories(folder / "others/inner");
    fs::create_directories(folder / "pictures");
    std::ofstream(folder / "pictures/scene.json") << "{}";
    const auto list =
        list_files(folder / "others/..", {(folder / "gone.mkv").string(), (folder / "clip10.mkv").string()});
    ASSERT_TRUE(list) << list.error().message;
    std::string rows;
    for (const FileList::Row& row : list->rows) rows += row.words + (row.is_folder ? "*; " : "; ");
    EXPECT_EQ(rows, "clip10.mkv, in " + folder.path().string() +
                        "; ../*; others/*; clip2.MKV; clip10.mkv; pictures; open this folder; ");
    EXPECT_EQ(list->rows[0].path, folder / "clip10.mkv");
    EXPECT_EQ(list->rows[1].path, fs::canonical(folder.path()).parent_path());
    EXPECT_TRUE(list_files("", {})->rows.empty());
    EXPECT_TRUE(contains(list_files(folder / "nowhere", {}).error().message, "cannot be listed"));
}

TEST(DoubleClick, NeedsTwoQuickClosePresses) {
    DoubleClick click;
    EXPECT_FALSE(click.press(0, {100, 100}));
    EXPECT_TRUE(click.press(0.25, {103, 98}));
    EXPECT_FALSE(click.press(0.4, {103, 98})) << "a third is a first again";
    EXPECT_FALSE(click.press(0.8, {103, 98})) << "too late";
    EXPECT_FALSE(click.press(1.0, {140, 98})) << "elsewhere";
    click.forget();
    EXPECT_FALSE(click.press(1.1, {140, 98}));
}

/// After so many frames, 16.7 ms apart.
bool is_why_after(int frames, double read_ms, double build_ms, double late_share) {
    SlowReading reading;
    WatchedFigures figures;
    for (int frame = 1; frame <= frames; ++frame) {
        figures.feed.frames = frame;
        figures.feed.read_ms = read_ms;
        figures.feed.build_ms = build_ms;
        figures.late_frames = static_cast<std::int64_t>(late_share * frame);
        // Looked at by every picture, of which a frame has several.
        for (int picture = 0; picture < 3; ++picture) reading.add(figures, 16.7);
    }
    EXPECT_NEAR(reading.read_ms(), read_ms, 1e-9);
    return reading.is_why();
}

TEST(SlowReading, IsNoticedForLateFrames) {
    EXPECT_TRUE(is_why_after(64, 18, 6, 0.8));
    EXPECT_TRUE(is_why_after(64, 10, 6, 0.3));
}

TEST(SlowReading, IgnoresOtherCauses) {
    EXPECT_FALSE(is_why_after(64, 18, 6, 0)) << "frames are in time";
    EXPECT_FALSE(is_why_after(15, 18, 6, 1)) << "they were few, as at the beginning";
    EXPECT_FALSE(is_why_after(1000, 18, 6, 0.1)) << "few of many";
    EXPECT_FALSE(is_why_after(64, 10, 30, 0.8)) << "building takes longer";
    EXPECT_FALSE(is_why_after(64, 2, 1, 0.8)) << "something else of the machine";
}

// An unattended window.

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
