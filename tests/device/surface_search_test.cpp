#include "device/hand_parts.hpp"

#include <gtest/gtest.h>

#include "tests/device/fake_probe.hpp"

namespace touchable {
namespace {

FakeProbe speck_at(double at_x, double at_y) {
    return camera_view([=](double x, double y) -> std::optional<double> {
        if (x != at_x || y != at_y) return std::nullopt;
        return 100 + x + y;
    });
}

TEST(NearestSurface, IsTheStartWhereThereIsOne) {
    const FakeProbe probe = flat_view();
    const auto found = nearest_surface(probe, {10.25, 20.5}, middle_of(probe, 1));
    ASSERT_TRUE(found);
    EXPECT_EQ(found->pixel, glm::dvec2(10.25, 20.5));
    EXPECT_EQ(found->depth, 800);
}

TEST(NearestSurface, FindsASinglePixelAnywhereInTheBox) {
    for (const glm::dvec2 at :
         {glm::dvec2(0, 0), {639, 479}, {639, 0}, {0, 479}, {320, 240}, {321, 7}, {3, 240}}) {
        const FakeProbe probe = speck_at(at.x, at.y);
        const auto found = nearest_surface(probe, {320, 240}, middle_of(probe, 1));
        ASSERT_TRUE(found) << at.x << " " << at.y;
        EXPECT_EQ(found->pixel, at);
        EXPECT_EQ(found->depth, 100 + at.x + at.y);
    }
}

TEST(NearestSurface, LooksNowhereOutsideTheBox) {
    const FakeProbe probe = speck_at(10, 10);
    EXPECT_FALSE(nearest_surface(probe, {320, 240}, middle_of(probe, 0.5)));
}

TEST(NearestSurface, PrefersTheClosestOfARing) {
    const FakeProbe probe = camera_view([](double x, double y) -> std::optional<double> {
        if (x == 326 && y == 246) return 1.0;
        if (x == 314 && y == 240) return 2.0;
        return std::nullopt;
    });
    EXPECT_EQ(nearest_surface(probe, {320, 240}, middle_of(probe, 1))->depth, 2.0);
}

TEST(MiddleOf, IsCentredAndScaled) {
    const FakeProbe probe = flat_view();
    const HandArea whole = middle_of(probe, 1), half = middle_of(probe, 0.5);
    EXPECT_EQ(whole.least, glm::dvec2(0, 0));
    EXPECT_EQ(whole.greatest, glm::dvec2(639, 479));
    EXPECT_EQ(half.least, glm::dvec2(159.75, 119.75));
    EXPECT_EQ(half.greatest, glm::dvec2(479.25, 359.25));
}

TEST(Workspace, DefaultSpansSixteenCentimetresAtTheMedianDepth) {
    const Workspace workspace = default_workspace(640, 500, 800);
    EXPECT_EQ(workspace.origin, glm::dvec3(0, 0, -800));
    EXPECT_EQ(device_depth(workspace), 800);
    const FakeProbe probe = flat_view();
    const glm::dvec3 left = workspace.to_device(probe.unproject(0, 240, 800));
    const glm::dvec3 right = workspace.to_device(probe.unproject(640, 240, 800));
    EXPECT_NEAR(right.x - left.x, 0.16, 1e-15);
    EXPECT_NEAR(right.z, 0, 1e-15);
}

TEST(Workspace, GoesThereAndBack) {
    const Workspace workspace{0.004, {1, 2, -30}};
    const glm::dvec3 there = workspace.to_scene({0.008, -0.004, 0.02});
    EXPECT_NEAR(there.x, 3, 1e-12);
    EXPECT_NEAR(there.y, 1, 1e-12);
    EXPECT_NEAR(there.z, -25, 1e-12);
    EXPECT_NEAR(workspace.to_device(there).z, 0.02, 1e-15);
}

}  // namespace
}  // namespace touchable
