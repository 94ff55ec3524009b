// SPDX-License-Identifier: Apache-2.0
// The solver's inputs: vertices, the ring and beyond, heights, blends, properties, bounds.

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include <cmath>

#include "haptics_cpu/cast.hpp"
#include "haptics_cpu/world_space.hpp"
#include "tests/haptics/touch_rig.hpp"
#include "tests/reference/solver.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

TEST(HeightField, RingLiesAtFarPlane) {
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

TEST(HeightField, HeightReducesDepth) {
    SmallField small(3, 3, 100.0);
    small.scene.height_coding = {2.0, HeightUnits::world, 255};
    small.prev.heights.assign(9, 0);
    small.prev.heights[4] = 51;
    EXPECT_DOUBLE_EQ(small.field().vertex(1, 1).depth, 100.0 - 2.0 * 51 / 255);
    EXPECT_EQ(small.field().vertex(0, 1).depth, 100.0);
    small.scene.height_coding.units = HeightUnits::levels;
    EXPECT_DOUBLE_EQ(small.field().vertex(1, 1).depth, 100.0 - 2.0 * 51 / 255 * small.scene.depth.level());
}

TEST(HeightField, HolesLieAtFarPlane) {
    SmallField small(3, 3, 100.0);
    small.scene.height_coding = {2.0, HeightUnits::world, 255};
    small.prev.heights.assign(9, 255);
    small.set(small.prev, 1, 1, NAN);
    EXPECT_EQ(small.field().vertex(1, 1).depth, small.scene.depth.far);
    EXPECT_FALSE(small.field().vertex(1, 1).valid);
}

TEST(HeightField, DepthIsLinearInTime) {
    SmallField small(3, 3, 100.0);
    small.fill(small.next, 108.0);
    EXPECT_EQ(small.field(0.25).vertex(1, 1).depth, 102.0);
    small.scene.interpolation = FrameInterpolation::hold;
    EXPECT_EQ(small.field(0.25).vertex(1, 1).depth, 100.0);
    EXPECT_EQ(small.field(0.25).blend(), 0);
}

TEST(HeightField, MomentLiesBetweenFrames) {
    const SmallField small(3, 3, 100.0);
    const HeightField field(small.scene, {{4, 40'000'000, &small.prev}, {5, 60'000'000, &small.next}, 0.25});
    EXPECT_EQ(field.moment_ns(), 45e6);
    EXPECT_DOUBLE_EQ(field.frame_interval().value_or(0), 0.02);
}

TEST(HeightField, NearerFrameDecidesValidity) {
    SmallField small(3, 3, 100.0);
    small.set(small.next, 1, 1, NAN);
    EXPECT_TRUE(small.field(0.49).vertex(1, 1).valid);
    EXPECT_EQ(small.field(0.49).vertex(1, 1).depth, 100.0);
    EXPECT_FALSE(small.field(0.5).vertex(1, 1).valid);
}

TEST(HeightField, InterpolatesProperties) {
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

TEST(HeightField, MissingHapticImageMeansDefaults) {
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

TEST(HeightField, LimitsDynamicMeanByStatic) {
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

TEST(HeightField, HolesAndRingAreFrictionless) {
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

TEST(WorldSpace, TileBoundCoversItsVertices) {
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

TEST(WorldSpace, ImageStepTracksStraightMove) {
    SmallField small(5, 4, 100.0);
    const HeightField field = small.field();
    const WorldSpace world(field);
    const dvec3 p{3, -2, -100}, d{20, 15, -30};
    const ChartPoint from = world.chart(p).value(), to = world.chart(p + d).value();
    const ImageStep step = world.image_step(p, d);
    EXPECT_NEAR(from.x + step.dx * step.length_at(1), to.x, 1e-9);
    EXPECT_NEAR(from.y + step.dy * step.length_at(1), to.y, 1e-9);
    EXPECT_TRUE(std::isinf(world.image_step(p, {0, 1, 200}).length_at(1)));
}

// Where a straight way meets the surface.

void expect_on_way(const dvec3& met, const dvec3& from, const dvec3& to) {
    const dvec3 way = to - from, along = met - from;
    const double share = glm::dot(along, way) / glm::dot(way, way);
    EXPECT_LT(glm::distance(met, from + share * way), 1e-9);
    EXPECT_TRUE(share > 0 && share < 1) << share;
}

/// Also beside the picture, a pixel or thousands from where the way began, where no line bends the surface.
TEST(Cast, PutsProxyOnPath) {
    SmallField wall(64, 48, 100.0);
    wall.scene.depth.semantics = DepthSemantics::planar;
    const HeightField field = wall.field();
    const WorldSpace world(field);
    Random random(5);
    int inside = 0, beside = 0;
    for (int k = 0; k < 20000; ++k) {
        const auto point = [&](double depth) {
            return dvec3(random.below(400) - 200.0, random.below(300) - 150.0, -depth);
        };
        const double x = random.within(-5, 68), y = random.within(-5, 52);
        const auto near = [&](double depth) {
            return unproject(wall.scene.camera, x + random.within(-2, 2), y + random.within(-2, 2), depth);
        };
        const dvec3 from = k % 2 ? near(50) : point(1 + random.below(90));
        const dvec3 to = k % 2 ? near(500) : point(420 + random.below(100));
        int cells = 0;
        const auto place = cast(world, from, nullptr, to, cells, 100'000).hit;
        ASSERT_TRUE(place);
        expect_on_way(surface_point(world, *place), from, to);
        const bool in_picture = place->i >= 0 && place->i < 63 && place->j >= 0 && place->j < 47;
        (in_picture ? inside : beside) += 1;
    }
    EXPECT_GT(inside, 20);
    EXPECT_GT(beside, 5000);
}

// A finger far from everything: what is skipped for it, and that nothing else changes.

/// Counts what is asked of it.
class CountedVertices final : public VertexSource {
public:
    explicit CountedVertices(std::unique_ptr<VertexSource> counted) : counted_(std::move(counted)) {}
    DepthSample at(int x, int y) const override {
        ++vertices;
        return counted_->at(x, y);
    }
    TileDepths tile(int tx, int ty) const override {
        ++tiles;
        return counted_->tile(tx, ty);
    }
    mutable int vertices = 0, tiles = 0;

private:
    std::unique_ptr<VertexSource> counted_;
};

TEST(ClearPath, ReadsBoundsButNoVertex) {
    SmallField wall(64, 48, 100.0);
    auto counted = std::make_unique<CountedVertices>(std::move(wall.prev.vertices));
    const CountedVertices& counts = *counted;
    wall.prev.vertices = std::move(counted);
    FingerState finger;
    for (int tick = 1; tick <= 50; ++tick) {
        const Contact contact = wall.touch(finger, {0.01 * tick, 0.02 * tick, -60 - 0.1 * tick});
        EXPECT_FALSE(contact.touching);
        EXPECT_EQ(contact.proxy, contact.goal);
        EXPECT_EQ(counts.tiles, tick);
    }
    EXPECT_EQ(counts.vertices, 0);
    EXPECT_TRUE(wall.touch(finger, {0, 0, -101}).touching) << "and it is stopped all the same";
}

TEST(ClearPath, IsNeverClaimedThroughSurface) {
    SmallField rough(40, 35, 100.0);
    Random random(11);
    // The tile in the middle is skipped.
    rough.shape(rough.prev, [&](int x, int) { return x >= 16 && x <= 32 ? 139.0 : 60.0 + random.below(80); });
    const HeightField field = rough.field();
    const WorldSpace world(field);
    int clear = 0, met = 0;
    for (int k = 0; k < 20000; ++k) {
        const auto point = [&] {
            const double depth = 30.0 + random.below(90);
            return unproject(rough.scene.camera, random.below(60) - 10.0, random.below(55) - 10.0, depth);
        };
        const dvec3 from = point(), to = point();
        int cells = 0;
        const auto hit = [&] { return cast(world, from, nullptr, to, cells, 100'000).hit; };
        if (is_clear(world, from, to)) {
            ++clear;
            EXPECT_FALSE(hit());
            EXPECT_FALSE(is_behind_surface(field, from, 0));
        } else if (!is_behind_surface(field, from, 0)) {
            const auto place = hit();
            met += place.has_value();
            if (place) expect_on_way(surface_point(world, *place), from, to);
        }
    }
    EXPECT_GT(clear, 200);
    EXPECT_GT(met, 2000);
}

// A proxy on the very rim of a face belongs to what is on the other side of the rim as well.

/// Columns that come nearer to the right; above row 4 the ground falls away. Focal length and depths are
/// powers of two and their sums, so that goals of height 0 run along row 4 to the bit.
TEST(Rim, ProxyLeavesWhereGroundFalls) {
    SmallField cliff(9, 9, 256, DepthSemantics::planar);
    cliff.scene.camera = {8, 8, 4, 4};
    cliff.shape(cliff.prev, [](int x, int y) { return y < 4 ? 256.0 : 128.0 - 8 * x; });
    const reference::Surface surface(cliff.scene, cliff.pair());
    FingerState finger;
    cliff.touch(finger, {5.5, 0, -32});
    for (int k = 0; k < 20; ++k) {
        const Contact contact = cliff.touch(finger, {5.5 + 0.125 * k, 0, -93});
        ASSERT_TRUE(contact.touching);
        EXPECT_LT(reference::way_left(surface, finger.proxy, contact.goal), 1e-9L) << "tick " << k;
    }
}

}  // namespace
}  // namespace touchable::test
