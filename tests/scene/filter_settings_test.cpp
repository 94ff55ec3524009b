// The table of filters' settings, by which scene files, options, windows and reports go.
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "engine/scene/scene.hpp"

namespace touchable::test {
namespace {

const FilterSetting& setting_of(std::string_view name) {
    return *std::ranges::find(filter_settings(), name,
                              [](const FilterSetting& setting) { return std::string_view(setting.name); });
}

TEST(SettingRange, TakesNamesNumbersAndNothingElse) {
    const SettingRange names{.words = {"off", "on", "auto"}}, sides{.words = {"0", "3", "5"}, .whole = true},
        passes{.most = 16, .whole = true, .unit = "passes"}, force{.least = 0.1, .most = 20, .unit = "N"};
    EXPECT_EQ(names.value_of("auto"), 2);
    EXPECT_EQ(names.word_of(1), "on");
    EXPECT_EQ(names.value_of("1"), std::nullopt);
    EXPECT_EQ(names.in_words(), "off, on or auto");
    EXPECT_EQ(sides.value_of("5"), 5);
    EXPECT_EQ(sides.value_of("4"), std::nullopt);
    EXPECT_TRUE(sides.has(3));
    EXPECT_FALSE(sides.has(1)) << "which is a place, and no side";
    for (const char* word : {"17", "-1", "1.5", "2.0", "1e1", "x", "", " 2", "nan"})
        EXPECT_EQ(passes.value_of(word), std::nullopt) << word;
    EXPECT_EQ(passes.value_of("010"), 10);
    EXPECT_EQ(passes.in_words(), "a whole number from 0 to 16 passes");
    EXPECT_EQ(force.value_of("2.50"), 2.5);
    EXPECT_EQ(force.word_of(2.5), "2.5");
    for (const char* word : {"0.05", "21", "inf", "nan", "2,5"})
        EXPECT_EQ(force.value_of(word), std::nullopt) << word;
}

TEST(FilterSetting, EachHasANameAndADefaultOfItsOwn) {
    std::set<std::string> names;
    for (const FilterSetting& setting : filter_settings()) {
        EXPECT_TRUE(names.insert(setting.name).second) << setting.name;
        EXPECT_TRUE(setting.is_default({})) << setting.name;
        EXPECT_TRUE(setting.range.is_length || setting.range.has(setting.value.of({}).constant))
            << setting.name;
        FilterSettings named;
        if (*setting.usual) {
            EXPECT_TRUE(setting.read(setting.usual, named)) << setting.name;
            EXPECT_FALSE(setting.is_default(named)) << setting.name;
        }
        EXPECT_TRUE(!*setting.what || setting.open) << setting.name << ": a choice says whether it is stated";
    }
    EXPECT_EQ(setting_of("fill_holes").typed_name(), "fill-holes");
}

TEST(FilterSetting, ReadsWhatAPersonTypes) {
    FilterSettings filter;
    EXPECT_TRUE(setting_of("terraces").read("auto", filter));
    EXPECT_EQ(filter, FilterSettings{.terraces = TerraceRemoval::automatic});
    EXPECT_FALSE(setting_of("terraces").read("2", filter));
    const FilterSetting& temporal = setting_of("temporal");
    for (const char* word : {"1.5,2e-6", "1.5+2e-6"}) {
        filter = {};
        EXPECT_TRUE(temporal.read(word, filter)) << word;
        EXPECT_EQ(filter, (FilterSettings{.temporal = true, .temporal_noise = {1.5, 2e-6}})) << word;
    }
    EXPECT_TRUE(temporal.read("1e+5", filter));
    EXPECT_EQ(filter.temporal_noise, (DepthLength{1e5, 0}));
    for (const char* word : {"", "0", "0,0", "-1", "1,", ",1", "1,2,3", "1,-1", "nan", "much"})
        EXPECT_FALSE(temporal.read(word, filter)) << word;
    EXPECT_TRUE(temporal.read("on", filter));
    EXPECT_EQ(filter, FilterSettings{.temporal = true}) << "the noise is the scene's again";
    EXPECT_FALSE(setting_of("flying_pixels").read("on", filter));
    EXPECT_TRUE(setting_of("flying_pixels").read("2", filter));
    EXPECT_EQ(filter.flying_pixels, (DepthLength{2, 0}));
}

TEST(FilterSetting, IsCopiedWithTheLengthThatGoesWithIt) {
    const FilterSetting& temporal = setting_of("temporal");
    FilterSettings scene{.median = 5, .temporal_noise = {3, 0}};
    temporal.copy({.median = 3, .temporal = true}, scene);
    EXPECT_EQ(scene, (FilterSettings{.median = 5, .temporal = true, .temporal_noise = {3, 0}}));
    temporal.copy({.temporal_noise = {4, 1}}, scene);
    EXPECT_EQ(scene, (FilterSettings{.median = 5, .temporal_noise = {4, 1}}));
}

TEST(FilterSetting, ReachIsLeftOpenWithRemovalAlone) {
    const FilterSetting& reach = setting_of("terrace_reach");
    EXPECT_TRUE(reach.is_open_if_left_out({}, {.terraces = true}));
    EXPECT_TRUE(reach.is_open_if_left_out({.terraces = TerraceRemoval::automatic}, {}));
    EXPECT_FALSE(reach.is_open_if_left_out({.terraces = TerraceRemoval::on}, {.median = true}));
    EXPECT_TRUE(setting_of("median").is_open_if_left_out({}, {}));
    EXPECT_FALSE(setting_of("levels").is_open_if_left_out({}, {}));
}

}  // namespace
}  // namespace touchable::test
