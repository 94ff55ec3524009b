// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "engine/base/same_bits.hpp"
#include "haptics_cpu/touch_solver.hpp"
#include "player/draw/finger_marks.hpp"
#include "player/draw/gpu_painting.hpp"
#include "player/draw/light_picture.hpp"
#include "player/draw/pictures.hpp"
#include "player/view/drawn_surface.hpp"
#include "player/view/view.hpp"
#include "shaders/cut_rule.h"
#include "tests/gpu/gpu_fixture.hpp"
#include "tests/view/shown.hpp"

namespace touchable::test {
namespace {

const Viewpoint own = *parse_viewpoint("own");

Result<Image> picture(const Shown& shown, const SurfacePainter::Settings& settings,
                      std::span<const FingerMark> fingers) {
    const HeightField field = shown.field();
    const auto painter = make_cpu_painter();
    return make_picture(settings, shown.scene, make_view_surface(field, shown.raw_prev.colour),
                        subject_of(field), fingers, {2, 6}, *painter);
}

TEST(ScenePicture, HasTheSizeAskedFor) {
    const auto shown = shown_scene("globe", 96, 64);
    const int sizes[][2] = {{1, 1}, {2, 2}, {5, 300}, {160, 90}};
    for (const auto& [width, height] : sizes) {
        const auto image = picture(*shown, {{}, width, height}, {});
        ASSERT_TRUE(image);
        EXPECT_EQ(image->width, width);
        EXPECT_EQ(image->height, height);
        EXPECT_EQ(image->channels, 3);
        EXPECT_EQ(image->samples.size(), static_cast<std::size_t>(3 * width * height));
    }
}

TEST(ScenePicture, IsTheSameEveryTime) {
    const auto shown = shown_scene("globe", 96, 64);
    const FingerMark finger{{0, 0, -80}, {0, 0, -70}, {0, 0, 2}, true, {{-5, 0, -70}, {0, 0, -70}}};
    const auto first = picture(*shown, {{}, 160, 90}, {&finger, 1});
    const auto again = picture(*shown, {{}, 160, 90}, {&finger, 1});
    EXPECT_EQ(first->samples, again->samples);
}

TEST(ScenePicture, IsBackgroundWithoutSurface) {
    auto shown = shown_scene("globe", 96, 64);
    shown->prev.vertices = std::make_unique<ExactVertices>(96, 64, std::vector<double>(96 * 64, NAN));
    const auto image = picture(*shown, {*parse_viewpoint("orbit:az=30"), 20, 10}, {});
    ASSERT_TRUE(image);
    for (int y = 0; y < 10; ++y)
        for (int x = 1; x < 20; ++x)
            for (int channel = 0; channel < 3; ++channel)
                EXPECT_EQ(image->view().sample(x, y, channel), image->view().sample(0, y, channel));
}

/// The clip's own view shows colours where depth is missing; a turned one does not know where they are.
TEST(ScenePicture, ShowsColoursWithoutDepth) {
    auto shown = shown_scene("globe", 96, 64);
    const ManyColours colours(96, 64);
    std::vector<double> depths(96 * 64);
    for (std::size_t k = 0; k < depths.size(); ++k) depths[k] = k % 96 < 48 ? NAN : 100.0;
    shown->prev.vertices = std::make_unique<ExactVertices>(96, 64, depths);
    const HeightField field = shown->field();
    const ViewCamera camera = own_view(shown->scene, 96, 64, 10);
    for (const Lighting lighting : {Lighting::off, Lighting::values}) {
        const ViewSurface surface = make_view_surface(field, colours.view(), lighting);
        const PicturePlanes planes = must(make_cpu_painter()->paint(surface, camera));
        for (const int x : {10, 30, 70}) {
            const std::size_t at = planes.index(x, 20);
            EXPECT_EQ(planes.z[at] > 0, x > 48 || lighting == Lighting::off) << x;
            if (planes.z[at] > 0) {
                EXPECT_EQ(planes.colours[at], colours.at(at)) << x;
            }
            EXPECT_EQ(planes.z[at] > 1e-6F, x > 48) << x << ": fingers are in front of what is missing";
        }
    }
}

int pixels_that_differ(const Image& a, const Image& b) {
    int count = 0;
    for (std::size_t k = 0; k < a.samples.size(); k += 3)
        count += a.samples[k] != b.samples[k] || a.samples[k + 1] != b.samples[k + 1] ||
                 a.samples[k + 2] != b.samples[k + 2];
    return count;
}

TEST(ScenePicture, ShowsFingerInPlace) {
    const auto shown = shown_scene("plane", 96, 64);
    const auto bare = picture(*shown, {own, 192, 128}, {});
    // Half a finger before the surface, over the pixel (60, 20).
    const HeightField field = shown->field();
    const Camera& camera = shown->scene.camera;
    const double depth =
        planar_depth(camera, shown->scene.depth.semantics, 60, 20, field.vertex(60, 20).depth);
    FingerMark finger;
    finger.proxy = finger.goal = unproject(camera, 60, 20, depth);
    const auto marked = picture(*shown, {own, 192, 128}, {&finger, 1});
    EXPECT_GT(pixels_that_differ(*bare, *marked), 10);
    const auto ball = marked->view(), before = bare->view();
    EXPECT_NE(ball.sample(121, 41, 0), before.sample(121, 41, 0));
    // Away from the finger and its shadow nothing changes.
    const double reach = 6.0 * camera.fx * 2 / depth + 3;
    for (int y = 0; y < 128; ++y)
        for (int x = 0; x < 192; ++x) {
            if (std::hypot(x - 121.0, y - 41.0) <= reach) continue;
            for (int channel = 0; channel < 3; ++channel)
                ASSERT_EQ(ball.sample(x, y, channel), before.sample(x, y, channel)) << x << ", " << y;
        }
}

TEST(ScenePicture, HidesFingerBehindSurface) {
    const auto shown = shown_scene("plane", 96, 64);
    const auto bare = picture(*shown, {own, 96, 64}, {});
    FingerMark hidden;
    hidden.proxy = hidden.goal = {0, 0, -2 * shown->scene.depth.far};
    const auto marked = picture(*shown, {own, 96, 64}, {&hidden, 1});
    EXPECT_EQ(pixels_that_differ(*bare, *marked), 0);
}

TEST(ScenePicture, ShowsGoalOfTouchingFinger) {
    const auto shown = shown_scene("plane", 96, 64);
    FingerMark hidden;
    hidden.touching = true;
    hidden.proxy = {0, 0, -2 * shown->scene.depth.far};
    hidden.goal = hidden.proxy - glm::dvec3(0, 0, 1);
    const auto bare = picture(*shown, {own, 192, 128}, {});
    const auto marked = picture(*shown, {own, 192, 128}, {&hidden, 1});
    EXPECT_GT(pixels_that_differ(*bare, *marked), 0);
}

FingerMark pushed(const glm::dvec3& proxy, const glm::dvec3& goal, const glm::dvec3& force) {
    return {goal, proxy, force, true};
}
FingerShapes shapes_of(std::span<const FingerMark> fingers) {
    FingerShapes shapes;
    shape_fingers(fingers, {2, 6}, {0, 0, 0}, shapes);
    return shapes;
}

/// docs/play.md: the arrow is the force on the finger.
TEST(FingerMarks, ArrowPointsAlongForce) {
    const FingerMark finger = pushed({1, 2, -70}, {1, 2, -80}, {0, 3, 4});
    const FingerShapes shapes = shapes_of({&finger, 1});
    double farthest = 0;
    int parts = 0;
    for (const Solid& solid : shapes.solids) {
        if (solid.is_ball) continue;
        ++parts;
        EXPECT_NEAR(solid.along.y, 0.6, 1e-12);
        EXPECT_NEAR(solid.along.z, 0.8, 1e-12);
        const glm::dvec3 tip = solid.foot + solid.to.height * solid.along;
        farthest = std::max(farthest, glm::dot(tip - finger.proxy, glm::dvec3(0, 0.6, 0.8)));
    }
    EXPECT_GT(parts, 0);
    EXPECT_NEAR(farthest, 5 * 6 + 2, 0.2) << "5 N, 6 units each, from the rim of the finger";
}

/// Of 1 N and of 9 N that come at the eye, and of 9 N aside.
TEST(FingerMarks, ArrowAtEyeStaysThin) {
    const auto widest = [](const glm::dvec3& force) {
        const FingerMark finger = pushed({0, 0, -100}, {0, 0, -102}, force);
        const FingerShapes shapes = shapes_of({&finger, 1});
        double radii = 0;  // as they are seen, at the ball's distance
        for (const Solid& solid : shapes.solids)
            if (!solid.is_ball)
                for (const Ring& ring : {solid.from, solid.to}) {
                    const glm::dvec3 at = solid.foot + ring.height * solid.along;
                    radii = std::max(radii, ring.radius / 2 * 100 / -at.z);
                }
        return radii;
    };
    EXPECT_LT(widest({0, 0, 1}), 0.6);
    EXPECT_LT(widest({0, 0, 9}), 0.6);
    EXPECT_LT(widest({0, 0, 15}), 0.6) << "nearly at the eye";
    EXPECT_NEAR(widest({0, 9, 0}), 0.884, 1e-3);
}

/// In every finger's colour, so that it is seen on dark ground.
TEST(FingerMarks, ArrowIsBrighterThanFinger) {
    for (std::size_t k = 0; k < 5; ++k) {
        std::vector<FingerMark> fingers(5);
        for (FingerMark& finger : fingers) finger.shown = false;
        fingers[k].shown = fingers[k].touching = true;
        fingers[k].force = {0, 3, 4};
        const FingerShapes shapes = shapes_of(fingers);
        const auto most = [](const Solid& solid) {
            const glm::vec3& light = solid.material.light;
            return std::max({light.x, light.y, light.z});
        };
        for (const Solid& solid : shapes.solids) {
            if (solid.is_ball) continue;
            EXPECT_NEAR(most(solid), 1, 1e-6) << k;
            EXPECT_GT(most(solid), most(shapes.solids.front())) << k;
        }
    }
}

TEST(LightPicture, KeepsEveryByte) {
    LightPicture picture{256, 1, {}, {}};
    for (unsigned k = 0; k < 256; ++k) picture.light.push_back(light_of(pack_colour(k, k, k)));
    const Image image = developed(picture, 1);
    for (std::size_t k = 0; k < 256; ++k) EXPECT_EQ(image.samples[3 * k], k);
}

TEST(LightPicture, AveragesLightNotBrightness) {
    LightPicture picture{2, 2, {}, {glm::vec3(0), glm::vec3(1), glm::vec3(1), glm::vec3(0)}};
    EXPECT_EQ(developed(picture, 2).samples[0], 188);  // sRGB of half the light; brightness would be 128
}

class SurfaceLight : public GpuTest {
protected:
    void SetUp() override {
        GpuTest::SetUp();
        lattices.emplace(gpu);
        kernel.emplace(gpu);
    }
    void TearDown() override {
        lattices.reset();
        kernel.reset();
        GpuTest::TearDown();
    }

