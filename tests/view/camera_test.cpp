// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "engine/base/same_bits.hpp"
#include "engine/gpu/surface_kernels.hpp"
#include "engine/gpu/vulkan_builder.hpp"
#include "player/view/drawn_surface.hpp"
#include "player/view/view.hpp"
#include "tests/gpu/gpu_fixture.hpp"
#include "tests/view/shown.hpp"

namespace touchable {
namespace {

const Scene usual_scene = [] {
    Scene any;
    any.width = 640;
    any.height = 480;
    any.camera = {600, 590, 311.5, 243.25};
    any.depth.near = 50;
    any.depth.far = 900;
    return any;
}();

void expect_near(const glm::dvec3& a, const glm::dvec3& b, double tolerance) {
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(a[axis], b[axis], tolerance);
}

TEST(ViewCamera, OwnViewCentresPixels) {
    const ViewCamera view = own_view(usual_scene, usual_scene.width, usual_scene.height, 1.0);
    for (const double x : {0.0, 17.0, 311.0, 639.0})
        for (const double y : {0.0, 100.0, 479.0})
            for (const double depth : {50.0, 333.3, 900.0}) {
                const auto screen = view.project(unproject(usual_scene.camera, x, y, depth));
                ASSERT_TRUE(screen);
                expect_near(*screen, {x + 0.5, y + 0.5, 1.0 / depth}, 1e-9);
            }
}

TEST(ViewCamera, OwnViewFitsAndCentres) {
    const ViewCamera view = own_view(usual_scene, 1280, 720, 1.0);
    const auto corner = view.project(unproject(usual_scene.camera, -0.5, -0.5, 100));
    const auto other = view.project(unproject(usual_scene.camera, 639.5, 479.5, 100));
    ASSERT_TRUE(corner && other);
    expect_near(*corner, {160, 0, 0.01}, 1e-9);
    expect_near(*other, {1120, 720, 0.01}, 1e-9);
}

TEST(ViewCamera, KeepsNearSurfaceWhenTurned) {
    for (const double depth : {2.0, 4.0, 50.0, 900.0, 1e5})
        for (const double turned : {0.0, 0.05, -0.1}) {
            Viewpoint viewpoint;
            viewpoint.own = turned == 0.0;
            viewpoint.azimuth = turned;
            const auto seen = make_view(viewpoint, usual_scene, {0, 0, -400}, 800, 600)
                                  .project(unproject(usual_scene.camera, 311.5, 243.25, depth));
            ASSERT_TRUE(seen) << depth << ", turned by " << turned;
            EXPECT_GT(seen->z, 0);
        }
}

TEST(ViewCamera, LatticeAndWorldProjectAlike) {
    Viewpoint viewpoint;
    viewpoint.azimuth = 31;
    viewpoint.elevation = -12;
    viewpoint.zoom = 1.4;
    const ViewCamera view = make_view(viewpoint, usual_scene, {12, -7, -400}, 800, 600);
    for (const double x : {3.0, 300.0, 600.0})
        for (const double depth : {200.0, 500.0}) {
            const glm::dvec4 lattice = view.clip_from_lattice * glm::dvec4(x, 77, 1, 1 / depth);
            const auto world = view.project(unproject(usual_scene.camera, x, 77, depth));
            ASSERT_TRUE(world);
            expect_near(
                {(lattice.x / lattice.w + 1) * 400, (lattice.y / lattice.w + 1) * 300, lattice.z / lattice.w},
                *world, 1e-8);
        }
}

TEST(ViewCamera, OrbitKeepsCentreAndDistance) {
    const glm::dvec3 centre(40, 25, -300);
    for (const double azimuth : {-120.0, 0.0, 45.0})
        for (const double elevation : {-80.0, 0.0, 30.0}) {
            Viewpoint viewpoint{false, azimuth, elevation, 2, std::nullopt};
            const ViewCamera view = make_view(viewpoint, usual_scene, centre, 640, 480);
            const auto screen = view.project(centre);
            ASSERT_TRUE(screen);
            EXPECT_NEAR(screen->x, 320, 1e-6);
            EXPECT_NEAR(screen->y, 240, 1e-6);
            EXPECT_NEAR(view.near / screen->z, 150, 1e-6);
        }
}

TEST(ViewCamera, OrbitTurnsRightAndUp) {
    const ViewCamera right = make_view({false, 30, 0, 1, std::nullopt}, usual_scene, {0, 0, -300}, 640, 480);
    EXPECT_GT(right.eye.x, 0);
    EXPECT_NEAR(right.eye.y, 0, 1e-9);
    const ViewCamera above = make_view({false, 0, 30, 1, std::nullopt}, usual_scene, {0, 0, -300}, 640, 480);
    EXPECT_GT(above.eye.y, 0);
    // Up is up, and right is right.
    const auto higher = above.project({0, 10, -300}), rightmost = above.project({10, 0, -300});
    EXPECT_LT(higher->y, 240);
    EXPECT_GT(rightmost->x, 320);
}

TEST(ViewCamera, FieldOfViewIsVertical) {
    const ViewCamera view = make_view({false, 0, 0, 1, 90.0}, usual_scene, {0, 0, -300}, 640, 480);
    EXPECT_NEAR(view.project({0, 300, -300})->y, 0, 1e-6);
}

TEST(ViewCamera, WholeZoomFitsPoints) {
    const glm::dvec3 centre(0, 0, -300);
    std::vector<glm::dvec3> ball;
    for (int k = 0; k < 100; ++k)
        for (int j = 0; j < 50; ++j) {
            const double longitude = 0.0628 * k, latitude = 0.0628 * (j - 25);
            ball.push_back(centre + 190.0 * glm::dvec3(std::cos(longitude) * std::cos(latitude),
                                                       std::sin(latitude),
                                                       std::sin(longitude) * std::cos(latitude)));
        }
    for (const auto& [width, height] : {std::pair(640, 480), std::pair(300, 900), std::pair(900, 200)})
        for (const std::optional<double> fov : {std::optional<double>(), std::optional(30.0)}) {
            Viewpoint viewpoint{false, 20, 15, std::nullopt, fov};
            viewpoint.zoom = whole_zoom(viewpoint, usual_scene, centre, ball, width, height);
            ASSERT_LT(*viewpoint.zoom, 1);
            ASSERT_GT(*viewpoint.zoom, 0.1);
            const ViewCamera view = make_view(viewpoint, usual_scene, centre, width, height);
            double farthest = 0;  // from the middle, in halves of the picture
            for (const glm::dvec3& point : ball) {
                const auto screen = view.project(point);
                ASSERT_TRUE(screen);
                farthest = std::max(
                    {farthest, std::abs(2 * screen->x / width - 1), std::abs(2 * screen->y / height - 1)});
            }
            EXPECT_LT(farthest, 1.0);
            EXPECT_GT(farthest, 0.88);
        }
}

TEST(ViewCamera, WholeZoomNeverExceedsOne) {
    const glm::dvec3 centre(0, 0, -300);
    const std::vector<glm::dvec3> points{{10, 0, -300}, {0, 10, -290}};
    EXPECT_EQ(whole_zoom({}, usual_scene, centre, points, 640, 480), 1);
    EXPECT_EQ(whole_zoom({}, usual_scene, centre, {}, 640, 480), 1);
}

TEST(ViewCamera, UnprojectInvertsProject) {
    const ViewCamera view =
        make_view({false, -50, 20, 1.5, std::nullopt}, usual_scene, {5, 6, -250}, 300, 200);
    const glm::dvec3 point(31, -14, -222);
    const auto screen = view.project(point);
    ASSERT_TRUE(screen);
    expect_near(view.unproject(screen->x, screen->y, screen->z), point, 1e-8);
}

TEST(ViewCamera, RejectsPointsBehindNearPlane) {
    const ViewCamera view = own_view(usual_scene, 640, 480, 10);
    EXPECT_TRUE(view.project({0, 0, -10.001}));
    EXPECT_FALSE(view.project({0, 0, -9.999}));
    EXPECT_FALSE(view.project({0, 0, 5}));
}

TEST(Viewpoint, ParsesWords) {
    EXPECT_TRUE(parse_viewpoint("own")->own);
    EXPECT_FALSE(parse_viewpoint("orbit")->own);
    const auto orbit = parse_viewpoint("orbit:az=-20.5,el=10,zoom=1.25,fov=40");
    ASSERT_TRUE(orbit);
    EXPECT_EQ(orbit->azimuth, -20.5);
    EXPECT_EQ(orbit->elevation, 10);
    EXPECT_EQ(orbit->zoom, 1.25);
    EXPECT_EQ(orbit->fov, 40);
}

TEST(Viewpoint, RejectsInvalidWithHint) {
    for (const char* words :
         {"", "front", "orbits", "orbit:az", "orbit:az=", "orbit:az=1x", "orbit:az=nan", "orbit:roll=3",
          "orbit:el=90", "orbit:az=1,az=1", "orbit:zoom=0", "orbit:fov=180", "orbit:az=181"}) {
        const auto refused = parse_viewpoint(words);
        ASSERT_FALSE(refused) << words;
        EXPECT_EQ(refused.error().kind, ErrorKind::usage);
        EXPECT_TRUE(refused.error().message.starts_with("view ")) << refused.error().message;
        EXPECT_EQ(refused.error().hints.at(0).setting, Setting::view);
    }
    EXPECT_NE(parse_viewpoint("orbit:zoom=0").error().message.find("0.1 to 20"), std::string::npos);
}

}  // namespace
}  // namespace touchable

