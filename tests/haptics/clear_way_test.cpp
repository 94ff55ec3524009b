// A finger far from everything: what is skipped for it, and that nothing else changes.
#include <gtest/gtest.h>

#include "haptics_cpu/cast.hpp"
#include "haptics_cpu/world_space.hpp"
#include "tests/frame/random.hpp"
#include "tests/haptics/small_field.hpp"

namespace touchable::test {
namespace {

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

TEST(ClearWay, AFingerFarFromEverythingCostsOneBoundAndNoVertex) {
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

TEST(ClearWay, IsNeverClaimedOfAWayThatMeetsTheSurface) {
    SmallField rough(40, 35, 100.0);
    Random random(11);
    rough.shape(rough.prev, [&](int, int) { return 60.0 + random.below(80); });
    const HeightField field = rough.field();
    const WorldSpace world(field);
    int clear = 0, met = 0;
    for (int k = 0; k < 20000; ++k) {
        const auto point = [&] {
            const double depth = 30.0 + random.below(90);
            return unproject(rough.scene.camera, random.below(60) - 10.0, random.below(55) - 10.0, depth);
        };
        const glm::dvec3 from = point(), to = point();
        int cells = 0;
        const auto hit = [&] { return cast(world, from, nullptr, to, cells, 100'000).hit; };
        if (is_clear(world, from, to)) {
            ++clear;
            EXPECT_FALSE(hit());
            EXPECT_FALSE(is_behind_surface(field, from, 0));
        } else if (!is_behind_surface(field, from, 0)) {
            met += hit().has_value();
        }
    }
    EXPECT_GT(clear, 200);
    EXPECT_GT(met, 2000);
}

}  // namespace
}  // namespace touchable::test
