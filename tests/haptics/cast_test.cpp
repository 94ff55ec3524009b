// Where a straight way meets the surface.
#include "haptics_cpu/cast.hpp"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "haptics_cpu/world_space.hpp"
#include "tests/frame/random.hpp"
#include "tests/haptics/small_field.hpp"

namespace touchable::test {
namespace {

/// Also beside the picture, thousands of pixels from where the way began, where no line bends the surface.
TEST(Cast, PutsTheProxyOnTheWay) {
    SmallField wall(64, 48, 100.0);
    wall.scene.depth.semantics = DepthSemantics::planar;
    const HeightField field = wall.field();
    const WorldSpace world(field);
    Random random(5);
    int inside = 0, beside = 0;
    for (int k = 0; k < 20000; ++k) {
        const auto point = [&](double depth) {
            return glm::dvec3(random.below(400) - 200.0, random.below(300) - 150.0, -depth);
        };
        const glm::dvec3 from = point(1 + random.below(90)), to = point(420 + random.below(100));
        int cells = 0;
        const auto place = cast(world, from, nullptr, to, cells, 100'000).hit;
        ASSERT_TRUE(place);
        const glm::dvec3 met = surface_point(world, *place), way = to - from, along = met - from;
        const double share = glm::dot(along, way) / glm::dot(way, way);
        EXPECT_LT(glm::distance(met, from + share * way), 1e-9) << "way " << k;
        EXPECT_TRUE(share > 0 && share < 1) << "way " << k;
        const bool in_picture = place->i >= 0 && place->i < 63 && place->j >= 0 && place->j < 47;
        (in_picture ? inside : beside) += 1;
    }
    EXPECT_GT(inside, 20);
    EXPECT_GT(beside, 5000);
}

}  // namespace
}  // namespace touchable::test
