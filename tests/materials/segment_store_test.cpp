// SPDX-License-Identifier: Apache-2.0
// Labels of whole clips in little memory, and segments that a stroke cuts in two.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <sstream>

#include "engine/authoring/segment_parts.hpp"
#include "engine/authoring/segments.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/materials/segment_colours.hpp"

namespace touchable::test {
namespace {

using Rows = std::vector<std::string>;

std::vector<std::string> after(const SegmentStore& store, const SegmentCut& cut, std::int64_t frame = 0) {
    const auto made = store.with_cut(cut);
    EXPECT_EQ(message(made), "");
    return made ? drawing(*made, frame) : Rows{};
}

TEST(SegmentStore, ReturnsWhatItStores) {
    const std::vector<Rows> frames{{"aabb", "a..b"}, {"abbb", ".ccb"}};
    const SegmentStore store = stored(frames);
    EXPECT_EQ(store.frames(), 2);
    for (std::size_t frame = 0; frame < 2; ++frame) {
        EXPECT_EQ(drawing(store, static_cast<std::int64_t>(frame)), frames[frame]);
        for (int y = 0; y < 2; ++y)
            for (int x = 0; x < 4; ++x)
                EXPECT_EQ(store.label_at(static_cast<std::int64_t>(frame), x, y),
                          drawn(frames[frame]).labels[static_cast<std::size_t>(4 * y + x)]);
    }
    ASSERT_EQ(store.seen().size(), 3U);
    EXPECT_EQ(store.find(3)->frame, 1);
    EXPECT_EQ(store.find(3)->segment.pixels, 2);
    EXPECT_EQ(store.find(4), nullptr);
    EXPECT_EQ(store.segmentation(0).segments.size(), 2U);
    EXPECT_EQ(store.segmentation(1).segments.size(), 3U);
}

TEST(SegmentStore, HoldsLongRuns) {
    Segmentation frame{400, 300, std::vector<std::uint16_t>(120'000, 7), {{7, 120'000, {}, 1, 1, 0}}};
    SegmentStore store(400, 300);
    store.add(frame);
    EXPECT_EQ(store.segmentation(0).labels, frame.labels);
    EXPECT_EQ(store.label_at(0, 399, 299), 7);
    EXPECT_LE(store.bytes(), 16U);
}

TEST(SegmentCut, PartsCrossedSegment) {
    const SegmentStore store = stored({{"aaaaaab", "aaaaaab", "aaaaaab"}});
    // The stroke's own pixels go to the nearest part, the upper left one where two are as near.
    EXPECT_EQ(after(store, {0, {{2, 0}, {2, 2}}}), (Rows{"cccaaab", "cccaaab", "cccaaab"}));
    EXPECT_EQ(after(store, {0, {{2, 1}, {2, 2}}}), (Rows{"cccaaab", "cccaaab", "cccaaab"}))
        << "an end inside of the segment goes on to its border";
    EXPECT_EQ(drawing(store, 0)[0], "aaaaaab") << "the store that was cut is as it was";
    const auto made = must(store.with_cut({0, {{2, 0}, {2, 2}}}));
    EXPECT_EQ(made.find(3)->segment.pixels, 9);
    EXPECT_EQ(made.find(3)->segment.colour, made.find(1)->segment.colour);
    EXPECT_EQ(made.find(1)->segment.pixels, 9);
    for (const std::uint16_t label : {1, 2, 3})
        EXPECT_EQ(made.label_at(0, made.find(label)->segment.x, made.find(label)->segment.y), label);
}

TEST(SegmentCut, PartsInsideOfLoop) {
    const SegmentStore store = stored({Rows(12, std::string(16, 'a'))});
    const auto made = after(store, {0, {{3, 3}, {9, 3}, {9, 8}, {3, 8}, {3, 4}}});
    EXPECT_EQ(made[5], "aaaabbbbbbaaaaaa") << "inside, and what is nearest to it of the stroke";
    EXPECT_EQ(made[0], std::string(16, 'a'));
    EXPECT_EQ(made[11], std::string(16, 'a'));
}

TEST(SegmentCut, LeavesUntouchedPieces) {
    // Another piece of the same segment, beyond something before it.
    const SegmentStore store = stored({{"aaaabbaa", "aaaabbaa"}});
    EXPECT_EQ(after(store, {0, {{1, 0}, {1, 1}}}), (Rows{"ccaabbaa", "ccaabbaa"}));
}

TEST(SegmentCut, KeepsBorderOfStillThings) {
    // A hand passes before it.
    const SegmentStore store = stored({{"aaaaaaaa", "aaaaaaaa"},
                                       {"bbaaaaaa", "bbaaaaaa"},
                                       {"bbbbaaaa", "bbbbaaaa"},
                                       {"aabbbbaa", "aabbbbaa"},
                                       {"aaaaaabb", "aaaaaabb"}});
    for (const std::int64_t drawn_at : {0, 4}) {
        const auto made = must(store.with_cut({drawn_at, {{2, 0}, {2, 1}}}));
        EXPECT_EQ(drawing(made, 0)[0], "cccaaaaa");
        EXPECT_EQ(drawing(made, 1)[0], "bbcaaaaa");
        EXPECT_EQ(drawing(made, 2)[0], "bbbbaaaa");
    }
}

TEST(SegmentCut, MovesBorderWithThings) {
    std::vector<Rows> frames;
    for (int k = 0; k < 5; ++k) {
        std::string row(20, 'a');
        std::fill_n(row.begin() + 2 + 2 * k, 6, 'b');
        frames.push_back({row, row, row});
    }
    const SegmentStore store = stored(frames);
    for (const std::int64_t drawn_at : {0, 2, 4}) {
        const int left = 2 + 2 * static_cast<int>(drawn_at);
        const auto made = must(store.with_cut({drawn_at, {{left + 1, 0}, {left + 1, 2}}}));
        for (int k = 0; k < 5; ++k) {
            std::string row(20, 'a');
            std::fill_n(row.begin() + 2 + 2 * k, 2, 'c');
            std::fill_n(row.begin() + 4 + 2 * k, 4, 'b');
            EXPECT_EQ(drawing(made, k)[1], row) << drawn_at;
        }
        EXPECT_EQ(made.find(3)->frame, 0);
    }
}

TEST(SegmentCut, IsRefusedIfPartingNothing) {
    const SegmentStore store = stored({{"aaaa...", "aaaa...", "aaaa..."}});
    EXPECT_NE(message(store.with_cut({0, {{4, 0}, {6, 0}}})).find("no surface"), std::string::npos);
    EXPECT_NE(message(store.with_cut({0, {{0, 0}, {0, 2}}})).find("does not part"), std::string::npos);
    EXPECT_NE(message(store.with_cut({1, {{0, 0}, {0, 2}}})).find("frame 1"), std::string::npos);
    EXPECT_NE(message(store.with_cut({0, {{1, 0}, {7, 2}}})).find("7,2"), std::string::npos);
}

SegmentNames parsed(const std::string& text) {
    const auto names = parse_segment_names(text, "n.json");
    EXPECT_TRUE(names) << names.error().message;
    return names ? *names : SegmentNames{};
}

TEST(SegmentNames, ReadMaterialsAndValues) {
    const SegmentNames names = parsed(R"({"touchable_segments": 1, "otherwise": "wood", "segments": [
        {"name": "table", "material": "glass", "at": [3, 4]},
        {"name": "mat", "material": "foam", "stiffness": 0.4, "at": [5, 6, 7]},
        {"name": "jelly", "stiffness": 0.1, "static_friction": 0.2, "dynamic_friction": 0.1, "relief": 0,
         "index": 9}]})");
    ASSERT_EQ(names.segments.size(), 3U);
    EXPECT_EQ(names.otherwise, "wood");
    EXPECT_EQ(names.segments[0].at, (std::vector<PixelOfFrame>{{3, 4, 0}}));
    EXPECT_EQ(names.segments[0].feel, find_material("glass")->feel());
    EXPECT_EQ(names.segments[1].at, (std::vector<PixelOfFrame>{{5, 6, 7}}));
    EXPECT_EQ(names.segments[1].feel.properties.stiffness, 400);
    EXPECT_EQ(names.segments[1].feel.properties.static_friction, find_material("foam")->static_friction);
    EXPECT_EQ(names.segments[2].index, 9);
    EXPECT_EQ(names.segments[2].feel, (Feel{{100, 0.2, 0.1}, 0}));
    EXPECT_EQ(names.segments[2].said_by, "n.json: segments[2]");
}

