#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>

#include "player/window/play_window.hpp"
#include "player/window/user_files.hpp"
#include "tests/temporary_folder.hpp"

namespace touchable::test {
namespace {

namespace fs = std::filesystem;

SessionSettings felt(std::initializer_list<std::pair<const char*, const char*>> values) {
    SessionSettings settings;
    for (const auto& [name, value] : values) EXPECT_TRUE(settings.set(name, value)) << name;
    return settings;
}

void put(const fs::path& file, const std::string& words) {
    std::ofstream(file) << words;
}

std::string words_in(const fs::path& file) {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), {}};
}

TEST(SessionSettings, FiltersAtOnceTakeThePlaceOfThoseOneByOne) {
    SessionSettings settings =
        felt({{"median", "5"}, {"max-force", "2.50"}, {"filters", "off"}, {"temporal", "on"}});
    EXPECT_EQ(settings.in_words(), "max-force 2.5 N, filters off, temporal on");
    EXPECT_TRUE(settings.set("filters", "clip"));
    EXPECT_EQ(settings, felt({{"max-force", "2.5"}}));
    EXPECT_EQ(SessionSettings().in_words(), "as the clip says");
}

TEST(SessionSettings, MakeTheOptionsOfARun) {
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

TEST(SessionSettings, ReliefIsThereOnceAnyOfItIsWanted) {
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
    EXPECT_NE(refused.error().message.find("touchable relief"), std::string::npos) << refused.error().message;
}

TEST(TwoSettings, BBeginsAsAWithoutFiltersAndStaysAsItWasLeft) {
    TwoSettings two;
    EXPECT_TRUE(two.set("median", "5"));
    EXPECT_TRUE(two.set("metric", "scaled"));
    two.turn_to(true);
    EXPECT_EQ(two.now(), felt({{"metric", "scaled"}, {"filters", "off"}}));
    EXPECT_TRUE(two.set("median", "3"));
    two.turn_to(false);
    EXPECT_EQ(two.now(), felt({{"metric", "scaled"}, {"median", "5"}}));
    two.turn_to(true);
    EXPECT_EQ(two.in_words(), "B: metric scaled, filters off, median 3");
}

TEST(SettingsFile, AreReadAsTheyWereWritten) {
    const TemporaryFolder folder;
    const fs::path file = folder / "new/folder/play.json";
    KeptSettings kept{true, 3, 900, 700, felt({{"median", "5"}, {"max-force", "2.5"}}), {}, false};
    kept.b = felt({{"filters", "off"}, {"fill-holes", "3"}});
    kept.volume = 60;
    const SettingsFile none(file);
    EXPECT_EQ(none.read(), KeptSettings());
    EXPECT_EQ(none.message(), "");
    ASSERT_TRUE(none.write(kept));
    const SettingsFile again(file);
    EXPECT_EQ(again.read(), kept);
    EXPECT_EQ(again.message(), "");
    // A link stays one, and nothing is written that is there already.
    fs::create_symlink(file, folder / "link.json");
    const SettingsFile link(folder / "link.json");
    const auto written = fs::last_write_time(file);
    EXPECT_TRUE(link.write(kept));
    EXPECT_EQ(fs::last_write_time(file), written);
    kept.fingers = 1;
    EXPECT_TRUE(link.write(kept));
    EXPECT_TRUE(fs::is_symlink(folder / "link.json"));
    EXPECT_EQ(SettingsFile(file).read().fingers, 1);
}

TEST(SettingsFile, WhatIsUnknownOrWrongIsSaidOnceAndIgnored) {
    const TemporaryFolder folder;
    const fs::path file = folder / "play.json";
    put(file,
        R"({"panel": true, "sparkle": 1, "fingers": 9, "volume": 101, "window": [10, 10], "overlay": "night",
                  "a": {"median": 4, "metric": "pixel", "taste": [[]]}, "b": 3})");
    const SettingsFile read(file);
    KeptSettings right;
    right.panel = true;
    right.a = felt({{"metric", "pixel"}});
    right.b.emplace();
    EXPECT_EQ(read.read(), right);
    for (const char* word :
         {"'sparkle' is unknown", "1 to 5", "0 to 100", "[320, 200]", "0, 3 or 5", "'taste'", "object"})
        EXPECT_NE(read.message().find(word), std::string::npos) << word << " in " << read.message();
    EXPECT_EQ(read.message().find('\n'), std::string::npos) << "a warning has one line";
    ASSERT_TRUE(read.write(read.read()));
    EXPECT_EQ(SettingsFile(file).message(), "");
}

