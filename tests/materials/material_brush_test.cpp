// Materials painted by a person: joined, cut, undone, saved, and brought back.
#include "engine/authoring/materials.hpp"

#include <gtest/gtest.h>
#include "tests/clip/clip_fixture.hpp"
#include "tests/materials/colour_segments.hpp"
#include "tests/materials/drawn_segments.hpp"

namespace touchable::test {
namespace {

using Paint = MaterialBrush::Paint;
using Join = MaterialBrush::Join;

class Brush : public ::testing::Test {
protected:
    static MaterialBrush begun(const SegmentNames& names = {}) {
        auto brush =
            MaterialBrush::begin(stored({{"aaaabbcc", "aaaabbcc"}, {"aaaabbcc", "aaaaddcc"}}), names);
        EXPECT_EQ(message(brush), "");
        return std::move(*brush);
    }
    static std::string material(const MaterialBrush& brush, int x, int y, std::int64_t frame = 0) {
        const auto painted = brush.painted();
        return painted->by_label.at(painted->segments->label_at(frame, x, y)).material;
    }
    static void expect_done(MaterialBrush& brush, const MaterialBrush::Edit& edit) {
        EXPECT_EQ(message(brush.edit(edit)), "");
    }
};

TEST_F(Brush, PaintsAWholeSegmentInAllFrames) {
    MaterialBrush brush = begun();
    EXPECT_TRUE(brush.painted()->by_label.at(1).is_guess);
    const auto said = brush.edit(Paint{{1, 1, 1}, "foam"});
    ASSERT_EQ(message(said), "");
    EXPECT_EQ(*said, "segment 1 is foam");
    EXPECT_EQ(material(brush, 3, 0), "foam");
    EXPECT_FALSE(brush.painted()->by_label.at(1).is_guess);
    EXPECT_EQ(brush.painted()->by_label.at(1).feel, find_material("foam")->feel());
    EXPECT_TRUE(brush.painted()->by_label.at(2).is_guess);
    const auto late = brush.edit(Paint{{4, 1, 1}, "felt"});
    ASSERT_EQ(message(late), "");
    EXPECT_EQ(*late, "segment 4 is felt; only frame 1 has it");
    EXPECT_EQ(message(brush.undo()), "");
    expect_done(brush, Paint{{0, 0, 0}, "stone"});
    EXPECT_EQ(material(brush, 3, 0), "stone");
    EXPECT_EQ(brush.names().segments.size(), 1U) << "one segment, one name";
}

TEST_F(Brush, UndoesAndDoesAgain) {
    MaterialBrush brush = begun();
    const auto before = brush.painted();
    EXPECT_NE(message(brush.undo()), "");
    expect_done(brush, Paint{{0, 0, 0}, "foam"});
    expect_done(brush, Paint{{5, 0, 0}, "stone"});
    EXPECT_EQ(message(brush.undo()), "");
    EXPECT_EQ(material(brush, 0, 0), "foam");
    EXPECT_NE(material(brush, 5, 0), "stone");
    EXPECT_EQ(message(brush.undo()), "");
    EXPECT_EQ(brush.painted(), before);
    EXPECT_EQ(message(brush.redo()), "");
    EXPECT_EQ(message(brush.redo()), "");
    EXPECT_NE(message(brush.redo()), "");
    EXPECT_EQ(material(brush, 5, 0), "stone");
    EXPECT_EQ(message(brush.undo()), "");
    expect_done(brush, Paint{{5, 0, 0}, "felt"});
    EXPECT_NE(message(brush.redo()), "") << "another way was gone";
    EXPECT_EQ(brush.edits(), 2U);
}

TEST_F(Brush, JoinedSegmentsAreOneThing) {
    MaterialBrush brush = begun();
    expect_done(brush, Paint{{5, 0, 0}, "stone"});
    expect_done(brush, Join{{0, 0, 0}, {5, 0, 0}});
    EXPECT_EQ(material(brush, 0, 0), "stone") << "what a person said counts";
    expect_done(brush, Join{{7, 0, 0}, {1, 1, 1}});
    expect_done(brush, Paint{{7, 1, 1}, "felt"});
    for (const int x : {0, 5, 7}) EXPECT_EQ(material(brush, x, 0), "felt") << x;
    EXPECT_NE(material(brush, 4, 1, 1), "felt");
    EXPECT_EQ(brush.names().segments.size(), 1U);
    EXPECT_EQ(brush.names().segments[0].at.size(), 3U);
    EXPECT_NE(message(brush.edit(Join{{0, 0, 0}, {7, 0, 0}})).find("one already"), std::string::npos);
    EXPECT_NE(message(brush.edit(Join{{0, 0, 0}, {1, 0, 0}})).find("both places"), std::string::npos);
}

TEST_F(Brush, JoinedGuessesAreTheFirstOne) {
    MaterialBrush brush = begun();
    const std::string first = material(brush, 0, 0);
    expect_done(brush, Join{{0, 0, 0}, {5, 0, 0}});
    EXPECT_EQ(material(brush, 5, 0), first);
    EXPECT_TRUE(brush.painted()->by_label.at(2).is_guess);
}

TEST_F(Brush, BothPartsOfWhatIsCutFeelAsItDid) {
    MaterialBrush brush = begun();
    expect_done(brush, Paint{{0, 0, 0}, "foam"});
    expect_done(brush, SegmentCut{0, {{1, 0}, {1, 1}}});
    EXPECT_EQ(material(brush, 0, 0), "foam");
    EXPECT_EQ(material(brush, 3, 0), "foam");
    expect_done(brush, Paint{{3, 0, 0}, "glass"});
    EXPECT_EQ(material(brush, 0, 0), "foam");
    EXPECT_EQ(material(brush, 3, 1, 1), "glass");
    ASSERT_EQ(brush.names().segments.size(), 2U);
    EXPECT_NE(brush.names().segments[0].name, brush.names().segments[1].name);
    EXPECT_EQ(message(brush.undo()), "");
    EXPECT_EQ(message(brush.undo()), "");
    EXPECT_EQ(brush.painted()->by_label.size(), 4U);
}

TEST_F(Brush, WhatIsRefusedChangesNothing) {
    MaterialBrush brush = begun();
    const auto before = brush.painted();
    EXPECT_NE(message(brush.edit(Paint{{0, 0, 0}, "woood"})).find("wood"), std::string::npos);
    EXPECT_NE(message(brush.edit(Paint{{8, 0, 0}, "wood"})).find("beyond"), std::string::npos);
    EXPECT_NE(message(brush.edit(Paint{{0, -1, 0}, "wood"})).find("beyond"), std::string::npos);
    EXPECT_NE(message(brush.edit(Paint{{0, 0, 2}, "wood"})).find("beyond"), std::string::npos);
    EXPECT_NE(message(brush.edit(MaterialBrush::Otherwise{"woood"})), "");
    EXPECT_NE(message(brush.edit(SegmentCut{0, {{7, 0}, {7, 1}}})), "");
    EXPECT_EQ(brush.painted(), before);
    EXPECT_EQ(brush.edits(), 0U);
}

/// A brush with one edit of each kind, and one undone.
MaterialBrush used(MaterialBrush brush) {
    EXPECT_EQ(message(brush.edit(MaterialBrush::Otherwise{"felt"})), "");
    EXPECT_EQ(message(brush.edit(Paint{{0, 0, 0}, "foam"})), "");
    EXPECT_EQ(message(brush.edit(SegmentCut{1, {{1, 0}, {1, 1}}})), "");
    EXPECT_EQ(message(brush.edit(Join{{0, 0, 0}, {5, 0, 0}})), "");
    EXPECT_EQ(message(brush.edit(Paint{{7, 0, 0}, "glass"})), "");
    EXPECT_EQ(message(brush.undo()), "");
    return brush;
}

TEST_F(Brush, AnotherRunHasItsHistory) {
    SegmentNames names;
    names.segments = {{"lamp", "glass", find_material("glass")->feel(), {{4, 1, 1}}}};
    const MaterialBrush brush = used(begun(names));
    MaterialBrush later = begun();
    ASSERT_EQ(message(later.repeat(brush.history(), "h.json")), "");
    EXPECT_EQ(later.history(), brush.history());
    EXPECT_EQ(segment_names_to_json(later.names()), segment_names_to_json(brush.names()));
    for (const auto& [label, paint] : brush.painted()->by_label)
        EXPECT_EQ(later.painted()->by_label.at(label).feel, paint.feel) << label;
    EXPECT_EQ(later.painted()->by_label.at(4).name, "lamp");
    EXPECT_EQ(message(later.redo()), "");
    EXPECT_EQ(material(later, 7, 0), "glass");
}

TEST_F(Brush, AHistoryThatDoesNotFitIsRefused) {
    MaterialBrush brush = used(begun());
    const std::string text = brush.history();
    const auto refused = [&](const std::string& from, const std::string& to, const std::string& why) {
        std::string changed = text;
        const std::size_t at = changed.find(from);
        ASSERT_NE(at, std::string::npos) << from;
        changed.replace(at, from.size(), to);
        MaterialBrush other = begun();
        const std::string said = message(other.repeat(changed, "h.json"));
        EXPECT_EQ(said.rfind("h.json: ", 0), 0U) << said;
        EXPECT_NE(said.find(why), std::string::npos) << said;
        EXPECT_EQ(other.edits(), 0U);
    };
    refused("\"segments\": \"", "\"segments\": \"0", "other segments");
    refused("\"touchable_brush\": 1", "\"touchable_brush\": 2", "touchable_brush");
    refused("\"done\": 4", "\"done\": 6", "done");
    refused("\"paint\":[0,0,0]", "\"paint\":[0,0,9]", "edits[1]");
    refused("\"join\"", "\"joint\"", "edits[3]");
    refused("}", "", "");
}

/// Whoever goes on and on loses no more than the oldest steps back.
TEST_F(Brush, ForgetsTheOldestEditsRatherThanRefuse) {
    MaterialBrush brush = begun();
    expect_done(brush, SegmentCut{0, {{1, 0}, {1, 1}}});
    const std::size_t labels = brush.painted()->by_label.size();
    for (std::size_t k = 0; k <= MaterialBrush::most_edits; ++k)
        expect_done(brush, Paint{{3, 0, 0}, k % 2 == 0 ? "glass" : "foam"});
    EXPECT_EQ(brush.edits(), MaterialBrush::most_edits);
    while (brush.undo()) continue;
    EXPECT_EQ(brush.done(), 0U);
    EXPECT_EQ(brush.painted()->by_label.size(), labels) << "the cut is older, and stays";
    EXPECT_EQ(material(brush, 3, 0), "glass");
    MaterialBrush later = begun();
    ASSERT_EQ(message(later.repeat(brush.history(), "h.json")), "");
    EXPECT_EQ(later.history(), brush.history());
}

/// As a file may have it, where both feel the same.
TEST_F(Brush, ASegmentUnderTwoNamesIsPaintedWhole) {
    SegmentNames names;
    const Feel felt = find_material("felt")->feel();
    names.segments = {{"table", "felt", felt, {{0, 0, 0}, {5, 0, 0}}},
                      {"again", "felt", felt, {{1, 1, 1}, {7, 0, 0}}}};
    MaterialBrush brush = begun(names);
    EXPECT_EQ(brush.names().segments.size(), 1U);
    expect_done(brush, Paint{{0, 0, 0}, "glass"});
    for (const int x : {0, 5, 7}) EXPECT_EQ(material(brush, x, 0), "glass") << x;
    expect_done(brush, Join{{4, 1, 1}, {0, 0, 0}});
    EXPECT_EQ(material(brush, 4, 1, 1), "glass");
    EXPECT_EQ(material(brush, 7, 0), "glass");
}

/// What is saved, materials of the command line make the same clip of.
TEST_F(Brush, WhatIsSavedIsWhatWasFelt) {
    Scene scene = small_scene(12, 8);
    scene.depth.invalid_code_count = 1;
    derive_valid_range(scene.depth);
    TemporaryFolder folder;
    auto writer = create_clip(folder / "clip.mkv", scene, exact_clip);
    ASSERT_EQ(message(writer), "");
    for (int n = 0; n < 3; ++n) {
        auto memory = std::make_shared<std::array<Image, 2>>();
        (*memory)[0] = {12, 8, 1, 1, std::vector<std::uint8_t>(96, 100)};
        (*memory)[1] = {12, 8, 1, 3, {}};
        for (int k = 0; k < 96; ++k) {
            const std::array<std::uint8_t, 3> colour = k % 12 < 5 + n
                                                           ? std::array<std::uint8_t, 3>{150, 100, 60}
                                                           : std::array<std::uint8_t, 3>{60, 70, 150};
            (*memory)[1].samples.insert((*memory)[1].samples.end(), colour.begin(), colour.end());
        }
        RawFrame frame;
        frame.number = n;
        frame.time_ns = scene.rate.time_ns(n);
        frame.depth = (*memory)[0].view();
        frame.colour = (*memory)[1].view();
        frame.storage = std::move(memory);
        ASSERT_EQ(message((*writer)->write(frame)), "");
    }
    ASSERT_EQ(message((*writer)->finish()), "");

    auto clip = open_clip(folder / "clip.mkv");
    ASSERT_EQ(message(clip), "");
    auto segments = read_segments(**clip, ColourSegments::begin, {});
    ASSERT_EQ(message(segments), "");
    auto brush = MaterialBrush::begin(std::move(*segments));
    ASSERT_EQ(message(brush), "");
    expect_done(*brush, SegmentCut{1, {{0, 3}, {5, 3}}});
    expect_done(*brush, Paint{{0, 0, 0}, "foam"});
    expect_done(*brush, Paint{{0, 7, 1}, "glass"});
    ASSERT_EQ(message((*clip)->rewind()), "");
    auto felt = with_painted_segments(std::move(*clip), brush->painted());
    ASSERT_EQ(message(felt), "");
    const auto of_brush = read_all(**felt);
    ASSERT_EQ(message(of_brush), "");

    const auto names = parse_segment_names(segment_names_to_json(brush->names()), "n.json");
    ASSERT_EQ(message(names), "");
    MaterialSettings settings;
    settings.names = *names;
    auto again = open_clip(folder / "clip.mkv");
    ASSERT_EQ(message(again), "");
    auto command = with_materials(std::move(*again), settings, ColourSegments::begin,
                                  std::make_shared<MaterialReport>());
    ASSERT_EQ(message(command), "");
    const auto of_command = read_all(**command);
    ASSERT_EQ(message(of_command), "");
    ASSERT_EQ(of_command->size(), of_brush->size());
    for (std::size_t n = 0; n < of_brush->size(); ++n)
        EXPECT_TRUE(same_frame((*of_command)[n], (*of_brush)[n])) << n;
    EXPECT_NE((*of_brush)[0].haptic.sample(0, 0), (*of_brush)[0].haptic.sample(0, 7));
    ASSERT_EQ(message((*felt)->seek(2)), "");
    const auto last = (*felt)->next();
    ASSERT_EQ(message(last), "");
    EXPECT_TRUE(same_frame(**last, of_brush->back()));
}

}  // namespace
}  // namespace touchable::test
