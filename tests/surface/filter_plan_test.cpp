#include <gtest/gtest.h>

#include "engine/surface/surface_builder.hpp"
#include "tests/surface/pictures.hpp"

namespace touchable::test {
namespace {

FilterPlan plan_of(const FilterSettings& filter, int bits = 8) {
    return FilterPlan(depth_scene(40, 30, bits, Marking::none, filter));
}

TEST(FilterPlan, OfNoFilterOnlyDecodes) {
    const FilterPlan plan = plan_of({});
    EXPECT_TRUE(plan.filters.empty());
    EXPECT_EQ(plan.reach(), 0);
    EXPECT_FALSE(plan.remembers());
    EXPECT_EQ(plan.coding(), plan.stored);
}

TEST(FilterPlan, HasTheFiltersInTheOrderOfTheConventions) {
    FilterSettings all{.median = 5, .fill_holes = 2, .terraces = TerraceRemoval::on};
    const FilterPlan still = plan_of(all);
    ASSERT_EQ(still.filters.size(), 3U);
    EXPECT_EQ(std::get<FilterPlan::HoleFilling>(still.filters[0].filter).passes, 2);
    EXPECT_EQ(std::get<FilterPlan::MedianWindow>(still.filters[1].filter).side, 5);
    EXPECT_EQ(std::get<TerraceFilter>(still.filters[2].filter).working.factor, 126);  // floor(32767 / 260)
    EXPECT_EQ(still.reach(), 2 + 2 + 16);
    EXPECT_FALSE(still.remembers());

    all.temporal = true;
    all.temporal_noise = {0.1, 0};
    const FilterPlan moving = plan_of(all);
    ASSERT_EQ(moving.filters.size(), 4U);
    EXPECT_EQ(std::get<TemporalFilter>(moving.filters[2].filter).working.factor, 126);
    EXPECT_EQ(std::get<TerraceFilter>(moving.filters[3].filter).working.factor, 1) << "multiplied before";
    EXPECT_TRUE(moving.remembers());
    EXPECT_NE(moving, still);
}

TEST(FilterPlan, EndsInTheCodingOfTheLastFilter) {
    EXPECT_EQ(plan_of({.median = 3}).coding().code_max, 255);
    FilterSettings finer{.median = 3, .temporal = true, .temporal_noise = {0.1, 0}};
    EXPECT_EQ(plan_of(finer).coding().code_max, 255 * 126);
    finer.terraces = TerraceRemoval::on;
    EXPECT_EQ(plan_of(finer).coding().code_max, 255 * 126 * 2);
    EXPECT_EQ(plan_of(finer).filters.front().coding.code_max, 255);
}

TEST(FilterPlan, FindsWhatTheSceneAsksFor) {
    const FilterPlan plan = plan_of({.median = 3});
    ASSERT_NE(plan.find<FilterPlan::MedianWindow>(), nullptr);
    EXPECT_EQ(plan.find<FilterPlan::MedianWindow>()->side, 3);
    EXPECT_EQ(plan.find<FilterPlan::HoleFilling>(), nullptr);
    EXPECT_EQ(plan.find<TemporalFilter>(), nullptr);
    const FilterPlan too_fine = plan_of({.terraces = TerraceRemoval::automatic}, 16);
    EXPECT_EQ(too_fine.find<TerraceFilter>(), nullptr) << "a step is too small to be felt";
}

}  // namespace
}  // namespace touchable::test
