// SPDX-License-Identifier: Apache-2.0
// The brush in the hand: commands, clicks and strokes; the colours of materials.

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <set>
#include <stop_token>
#include <string>
#include <vector>

#include "engine/authoring/segments.hpp"
#include "engine/base/threads.hpp"
#include "player/session/clip_choice.hpp"
#include "player/window/brush.hpp"
#include "player/window/command_table.hpp"
#include "player/window/window_files.hpp"
#include "tests/materials/segment_colours.hpp"
#include "tests/window/scripted_window.hpp"

namespace touchable::test {
namespace {

using Places = std::vector<PixelOfFrame>;

TEST(BrushCommand, ParsesPlacesAndMaterials) {
    const auto paint = parse_window_command("paint 12,34");
    ASSERT_TRUE(paint) << paint.error().message;
    EXPECT_EQ(paint->verb, WindowVerb::paint);
    EXPECT_EQ(paint->places, (Places{{12, 34, -1}}));
    EXPECT_EQ(parse_window_command("paint 12,34,5").value().places, (Places{{12, 34, 5}}));
    EXPECT_EQ(parse_window_command("join 1,2 3,4,9").value().places, (Places{{1, 2, -1}, {3, 4, 9}}));
    EXPECT_EQ(parse_window_command("cut 1,2 3,4  5,6").value().places.size(), 3U);
    EXPECT_EQ(parse_window_command("material felt").value().word, "felt");
    EXPECT_EQ(parse_window_command("otherwise guess").value().word, "");
    EXPECT_EQ(parse_window_command("otherwise brick").value().word, "brick");
    for (const char* words : {"tool", "tool touch", "tool cut", "undo", "redo", "save-materials",
                              "save-materials a b.json", "materials off"})
        EXPECT_TRUE(parse_window_command(words)) << words;
}

TEST(BrushCommand, RejectsInvalidWithHint) {
    const struct {
        const char *words, *right;
    } faults[] = {{"paint", "X,Y,FRAME"},
                  {"paint 3", "120,80"},
                  {"paint 3,4 5,6", "120,80"},
                  {"paint 3,-4", "120,80"},
                  {"paint 3,4,", "120,80"},
                  {"paint 3,4,5,6", "120,80"},
                  {"paint 99999,1", "120,80"},
                  {"join 1,2", "two segments"},
                  {"join 1,2 3,4 5,6", "two"},
                  {"cut 1,2", "a stroke"},
                  {"cut 1,2,3 4,5,6", "one frame"},
                  {"material woood", "wood"},
                  {"material", "wood"},
                  {"otherwise", "guess"},
                  {"tool brush", "touch, paint"},
                  {"save-materials a.mkv", ".json"},
                  {"undo 2", "nothing"},
                  {"materials maybe", "off or on"}};
    for (const auto& fault : faults) {
        const auto read = parse_window_command(fault.words);
        ASSERT_FALSE(read) << fault.words;
        EXPECT_EQ(read.error().kind, ErrorKind::usage);
        EXPECT_TRUE(contains(read.error().message, fault.right));
    }
}

TEST(BrushCommand, HasUsualUndoKeys) {
    ASSERT_TRUE(binding_of("z", true, false) && binding_of("p", false, false));
    EXPECT_EQ(binding_of("z", true, false)->verb, WindowVerb::undo);
    EXPECT_EQ(binding_of("z", true, true)->verb, WindowVerb::redo);
    EXPECT_EQ(binding_of("y", true, false)->verb, WindowVerb::redo);
    EXPECT_EQ(binding_of("s", true, false)->verb, WindowVerb::save_materials);
    EXPECT_EQ(binding_of("s", false, false)->verb, WindowVerb::point_down) << "without Ctrl as ever";
    EXPECT_EQ(binding_of("p", false, false)->verb, WindowVerb::tool);
}

HeldBrush::Place at(int x, int y, std::int64_t frame = 7) {
    return {{10.0 * x, 10.0 * y}, PixelOfFrame{x, y, frame}};
}

TEST(HeldBrush, PaintsClickedPlace) {
    HeldBrush brush;
    EXPECT_FALSE(brush.press(at(1, 2))) << "there is none in the hand";
    brush.take_or_put_away();
    EXPECT_EQ(brush.tool(), BrushTool::paint);
    const auto paint = brush.press(at(1, 2));
    ASSERT_TRUE(paint);
    EXPECT_EQ(paint->verb, WindowVerb::paint);
    EXPECT_EQ(paint->places, (Places{{1, 2, 7}}));
    EXPECT_FALSE(brush.release());
    EXPECT_FALSE(brush.press({{5, 5}})) << "no surface";
}

TEST(HeldBrush, JoinsTwoClicks) {
    HeldBrush brush;
    brush.take(BrushTool::join);
    EXPECT_FALSE(brush.press(at(1, 2, 3)));
    brush.move(at(4, 4, 5));
    ASSERT_EQ(brush.line().size(), 2U);
    EXPECT_EQ(brush.line()[1], glm::dvec2(40, 40));
    const auto join = brush.press(at(8, 9, 6));
    ASSERT_TRUE(join);
    EXPECT_EQ(join->places, (Places{{1, 2, 3}, {8, 9, 6}}));
    EXPECT_TRUE(brush.line().empty());
    // A click beside every surface, or another tool, begins again.
    EXPECT_FALSE(brush.press(at(1, 2)));
    EXPECT_FALSE(brush.press({{5, 5}}));
    EXPECT_FALSE(brush.press(at(1, 2)));
    brush.take(BrushTool::join);
    EXPECT_FALSE(brush.press(at(3, 3)));
}

TEST(HeldBrush, CutsByStroke) {
    HeldBrush brush;
    brush.take(BrushTool::cut);
    brush.move(at(0, 0));
    EXPECT_FALSE(brush.press({{5, 10}})) << "it may begin beside all surfaces";
    EXPECT_TRUE(brush.is_drawing());
    brush.move(at(1, 1, 4));
    brush.move(at(2, 1, 4));
    brush.move(at(2, 1, 5));  // the same place
    brush.move({{25, 10}});   // a hole on the way
    brush.move(at(3, 1, 5));
    EXPECT_EQ(brush.line().size(), 3U);
    const auto cut = brush.release();
    ASSERT_TRUE(cut);
    EXPECT_EQ(cut->verb, WindowVerb::cut);
    EXPECT_EQ(cut->places, (Places{{1, 1, 4}, {2, 1, 4}, {3, 1, 4}}));
    EXPECT_FALSE(brush.is_drawing());
    EXPECT_FALSE(brush.press(at(1, 1)));
    EXPECT_FALSE(brush.release()) << "a click is no stroke";
    brush.take_or_put_away();
    EXPECT_FALSE(brush.is_held());
    brush.take_or_put_away();
    EXPECT_EQ(brush.tool(), BrushTool::cut) << "the last one";
}

TEST(HeldBrush, StrokeLengthIsLimited) {
    HeldBrush brush;
    brush.take(BrushTool::cut);
    EXPECT_FALSE(brush.press(at(0, 0)));
    for (int k = 1; k < 10'000; ++k) brush.move(at(k % 1000, k / 1000));
    EXPECT_EQ(brush.release()->places.size(), HeldBrush::most_points);
}

TEST(MaterialColours, AreDistinguishable) {
    for (const PaletteMaterial& a : palette()) {
        EXPECT_NE(material_colour(a.name), material_colour("")) << a.name;
        for (const PaletteMaterial& b : palette()) {
            if (a.name >= b.name) continue;
            const auto one = material_colour(a.name), other = material_colour(b.name);
            int apart = 0;
            for (std::size_t c = 0; c < 3; ++c) apart += std::abs(one[c] - other[c]);
            EXPECT_GE(apart, 40) << a.name << " and " << b.name;
        }
    }
}

// The brush's changes return in the next window, also after a crash of the last one.

namespace fs = std::filesystem;
using Paint = MaterialBrush::Paint;

class ClipBrush : public ::testing::Test {
protected:
    static SegmentStore segments() { return stored({{"aaaabbcc", "aaaabbcc"}, {"aaaabbcc", "aaaabbcc"}}); }
    Result<KeptBrush> begin() { return KeptBrush::begin(segments(), files_); }
    KeptBrush begun() {
        auto brush = begin();
        EXPECT_TRUE(brush) << brush.error().message;
        return std::move(*brush);
    }
    void put(const fs::path& file, const std::string& text) {
        const auto written = write_text(file, text);
        EXPECT_TRUE(written) << written.error().message;
    }
    /// Edits and writes the history, as the window does.
    void edit(KeptBrush& brush, const MaterialBrush::Edit& edit) {
        const auto done = brush.brush().edit(edit);
        ASSERT_TRUE(done) << done.error().message;
        put(files_.history(), brush.history());
    }
    /// In a window before; its history.
    std::string paint_foam() {
        KeptBrush brush = begun();
        edit(brush, Paint{{0, 0, 0}, "foam"});
        return brush.history();
    }
    void save(KeptBrush& brush) {
        const std::string text = brush.save();
        put(files_.history(), brush.history());
        put(files_.saved(), text);
    }
    static std::string material(const KeptBrush& brush, int x) {
        const auto painted = brush.brush().painted();
        return painted->by_label.at(painted->segments->label_at(0, x, 0)).material;
    }

    const TemporaryFolder folder_;
    BrushFiles files_{.clip = folder_ / "clip.mkv", .history_folder = folder_ / "state/touchable"};
};

TEST_F(ClipBrush, RestoresHistoryAfterKill) {
    {
        KeptBrush brush = begun();
        EXPECT_FALSE(brush.is_painted());
        edit(brush, Paint{{0, 0, 0}, "foam"});
        edit(brush, SegmentCut{0, {{1, 0}, {1, 1}}});
        edit(brush, Paint{{0, 0, 0}, "brick"});
    }
    {
        KeptBrush again = begun();
        EXPECT_TRUE(again.is_painted());
        EXPECT_TRUE(contains(again.begun_with(), "3 changes of last time are here again"));
        EXPECT_EQ(material(again, 0), "brick");
        EXPECT_EQ(material(again, 3), "foam");
        ASSERT_TRUE(again.brush().undo());
        EXPECT_EQ(material(again, 0), "foam");
        ASSERT_TRUE(again.brush().undo());
        put(files_.history(), again.history());
    }
    const KeptBrush once_more = begun();
    EXPECT_TRUE(contains(once_more.begun_with(), "1 change of last time is"));
    EXPECT_EQ(once_more.brush().edits(), 3U) << "what was undone can be done again";
}

TEST_F(ClipBrush, SavesBesideClip) {
    {
        KeptBrush brush = begun();
        edit(brush, Paint{{0, 0, 0}, "foam"});
        save(brush);
        EXPECT_TRUE(fs::exists(folder_ / "clip.mkv.materials.json"));
        edit(brush, Paint{{4, 0, 0}, "glass"});
    }
    {
        const KeptBrush again = begun();
        EXPECT_EQ(material(again, 4), "glass");
        EXPECT_EQ(again.brush().done(), 2U) << "undo goes on beyond what was saved";
    }
    // Without a history the saved file counts.
    fs::remove(files_.history());
    const KeptBrush saved = begun();
    EXPECT_EQ(material(saved, 0), "foam");
    EXPECT_NE(material(saved, 4), "glass");
    EXPECT_TRUE(saved.is_painted());
    EXPECT_TRUE(contains(saved.begun_with(), "clip.mkv.materials.json"));
}

TEST_F(ClipBrush, StartsFromGivenFile) {
    put(folder_ / "given.json", R"({"touchable_segments": 1, "segments":
        [{"name": "table", "material": "cork", "at": [0, 0, 0]}]})");
    files_.segments = folder_ / "given.json";
    EXPECT_EQ(material(begun(), 0), "cork");
    EXPECT_EQ(files_.saved(), folder_ / "given.json");
    put(folder_ / "given.json", R"({"touchable_segments": 1, "segments":
        [{"name": "table", "material": "cork", "at": [0, 9, 0]}]})");
    const auto refused = begin();
    ASSERT_FALSE(refused);
    EXPECT_TRUE(contains(refused.error().message, "outside"));
}

TEST_F(ClipBrush, SetsAsideUnfitHistory) {
    const std::string history = paint_foam();
    const fs::path file = files_.history();
    int count = 0;
    fs::path aside;
    const auto expect_aside = [&](const std::string& text, const std::string& why) {
        aside = file.string() + ".broken" + (++count == 1 ? "" : std::to_string(count));
        put(file, text);
        const KeptBrush again = begun();
        EXPECT_EQ(again.brush().edits(), 0U);
        EXPECT_TRUE(contains(again.begun_with(), "set aside as " + aside.filename().string()));
        EXPECT_TRUE(contains(again.begun_with(), why));
        EXPECT_FALSE(fs::exists(file));
        EXPECT_EQ(file_contents(aside), text);
    };
    expect_aside("{", "no history");
    expect_aside("[1]", "no history");
    expect_aside(R"({"saved": [], "changes": "{}"})", "touchable_brush");
    std::string other = history;
    other.replace(other.find("paint"), 5, "faint");
    expect_aside(other, "edits[0]");
    // Another program has named the segments meanwhile.
    put(files_.saved(), R"({"touchable_segments": 1, "otherwise": "wood", "segments": []})");
    expect_aside(history, "other materials than");
    EXPECT_EQ(material(begun(), 0), "wood");
    EXPECT_EQ(file_contents(file.string() + ".broken"), "{") << "none that was set aside is lost";
    EXPECT_EQ(names_in(folder_ / "state/touchable").size(), 5U);
}

TEST_F(ClipBrush, LeavesUnreadableHistory) {
    const fs::path file = files_.history();
    fs::create_directories(file);  // no user can read a folder as a file
    const KeptBrush brush = begun();
    EXPECT_TRUE(contains(brush.begun_with(), file.string()));
    EXPECT_TRUE(contains(brush.begun_with(), "not kept"));
    EXPECT_EQ(brush.history_file(), fs::path());
    EXPECT_TRUE(fs::is_directory(file));
    EXPECT_FALSE(fs::exists(file.string() + ".broken"));
}

TEST_F(ClipBrush, LocksHistoryToOneWindow) {
    {
        KeptBrush brush = begun();
        edit(brush, Paint{{0, 0, 0}, "foam"});
        const KeptBrush other = begun();
        EXPECT_EQ(other.brush().edits(), 0U);
        EXPECT_EQ(other.history_file(), fs::path());
        EXPECT_TRUE(contains(other.begun_with(), "another window"));
        EXPECT_EQ(brush.history_file(), files_.history());
    }
    const KeptBrush again = begun();
    EXPECT_EQ(again.brush().edits(), 1U);
    EXPECT_EQ(again.history_file(), files_.history());
}

/// A stop of the program, or another clip, breaks no history.
TEST_F(ClipBrush, KeepsHistoryWhenStopped) {
    paint_foam();
    std::stop_source given_up;
    given_up.request_stop();
    {
        const StopScope until(given_up.get_token());
        const auto stopped = begin();
        ASSERT_FALSE(stopped);
        EXPECT_EQ(stopped.error().kind, ErrorKind::interrupted);
    }
    EXPECT_EQ(begun().brush().edits(), 1U);
}

TEST_F(ClipBrush, KeepsHistoryPerClip) {
    BrushFiles folder = files_, with_slash = files_, other = files_;
    folder.clip = folder_ / "pictures";
    with_slash.clip = folder_ / "pictures/";
    other.clip = folder_ / "other.mkv";
    EXPECT_EQ(folder.history(), with_slash.history());
    EXPECT_EQ(with_slash.saved(), folder_ / "pictures.materials.json");
    EXPECT_NE(files_.history(), other.history());
    BrushFiles filled = files_;
    filled.opened_as = R"({"fill-from-motion":true})";
    EXPECT_NE(files_.history(), filled.history()) << "it has other segments";
    EXPECT_EQ(files_.saved(), filled.saved());
    other.history_folder.clear();
    EXPECT_TRUE(other.history().empty());
}

/// What changes frames changes segments; other touch settings do not.
TEST(SegmentDependencies, CoverEveryFrameOption) {
    const auto with = [](auto&& say) {
        ClipChoice choice;
        choice.file = "clip.mkv";
        say(choice);
        return segments_depend_on(choice);
    };
    const std::vector<std::string> others{with([](auto& choice) { choice.scene_file = "scene.json"; }),
                                          with([](auto& choice) { choice.alignment = DepthAlignment::on; }),
                                          with([](auto& choice) { choice.alignment = DepthAlignment::off; }),
                                          with([](auto& choice) { choice.fill_from_motion = true; }),
                                          with([](auto& choice) { choice.camera.fov = 60; }),
                                          with([](auto& choice) { choice.camera.least_confidence = 0.5; }),
                                          with([](auto& choice) { choice.camera.channel = "V.Depth.Z"; }),
                                          with([](auto& choice) {
                                              choice.camera.intrinsics = Intrinsics{500, 500, {}, {}};
                                          })};
    std::set<std::string> all{""};
    for (const std::string& other : others) EXPECT_TRUE(all.insert(other).second) << other;
    EXPECT_EQ(with([](ClipChoice&) {}), "");
    EXPECT_EQ(with([](ClipChoice& choice) { choice.camera = {}; }), "") << "nothing is said";
    EXPECT_EQ(with([](ClipChoice& choice) {
                  choice.single_filters = {.settings = {.median = 5}, .stated = {.median = true}};
              }),
              "")
        << "segments are of unfiltered frames";
}

}  // namespace
}  // namespace touchable::test
