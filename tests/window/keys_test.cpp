// What keys are called on keyboards of many languages. GLFW's numbers of letters and digits are those of
// ASCII.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "player/window/clip_picture.hpp"
#include "player/window/command_table.hpp"
#include "player/window/panel_facts.hpp"
#include "player/window/panel_parts.hpp"
#include "player/window/play_window.hpp"
#include "player/window/screen.hpp"
#include "player/window/user_files.hpp"
#include "player/window/window_command.hpp"
#include "player/window/window_input.hpp"
#include "tests/temporary_folder.hpp"
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
    EXPECT_EQ(rows_that_say(by_hand, "so many fingers"), 0);
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

TEST(Notices, RemarksExpireFaultsWait) {
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
    EXPECT_EQ(list.previous(), nullptr);
    EXPECT_EQ(list.now().file, "a");
    ASSERT_NE(list.next(), nullptr);
    EXPECT_EQ(list.now().file, "b");
    EXPECT_EQ(list.next(), nullptr);
    EXPECT_EQ(list.place(), 1U);
    ASSERT_NE(list.previous(), nullptr);
    EXPECT_EQ(list.now().file, "a");
}

TEST(Playlist, WrapsAround) {
    Playlist list = list_of({"a", "b", "c"}, true);
    EXPECT_EQ(list.previous()->file, "c");
    EXPECT_EQ(list.next()->file, "a");
    Playlist alone = list_of({"a"}, true);
    EXPECT_EQ(alone.next(), nullptr) << "it would be opened again and again";
    EXPECT_EQ(alone.previous(), nullptr);
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

}  // namespace
}  // namespace touchable::test