/// The example of docs/content.md.
TEST(SegmentNames, ReadDocumentedExample) {
    const std::string docs = read_bytes(std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "docs/content.md");
    const std::size_t first = docs.find("    {\"touchable_segments\""), last = docs.find("\n     ]}", first);
    ASSERT_NE(last, std::string::npos);
    EXPECT_EQ(parsed(docs.substr(first, last + 8 - first)).segments.size(), 3U);
}

TEST(SegmentNames, SurviveWritingAndReading) {
    SegmentNames names;
    names.otherwise = "skin";
    names.segments = {{"a \"b\"\n\xff", "wood", find_material("wood")->feel(), {{1, 2, 3}, {4, 5, 6}}},
                      {"own", "", {{123.456, 0.7, 0.7}, 33}, {{4, 5, 0}}},
                      {"other", "foam", {{300, 1, 0.5}, 80}, {}, 17}};
    names.cuts = {{2, {{1, 2}, {3, 4}, {5, 6}}}, {0, {{0, 0}, {9, 9}}}};
    names.segments[1].is_guess = true;
    const std::string text = segment_names_to_json(names);
    const SegmentNames again = parsed(text);
    EXPECT_EQ(segment_names_to_json(again), text);
    EXPECT_EQ(again.cuts, names.cuts);
    ASSERT_EQ(again.segments.size(), 3U);
    for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_EQ(again.segments[k].feel, names.segments[k].feel) << k;
        EXPECT_EQ(again.segments[k].material, names.segments[k].material);
        EXPECT_EQ(again.segments[k].at, names.segments[k].at);
        EXPECT_EQ(again.segments[k].is_guess, names.segments[k].is_guess);
        EXPECT_EQ(again.segments[k].index, names.segments[k].index);
    }
    EXPECT_EQ(parsed(segment_names_to_json({})).segments.size(), 0U);
}

