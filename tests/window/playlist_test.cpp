#include "player/window/play_window.hpp"
#include "player/window/user_files.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "player/window/window_input.hpp"
#include "tests/temporary_folder.hpp"

namespace touchable::test {
namespace {

namespace fs = std::filesystem;

Playlist list_of(const std::vector<std::string>& names, bool wraps = false) {
    std::vector<ClipChoice> clips;
    for (const std::string& name : names) clips.emplace_back().file = name;
    return Playlist(std::move(clips), wraps);
}

TEST(Playlist, GoesOnAndBackAndStaysAtItsEnds) {
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

TEST(Playlist, ThatWrapsHasNoEnds) {
    Playlist list = list_of({"a", "b", "c"}, true);
    EXPECT_EQ(list.previous()->file, "c");
    EXPECT_EQ(list.next()->file, "a");
    Playlist alone = list_of({"a"}, true);
    EXPECT_EQ(alone.next(), nullptr) << "it would be opened again and again";
    EXPECT_EQ(alone.previous(), nullptr);
}

TEST(Playlist, OfAFolderIsItsClipsByName) {
    const TemporaryFolder folder;
    for (const char* name : {"clip10.mkv", "clip2.MKV", "b.webm", ".hidden.mkv", "notes.txt"})
        std::ofstream(folder / name) << "x";
    fs::create_directories(folder / "pictures");
    std::ofstream(folder / "pictures/scene.json") << "{}";
    fs::create_directories(folder / "others");
    const std::vector<fs::path> clips{folder / "b.webm", folder / "clip2.MKV", folder / "clip10.mkv",
                                      folder / "pictures"};
    EXPECT_EQ(clips_of(folder.path()), clips);
    // What is a clip itself, or has none, is itself.
    EXPECT_EQ(clips_of(folder / "pictures"), std::vector<fs::path>{folder / "pictures"});
    EXPECT_EQ(clips_of(folder / "others"), std::vector<fs::path>{folder / "others"});
    EXPECT_EQ(clips_of(folder / "b.webm"), std::vector<fs::path>{folder / "b.webm"});
    EXPECT_EQ(clips_of("nowhere"), std::vector<fs::path>{"nowhere"});
    std::ofstream(folder / "scene.json") << "{}";
    EXPECT_EQ(clips_of(folder.path()), std::vector<fs::path>{folder.path()});
}

TEST(DoubleClick, IsTwoQuickPressesAtOnePlace) {
    DoubleClick click;
    EXPECT_FALSE(click.press(0, {100, 100}));
    EXPECT_TRUE(click.press(0.25, {103, 98}));
    EXPECT_FALSE(click.press(0.4, {103, 98})) << "a third is a first again";
    EXPECT_FALSE(click.press(0.8, {103, 98})) << "too late";
    EXPECT_FALSE(click.press(1.0, {140, 98})) << "elsewhere: somebody taps along";
    click.forget();
    EXPECT_FALSE(click.press(1.1, {140, 98}));
}

}  // namespace
}  // namespace touchable::test
