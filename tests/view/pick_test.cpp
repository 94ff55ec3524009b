// What is under a place of a picture, against the plain picture.
#include "player/draw/view.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "player/draw/drawn_surface.hpp"
#include "tests/view/plain_picture.hpp"
#include "tests/view/shown.hpp"

namespace touchable::test {
namespace {

ViewCamera view_from(const Shown& shown, const HeightField& field, const char* from) {
    return make_view(*parse_viewpoint(from), shown.scene, subject_of(field).middle, 160, 100);
}

/// Places whose pixel is drawn as its neighbours are, at about one depth: where the picture has no edge.
bool is_inside(const PicturePlanes& planes, int x, int y) {
    const float here = planes.z[planes.index(x, y)];
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
            const float there = planes.z[planes.index(x + dx, y + dy)];
            if ((there > 0) != (here > 0) || std::fabs(there - here) > 0.02F * here) return false;
        }
    return true;
}

struct Compared {
    int drawn = 0, walls = 0, nothing = 0, backs = 0;
};

Compared compare(const Shown& shown, const HeightField& field, const ViewCamera& camera) {
    const ViewSurface surface = make_view_surface(field, {});
    const PicturePlanes planes = plain_picture(surface, camera);
    Compared counts;
    for (int y = 1; y + 1 < camera.height; y += 2)
        for (int x = 1; x + 1 < camera.width; x += 2) {
            if (!is_inside(planes, x, y)) continue;
            const double z = static_cast<double>(planes.z[planes.index(x, y)]);
            const auto found = pick(field, camera, x + 0.5, y + 0.5);
            EXPECT_EQ(found && found->drawn, z > 0) << x << ", " << y;
            if (found && !found->drawn) ++counts.walls;
            if (!found) ++counts.nothing;
            if (!found || !found->drawn || !(z > 0)) continue;
            ++counts.drawn;
            counts.backs += !found->from_front;
            const glm::dvec3 drawn = camera.unproject(x + 0.5, y + 0.5, z);
            const double distance = glm::length(drawn - camera.eye);
            // Painters round screen places to 1/256 pixel: on a steep slope that is some depth.
            EXPECT_LT(glm::length(found->point - drawn), 2e-3 * distance) << x << ", " << y;
            EXPECT_LT(glm::length(camera.eye + distance * found->direction - drawn), 1e-6 * distance);
            const auto seen = project(shown.scene.camera, found->point);
            EXPECT_NEAR(seen->x, found->x, 1e-6);
            EXPECT_NEAR(seen->y, found->y, 1e-6);
            EXPECT_NEAR(seen->planar_depth, found->depth, 1e-9 * found->depth);
        }
    return counts;
}

TEST(SurfacePick, IsWhatIsDrawn) {
    const char* views[] = {"own", "orbit:az=20,el=15", "orbit:az=-75,el=-30,zoom=2", "orbit:az=170,el=20",
                           "orbit:az=0,el=89,fov=90"};
    for (const char* scene : {"globe", "rough"}) {
        const auto shown = shown_scene(scene, 120, 80);
        for (const std::string from : views) {
            if (std::string(scene) == "rough" && from.size() > 20) continue;  // it is all edges from aside
            SCOPED_TRACE(scene + (" " + from));
            const HeightField field = shown->field(0.4);
            const Compared counts = compare(*shown, field, view_from(*shown, field, from.c_str()));
            EXPECT_GT(counts.drawn, 200);
            if (from == "orbit:az=170,el=20") {
                EXPECT_GT(counts.backs, counts.drawn / 2);
            } else if (from == "own") {
                EXPECT_EQ(counts.backs, 0);
            }
        }
    }
}

/// Also on walls, which the clip's own view shows: there a rounding of a place is some depth.
TEST(SurfacePick, OfTheClipsOwnViewIsEveryPixelOfIt) {
    for (const char* scene : {"globe", "cliffs"}) {
        const auto shown = shown_scene(scene, 120, 80);
        const HeightField field = shown->field();
        const ViewCamera camera = own_view(shown->scene, 480, 320, 1);
        const ViewSurface surface = make_view_surface(field, {});
        const PicturePlanes planes = plain_picture(surface, camera);
        int walls = 0;
        for (int y = 4; y + 4 < camera.height; ++y)
            for (int x = 4; x + 4 < camera.width; ++x) {
                const auto z = [&](int i, int j) {
                    return static_cast<double>(planes.z[planes.index(i, j)]);
                };
                const auto found = pick(field, camera, x + 0.5, y + 0.5);
                ASSERT_EQ(found && found->drawn, z(x, y) > 0) << scene << " " << x << ", " << y;
                if (!found || !found->drawn) continue;
                const double steep =
                    std::max(std::fabs(z(x + 1, y) - z(x - 1, y)), std::fabs(z(x, y + 1) - z(x, y - 1)));
                walls += steep > 0.06 * z(x, y);
                ASSERT_NEAR(1 / found->depth, z(x, y), 1e-5 * z(x, y) + 0.05 * steep)
                    << scene << " " << x << ", " << y;
            }
        EXPECT_GT(walls, 500) << scene;
    }
}

TEST(SurfacePick, LooksNoFartherThanItIsTold) {
    const auto shown = shown_scene("globe", 120, 80);
    const HeightField field = shown->field();
    const ViewCamera camera = view_from(*shown, field, "orbit:az=-75,el=-30,zoom=2");
    int met = 0;
    for (int y = 5; y < camera.height; y += 10)
        for (int x = 5; x < camera.width; x += 10) {
            const auto found = pick(field, camera, x, y);
            if (!found || !found->drawn) continue;
            ++met;
            const double distance = glm::length(found->point - camera.eye);
            const auto nearer = pick(field, camera, x, y, 0.999 * distance),
                       farther = pick(field, camera, x, y, 1.001 * distance);
            EXPECT_FALSE(nearer && nearer->drawn) << x << ", " << y;
            ASSERT_TRUE(farther && farther->drawn) << x << ", " << y;
            EXPECT_LT(glm::length(farther->point - found->point), 1e-9 * distance);
        }
    EXPECT_GT(met, 30);
}

TEST(SurfacePick, IsExactWhereRoundingsOfPicturesAreNot) {
    const auto shown = shown_scene("globe", 120, 80);
    const HeightField field = shown->field();
    const ViewCamera camera = view_from(*shown, field, "orbit:az=20,el=15");
    int inside = 0;
    for (int k = 0; k < 200; ++k) {
        const auto found = pick(field, camera, 30 + 0.5 * k, 50 + 0.1 * k);
        if (!found) continue;
        // The point is on the triangle of its cell, and on the line of sight. Vertices at edges are drawn
        // elsewhere.
        const double i = std::floor(found->x), j = std::floor(found->y);
        if (DrawnLattice(field, true).is_near_edges(static_cast<int>(i), static_cast<int>(j))) continue;
        ++inside;
        const double a = found->x - i, b = found->y - j;
        const auto q = [&](double di, double dj) {
            const auto x = static_cast<std::int64_t>(i + di), y = static_cast<std::int64_t>(j + dj);
            return 1 / planar_depth(shown->scene.camera, shown->scene.depth.semantics, i + di, j + dj,
                                    field.vertex(x, y).depth);
        };
        const double on = a >= b ? q(0, 0) + a * (q(1, 0) - q(0, 0)) + b * (q(1, 1) - q(1, 0))
                                 : q(0, 0) + b * (q(0, 1) - q(0, 0)) + a * (q(1, 1) - q(0, 1));
        EXPECT_NEAR(on * found->depth, 1, 1e-9);
        const glm::dvec3 way = found->point - camera.eye;
        EXPECT_LT(glm::length(glm::cross(way, found->direction)), 1e-9 * glm::length(way));
    }
    EXPECT_GT(inside, 100);
}

TEST(SurfacePick, AWallIsDrawnInTheClipsOwnViewAndAHoleInNone) {
    auto shown = shown_scene("plane", 60, 40);
    std::vector<double> depths(60 * 40);
    for (std::size_t k = 0; k < depths.size(); ++k)
        depths[k] = k % 60 < 20 ? NAN : k % 60 < 40 ? 0.5 * shown->scene.depth.far : shown->scene.depth.near;
    shown->prev.vertices = std::make_unique<ExactVertices>(60, 40, depths);
    const HeightField field = shown->field();
    const ViewCamera camera = own_view(shown->scene, 600, 400, 1e-3 * shown->scene.depth.near);
    const auto hole = pick(field, camera, 10 * 10 + 5, 205);
    ASSERT_TRUE(hole);
    EXPECT_FALSE(hole->drawn);
    EXPECT_NEAR(hole->x, 10, 1e-6);
    EXPECT_NEAR(hole->y, 20, 1e-6);
    const auto ground = pick(field, camera, 305, 205), near = pick(field, camera, 505, 205);
    ASSERT_TRUE(ground && near);
    EXPECT_TRUE(ground->drawn && near->drawn);
    EXPECT_TRUE(ground->from_front);
    const auto wall = pick(field, camera, 395 + 4, 205);  // between columns 39 and 40
    ASSERT_TRUE(wall);
    EXPECT_TRUE(wall->drawn) << "the clip's own view shows walls";
    EXPECT_GT(wall->depth, ground->depth + 10);
    EXPECT_LT(wall->depth, near->depth - 10);
    EXPECT_FALSE(pick(field, camera, -50, 205)) << "beside the picture";
    // From the right, the wall between near and ground hides nothing that is drawn.
    const ViewCamera aside = view_from(*shown, field, "orbit:az=-60,el=0");
    int through = 0;
    for (int x = 0; x < 160; ++x)
        if (const auto found = pick(field, aside, x + 0.5, 50); found && found->drawn) ++through;
    EXPECT_GT(through, 10);
}

TEST(PixelValues, AreInUnitsOfTheSceneAndMillimetres) {
    const auto shown = shown_scene("globe", 120, 80);
    const FramePair pair = shown->pair(0.25);
    const HeightField field = shown->field(0.25);
    const double millimetres = 1000 * shown->scene.metres_per_unit;
    double highest = 0;
    for (int y = 0; y < 80; ++y)
        for (int x = 0; x < 120; ++x) {
            const PixelValues values = values_at(field, pair, x, y);
            EXPECT_EQ(values.depth, field.vertex(x, y).depth);
            EXPECT_DOUBLE_EQ(values.depth_mm, values.depth * millimetres);
            EXPECT_DOUBLE_EQ(values.height_mm, values.height * millimetres);
            // The height is what the depth would have without it.
            const double bare =
                0.75 * sample_of(shown->prev, x, y).depth + 0.25 * sample_of(shown->next, x, y).depth;
            EXPECT_NEAR(values.depth + values.height, bare, 1e-9 * bare);
            EXPECT_EQ(values.properties.stiffness, field.properties(x, y, 0, 0).stiffness);
            highest = std::max(highest, values.height);
        }
    EXPECT_GT(highest, 0);
}

/// Planar depth of the surface under a place of the picture, by the cell's two triangles.
double plain_depth_at(const HeightField& field, double x, double y) {
    const int i = std::min(static_cast<int>(x), field.width() - 2),
              j = std::min(static_cast<int>(y), field.height() - 2);
    const auto q = [&](int di, int dj) {
        return 1 / planar_depth(field.scene().camera, field.scene().depth.semantics, i + di, j + dj,
                                field.vertex(i + di, j + dj).depth);
    };
    const double a = x - i, b = y - j;
    return 1 / (a >= b ? q(0, 0) + a * (q(1, 0) - q(0, 0)) + b * (q(1, 1) - q(1, 0))
                       : q(0, 0) + b * (q(0, 1) - q(0, 0)) + a * (q(1, 1) - q(0, 1)));
}

TEST(SurfaceOnWay, IsWhatManyPlacesOfItSay) {
    const auto shown = shown_scene("globe", 90, 60);
    const HeightField field = shown->field();
    const Camera& camera = field.scene().camera;
    const std::array<glm::dvec2, 6> places{
        {{3.2, 5.7}, {80.1, 55.5}, {45, 30}, {12.5, 50.25}, {70, 4}, {45, 2}}};
    int behind = 0;
    for (const glm::dvec2& a : places)
        for (const glm::dvec2& b : places)
            for (const double lift : {0.0, 2.0}) {
                if (a == b) continue;
                const glm::dvec3 from = unproject(camera, a.x, a.y, plain_depth_at(field, a.x, a.y) - lift),
                                 to = unproject(camera, b.x, b.y, plain_depth_at(field, b.x, b.y) - lift);
                const auto found = surface_on_way(field, from, to);
                ASSERT_TRUE(found);
                double most_behind = -1e9, nearest = 1e9;
                constexpr int steps = 20'000;
                for (int k = 0; k <= steps; ++k) {
                    const glm::dvec3 at = from + (to - from) * (k / static_cast<double>(steps));
                    const auto seen = project(camera, at);
                    const double depth = plain_depth_at(field, seen->x, seen->y);
                    most_behind = std::max(most_behind, -at.z - depth);
                    nearest = std::min(nearest, depth);
                }
                EXPECT_GE(found->behind, most_behind - 1e-9);
                EXPECT_NEAR(found->behind, most_behind, 0.05);
                EXPECT_LE(found->nearest, nearest + 1e-9);
                EXPECT_NEAR(found->nearest, nearest, 0.05);
                behind += found->behind > 1;
            }
    EXPECT_GT(behind, 10) << "nothing was in any way";
}

TEST(SurfaceOnWay, IsThatOfThePictureAlone) {
    const auto shown = shown_scene("globe", 90, 60);
    const HeightField field = shown->field();
    const Camera& camera = field.scene().camera;
    const double depth = 0.5 * plain_depth_at(field, 45, 30);
    const auto across =
        surface_on_way(field, unproject(camera, -50, 30, depth), unproject(camera, 140, 30, depth));
    const auto inside =
        surface_on_way(field, unproject(camera, 0, 30, depth), unproject(camera, 89, 30, depth));
    ASSERT_TRUE(across && inside);
    EXPECT_NEAR(across->behind, inside->behind, 1e-9);
    EXPECT_NEAR(across->nearest, inside->nearest, 1e-9);
    EXPECT_LT(across->behind, 0);
    EXPECT_FALSE(surface_on_way(field, unproject(camera, -50, 30, depth), unproject(camera, -2, 30, depth)));
    EXPECT_FALSE(surface_on_way(field, {0, 0, 1}, unproject(camera, 45, 30, depth))) << "behind the camera";
}

}  // namespace
}  // namespace touchable::test
