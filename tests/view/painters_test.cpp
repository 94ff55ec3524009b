// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/same_bits.hpp"
#include "engine/surface/surface_builder.hpp"
#include "player/draw/cpu_painting.hpp"
#include "player/draw/gpu_painting.hpp"
#include "player/view/drawn_surface.hpp"
#include "shaders/cut_rule.h"
#include "shaders/tile_lists.h"
#include "tests/gpu/gpu_fixture.hpp"
#include "tests/real_data.hpp"
#include "tests/view/shown.hpp"

namespace touchable::test {
namespace {

struct Difference {
    std::size_t covered = 0;   // by the first
    std::size_t coverage = 0;  // pixels that only one covers
    std::size_t z = 0;         // pixels both cover, farther apart than they may be
    std::size_t colour = 0;    // pixels both cover, more than 2 of 255 apart

    /// `subpixels`: by which places may differ, beside 1e-6 of z.
    static Difference between(const PicturePlanes& a, const PicturePlanes& b, float subpixels) {
        Difference d;
        for (std::size_t k = 0; k < a.z.size(); ++k) {
            d.covered += a.z[k] > 0;
            if ((a.z[k] > 0) != (b.z[k] > 0)) ++d.coverage;
            if (!(a.z[k] > 0 && b.z[k] > 0)) continue;
            d.z += std::fabs(a.z[k] - b.z[k]) > 1e-6F + subpixels / 256 * slope(a, k);
            d.colour += colour_distance(a.colours[k], b.colours[k]) > 2;
        }
        return d;
    }

    /// Difference of z to the pixel beside or below.
    static float slope(const PicturePlanes& planes, std::size_t k) {
        float most = 0;
        for (const std::size_t other : {k + 1, k + static_cast<std::size_t>(planes.width)})
            if (other < planes.z.size() && planes.z[other] > 0)
                most = std::max(most, std::fabs(planes.z[other] - planes.z[k]));
        return most;
    }
};

/// A picture's silhouettes may differ by the rounding of a projection, and nothing else may.
void expect_alike(const PicturePlanes& cpu, const PicturePlanes& other, float subpixels,
                  const std::string& what) {
    ASSERT_EQ(cpu.z.size(), other.z.size()) << what;
    const Difference d = Difference::between(cpu, other, subpixels);
    const std::size_t few = 1 + d.covered / 1000;
    EXPECT_LE(d.coverage, few) << what << ", of " << d.covered;
    EXPECT_LE(d.z, few) << what << ", of " << d.covered;
    EXPECT_LE(d.colour, few) << what << ", of " << d.covered;
}

class Painters : public GpuTest {
protected:
    std::array<std::unique_ptr<SurfacePainter>, 3> all_painters() {
        return {make_cpu_painter(), must(make_raster_painter(gpu)), must(make_mesh_painter(gpu))};
    }
    static ViewCamera orbit(const Scene& scene, double azimuth, double elevation, int width, int height,
                            double zoom = 1) {
        return make_view({false, azimuth, elevation, zoom, std::nullopt}, scene, {0, 0, -100}, width, height);
    }
    void compare(const ViewSurface& surface, const ViewCamera& camera, const std::string& what) {
        const PicturePlanes plain = plain_picture(surface, camera),
                            cpu = must(make_cpu_painter()->paint(surface, camera));
        if (is_own_view(camera))  // by cell, not by edge: rounded in another way
            expect_alike(plain, cpu, 0, "cpu, " + what);
        else
            EXPECT_TRUE(cpu.z == plain.z && cpu.colours == plain.colours) << what;
        expect_alike(cpu, must(must(make_raster_painter(gpu))->paint(surface, camera)), 0, "raster, " + what);
        // Triangle hardware rounds places, and the way to z from them, in its own way.
        expect_alike(cpu, must(must(make_mesh_painter(gpu))->paint(surface, camera)), 2, "mesh, " + what);
    }