TEST(SegmentNames, RejectInvalidMembers) {
    const auto refused = [](const std::string& segments, const std::string& why) {
        const auto names =
            parse_segment_names("{\"touchable_segments\": 1, \"segments\": " + segments + "}", "n.json");
        ASSERT_FALSE(names) << segments;
        EXPECT_EQ(names.error().kind, ErrorKind::input);
        EXPECT_TRUE(names.error().message.starts_with("n.json: ")) << names.error().message;
        EXPECT_NE(names.error().message.find(why), std::string::npos) << names.error().message;
        EXPECT_EQ(names.error().message.find('\n'), std::string::npos) << names.error().message;
    };
    refused(R"([{"name": "a", "material": "gold", "at": [1, 2]}])",
            "segments[0].material is \"gold\": must be one of wood");
    refused(R"([{"name": "a", "material": "wood"}])", "either at");
    refused(R"([{"name": "a", "material": "wood", "at": [1, 2], "index": 1}])", "either at");
    refused(R"([{"name": "a", "material": "wood", "at": [1]}])", "[X, Y]");
    refused(R"([{"name": "a", "material": "wood", "at": [1, -2]}])", "segments[0].at[1]");
    refused(R"([{"name": "a", "material": "wood", "at": [1, 2, -1]}])", "segments[0].at[2]");
    refused(R"([{"name": "a", "material": "wood", "index": 256}])", "segments[0].index");
    refused(R"([{"name": "a", "stiffness": 1, "at": [1, 2]}])", "of a material, or of stiffness");
    refused(R"([{"name": "a", "material": "wood", "stiffness": 0, "at": [1, 2]}])", "0.001 to 10 N/mm");
    refused(R"([{"name": "a", "material": "wood", "dynamic_friction": 1, "at": [1, 2]}])",
            "not above static_friction");
    refused(R"([{"name": "a", "material": "wood", "relief": 401, "at": [1, 2]}])", "relief");
    refused(R"([{"material": "wood", "at": [1, 2]}])", "name is missing");
    refused(R"([{"name": "a", "material": "wood", "at": [1, 2], "colour": 1}])", "unknown member");
    refused(R"([{"name": "a", "material": "wood", "at": [[1, 2], [3]]}])", "segments[0].at[1]");
    refused(R"([{"name": "a", "material": "wood", "at": []}])", "segments[0].at");
    refused("3", "a list");
    refused("[], \"cuts\": [{\"frame\": 0, \"stroke\": [[1, 2]]}]", "cuts[0].stroke");
    refused("[], \"cuts\": [{\"frame\": -1, \"stroke\": [[1, 2], [3, 4]]}]", "cuts[0].frame");
    EXPECT_FALSE(parse_segment_names("{", "n.json"));
    EXPECT_FALSE(parse_segment_names(R"({"touchable_segments": 2, "segments": []})", "n.json"));
    EXPECT_FALSE(
        parse_segment_names(R"({"touchable_segments": 1, "otherwise": "x", "segments": []})", "n.json"));
}

