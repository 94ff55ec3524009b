// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <set>
#include <string>
#include <tuple>

#include "player/session/touch_setup.hpp"
#include "player/window/command_table.hpp"
#include "player/window/user_files.hpp"
#include "player/window/window_clips.hpp"
#include "player/window/window_clock.hpp"
#include "player/window/window_command.hpp"
#include "tests/window/scripted_window.hpp"

namespace touchable::test {
namespace {

TEST(WindowCommand, EachKeyHasOneCommand) {
    std::set<std::tuple<std::string, bool, bool>> keys;
    bool first = true;
    for (const KeyBinding& binding : key_bindings()) {
        EXPECT_TRUE(keys.insert({binding.key, binding.shift, binding.control}).second) << binding.key;
        EXPECT_TRUE(!first || binding.what) << "nothing is above it";
        first = false;
    }
}

TEST(CommandTable, HasOneRowPerVerb) {
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

TEST(CommandTable, ParticipantCommandsAreVisitorCommands) {
    int visitors = 0, participants = 0;
    for (const CommandRow& row : command_rows()) {
        visitors += row.has(CommandRow::for_visitors);
        participants += row.has(CommandRow::for_participants);
        EXPECT_TRUE(row.has(CommandRow::for_visitors) || !row.has(CommandRow::for_participants));
    }
    EXPECT_EQ(visitors, 17);
    EXPECT_EQ(participants, 9);
}

TEST(CommandTable, AlternatesPairedKeys) {
    std::string keys;
    for (const KeyBinding& binding : key_bindings())
        if (binding.verb == WindowVerb::point_down || binding.verb == WindowVerb::point_right)
            keys += binding.key;
    EXPECT_EQ(keys, "wasd");
}

TEST(CommandTable, HintsAtValidValues) {
    const struct {
        const char *words, *right;
    } faults[] = {{"home 3", "home needs nothing else"}, {"clutch", "clutch needs on or off"},
                  {"size 10x10", "such as 1280x720"},    {"fingers 2.5", "a whole number from 1 to 5"},
                  {"screenshot a.mkv", "ends in .png"},  {"open", "open needs a name"}};
    for (const auto& fault : faults)
        EXPECT_TRUE(contains(parse_window_command(fault.words).error().message, fault.right));
}

TEST(WindowCommand, ControlArrowsTurnView) {
    ASSERT_TRUE(binding_of("left", true, false) && binding_of("left", false, false));
    EXPECT_EQ(binding_of("left", true, false)->verb, WindowVerb::turn);
    EXPECT_EQ(binding_of("up", true, false)->verb, WindowVerb::tilt);
    EXPECT_EQ(binding_of("left", false, false)->verb, WindowVerb::seek_by);
    EXPECT_EQ(binding_of("up", false, false), nullptr);
    for (const bool control : {false, true})
        for (const bool shift : {false, true}) {
            ASSERT_TRUE(binding_of("f", control, shift)) << "the stop, also with another key held";
            EXPECT_EQ(binding_of("f", control, shift)->verb, WindowVerb::force);
        }
    for (const WindowVerb verb : {WindowVerb::turn, WindowVerb::tilt})
        EXPECT_TRUE(row_of(verb).has(CommandRow::by_steps)) << "a held key repeats it";
}

TEST(WindowCommand, ParsesNumberAndWord) {
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

TEST(WindowCommand, ParsesClutch) {
    for (const char* words : {"clutch on", "clutch off"}) {
        const auto clutch = parse_window_command(words);
        ASSERT_TRUE(clutch) << words;
        EXPECT_EQ(clutch->verb, WindowVerb::clutch);
        EXPECT_EQ(clutch->number, std::string(words) == "clutch on" ? 1 : 0);
    }
    EXPECT_TRUE(parse_window_command("recentre"));
    EXPECT_EQ(parse_window_command("hand-scale 0.5").value().verb, WindowVerb::feel);
}

TEST(WindowCommand, RejectsInvalid) {
    for (const char* words :
         {"jump 3",     "",         "seek",           "seek x",      "seek nan", "seek -1",
          "speed 5",    "step 2",   "fingers 6",      "fingers 2.5", "step 0.5", "screenshot a.mkv",
          "size 10x10", "size 640", "size 640x480x2", "home 3",      "clutch",   "clutch 1",
          "recentre 2", "open",     "deeper 1 2"}) {
        const auto read = parse_window_command(words);
        ASSERT_FALSE(read) << words;
        EXPECT_EQ(read.error().kind, ErrorKind::usage);
    }
    EXPECT_TRUE(contains(parse_window_command("jump 3").error().message, "seek"));
    EXPECT_TRUE(contains(parse_window_command("speed 5").error().message, "0.1 to 4"));
}

TEST(WindowCommand, ParsesMeasure) {
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
        EXPECT_TRUE(contains(read.error().message, "two pixels"));
    }
    ASSERT_TRUE(binding_of("t", false, false));
    EXPECT_EQ(binding_of("t", false, false)->verb, WindowVerb::measure);
}

TEST(WindowCommand, ParsesTouchSettings) {
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
    } faults[] = {{"median 4", "0 (off), 3 or 5"},
                  {"median", "0 (off), 3 or 5"},
                  {"metric metre", "world, pixel or scaled"},
                  {"max-force 21", "0.1 to 20 N"},
                  {"max-force nan", "to 20"},
                  {"max-stiffness 0", "0.1 to 10 N/mm"},
                  {"fill-holes 1.5", "whole"},
                  {"temporal 5", "off or on"},
                  {"hand-scale 0", "0.01 to 100"},
                  {"settings c", "a or b"},
                  {"reset 1", "nothing"}};
    for (const auto& fault : faults) {
        const auto read = parse_window_command(fault.words);
        ASSERT_FALSE(read) << fault.words;
        EXPECT_EQ(read.error().kind, ErrorKind::usage);
        EXPECT_TRUE(contains(read.error().message, fault.right));
    }
    EXPECT_TRUE(contains(parse_window_command("jump").error().message, "median"));
}

Result<std::vector<ScriptedInput>> read_words(const std::string& words) {
    const TemporaryFolder folder;
    std::ofstream(folder / "script") << words;
    return read_window_script(folder / "script");
}

TEST(ScriptClock, SkipsStandstills) {
    ScriptClock clock;
    EXPECT_DOUBLE_EQ(clock.at(0), 0);
    EXPECT_DOUBLE_EQ(clock.at(0.03), 0.03);
    EXPECT_NEAR(clock.at(5.03), 0.13, 1e-12) << "0.1 s of it";
    EXPECT_NEAR(clock.at(5.05), 0.15, 1e-12);
    EXPECT_NEAR(clock.at(5.15, true), 0.15, 1e-12) << "while a brush works it stands";
    EXPECT_NEAR(clock.at(5.2), 0.2, 1e-12);
}

TEST(WindowScript, KeepsOrder) {
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

TEST(WindowScript, ParsesTouches) {
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

TEST(WindowScript, NamesLineOfFault) {
    const struct {
        const char *words, *where, *what;
    } faults[] = {{"0 move 1\n", "line 1", "two numbers"},
                  {"0 move 1 2\nx key a\n", "line 2", "a time"},
                  {"2 key a\n1 key b\n", "line 2", "before that of the line above"},
                  {"0 press up\n", "line 1", "left, right or middle"},
                  {"0 wheel\n", "line 1", "notches"},
                  {"0 dance\n", "line 1", "unknown command"},
                  {"nan key a\n", "line 1", "a time"},
                  {"-1 key a\n", "line 1", "a time"},
                  {"0 key esc\n", "line 1", "escape"},
                  {"0 key end\n", "line 1", "unknown key 'end'"},
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
        EXPECT_TRUE(contains(read.error().message, fault.where));
        EXPECT_TRUE(contains(read.error().message, fault.what));
        EXPECT_EQ(read.error().message.find("or an input:") != std::string::npos,
                  std::string_view(fault.what) == "unknown command")
            << read.error().message;
    }
    EXPECT_FALSE(read_window_script("nowhere/at/all"));
}

namespace fs = std::filesystem;

SessionSettings felt(std::initializer_list<std::pair<const char*, const char*>> values) {
    SessionSettings settings;
    for (const auto& [name, value] : values) EXPECT_TRUE(settings.set(name, value)) << name;
    return settings;
}

void put(const fs::path& file, const std::string& words) {
    std::ofstream(file) << words;
}

TEST(SessionSettings, FiltersReplaceSingleFilters) {
    SessionSettings settings =
        felt({{"median", "5"}, {"max-force", "2.50"}, {"filters", "off"}, {"temporal", "on"}});
    EXPECT_EQ(settings.in_words(), "max-force 2.5 N, filters off, temporal on");
    EXPECT_TRUE(settings.set("filters", "clip"));
    EXPECT_EQ(settings, felt({{"max-force", "2.5"}}));
    EXPECT_EQ(SessionSettings().in_words(), "as the clip says");
}

TEST(SessionSettings, OverrideRunOptions) {
    SessionOptions typed;
    typed.clip.single_filters = {.settings = {.median = 3, .temporal = true, .temporal_noise = {2, 0}},
                                 .stated = {.median = true, .temporal = true}};
    const SessionOptions as_typed = with_settings(typed, {});
    EXPECT_EQ(as_typed.clip.single_filters.settings, typed.clip.single_filters.settings);
    EXPECT_EQ(as_typed.clip.filters.stated, FilterSet());
    EXPECT_EQ(as_typed.clip.filters.measured, FilterSet());
    const SessionOptions off = with_settings(
        typed, felt({{"filters", "off"}, {"fill-holes", "2"}, {"metric", "pixel"}, {"max-stiffness", "2"}}));
    EXPECT_EQ(off.clip.single_filters.stated, FilterSet{.fill_holes = true})
        << "nothing that the command line says of filters";
    EXPECT_EQ(off.clip.single_filters.settings, FilterSettings{.fill_holes = 2});
    FilterSet but_the_reach = all_unstated;
    but_the_reach.terrace_reach = false;
    EXPECT_EQ(off.clip.filters.stated, but_the_reach);
    EXPECT_EQ(off.clip.filters.settings, FilterSettings());
    EXPECT_EQ(off.clip.filters.measured, FilterSet());
    EXPECT_EQ(off.touch.metric, TouchMetric::pixel);
    EXPECT_EQ(off.guard.max_stiffness, 2000);
    EXPECT_EQ(with_settings(typed, felt({{"filters", "auto"}})).clip.filters.measured, all_unstated);
    EXPECT_EQ(with_settings(typed, felt({{"terraces", "auto"}})).clip.single_filters.settings.terraces,
              TerraceRemoval::automatic);
    EXPECT_EQ(with_settings(typed, felt({{"interpolation", "hold"}})).clip.interpolation,
              FrameInterpolation::hold);
    EXPECT_EQ(with_settings(typed, felt({{"max-force", "5"}})).guard.max_force, 5);
}

TEST(SessionSettings, ReliefNeedsAnAmount) {
    SessionSettings settings;
    ASSERT_TRUE(settings.set("relief-fine", "-100"));
    EXPECT_FALSE(with_settings({}, settings).clip.relief);
    ASSERT_TRUE(settings.set("relief", "150"));
    ASSERT_TRUE(settings.set("relief-invert", "on"));
    ASSERT_TRUE(settings.set("relief-height", "2"));
    const auto relief = with_settings({}, settings).clip.relief;
    ASSERT_TRUE(relief);
    EXPECT_EQ(relief->settings, (ReliefSettings{{-100, 70, 40}, 150, true}));
    EXPECT_EQ(relief->height_mm, 2);
    EXPECT_FALSE(settings.set("relief", "401"));
    // A recording would not know of it.
    SessionOptions recorded = with_settings({}, settings);
    recorded.recorded = true;
    const auto refused = validate(recorded);
    ASSERT_FALSE(refused);
    EXPECT_TRUE(contains(refused.error().message, "touchable relief"));
}

TEST(TwoSettings, BStartsUnfiltered) {
    TwoSettings two;
    EXPECT_TRUE(two.now().set("median", "5"));
    EXPECT_TRUE(two.now().set("metric", "scaled"));
    two.turn_to(true);
    EXPECT_EQ(two.now(), felt({{"metric", "scaled"}, {"filters", "off"}}));
    EXPECT_TRUE(two.now().set("median", "3"));
    two.turn_to(false);
    EXPECT_EQ(two.now(), felt({{"metric", "scaled"}, {"median", "5"}}));
    two.turn_to(true);
    EXPECT_EQ(two.in_words(), "B: metric scaled, filters off, median 3");
}

TEST(WindowSettings, TellPaintAndSettings) {
    WindowSettings settings;
    EXPECT_EQ(settings.in_words(), "A: as the clip says");
    settings.painted = std::make_shared<PaintedSegments>();
    EXPECT_EQ(settings.in_words(), "A: as painted");
    EXPECT_TRUE(settings.in_effect.now().set("median", "5"));
    EXPECT_EQ(settings.in_words(), "A: median 5, as painted");
    EXPECT_TRUE(settings.in_effect.now().set("materials", "off"));
    EXPECT_FALSE(contains(settings.in_words(), "painted")) << "it is not felt";
}

class SettingsFileTest : public ::testing::Test {
protected:
    /// Two fingers, in place of what is in the file.
    static Result<void> write_two(const SettingsFile& settings) {
        KeptSettings kept;
        kept.fingers = 2;
        return settings.write(kept);
    }

    const TemporaryFolder folder;
    const fs::path file = folder / "play.json";
};

TEST_F(SettingsFileTest, RoundTrips) {
    const fs::path deep = folder / "new/folder/play.json";
    KeptSettings kept{true, 3, 900, 700, felt({{"median", "5"}, {"max-force", "2.5"}}), {}, false};
    kept.b = felt({{"filters", "off"}, {"fill-holes", "3"}});
    kept.volume = 60;
    kept.recent = {"/clips/b.mkv", "/clips/a.mkv"};
    const SettingsFile none(deep);
    EXPECT_EQ(none.read(), KeptSettings());
    EXPECT_EQ(none.message(), "");
    ASSERT_TRUE(none.write(kept));
    const SettingsFile again(deep);
    EXPECT_EQ(again.read(), kept);
    EXPECT_EQ(again.message(), "");
    // A link stays one, and nothing is written that is there already.
    fs::create_symlink(deep, folder / "link.json");
    const SettingsFile link(folder / "link.json");
    const auto written = fs::last_write_time(deep);
    EXPECT_TRUE(link.write(kept));
    EXPECT_EQ(fs::last_write_time(deep), written);
    kept.fingers = 1;
    kept.recent = {"/clips/\xff.mkv"};  // no UTF-8
    EXPECT_TRUE(link.write(kept));
    EXPECT_TRUE(fs::is_symlink(folder / "link.json"));
    EXPECT_EQ(SettingsFile(deep).read().fingers, 1);
}

TEST_F(SettingsFileTest, ReportsAndIgnoresInvalidValues) {
    put(file,
        R"({"panel": true, "sparkle": 1, "fingers": 9, "volume": 101, "window": [10, 10], "overlay": "night", "recent": ["a", 2],
                  "a": {"median": 4, "metric": "pixel", "taste": [[]]}, "b": 3})");
    const SettingsFile read(file);
    KeptSettings right;
    right.panel = true;
    right.a = felt({{"metric", "pixel"}});
    right.b.emplace();
    EXPECT_EQ(read.read(), right);
    for (const char* word : {"'sparkle' is unknown", "1 to 5", "0 to 100", "[320, 200]", "up to 8 files",
                             "0 (off), 3 or 5", "'taste'", "object"})
        EXPECT_TRUE(contains(read.message(), word));
    EXPECT_EQ(read.message().find('\n'), std::string::npos) << "a warning has one line";
    ASSERT_TRUE(read.write(read.read()));
    EXPECT_EQ(SettingsFile(file).message(), "");
}

TEST_F(SettingsFileTest, SetsAsideBrokenFile) {
    int count = 0;
    for (const char* words : {"", "{\"panel\": tr", "[1]", "\xff\xfe"}) {
        const std::string aside = "play.json.broken" + (++count == 1 ? "" : std::to_string(count));
        put(file, words);
        const SettingsFile read(file);
        EXPECT_EQ(read.read(), KeptSettings());
        EXPECT_TRUE(contains(read.message(), aside));
        EXPECT_FALSE(fs::exists(file));
        EXPECT_EQ(file_contents(folder / aside), words) << "none that was set aside is lost";
        ASSERT_TRUE(read.write(KeptSettings()));
        EXPECT_EQ(SettingsFile(file).message(), "");
    }
}

TEST_F(SettingsFileTest, LeavesForeignFileAlone) {
    const std::string labels = R"({"touchable_labels": 1, "labels": []})";
    put(folder / "labels.json", labels);
    const SettingsFile read(folder / "labels.json");
    EXPECT_TRUE(contains(read.message(), "no file of settings"));
    EXPECT_TRUE(write_two(read));
    EXPECT_EQ(file_contents(folder / "labels.json"), labels);
    // Another program's, which shares names with ours: neither its other members nor its values are lost.
    for (const std::string& shared :
         {std::string(R"({"panel": true, "fingers": 2, "theme": "dark"})"),
          std::string(R"({"window": {"x": 1, "y": 2}, "volume": 50})"), std::string(R"({"a": "alpha"})")}) {
        put(folder / "other.json", shared);
        const SettingsFile other(folder / "other.json");
        EXPECT_TRUE(contains(other.message(), "left alone"));
        EXPECT_EQ(other.message().find('\n'), std::string::npos);
        EXPECT_TRUE(write_two(other));
        EXPECT_EQ(file_contents(folder / "other.json"), shared);
    }
    // One of ours by hand, of which nothing is lost.
    put(folder / "own.json", R"({"fingers": 4, "volume": 30})");
    EXPECT_EQ(SettingsFile(folder / "own.json").message(), "");
    EXPECT_TRUE(write_two(SettingsFile(folder / "own.json")));
    EXPECT_EQ(SettingsFile(folder / "own.json").read().fingers, 2);
    put(folder / "empty.json", "{}");
    EXPECT_TRUE(write_two(SettingsFile(folder / "empty.json")));
    EXPECT_EQ(SettingsFile(folder / "empty.json").read().fingers, 2);
}

TEST_F(SettingsFileTest, LeavesUnwritableFileAlone) {
    fs::create_directory(file);
    const SettingsFile is_folder(file);
    EXPECT_TRUE(contains(is_folder.message(), "left alone"));
    EXPECT_TRUE(write_two(is_folder));
    EXPECT_TRUE(fs::is_directory(file));
    put(folder / "file", "x");
    const SettingsFile nowhere(folder / "file/touchable/play.json");
    const auto written = write_two(nowhere);
    ASSERT_FALSE(written);
    EXPECT_TRUE(contains(written.error().message, "touchable"));
    if (geteuid() == 0) return;  // root may write everywhere
    fs::create_directory(folder / "locked");
    put(folder / "locked/play.json", "{\"fingers\": 4}");
    fs::permissions(folder / "locked", fs::perms::owner_read | fs::perms::owner_exec);
    const SettingsFile locked(folder / "locked/play.json");
    EXPECT_FALSE(write_two(locked));
    EXPECT_EQ(SettingsFile(folder / "locked/play.json").read().fingers, 4);
    fs::permissions(folder / "locked", fs::perms::owner_all);
}

/// The environment as it was, once this is gone.
class Variable {
public:
    Variable(const char* name, const char* value) : name_(name) {
        if (const char* was = std::getenv(name)) was_ = was;
        set(value);
    }
    ~Variable() { set(was_ ? was_->c_str() : nullptr); }
    Variable(const Variable&) = delete;
    Variable& operator=(const Variable&) = delete;

private:
    void set(const char* value) { value ? setenv(name_, value, 1) : unsetenv(name_); }

    const char* name_;
    std::optional<std::string> was_;
};

TEST_F(SettingsFileTest, FollowsXdgConfigHome) {
    const Variable home("HOME", "/home/ada");
    {
        const Variable config("XDG_CONFIG_HOME", "/etc/ada");
        EXPECT_EQ(*own_settings_file(), "/etc/ada/touchable/play.json");
    }
    const Variable relative("XDG_CONFIG_HOME", "ada");
    EXPECT_EQ(*own_settings_file(), "/home/ada/.config/touchable/play.json");
    const Variable no_home("HOME", nullptr);
    EXPECT_FALSE(own_settings_file());
}

}  // namespace
}  // namespace touchable::test
