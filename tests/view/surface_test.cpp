#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "engine/content/seeded_noise.hpp"
#include "player/draw/drawn_surface.hpp"
#include "player/draw/view.hpp"
#include "shaders/cut_rule.h"
#include "tests/view/shown.hpp"

namespace touchable::test {
namespace {

TEST(ViewSurface, QIsThatOfTheFieldTheHandTouches) {
    const auto shown = shown_scene("globe", 96, 64);
    for (const double blend : {0.0, 0.3, 0.8}) {
        const HeightField field = shown->field(blend);
        const std::vector<float> q = q_of(field);
        ASSERT_EQ(q.size(), 96U * 64U);
        for (int y = 0; y < 64; ++y)
            for (int x = 0; x < 96; ++x) {
                const double depth = planar_depth(shown->scene.camera, shown->scene.depth.semantics, x, y,
                                                  field.vertex(x, y).depth);
                EXPECT_EQ(q[static_cast<std::size_t>(y * 96 + x)], static_cast<float>(1 / depth));
            }
    }
}

/// Depths of two frames at random, in steps so that some triangles are cut and some not, with holes.
class RandomDepths {
public:
    RandomDepths(std::uint64_t seed, DepthSemantics semantics, double step) {
        scene.width = 53;
        scene.height = 38;
        scene.camera = {30, 30, 20, 25};
        scene.depth.semantics = semantics;
        scene.depth.near = 40;
        scene.depth.far = 400;
        SplitMix64 random(seed);
        for (SurfaceFrame* frame : {&prev, &next}) {
            frame->width = scene.width;
            frame->height = scene.height;
            std::vector<double> depths;
            for (int k = 0; k < scene.width * scene.height; ++k)
                depths.push_back(random.unit() < 0.01 ? NAN : 100 + step * random.unit());
            frame->vertices = std::make_unique<ExactVertices>(scene.width, scene.height, depths);
        }
    }
    HeightField field(double blend) const {
        FramePair pair;
        pair.prev = {0, 0, &prev};
        pair.next = {1, 1, &next};
        pair.blend = blend;
        return {scene, pair};
    }
    Scene scene;
    SurfaceFrame prev, next;
};

TEST(ViewTiles, WholeOnesKeepAllTheirTrianglesMixedOnesSomeInSomeView) {
    std::size_t whole = 0, mixed = 0, all_cut = 0;
    for (const DepthSemantics semantics : {DepthSemantics::range, DepthSemantics::planar})
        for (const double step : {0.5, 5.0, 12.0, 900.0})
            for (std::uint64_t seed = 1; seed <= 8; ++seed) {
                const RandomDepths depths(seed, semantics, step);
                const HeightField field = depths.field(seed % 2 ? 0.4 : 0.0);
                const std::vector<float> q = q_of(field);
                const ViewSurface::Tiles tiles = classify_tiles(field.width(), field.height(), q);
                whole += tiles.whole.size();
                mixed += tiles.mixed.size();
                const TileGrid grid = field.tiles();
                std::map<std::uint32_t, std::set<bool>> cut_of, hole_of;  // of each tile's triangles
                auto at = [&](int x, int y) { return q[static_cast<std::size_t>(y * field.width() + x)]; };
                for (int y = 0; y + 1 < field.height(); ++y)
                    for (int x = 0; x + 1 < field.width(); ++x) {
                        const auto tile = static_cast<std::uint32_t>(grid.row_of_cell(y) * grid.tiles_x +
                                                                     grid.column_of_cell(x));
                        for (const auto& [dx, dy] : {std::pair(1, 0), std::pair(0, 1)}) {
                            const float a = at(x, y), b = at(x + dx, y + dy), c = at(x + 1, y + 1);
                            cut_of[tile].insert(triangle_is_cut(a, b, c));
                            hole_of[tile].insert(!(a > 0 && b > 0 && c > 0));
                        }
                    }
                ViewSurface::Tiles expected;
                for (const auto& [tile, cut] : cut_of) {
                    if (cut == std::set{false}) expected.whole.push_back(tile);
                    // All may be cut: the clip's own view shows those without a hole.
                    const bool has_surface = hole_of[tile].contains(false);
                    if (cut.contains(true) && has_surface) expected.mixed.push_back(tile);
                    all_cut += has_surface && !cut.contains(false);
                }
                EXPECT_EQ(tiles, expected) << "seed " << seed;
            }
    EXPECT_GT(whole, 0U);  // or the test says nothing
    EXPECT_GT(mixed, 0U);
    EXPECT_GT(all_cut, 0U);
}

TEST(ViewTiles, TilesWithoutAValidPixelAreLeftOut) {
    RandomDepths depths(1, DepthSemantics::range, 1.0);
    std::vector<double> with_hole(static_cast<std::size_t>(depths.scene.width * depths.scene.height), 100.0);
    for (int y = 0; y <= 16; ++y)
        for (int x = 16; x <= 32; ++x) with_hole[static_cast<std::size_t>(y * depths.scene.width + x)] = NAN;
    depths.prev.vertices =
        std::make_unique<ExactVertices>(depths.scene.width, depths.scene.height, with_hole);
    const HeightField field = depths.field(0);
    const ViewSurface::Tiles tiles = classify_tiles(field.width(), field.height(), q_of(field));
    EXPECT_EQ(std::count(tiles.whole.begin(), tiles.whole.end(), 1U), 0);
    EXPECT_EQ(std::count(tiles.mixed.begin(), tiles.mixed.end(), 1U), 0);
    EXPECT_EQ(tiles.whole.size() + tiles.mixed.size(), 11U);
}

TEST(ViewSurface, AColourIsTheTracksInALightThatLeavesItsHue) {
    const auto shown = shown_scene("globe", 96, 64);
    const ViewSurface surface = make_view_surface(shown->field(), shown->raw_prev.colour);
    ASSERT_EQ(surface.colours.size(), surface.q.size());
    for (std::size_t k = 0; k < surface.colours.size(); ++k) {
        const std::uint8_t* rgb = shown->raw_prev.colour.row(static_cast<int>(k / 96)) + 3 * (k % 96);
        const auto r = surface.colours[k] & 255U, b = surface.colours[k] >> 16 & 255U;
        EXPECT_EQ(surface.colours[k] >> 24, 255U);
        EXPECT_TRUE(rgb[0] <= rgb[2] + 2 || r >= b) << k;
        EXPECT_TRUE(rgb[2] <= rgb[0] + 2 || b >= r) << k;
    }
}

TEST(ViewSurface, TheMiddleIsOfWhatIsNotAtTheFarPlane) {
    const auto shown = shown_scene("globe", 96, 64);
    const glm::dvec3 middle = subject_of(shown->field()).middle;
    EXPECT_NEAR(middle.x, 0, 3);
    EXPECT_GT(middle.z, -140);
    EXPECT_LT(middle.z, -50);

    RandomDepths empty(1, DepthSemantics::range, 1.0);
    const std::vector<double> none(static_cast<std::size_t>(empty.scene.width * empty.scene.height), NAN);
    empty.prev.vertices = std::make_unique<ExactVertices>(empty.scene.width, empty.scene.height, none);
    EXPECT_EQ(subject_of(empty.field(0)).middle, glm::dvec3(0, 0, -400));
}

}  // namespace
}  // namespace touchable::test
