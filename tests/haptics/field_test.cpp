// What the solver reads: vertices, the ring and beyond, heights, blends, properties, bounds.
#include <gtest/gtest.h>

#include <cmath>

#include "haptics_cpu/world_space.hpp"
#include "tests/haptics/small_field.hpp"

namespace touchable::test {
namespace {

TEST(HeightField, RingLiesAtTheFarPlaneAndBeyondItTheSurfaceIsFlat) {
    SmallField small(5, 4, 100.0);
    const HeightField field = small.field();
    for (const auto& [i, j] : {std::pair{-1, 0}, {5, 3}, {2, -1}, {2, 4}, {-7, 2}, {900, -900}}) {
        EXPECT_EQ(field.vertex(i, j).depth, small.scene.depth.far);
        EXPECT_FALSE(field.vertex(i, j).valid);
    }
    EXPECT_TRUE(field.vertex(0, 0).valid);
    // Range coding: the ring's planar depth is far / L at the ring; beyond, q stays the ring's.
    const WorldSpace world(field);
    const double ring = world.vertex(5, 2).w;
    EXPECT_DOUBLE_EQ(ring, small.scene.camera.ray_length(5, 2) / small.scene.depth.far);
    EXPECT_EQ(world.vertex(50, 2).w, ring);
    EXPECT_DOUBLE_EQ(world.vertex(50, 2).position.z, -1 / ring);
    EXPECT_DOUBLE_EQ(world.vertex(50, 2).position.x, small.scene.camera.u(50) / ring);
}

TEST(HeightField, HeightIsALengthTakenOffTheDepth) {
    SmallField small(3, 3, 100.0);
    small.scene.height_coding = {2.0, HeightUnits::world, 255};
    small.prev.heights.assign(9, 0);
    small.prev.heights[4] = 51;
    EXPECT_DOUBLE_EQ(small.field().vertex(1, 1).depth, 100.0 - 2.0 * 51 / 255);
    EXPECT_EQ(small.field().vertex(0, 1).depth, 100.0);
    small.scene.height_coding.units = HeightUnits::levels;
    EXPECT_DOUBLE_EQ(small.field().vertex(1, 1).depth, 100.0 - 2.0 * 51 / 255 * small.scene.depth.level());
}

TEST(HeightField, InvalidPixelsAreHolesAtTheFarPlaneWithoutHeight) {
    SmallField small(3, 3, 100.0);
    small.scene.height_coding = {2.0, HeightUnits::world, 255};
    small.prev.heights.assign(9, 255);
    small.set(small.prev, 1, 1, NAN);
    EXPECT_EQ(small.field().vertex(1, 1).depth, small.scene.depth.far);
    EXPECT_FALSE(small.field().vertex(1, 1).valid);
}

TEST(HeightField, BetweenFramesDepthIsLinearInTime) {
    SmallField small(3, 3, 100.0);
    small.fill(small.next, 108.0);
    EXPECT_EQ(small.field(0.25).vertex(1, 1).depth, 102.0);
    small.scene.interpolation = FrameInterpolation::hold;
    EXPECT_EQ(small.field(0.25).vertex(1, 1).depth, 100.0);
    EXPECT_EQ(small.field(0.25).blend(), 0);
}

TEST(HeightField, APixelValidInOneFrameTakesTheStateOfTheNearerOne) {
    SmallField small(3, 3, 100.0);
    small.set(small.next, 1, 1, NAN);
    EXPECT_TRUE(small.field(0.49).vertex(1, 1).valid);
    EXPECT_EQ(small.field(0.49).vertex(1, 1).depth, 100.0);
    EXPECT_FALSE(small.field(0.5).vertex(1, 1).valid);
}

TEST(HeightField, PropertiesAreBilinearInSpaceAndLinearInTime) {
    SmallField small(3, 3, 100.0);
    small.scene.haptic = {{0.0, 2.55}, {0.0, 1.0}, {0.0, 1.0}};
    small.prev.haptic.assign(27, 0);
    small.next.haptic.assign(27, 255);
    small.prev.haptic[3 * 4] = 100;  // stiffness at (1, 1)
    const HapticProperties before = small.field().properties(0, 0, 0.5, 0.5);
    EXPECT_DOUBLE_EQ(before.stiffness, 1000.0 / 4);
    for (const double blend : {0.25, 0.4999, 0.5, 0.75}) {
        const HapticProperties between = small.field(blend).properties(0, 0, 0.5, 0.5);
        EXPECT_NEAR(between.stiffness, 250 + blend * (2550 - 250), 1e-11);
        EXPECT_NEAR(between.static_friction, blend, 1e-15);
        EXPECT_NEAR(between.dynamic_friction, blend, 1e-15);
        EXPECT_EQ(small.field(blend).stiffness(0, 0, 0.5, 0.5), between.stiffness);
    }
    small.scene.interpolation = FrameInterpolation::hold;
    EXPECT_EQ(small.field(0.75).properties(0, 0, 0.5, 0.5).stiffness, before.stiffness);
}

TEST(HeightField, AFrameWithoutAHapticImageHasTheDefaults) {
    SmallField small(3, 3, 100.0);
    small.scene.default_properties = {700, 0.8, 0.4};
    small.scene.haptic = {{0.1, 0.1}, {0.0, 1.0}, {0.0, 1.0}};
    small.next.haptic.assign(27, 0);
    EXPECT_FALSE(small.field().has_haptic_image());
    EXPECT_TRUE(small.field(0.25).has_haptic_image());
    EXPECT_DOUBLE_EQ(small.field(0.25).properties(0, 0, 0.5, 0.5).stiffness, 550);
    EXPECT_DOUBLE_EQ(small.field(0.25).properties(0, 0, 0.5, 0.5).static_friction, 0.6);
    EXPECT_DOUBLE_EQ(small.field(0.25).properties(0, 0, 0.5, 0.5).dynamic_friction, 0.3);
}

TEST(HeightField, OfBothFrictionsTheLesserIsTakenOfTheMeans) {
    SmallField small(3, 3, 100.0);
    small.scene.haptic = {{1, 1}, {0.0, 1.0}, {0.0, 1.0}};
    small.prev.haptic.assign(27, 0);
    small.next.haptic.assign(27, 0);
    for (std::size_t k = 0; k < 9; ++k) small.prev.haptic[3 * k + 2] = 51;  // mu_d 0.2, mu_s 0
    for (std::size_t k = 0; k < 9; ++k) small.next.haptic[3 * k + 1] = 51;  // mu_s 0.2, mu_d 0
    EXPECT_EQ(small.field().properties(0, 0, 0.5, 0.5).dynamic_friction, 0);
    EXPECT_NEAR(small.field(0.25).properties(0, 0, 0.5, 0.5).dynamic_friction, 0.05, 1e-15);
    EXPECT_NEAR(small.field(0.75).properties(0, 0, 0.5, 0.5).dynamic_friction, 0.05, 1e-15);
}

TEST(HeightField, FrictionIsZeroAtInvalidAndRingVertices) {
    SmallField small(3, 3, 100.0);
    small.scene.default_properties = {700, 0.8, 0.4};
    small.set(small.prev, 1, 1, NAN);
    EXPECT_EQ(small.field().properties(1, 1, 0, 0).static_friction, 0);
    EXPECT_DOUBLE_EQ(small.field().properties(0, 0, 0.5, 0).static_friction, 0.8);
    EXPECT_DOUBLE_EQ(small.field().properties(2, 0, 0.5, 0).static_friction, 0.4);
    EXPECT_EQ(small.field().properties(3, 0, 0.5, 0).dynamic_friction, 0);
    EXPECT_EQ(small.field().properties(3, 0, 0.5, 0).stiffness, 700);
}

TEST(HeightField, DynamicFrictionNeverExceedsStatic) {
    SmallField small(2, 2, 100.0);
    small.scene.haptic = {{1, 1}, {0.1, 0.1}, {0.9, 0.9}};
    small.prev.haptic.assign(12, 0);
    EXPECT_EQ(small.field().properties(0, 0, 0.5, 0.5).dynamic_friction, 0.1);
}

TEST(WorldSpace, ATilesBoundIsNearerThanEveryVertexOfIt) {
    for (const DepthSemantics semantics : {DepthSemantics::range, DepthSemantics::planar}) {
        SmallField small(40, 35, 100.0);
        small.scene.depth.semantics = semantics;
        small.scene.height_coding = {3.0, HeightUnits::world, 255};
        small.prev.heights.assign(40 * 35, 0);
        for (int y = 0; y < 35; ++y)
            for (int x = 0; x < 40; ++x) {
                small.set(small.prev, x, y, 60.0 + (x * 37 + y * 101) % 97);
                small.set(small.next, x, y, 60.0 + (x * 53 + y * 11) % 89);
                small.prev.heights[small.prev.index(x, y)] = static_cast<std::uint16_t>((x * y) % 256);
            }
        const HeightField field = small.field(0.3);
        const WorldSpace world(field);
        for (int j = -1; j <= 35; ++j)
            for (int i = -1; i <= 40; ++i)
                EXPECT_LE(world.vertex(i, j).w,
                          world.largest_w(field.tiles().column_of_cell(i), field.tiles().row_of_cell(j)));
    }
}

TEST(WorldSpace, ImageStepIsTheStraightMovesTrackOverThePicture) {
    SmallField small(5, 4, 100.0);
    const HeightField field = small.field();
    const WorldSpace world(field);
    const glm::dvec3 p{3, -2, -100}, d{20, 15, -30};
    const ChartPoint from = world.chart(p).value(), to = world.chart(p + d).value();
    const ImageStep step = world.image_step(p, d);
    EXPECT_NEAR(from.x + step.dx * step.length_at(1), to.x, 1e-9);
    EXPECT_NEAR(from.y + step.dy * step.length_at(1), to.y, 1e-9);
    EXPECT_TRUE(std::isinf(world.image_step(p, {0, 1, 200}).length_at(1)));
}

}  // namespace
}  // namespace touchable::test