TEST(Palette, HasTangibleMaterials) {
    std::set<std::string_view> names;
    for (const PaletteMaterial& material : palette()) {
        SCOPED_TRACE(material.name);
        EXPECT_TRUE(names.insert(material.name).second);
        EXPECT_GT(material.stiffness, 0);
        EXPECT_LE(material.stiffness, as_stiff_as_the_device);
        EXPECT_EQ(material.stiffness == as_stiff_as_the_device,
                  material.stiffness_source == "as stiff as the device can");
        EXPECT_GE(material.dynamic_friction, 0);
        EXPECT_LE(material.dynamic_friction, material.static_friction);
        // No source has both: the static one is estimated.
        EXPECT_NEAR(material.static_friction, material.dynamic_friction * 4 / 3, 0.0051);
        EXPECT_FALSE(material.friction_source.empty());
        EXPECT_EQ(find_material(material.name), &material);
    }
    EXPECT_GE(names.size(), 16U);
}

TEST(Palette, ListsItsMaterials) {
    EXPECT_EQ(find_material("wod"), nullptr);
    const std::string why = no_such_material("wod");
    EXPECT_NE(why.find("\"wod\" is no material (wood?)"), std::string::npos) << why;
    for (const PaletteMaterial& material : palette())
        EXPECT_NE(why.find(material.name), std::string::npos) << material.name;
}

TEST(Palette, IsCodedPrecisely) {
    const HapticRanges ranges = ranges_of_palette({}, {});
    for (const PaletteMaterial& material : palette()) {
        const auto code = haptic_code(material.feel().properties, ranges);
        const HapticProperties felt = ranges.at(code[0], code[1], code[2]);
        EXPECT_NEAR(felt.stiffness / 1000, material.stiffness, 0.0039) << material.name;
        EXPECT_NEAR(felt.static_friction, material.static_friction, 0.003) << material.name;
        EXPECT_NEAR(felt.dynamic_friction, material.dynamic_friction, 0.003) << material.name;
        EXPECT_LE(code[2], code[1]) << material.name;
    }
    const Feel stone{{5e3, 3, 2}, 100};
    EXPECT_EQ(ranges_of_palette({}, {stone}).stiffness.max, 5);
    EXPECT_EQ(ranges_of_palette({}, {stone}).dynamic_friction.max, 3);
}

/// As docs/content.md prints it.
TEST(Palette, MatchesDocumentation) {
    const std::string docs = read_bytes(std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "docs/content.md");
    for (const PaletteMaterial& material : palette()) {
        std::ostringstream row;
        row << "| `" << material.name << "` | " << material.stiffness << " | " << material.static_friction
            << ", " << material.dynamic_friction << " | " << material.relief << " | ";
        EXPECT_NE(docs.find(row.str()), std::string::npos) << row.str();
    }
}

TEST(Palette, GuessesWhatColoursSuggest) {
    const auto guess = [](std::array<std::uint8_t, 3> colour, int levels, int per_cent) {
        return guess_material({1, per_cent, colour, 0, 0, levels * 16}, 100).name;
    };
    EXPECT_EQ(guess({150, 100, 60}, 3, 30), "wood");
    EXPECT_EQ(guess({220, 170, 150}, 1, 10), "skin");
    EXPECT_EQ(guess({170, 70, 50}, 8, 30), "brick");
    EXPECT_EQ(guess({70, 130, 50}, 9, 30), "grass");
    EXPECT_EQ(guess({240, 240, 238}, 1, 10), "paper");
    EXPECT_EQ(guess({140, 140, 145}, 1, 5), "metal");
    EXPECT_EQ(guess({140, 140, 145}, 1, 10), "plastic");
    EXPECT_EQ(guess({140, 140, 140}, 9, 10), "stone");
    EXPECT_EQ(guess({30, 30, 30}, 1, 10), "rubber");
    EXPECT_EQ(guess({220, 30, 40}, 1, 5), "plastic");
    EXPECT_EQ(guess({60, 70, 150}, 4, 10), "cloth");
    EXPECT_EQ(guess({60, 70, 150}, 4, 40), "carpet");
}

TEST(Palette, AlwaysHasAGuess) {
    for (int red = 0; red < 256; red += 15)
        for (int green = 0; green < 256; green += 15)
            for (int blue = 0; blue < 256; blue += 15)
                for (const int contrast : {0, 32, 33, 96, 97, 5000})
                    for (const int pixels : {0, 1, 300, 1000}) {
                        const Segment segment{
                            1,
                            pixels,
                            {static_cast<std::uint8_t>(red), static_cast<std::uint8_t>(green),
                             static_cast<std::uint8_t>(blue)},
                            0,
                            0,
                            contrast};
                        ASSERT_NE(find_material(guess_material(segment, 1000).name), nullptr);
                    }
}

}  // namespace
}  // namespace touchable::test