    void compare_views(const Shown& shown, double blend) {
        const HeightField field = shown.field(blend);
        const ViewSurface surface = make_view_surface(field, shown.raw_prev.colour);
        for (const char* words :
             {"own", "orbit:az=20,el=8", "orbit:az=45,el=18", "orbit:az=-35,el=-25,zoom=4"}) {
            compare(surface, view_of(shown, field, words, 480, 320), words);
        }
    }
};

TEST_F(Painters, DrawTheGlobeAlike) {
    compare_views(*shown_scene("globe", 360, 240), 0.35);
}
TEST_F(Painters, DrawAStepAlike) {
    compare_views(*shown_scene("step", 200, 133), 0);
}
TEST_F(Painters, DrawNoiseAlike) {
    const auto shown = shown_scene("noise", 128, 128);
    const HeightField field = shown->field();
    const ViewSurface surface = make_view_surface(field, ManyColours(128, 128).view());  // gaps are filled
    const ViewCamera camera = view_of(*shown, field, "orbit:az=20,el=8", 480, 320);
    const PicturePlanes cpu = plain_picture(surface, camera);
    expect_alike(cpu, must(must(make_raster_painter(gpu))->paint(surface, camera)), 0, "raster");
    // Lone slivers, whose z triangle hardware finds less exactly: only where they are is compared.
    const Difference mesh =
        Difference::between(cpu, must(must(make_mesh_painter(gpu))->paint(surface, camera)), 0);
    EXPECT_GT(mesh.covered, 500U);
    EXPECT_LE(mesh.coverage, 1U);
}
TEST_F(Painters, DrawCameraDepthAlike) {
    const auto castel = shown_stand_in("castel_sr300");
    ASSERT_TRUE(castel);
    compare_views(*castel, 0.6);
}
TEST_F(Painters, DrawARecordingAlike) {
    TOUCHABLE_NEEDS_DATA(real_data("castel_sr300"));
    const auto castel = shown_recording("castel_sr300", "castel_sr300");
    ASSERT_TRUE(castel);
    compare_views(*castel, 0.6);
}

TEST_F(Painters, DrawOwnViewExactly) {
    const auto shown = shown_scene("globe", 96, 64);
    const HeightField field = shown->field();
    const ViewSurface surface = make_view_surface(field, {});
    const ViewCamera camera = own_view(shown->scene, 96, 64, 10);
    for (const auto& painter : all_painters()) {
        const PicturePlanes planes = must(painter->paint(surface, camera));
        int drawn = 0;
        for (std::size_t k = 0; k < planes.z.size(); ++k) {
            if (!(planes.z[k] > 0)) continue;
            ++drawn;
            // On walls a rounding of a place is some depth.
            EXPECT_NEAR(planes.z[k] / 10, surface.q[k], 1e-5 * static_cast<double>(surface.q[k]))
                << painter->name() << " at " << k;
        }
        EXPECT_EQ(drawn, 96 * 64) << painter->name();
    }
}

/// Something near before something far, in colours that differ everywhere, and a hole.
struct Step {
    explicit Step(int across) : side(across) {
        surface.width = surface.height = scene.width = scene.height = side;
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                const bool is_near = x > side / 3 && y > side / 4 + x / 5;
                const auto red = static_cast<std::uint32_t>((x * 37 + y * 91) % 200 + 20);
                surface.q.push_back(is_near ? 0.02F : 0.01F);
                surface.colours.push_back(is_near ? pack_colour(red, 240, 30) : pack_colour(red, 20, 210));
            }
        surface.q[1] = 0;
        surface.focal_length = 50;
        scene.camera = {50.0, 50.0, side / 2.0, side / 2.0};
    }
    /// The clip's picture between its pixels, by the triangle there.
    glm::dvec3 colour_at(double x, double y) const {
        const int i = static_cast<int>(x), j = static_cast<int>(y);
        const double into = x - i, down = y - j;
        const bool right = into >= down;
        const auto of = [&](int column, int row) {
            const PackedColour c = surface.colours[surface.index(column, row)];
            return glm::dvec3(c & 255U, c >> 8 & 255U, c >> 16 & 255U);
        };
        const glm::dvec3 a = of(i, j), b = right ? of(i + 1, j) : of(i, j + 1), c = of(i + 1, j + 1);
        return a + std::fabs(into - down) * (b - a) + std::min(into, down) * (c - a);
    }
    int side;
    ViewSurface surface;
    Scene scene;
};

TEST_F(Painters, KeepColoursAcrossDepthSteps) {
    // Cells for either kernel of raster.
    for (const auto& [side, scale] : {std::pair(40, 8), std::pair(6, 100)}) {
        const Step step(side);
        const ViewCamera camera = own_view(step.scene, scale * side, scale * side, 1);
        for (const auto& painter : all_painters()) {
            const PicturePlanes planes = must(painter->paint(step.surface, camera));
            std::size_t missing = 0, others = 0;
            for (int py = scale; py < scale * (side - 1); ++py)
                for (int px = scale; px < scale * (side - 1); ++px) {
                    const double x = (px + 0.5) / scale - 0.5, y = (py + 0.5) / scale - 0.5;
                    if (x < 2 && y < 1) continue;  // beside the hole
                    const std::size_t pixel = planes.index(px, py);
                    const PackedColour c = planes.colours[pixel];
                    const glm::dvec3 off =
                        glm::dvec3(c & 255U, c >> 8 & 255U, c >> 16 & 255U) - step.colour_at(x, y);
                    missing += !(planes.z[pixel] > 0);
                    others += glm::length(off) > 3;
                }
            EXPECT_EQ(missing, 0U) << painter->name() << " " << side;
            EXPECT_EQ(others, 0U) << painter->name() << " " << side;
            EXPECT_EQ(planes.z[planes.index(2 * scale - 1, scale)], 0.0F) << "a hole is none any more";
        }
    }
}

/// A flat surface along -Z of one colour.
ViewSurface flat(int width, int height, float depth, float focal_length) {
    ViewSurface surface;
    surface.width = width;
    surface.height = height;
    surface.focal_length = focal_length;
    const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    surface.q.assign(pixels, 1 / depth);
    surface.colours.assign(pixels, pack_colour(10, 200, 90));
    return surface;
}

Scene scene_of(const ViewSurface& surface) {
    Scene scene;
    scene.width = surface.width;
    scene.height = surface.height;
    scene.camera = {surface.focal_length, surface.focal_length, surface.width / 2.0, surface.height / 2.0};
    return scene;
}

/// Whether a ray of the camera meets the flat surface at a depth of 100 before the eye's near plane or not at
/// all.
bool meets(const ViewSurface& surface, const Scene& scene, const ViewCamera& camera, double x, double y) {
    const glm::dvec3 near_point = camera.unproject(x, y, 1.0);
    const glm::dvec3 along = near_point - camera.eye;
    const double share = (-100 - camera.eye.z) / along.z;
    if (!(share >= 1)) return false;  // at the near plane the share is 1
    const auto pixel = project(scene.camera, camera.eye + share * along);
    return pixel && pixel->x >= 0 && pixel->y >= 0 && pixel->x <= surface.width - 1 &&
           pixel->y <= surface.height - 1;
}

TEST_F(Painters, KeepCellsCrossingNearPlane) {
    const ViewSurface surface = flat(64, 64, 100, 32);
    const Scene scene = scene_of(surface);
    for (const double azimuth : {0.0, 88.0, -89.0}) {
        const Viewpoint grazing{false, azimuth, azimuth == 0.0 ? 89.0 : 0.0, 1, 120.0};
        const ViewCamera camera = make_view(grazing, scene, {0, 0, -100}, 300, 200);
        for (const auto& painter : all_painters()) {
            const PicturePlanes planes = must(painter->paint(surface, camera));
            int drawn = 0;
            for (int y = 1; y + 1 < camera.height; ++y)
                for (int x = 1; x + 1 < camera.width; ++x) {
                    int met = 0;  // at the pixel and round it: borders are left out
                    for (const double dx : {-1.0, 0.0, 1.0})
                        for (const double dy : {-1.0, 0.0, 1.0})
                            met += meets(surface, scene, camera, x + 0.5 + dx, y + 0.5 + dy);
                    if (met != 0 && met != 9) continue;
                    drawn += met == 9;
                    ASSERT_EQ(planes.z[planes.index(x, y)] > 0, met == 9)
                        << painter->name() << " at " << x << ", " << y << ", azimuth " << azimuth;
                }
            EXPECT_GT(drawn, 1000) << painter->name();
        }
    }
}

TEST_F(Painters, DrawCellFillingPicture) {
    const ViewSurface surface = flat(2, 2, 100, 4);
    const Scene scene = scene_of(surface);
    compare(surface, own_view(scene, 900, 700, 1), "own");
    compare(surface, orbit(scene, 30, 20, 900, 700, 3), "orbit");
    const PicturePlanes planes =
        must(must(make_raster_painter(gpu))->paint(surface, own_view(scene, 900, 700, 1)));
    EXPECT_GT(planes.z[planes.index(450, 350)], 0.0F);
}

TEST_F(Painters, SharedEdgesLeaveNoGaps) {
    // Where every pixel of a flat surface is drawn, no pixel is missed; from anywhere.
    const ViewSurface surface = flat(40, 40, 100, 20);
    const Scene scene = scene_of(surface);
    for (const double azimuth : {0.0, 7.0, 33.0}) {
        const ViewCamera camera = orbit(scene, azimuth, 11, 333, 222, 1.3);
        const PicturePlanes planes = must(make_cpu_painter()->paint(surface, camera));
        for (int y = 90; y < 130; ++y)
            for (int x = 140; x < 190; ++x) ASSERT_GT(planes.z[planes.index(x, y)], 0.0F) << x << ", " << y;
        compare(surface, camera, "flat");
    }
}

TEST_F(Painters, DrawNothingForEmptySurface) {
    ViewSurface surface = flat(40, 40, 100, 20);
    const Scene scene = scene_of(surface);
    const ViewCamera camera = own_view(scene, 60, 60, 1);
    surface.q.assign(surface.q.size(), 0.0F);
    for (const auto& painter : all_painters())
        for (const float z : must(painter->paint(surface, camera)).z) ASSERT_EQ(z, 0.0F) << painter->name();
}

TEST_F(Painters, DrawPicturesOfAnySize) {
    const ViewSurface surface = flat(96, 64, 100, 50);
    const Scene scene = scene_of(surface);
    const int sizes[][2] = {{1, 1}, {2, 2}, {1, 700}, {700, 1}, {17, 33}};
    for (const auto& [width, height] : sizes)
        compare(surface, orbit(scene, 20, 10, width, height),
                std::to_string(width) + "x" + std::to_string(height));
}

TEST_F(Painters, DrawLatticesOfAnySize) {
    const int sizes[][2] = {{1, 1}, {1, 9}, {9, 1}, {2, 2}, {16, 16}, {17, 17}, {18, 18}, {33, 2}};
    for (const auto& [width, height] : sizes) {
        const ViewSurface surface = flat(width, height, 100, 40);
        const Scene scene = scene_of(surface);
        const std::string what = std::to_string(width) + "x" + std::to_string(height);
        const ViewCamera camera = own_view(scene, 101, 77, 1);
        compare(surface, camera, what);
        std::size_t drawn = 0;
        for (const float z : must(make_cpu_painter()->paint(surface, camera)).z) drawn += z > 0;
        EXPECT_EQ(drawn > 0, width > 1 && height > 1) << what;
    }
}

TEST_F(Painters, ReuseForOtherSurfaces) {
    const auto painter = must(make_raster_painter(gpu));
    const auto large = shown_scene("globe", 200, 133);
    const auto small = shown_scene("step", 60, 40);
    for (const auto& shown : {large.get(), small.get(), large.get()}) {
        const HeightField field = shown->field();
        const ViewSurface surface = make_view_surface(field, {});
        const ViewCamera camera = view_of(*shown, field, "orbit:az=15,el=5", 240, 160);
        expect_alike(must(make_cpu_painter()->paint(surface, camera)), must(painter->paint(surface, camera)),
                     0, "again");
    }
}

TEST_F(Painters, KeepSurfacesApart) {
    const auto globe = shown_scene("globe", 96, 64), step = shown_scene("step", 96, 64);
    const auto painter = must(make_raster_painter(gpu));
    const ViewCamera camera = own_view(globe->scene, 96, 64, 1);
    const ViewSurface first = surface_of(globe->field(), globe->pair(), {}, Lighting::full);
    const PicturePlanes before = must(painter->paint(first, camera));
    const ViewSurface second = surface_of(step->field(), step->pair(), {}, Lighting::full);
    EXPECT_NE(must(painter->paint(second, camera)).z, before.z);
    EXPECT_EQ(must(painter->paint(first, camera)).z, before.z);
}

TEST_F(Painters, ReportTooLargeAndLost) {
    const ViewSurface surface = flat(20, 20, 100, 20);
    const Scene scene = scene_of(surface);
    const auto raster = must(make_raster_painter(gpu));
    if (gpu->facts().limits.max_storage_buffer_range < std::uint64_t{8} * 8192 * 8192) {
        const auto refused = raster->paint(surface, own_view(scene, 8192, 8192, 1));
        ASSERT_FALSE(refused);
        EXPECT_NE(refused.error().message.find("too large"), std::string::npos) << refused.error().message;
    }
    const auto mesh = must(make_mesh_painter(gpu));
    gpu->lose();
    for (SurfacePainter* painter : {raster.get(), mesh.get()}) {
        const auto lost = painter->paint(surface, own_view(scene, 64, 64, 1));
        ASSERT_FALSE(lost);
        EXPECT_EQ(lost.error().kind, ErrorKind::gpu);
    }
}

// A surface that the CPU draws for a window, from the clip's own view and from any other.

MappedLattice mapped(const ViewSurface& surface) {
    return {surface.q.data(), surface.colours.data(), surface.width, surface.height, 1, surface.fills_gaps};
}

const std::vector<PackedColour> background(200, 7);
PicturePlanes blank_picture() {
    return {301, 200, std::vector<float>(301 * 200, 9), std::vector<PackedColour>(301 * 200)};
}
PicturePlanes own_picture(const ViewSurface& surface, const ViewCamera& camera, VectorUnit unit) {
    PicturePlanes picture = blank_picture();
    OwnViewPicture(unit).draw(mapped(surface), camera, background, picture.colours, picture.z);
    return picture;
}

TEST(OwnViewPicture, AgreesForVectors) {
    const auto shown = shown_scene("globe", 203, 133);
    const HeightField field = shown->field();
    const ViewCamera camera = view_of(*shown, field, "own", 301, 200);
    ASSERT_TRUE(OwnViewPicture::draws(camera));
    const ViewSurface surface = make_view_surface(field, shown->raw_prev.colour);
    const PicturePlanes first = own_picture(surface, camera, usable_vector_units().front());
    for (const VectorUnit unit : usable_vector_units()) {
        const PicturePlanes picture = own_picture(surface, camera, unit);
        EXPECT_EQ(picture.colours, first.colours);
        EXPECT_EQ(picture.z, first.z);
    }
    EXPECT_GT(std::ranges::count(first.colours, 7U), 1000);
    EXPECT_GT(std::ranges::count_if(first.z, [](float z) { return z > 0; }), 10'000);
}

TEST(OwnViewPicture, MatchesPlainPicture) {
    for (const char* scene : {"globe", "cliffs", "noise"}) {
        const auto shown = shown_scene(scene, 203, 133);
        const ViewSurface surface = make_view_surface(shown->field(), shown->raw_prev.colour);
        const ViewCamera camera = own_view(shown->scene, 301, 200, 1);
        ASSERT_TRUE(OwnViewPicture::draws(camera));
        const PicturePlanes expected = plain_picture(surface, camera),
                            picture = own_picture(surface, camera, usable_vector_units().front());
        std::size_t drawn = 0, others = 0;
        for (std::size_t at = 0; at < picture.z.size(); ++at) {
            const float z = picture.z[at], wanted = expected.z[at];
            drawn += z > 0;
            others += (z > 0) != (wanted > 0);
            if (!(z > 0) || !(wanted > 0)) continue;
            others += std::fabs(z - wanted) > 1e-4F * z;
            others += colour_distance(picture.colours[at], expected.colours[at]) > 1;
        }
        EXPECT_EQ(others, 0U) << scene;
        EXPECT_GT(drawn, 10'000U) << scene;
    }
}

/// A surface's picture from a turned view, or the clip's own.
PicturePlanes raster_picture(LatticeRaster& raster, const ViewSurface& surface, const ViewCamera& camera) {
    SurfaceEdges edges(1);
    if (!is_own_view(camera))
        edges.find(edge_lattice(surface.q.data(), surface.width, surface.height, surface.width, 1,
                                surface.focal_length));
    PicturePlanes picture = blank_picture();
    raster.draw(mapped(surface), edges, camera, background, picture.colours, picture.z);
    return picture;
}

/// From the side, from behind, from so near that cells are large and reach before the eye.
TEST(LatticeRaster, MatchesPlainPictureFromAnyView) {
    for (const char* scene : {"globe", "cliffs", "noise", "rows without surface"}) {
        const bool has_gap = std::string_view(scene) == "rows without surface";
        const auto shown = shown_scene(has_gap ? "globe" : scene, 203, 133);
        const HeightField field = shown->field();
        ViewSurface surface = make_view_surface(field, ManyColours(203, 133).view());
        if (has_gap) std::fill(surface.q.begin() + 40 * 203, surface.q.begin() + 60 * 203, 0.0F);
        for (const char* words :
             {"own", "orbit:az=7,el=3", "orbit:az=70,el=5", "orbit:az=-60,el=30,zoom=2", "orbit:az=180,el=0",
              "orbit:az=25,el=10,zoom=8", "orbit:az=80,el=0,zoom=20"}) {
            const ViewCamera camera = view_of(*shown, field, words, 301, 200);
            PicturePlanes expected = plain_picture(surface, camera);
            EXPECT_GT(std::ranges::count_if(expected.z, [](float z) { return z > 0; }), 50)
                << scene << ", " << words;
            for (std::size_t at = 0; at < expected.z.size(); ++at)
                if (!(expected.z[at] > 0)) expected.colours[at] = 7;
            std::vector<std::pair<int, VectorUnit>> ways{{2, usable_vector_units().front()}};
            for (const VectorUnit unit : usable_vector_units()) ways.emplace_back(1, unit);
            for (const auto& [threads, unit] : ways) {
                LatticeRaster raster(threads, unit);
                const PicturePlanes picture = raster_picture(raster, surface, camera);
                EXPECT_TRUE(picture.z == expected.z && picture.colours == expected.colours)
                    << scene << ", " << words << ", by " << threads;
            }
        }
    }
}

/// As before the first frame of a camera.
TEST(LatticeRaster, DrawsBackgroundWithoutVertices) {
    const auto shown = shown_scene("globe", 203, 133);
    const ViewCamera camera = view_of(*shown, shown->field(), "orbit:az=70,el=5", 20, 10);
    std::vector<PackedColour> colours(20 * 10);
    std::vector<float> z(colours.size(), 9);
    LatticeRaster(1).draw({nullptr, nullptr, 0, 0}, SurfaceEdges(1), camera, background, colours, z);
    EXPECT_EQ(std::ranges::count(colours, PackedColour{7}), 200);
    EXPECT_EQ(std::ranges::count(z, 0.0F), 200);
}

/// What a wider lattice left beyond the width of the next is not drawn.
TEST(LatticeRaster, ForgetsWiderLattice) {
    const auto wide = shown_scene("globe", 230, 133), narrow = shown_scene("globe", 203, 133);
    const auto draw = [&](LatticeRaster& raster, const Shown& shown) {
        const HeightField field = shown.field();
        return raster_picture(raster, make_view_surface(field, shown.raw_prev.colour),
                              view_of(shown, field, "orbit:az=30,el=5,zoom=0.5", 301, 200));
    };
    for (const VectorUnit unit : usable_vector_units()) {
        LatticeRaster fresh(1, unit), used(1, unit);
        const PicturePlanes wanted = draw(fresh, *narrow);
        draw(used, *wide);
        const PicturePlanes is = draw(used, *narrow);
        EXPECT_EQ(is.z, wanted.z);
        EXPECT_EQ(is.colours, wanted.colours);
    }
}

/// Against the twins, and the same bits with any vectors and threads.
void compare_q(const Codes& codes, double blend) {
    const FramePair pair = codes.pair(blend);
    const Scene& scene = codes.scene;
    const HeightField field(scene, pair);
    std::vector<float> first;
    for (const VectorUnit unit : usable_vector_units())
        for (const int threads : {1, 3}) {
            CpuLattices lattices(threads, unit);
            std::vector<float> q;
            lattices.q_of(field, pair, q);
            if (first.empty()) first = q;
            ASSERT_EQ(q, first) << threads << " threads";
            EXPECT_EQ(lattices.tiles_of(scene.width, scene.height, q),
                      classify_tiles(scene.width, scene.height, q));
        }
    expect_close(field, codes.prev, q_of(field), first);
}

/// The same bits with any vectors and threads.
TEST(CpuLattices, LightMatchesTwin) {
    for_every_light([](const HeightField& field, const FramePair& pair, const PlaneView& colour) {
        std::vector<float> q;
        CpuLattices(1).q_of(field, pair, q);
        std::vector<PackedColour> first;
        for (const VectorUnit unit : usable_vector_units())
            for (const int threads : {1, 3}) {
                std::vector<PackedColour> lit;
                CpuLattices(threads, unit).light(field, q, colour, Lighting::full, lit);
                if (first.empty()) first = lit;
                ASSERT_EQ(lit, first) << threads << " threads";
            }
        expect_lit(field, q, colour, first);
    });
}

TEST(CpuLattices, KeepPlainColours) {
    const auto shown = shown_scene("globe", 67, 45);
    const ManyColours colours(67, 45);
    std::vector<float> q;
    CpuLattices lattices(2);
    lattices.q_of(shown->field(), shown->pair(), q);
    std::vector<PackedColour> plain;
    lattices.light(shown->field(), q, colours.view(), Lighting::values, plain);
    ASSERT_EQ(plain.size(), q.size());
    for (std::size_t k = 0; k < plain.size(); ++k) ASSERT_EQ(plain[k], colours.at(k));
}

TEST(CpuLattices, MatchTwinForEveryCoding) {
    for_every_coding(171, 53, compare_q);
}

TEST(CpuLattices, MatchTwinForAnySize) {
    const DepthCoding coding = coding_of(DepthCodingKind::linear, DepthSemantics::range, true);
    for (const int width : {1, 2, 7, 17, 31, 32, 33, 260})
        for (const int height : {1, 2, 5, 17, 33}) {
            const Codes codes(coding, width, height, false);
            compare_q(codes, 0.6);
        }
}

TEST(CpuLattices, ListTilesOfTwin) {
    const float edge = 0.01F * CUT_RULE_RATIO;
    const std::vector<float> about_the_edge{0.01F, edge, std::nextafter(edge, 0.0F),
                                            std::nextafter(edge, 1.0F), 0.0F};
    SplitMix64 random(5);
    for (const double holes : {0.0, 0.01, 0.9}) {
        std::vector<float> q(static_cast<std::size_t>(100 * 70));
        for (float& value : q)
            value =
                random.unit() < holes ? 0.0F : about_the_edge[static_cast<std::size_t>(random.within(0, 4))];
        for (const VectorUnit unit : usable_vector_units())
            EXPECT_EQ(CpuLattices(2, unit).tiles_of(100, 70, q), classify_tiles(100, 70, q)) << holes;
    }
}

TEST(CpuLattices, UseVerticesWithoutCodes) {
    const auto globe = shown_scene("globe", 96, 64);
    SurfaceFrame lazy;
    ASSERT_TRUE(make_lazy_builder(globe->scene)->build(globe->raw_prev, lazy));
    FramePair pair;
    pair.prev = pair.next = {0, 0, &lazy};
    const HeightField field(globe->scene, pair);
    EXPECT_EQ(surface_of(field, pair, {}, Lighting::full).q, q_of(field));
}

class TileListsOnGpu : public GpuTest {
protected:
    /// Lists by the kernels and by their twin, which are the same.
    ViewSurface::Tiles compare(int width, int height, const std::function<float()>& next_q) {
        GpuLattice lattice;
        lattice.width = width;
        lattice.height = height;
        lattice.pitch = SurfaceUnproject::pitch(width);
        lattice.focal_length = 1;
        lattice.q =
            must(GpuBuffer::create(*gpu, "q", SurfaceUnproject::q_bytes(width, height), GpuMemory::shared));
        lattice.tiles = must(
            GpuBuffer::create(*gpu, "tiles", GpuLattices::tile_list_bytes(width, height), GpuMemory::shared));
        std::vector<float> q;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < lattice.pitch; ++x) {
                float& stored = lattice.q.mapped<float>()[static_cast<std::size_t>(y * lattice.pitch + x)];
                stored = x < width ? next_q() : NAN;  // nothing depends on what lies beyond the width
                if (x < width) q.push_back(stored);
            }
        GpuLattices lattices(gpu);
        auto commands = must(GpuCommands::begin(gpu, "tile lists"));
        must(lattices.record_view(commands, false, lattice));
        must(must(std::move(commands).submit()).wait());
        const TileListsHeader& header = lattice.tiles.mapped<TileListsHeader>()[0];
        const auto list = lattice.tiles.mapped<std::uint32_t>().subspan(sizeof(header) / 4);
        const auto whole = list.first(header.whole_tiles),
                   mixed = list.subspan(header.whole_tiles, header.mixed_tiles);
        const ViewSurface::Tiles tiles{{whole.begin(), whole.end()}, {mixed.begin(), mixed.end()}};
        EXPECT_EQ(tiles, classify_tiles(width, height, q)) << width << "x" << height;
        return tiles;
    }

    SplitMix64 random{11};
};

TEST_F(TileListsOnGpu, MatchTwinForAnyQ) {
    const float edge = 0.01F * CUT_RULE_RATIO;
    const std::vector<float> about_the_edge{0.01F,
                                            edge,
                                            std::nextafter(edge, 0.0F),
                                            std::nextafter(edge, 1.0F),
                                            std::nextafter(0.01F, 0.0F),
                                            std::nextafter(0.01F, 1.0F)};
    ViewSurface::Tiles all;
    for (const double holes : {0.0, 0.0005, 0.3, 1.0})
        for (const double odd : {0.0, 0.002, 0.5}) {
            const ViewSurface::Tiles tiles = compare(331, 203, [&] {
                if (random.unit() < holes) return 0.0F;
                return random.unit() < odd ? about_the_edge[random.next() % about_the_edge.size()] : 0.01F;
            });
            all.whole.insert(all.whole.end(), tiles.whole.begin(), tiles.whole.end());
            all.mixed.insert(all.mixed.end(), tiles.mixed.begin(), tiles.mixed.end());
        }
    EXPECT_GT(all.whole.size(), 500U);
    EXPECT_GT(all.mixed.size(), 500U);
}

TEST_F(TileListsOnGpu, MatchTwinForAnySize) {
    for (const int width : {1, 2, 15, 16, 17, 18, 31, 32, 33, 34, 49, 64, 65, 66})
        for (const int height : {1, 2, 16, 17, 18, 33, 40})
            compare(width, height, [&] {
                const double u = random.unit();
                return u < 0.001 ? 0.0F : (u < 0.003 ? 0.02F : 0.01F);
            });
}

TEST_F(TileListsOnGpu, MatchTwinForManyTiles) {
    const ViewSurface::Tiles tiles = compare(1920, 1080, [&] { return random.unit() < 0.002 ? 0.0F : 1.0F; });
    EXPECT_GT(tiles.whole.size(), 1000U);
    EXPECT_GT(tiles.mixed.size(), 1000U);
}

TEST(TileListsHeader, CoversTilesWithinDeviceLimits) {
    for (const std::uint32_t whole : {0U, 1U, 5U, 32768U, 100'000U})
        for (const std::uint32_t mixed : {0U, 1U, 32767U, 32768U, 162'144U}) {
            const TileListsHeader header = tile_lists_header(whole, mixed);
            EXPECT_LE(header.groups_x, 65535U);
            EXPECT_GE(header.groups_x * header.groups_y, whole + mixed);
            EXPECT_LE(header.groups_y, 1 + (whole + mixed) / 32768);
        }
}

}  // namespace
}  // namespace touchable::test
