#include "engine/authoring/segments.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

SegmentNames parsed(const std::string& text) {
    const auto names = parse_segment_names(text, "n.json");
    EXPECT_TRUE(names) << names.error().message;
    return names ? *names : SegmentNames{};
}

TEST(SegmentNames, AreReadWithTheirMaterialsAndOwnValues) {
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
TEST(SegmentNames, AreReadAsTheDocumentsHaveThem) {
    const std::string docs = read_bytes(std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "docs/content.md");
    const std::size_t first = docs.find("    {\"touchable_segments\""), last = docs.find("\n     ]}", first);
    ASSERT_NE(last, std::string::npos);
    EXPECT_EQ(parsed(docs.substr(first, last + 8 - first)).segments.size(), 3U);
}

TEST(SegmentNames, ComeBackAsTheyWereWritten) {
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

TEST(SegmentNames, AreRefusedInWords) {
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

}  // namespace
}  // namespace touchable::test