TEST(SettingsFile, ThatIsBrokenIsSetAside) {
    const TemporaryFolder folder;
    const fs::path file = folder / "play.json";
    int count = 0;
    for (const char* words : {"", "{\"panel\": tr", "[1]", "\xff\xfe"}) {
        const std::string aside = "play.json.broken" + (++count == 1 ? "" : std::to_string(count));
        put(file, words);
        const SettingsFile read(file);
        EXPECT_EQ(read.read(), KeptSettings());
        EXPECT_NE(read.message().find(aside), std::string::npos) << read.message();
        EXPECT_FALSE(fs::exists(file));
        EXPECT_EQ(words_in(folder / aside), words) << "none that was set aside is lost";
        ASSERT_TRUE(read.write(KeptSettings()));
        EXPECT_EQ(SettingsFile(file).message(), "");
    }
}

TEST(SettingsFile, ThatHasNoSettingIsSomebodysOwnFile) {
    const TemporaryFolder folder;
    const std::string labels = R"({"touchable_labels": 1, "labels": []})";
    put(folder / "labels.json", labels);
    const SettingsFile read(folder / "labels.json");
    EXPECT_NE(read.message().find("no file of settings"), std::string::npos) << read.message();
    KeptSettings kept;
    kept.fingers = 2;
    EXPECT_TRUE(read.write(kept));
    EXPECT_EQ(words_in(folder / "labels.json"), labels);
    // Another program's, which shares names with ours: neither its other members nor its values are lost.
    for (const std::string& shared :
         {std::string(R"({"panel": true, "fingers": 2, "theme": "dark"})"),
          std::string(R"({"window": {"x": 1, "y": 2}, "volume": 50})"), std::string(R"({"a": "alpha"})")}) {
        put(folder / "other.json", shared);
        const SettingsFile other(folder / "other.json");
        EXPECT_NE(other.message().find("left alone"), std::string::npos) << other.message();
        EXPECT_EQ(other.message().find('\n'), std::string::npos);
        EXPECT_TRUE(other.write(kept));
        EXPECT_EQ(words_in(folder / "other.json"), shared);
    }
    // One of ours by hand, of which nothing is lost.
    put(folder / "own.json", R"({"fingers": 4, "volume": 30})");
    EXPECT_EQ(SettingsFile(folder / "own.json").message(), "");
    EXPECT_TRUE(SettingsFile(folder / "own.json").write(kept));
    EXPECT_EQ(SettingsFile(folder / "own.json").read().fingers, 2);
    put(folder / "empty.json", "{}");
    EXPECT_TRUE(SettingsFile(folder / "empty.json").write(kept));
    EXPECT_EQ(SettingsFile(folder / "empty.json").read().fingers, 2);
}

TEST(SettingsFile, ThatIsNoneOrCannotBeWrittenIsLeftAlone) {
    const TemporaryFolder folder;
    fs::create_directory(folder / "play.json");
    const SettingsFile is_folder(folder / "play.json");
    EXPECT_NE(is_folder.message().find("left alone"), std::string::npos);
    KeptSettings kept;
    kept.fingers = 2;
    EXPECT_TRUE(is_folder.write(kept));
    EXPECT_TRUE(fs::is_directory(folder / "play.json"));
    put(folder / "file", "x");
    const SettingsFile nowhere(folder / "file/touchable/play.json");
    const auto written = nowhere.write(kept);
    ASSERT_FALSE(written);
    EXPECT_NE(written.error().message.find("touchable"), std::string::npos) << written.error().message;
    if (geteuid() == 0) return;  // who may write everywhere
    fs::create_directory(folder / "locked");
    put(folder / "locked/play.json", "{\"fingers\": 4}");
    fs::permissions(folder / "locked", fs::perms::owner_read | fs::perms::owner_exec);
    const SettingsFile locked(folder / "locked/play.json");
    EXPECT_FALSE(locked.write(kept));
    EXPECT_EQ(SettingsFile(folder / "locked/play.json").read().fingers, 4);
    fs::permissions(folder / "locked", fs::perms::owner_all);
}

/// The environment as it was, once this is gone.
class Variable {
public:
    Variable(const char* name, const char* value) : name_(name) {
        if (const char* was = std::getenv(name)) was_ = was;
        if (value)
            setenv(name, value, 1);
        else
            unsetenv(name);
    }
    ~Variable() {
        if (was_)
            setenv(name_, was_->c_str(), 1);
        else
            unsetenv(name_);
    }
    Variable(const Variable&) = delete;
    Variable& operator=(const Variable&) = delete;

private:
    const char* name_;
    std::optional<std::string> was_;
};

TEST(SettingsFile, OfAPersonIsWhereConfigurationIs) {
    const Variable home("HOME", "/home/ada");
    {
        const Variable config("XDG_CONFIG_HOME", "/etc/ada");
        EXPECT_EQ(*own_settings_file(), "/etc/ada/touchable/play.json");
    }
    const Variable relative("XDG_CONFIG_HOME", "ada");
    EXPECT_EQ(*own_settings_file(), "/home/ada/.config/touchable/play.json");
    const Variable nobody("HOME", nullptr);
    EXPECT_FALSE(own_settings_file());
}

}  // namespace
}  // namespace touchable::test
