// The brush in the hand: commands, clicks and strokes; the colours of materials.
#include "player/window/brush.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "engine/authoring/segments.hpp"
#include "player/window/command_table.hpp"

namespace touchable::test {
namespace {

using Places = std::vector<PixelOfFrame>;

TEST(BrushCommand, HasPlacesAndMaterials) {
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

TEST(BrushCommand, ThatIsNoneIsRefusedWithWhatWouldBeRight) {
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
        EXPECT_NE(read.error().message.find(fault.right), std::string::npos) << read.error().message;
    }
}

TEST(BrushCommand, HasTheKeysThatUndoEverywhere) {
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

TEST(HeldBrush, PaintsWhatIsClicked) {
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

TEST(HeldBrush, JoinsTheFirstWithTheNext) {
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
    // Who clicks beside all, or takes another tool, begins again.
    EXPECT_FALSE(brush.press(at(1, 2)));
    EXPECT_FALSE(brush.press({{5, 5}}));
    EXPECT_FALSE(brush.press(at(1, 2)));
    brush.take(BrushTool::join);
    EXPECT_FALSE(brush.press(at(3, 3)));
}

TEST(HeldBrush, CutsByAStrokeOfOneFrame) {
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

TEST(HeldBrush, AStrokeHasAnEnd) {
    HeldBrush brush;
    brush.take(BrushTool::cut);
    EXPECT_FALSE(brush.press(at(0, 0)));
    for (int k = 1; k < 10'000; ++k) brush.move(at(k % 1000, k / 1000));
    EXPECT_EQ(brush.release()->places.size(), HeldBrush::most_points);
}

TEST(MaterialColours, AreToldApart) {
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

}  // namespace
}  // namespace touchable::test