    struct Lit {
        std::vector<float> q;
        std::vector<PackedColour> colours;
    };
    Lit light(const HeightField& field, const FramePair& pair, const PlaneView& colour, Lighting lighting) {
        GpuLattice lattice;
        auto commands = must(GpuCommands::begin(gpu, "light"));
        must(lattices->record(commands, field, pair, lattice));
        must(lattices->reserve_colours(lattice));
        must(kernel->record(commands, field, lattice, colour, lighting));
        must(must(std::move(commands).submit()).wait());
        return {rows_in<float>(gpu, lattice, lattice.q),
                rows_in<PackedColour>(gpu, lattice, lattice.colours)};
    }

    std::optional<GpuLattices> lattices;
    std::optional<SurfaceLighting> kernel;
};

TEST_F(SurfaceLight, MatchesTwin) {
    for_every_light([&](const HeightField& field, const FramePair& pair, const PlaneView& colour) {
        const Lit lit = light(field, pair, colour, Lighting::full);
        expect_lit(field, lit.q, colour, lit.colours);
    });
}

TEST_F(SurfaceLight, KeepsPlainColours) {
    const auto shown = shown_scene("globe", 67, 45);
    const ManyColours colours(67, 45);
    const Lit lit = light(shown->field(), shown->pair(), colours.view(), Lighting::values);
    for (std::size_t k = 0; k < lit.colours.size(); ++k) ASSERT_EQ(lit.colours[k], colours.at(k));
}

TEST_F(SurfaceLight, LightsFramesWithoutCodes) {
    auto shown = shown_scene("globe", 96, 64);
    std::vector<double> depths(96 * 64, 0.8 * shown->scene.depth.far);
    depths[1000] = NAN;
    shown->prev.vertices = std::make_unique<ExactVertices>(96, 64, depths);
    shown->prev.codes.clear();
    const Lit lit = light(shown->field(), shown->pair(), {}, Lighting::full);
    expect_lit(shown->field(), lit.q, {}, lit.colours);
}

TEST_F(SurfaceLight, RejectsColoursOfAnotherSize) {
    const auto shown = shown_scene("globe", 67, 45);
    const ManyColours colours(67, 44);
    EXPECT_THROW(light(shown->field(), shown->pair(), colours.view(), Lighting::full), std::runtime_error);
}

TEST(ViewSurface, QMatchesTouchedField) {
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
    HeightField field(double blend) const { return {scene, {{0, 0, &prev}, {1, 1, &next}, blend}}; }
    std::vector<double> everywhere(double depth) const {
        return std::vector<double>(static_cast<std::size_t>(scene.width * scene.height), depth);
    }
    void set_prev(const std::vector<double>& depths) {
        prev.vertices = std::make_unique<ExactVertices>(scene.width, scene.height, depths);
    }

    Scene scene;
    SurfaceFrame prev, next;
};

TEST(ViewTiles, ClassifyWholeAndMixed) {
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

TEST(ViewTiles, OmitTilesWithoutValidPixels) {
    RandomDepths depths(1, DepthSemantics::range, 1.0);
    std::vector<double> with_hole = depths.everywhere(100);
    for (int y = 0; y <= 16; ++y)
        for (int x = 16; x <= 32; ++x) with_hole[static_cast<std::size_t>(y * depths.scene.width + x)] = NAN;
    depths.set_prev(with_hole);
    const HeightField field = depths.field(0);
    const ViewSurface::Tiles tiles = classify_tiles(field.width(), field.height(), q_of(field));
    EXPECT_EQ(std::count(tiles.whole.begin(), tiles.whole.end(), 1U), 0);
    EXPECT_EQ(std::count(tiles.mixed.begin(), tiles.mixed.end(), 1U), 0);
    EXPECT_EQ(tiles.whole.size() + tiles.mixed.size(), 11U);
}

TEST(ViewSurface, LightKeepsHue) {
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

TEST(ViewSurface, MiddleIgnoresFarPlane) {
    const auto shown = shown_scene("globe", 96, 64);
    const glm::dvec3 middle = subject_of(shown->field()).middle;
    EXPECT_NEAR(middle.x, 0, 3);
    EXPECT_GT(middle.z, -140);
    EXPECT_LT(middle.z, -50);

    RandomDepths empty(1, DepthSemantics::range, 1.0);
    empty.set_prev(empty.everywhere(NAN));
    EXPECT_EQ(subject_of(empty.field(0)).middle, glm::dvec3(0, 0, -400));
}

// Samples along a cell's side; a power of two, so that every one is at a whole subpixel.
constexpr int samples = 8;

/// Pressed in at random places; proxies on the surface.
std::vector<glm::dvec3> pressed(const Shown& shown, const HeightField& field, int count) {
    TouchSettings settings;
    settings.metres_per_scene_unit = 0.001;
    const auto solver = TouchSolver::create(shown.scene, settings);
    SplitMix64 random(7);
    std::vector<glm::dvec3> proxies;
    for (int k = 0; k < count; ++k) {
        const auto x = static_cast<int>(random.within(2, field.width() - 3));
        const auto y = static_cast<int>(random.within(2, field.height() - 3));
        const double depth =
            planar_depth(shown.scene.camera, shown.scene.depth.semantics, x, y, field.vertex(x, y).depth);
        const glm::dvec3 surface = unproject(shown.scene.camera, x + random.unit(), y + random.unit(), depth);
        FingerState finger;
        Contact contact;
        for (const double share : {0.8, 0.9, 1.02}) {
            const glm::dvec3 goal = share * surface;
            solver->tick(field, {&goal, 1}, {&finger, 1}, {&contact, 1});
        }
        if (contact.touching) proxies.push_back(contact.proxy);
    }
    return proxies;
}

/// q at a place, from three samples of the drawn picture within the triangle it lies in; nothing where that
/// is cut.
std::optional<double> drawn_q(const PicturePlanes& planes, const ViewSurface& surface, double near, double x,
                              double y) {
    const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
    if (i < 0 || j < 0 || i + 1 >= surface.width || j + 1 >= surface.height) return std::nullopt;
    auto q = [&](int di, int dj) { return surface.q[surface.index(i + di, j + dj)]; };
    const bool lower = x - i >= y - j;
    if (lower ? triangle_is_cut(q(0, 0), q(1, 0), q(1, 1)) : triangle_is_cut(q(0, 0), q(1, 1), q(0, 1)))
        return std::nullopt;
    // Sample (a, b) of the cell is at ((a + 0.5) / samples, ...) from its first corner: half a cell further
    // on in the picture, whose pixels' centres are the lattice's corners.
    auto sample = [&](int a, int b) {
        const int px = i * samples + samples / 2 + a, py = j * samples + samples / 2 + b;
        return static_cast<double>(planes.z[planes.index(px, py)]) / near;
    };
    const std::array<int, 2> start = lower ? std::array{6, 1} : std::array{1, 6};
    const double here = sample(start[0], start[1]);
    const int step_x = lower ? -4 : 4, step_y = lower ? 4 : -4;
    const double along_x = (sample(start[0] + step_x, start[1]) - here) / step_x;
    const double along_y = (sample(start[0], start[1] + step_y) - here) / step_y;
    return here + along_x * ((x - i) * samples - 0.5 - start[0]) +
           along_y * ((y - j) * samples - 0.5 - start[1]);
}

class EyeAndHand : public GpuTest {};

TEST_F(EyeAndHand, MeetTheSameSurface) {
    for (const char* name : {"globe", "rough"})
        for (const double blend : {0.0, 0.37}) {
            const auto shown = shown_scene(name, 160, 107);
            const HeightField field = shown->field(blend);
            const std::vector<glm::dvec3> proxies = pressed(*shown, field, 200);
            const ViewSurface surface = make_view_surface(field, {});
            const double near = 30;
            const ViewCamera camera = own_view(shown->scene, 160 * samples, 107 * samples, near);
            for (const auto& painter :
                 {make_cpu_painter(), must(make_raster_painter(gpu)), must(make_mesh_painter(gpu))}) {
                const PicturePlanes planes = must(painter->paint(surface, camera));
                int compared = 0;
                for (const glm::dvec3& proxy : proxies) {
                    const auto at = project(shown->scene.camera, proxy);
                    ASSERT_TRUE(at);
                    const auto q = drawn_q(planes, surface, near, at->x, at->y);
                    if (!q) continue;
                    ++compared;
                    EXPECT_NEAR(*q * at->planar_depth, 1.0, 3e-6)
                        << painter->name() << ", " << name << " at " << at->x << ", " << at->y;
                }
                EXPECT_GT(compared, 100) << painter->name() << ", " << name;
            }
        }
}

}  // namespace
}  // namespace touchable::test