namespace touchable::test {
namespace {

// The surface under a place of a picture, against the plain picture.

ViewCamera view_from(const Shown& shown, const HeightField& field, const char* from) {
    return view_of(shown, field, from, 160, 100);
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

/// Whether a turned view may draw otherwise than touch feels: near a gap, where vertices are eroded or moved.
bool is_beside_gap(const ViewSurface& surface, const glm::ivec2& at) {
    constexpr int reach = 3;
    for (int y = std::max(at.y - reach, 0); y <= std::min(at.y + reach, surface.height - 2); ++y)
        for (int x = std::max(at.x - reach, 0); x <= std::min(at.x + reach, surface.width - 2); ++x) {
            const auto q = [&](int i, int j) { return surface.q[surface.index(x + i, y + j)]; };
            if (triangle_is_cut(q(0, 0), q(1, 0), q(1, 1)) || triangle_is_cut(q(0, 0), q(1, 1), q(0, 1)))
                return true;
        }
    return false;
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

struct Compared {
    int drawn = 0, walls = 0, nothing = 0, backs = 0, beside_gaps = 0;
};

Compared compare(const Shown& shown, const HeightField& field, const ViewCamera& camera) {
    ViewSurface surface = make_view_surface(field, {});
    surface.fills_gaps = false;
    const PicturePlanes planes = plain_picture(surface, camera);
    Compared counts;
    for (int y = 1; y + 1 < camera.height; ++y)
        for (int x = 1; x + 1 < camera.width; ++x) {
            if (!is_inside(planes, x, y)) continue;
            const double z = static_cast<double>(planes.z[planes.index(x, y)]);
            const auto found = pick(field, camera, x + 0.5, y + 0.5);
            if (!is_own_view(camera) && found && is_beside_gap(surface, found->pixel())) {
                ++counts.beside_gaps;
                continue;
            }
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

TEST(SurfacePick, MatchesPlainPicture) {
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
TEST(SurfacePick, OwnViewMatchesEveryPixel) {
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

TEST(SurfacePick, StopsAtGivenDistance) {
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

TEST(SurfacePick, LiesExactlyOnTriangle) {
    const auto shown = shown_scene("globe", 120, 80);
    const HeightField field = shown->field();
    const ViewCamera camera = view_from(*shown, field, "orbit:az=20,el=15");
    int inside = 0;
    for (int k = 0; k < 200; ++k) {
        const auto found = pick(field, camera, 30 + 0.5 * k, 50 + 0.1 * k);
        if (!found) continue;
        // The point is on the triangle of its cell, and on the line of sight.
        ++inside;
        EXPECT_NEAR(found->depth / plain_depth_at(field, found->x, found->y), 1, 1e-9);
        const glm::dvec3 way = found->point - camera.eye;
        EXPECT_LT(glm::length(glm::cross(way, found->direction)), 1e-9 * glm::length(way));
    }
    EXPECT_GT(inside, 100);
}

TEST(SurfacePick, TellsWallsFromHoles) {
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

TEST(PixelValues, AreSceneUnitsAndMillimetres) {
    const auto shown = shown_scene("globe", 120, 80);
    const FramePair pair = shown->pair(0.25);
    const HeightField field = shown->field(0.25);
    const double millimetres = 1000 * shown->scene.metres_per_unit;
    double highest = 0;
    for (int y = 0; y < 80; ++y)
        for (int x = 0; x < 120; ++x) {
            const PixelValues values = values_at(field, pair, x, y);
            EXPECT_EQ(values.depth, field.vertex(x, y).depth);
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

TEST(SurfaceOnWay, MatchesSampledWay) {
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

TEST(SurfaceOnWay, CoversPictureOnly) {
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

class Unproject : public GpuTest {
protected:
    void SetUp() override {
        GpuTest::SetUp();
        lattices.emplace(gpu);
    }
    void TearDown() override {
        lattices.reset();
        GpuTest::TearDown();
    }

    /// q of the kernel against its twin.
    template <class Frames>
    void compare(const Frames& frames, double blend) {
        compare(frames.scene, frames.prev, frames.next, blend);
    }
    void compare(const Scene& scene, const SurfaceFrame& prev, const SurfaceFrame& next, double blend) {
        const FramePair pair{{0, 0, &prev}, {1, 1'000'000, &next}, blend};
        const HeightField field(scene, pair);
        expect_close(field, prev, q_of(field), q_by_kernel(gpu, *lattices, field, pair));
    }

    std::optional<GpuLattices> lattices;
};

TEST_F(Unproject, MatchesTwinForEveryCoding) {
    for_every_coding(171, 93, [&](const Codes& codes, double blend) { compare(codes, blend); });
}

TEST_F(Unproject, MatchesTwinForAnySize) {
    const DepthCoding coding = coding_of(DepthCodingKind::linear, DepthSemantics::range, true);
    for (const int width : {1, 2, 7, 8, 9, 31, 32, 33, 260})
        for (const int height : {1, 2, 5}) {
            const Codes codes(coding, width, height, false);
            compare(codes, 0.6);
        }
}

TEST_F(Unproject, MatchesTwinOnGlobe) {
    const auto globe = shown_scene("globe", 360, 240);
    for (const double blend : {0.0, 0.37}) compare(*globe, blend);
}

TEST_F(Unproject, MatchesTwinOnCameraDepth) {
    const auto castel = shown_stand_in("castel_sr300");
    ASSERT_TRUE(castel);
    compare(*castel, 0.6);
}

TEST_F(Unproject, MatchesTwinOnRecording) {
    TOUCHABLE_NEEDS_DATA(real_data("castel_sr300"));
    const auto castel = shown_recording("castel_sr300", "castel_sr300");
    ASSERT_TRUE(castel);
    compare(*castel, 0.6);
}

TEST_F(Unproject, HoldsEarlierFrameOnRequest) {
    Codes codes(coding_of(DepthCodingKind::linear, DepthSemantics::planar, true), 64, 20, false);
    codes.scene.interpolation = FrameInterpolation::hold;
    compare(codes, 0.9);
}

TEST_F(Unproject, UsesVerticesWithoutCodes) {
    const auto globe = shown_scene("globe", 96, 64);
    SurfaceFrame lazy;
    ASSERT_TRUE(make_lazy_builder(globe->scene)->build(globe->raw_prev, lazy));
    FramePair pair;
    pair.prev = pair.next = {0, 0, &lazy};
    const HeightField field(globe->scene, pair);
    EXPECT_EQ(q_by_kernel(gpu, *lattices, field, pair), q_of(globe->field()));
}

TEST_F(Unproject, ReadsVulkanFramesInPlace) {
    const auto globe = shown_scene("globe", 171, 93);
    for (const bool copies : {false, true}) {
        auto builder = must(make_vulkan_builder(globe->scene, std::make_shared<SurfaceKernels>(gpu),
                                                SurfacePlan{8, 0, false, copies}));
        SurfaceFrame prev, next;
        must(builder->build(globe->raw_prev, prev));
        must(builder->build(globe->raw_next, next));
        compare(globe->scene, prev, next, 0.4);
        if (!copies) continue;
        // The CPU's copy of them does not count.
        const FramePair pair{{0, 0, &prev}, {1, 1, &next}, 0.4};
        const HeightField field(globe->scene, pair);
        const std::vector<float> q = q_by_kernel(gpu, *lattices, field, pair);
        prev.codes.assign(prev.codes.size(), 0);
        prev.validity.assign(prev.validity.size(), 0);
        EXPECT_EQ(q_by_kernel(gpu, *lattices, field, pair), q);
    }
}

TEST_F(Unproject, RejectsTooLargeFrame) {
    const auto globe = shown_scene("globe", 96, 64);
    SurfaceFrame frame;
    must(make_cpu_builder(globe->scene)->build(globe->raw_prev, frame));
    const FramePair still{{0, 0, &frame}, {0, 0, &frame}, 0};
    gpu->vulkan()->facts.limits.max_texel_buffer_elements = 96 / 8 * 64 - 1;
    auto commands = must(GpuCommands::begin(gpu, "lattice"));
    GpuLattice lattice;
    must(lattices->record(commands, HeightField(globe->scene, still), still, lattice));
    const auto submission = std::move(commands).submit();
    EXPECT_EQ(submission.error().kind, ErrorKind::gpu);
    expect_error(submission, "kernel unproject");
}

TEST_F(Unproject, UploadsFramesOfOtherDevice) {
    const auto globe = shown_scene("globe", 70, 45);
    const auto other = must(GpuDevice::open());
    auto builder = must(make_vulkan_builder(globe->scene, other));
    SurfaceFrame prev, next;
    must(builder->build(globe->raw_prev, prev));
    must(builder->build(globe->raw_next, next));
    compare(globe->scene, prev, next, 0.4);
}

}  // namespace
}  // namespace touchable::test
