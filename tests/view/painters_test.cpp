#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <glm/geometric.hpp>
#include <string>

#include "player/draw/gpu_painting.hpp"
#include "tests/gpu/gpu_fixture.hpp"
#include "tests/real_data.hpp"
#include "tests/view/plain_picture.hpp"
#include "tests/view/shown.hpp"

namespace touchable::test {
namespace {

struct Difference {
    std::size_t covered = 0;   // by the first
    std::size_t coverage = 0;  // pixels that only one covers
    std::size_t z = 0;         // pixels both cover, farther apart than they may be
    std::size_t colour = 0;    // likewise, more than 2 of 255 apart

    /// `subpixels`: by which places may differ, beside 1e-6 of z.
    static Difference between(const PicturePlanes& a, const PicturePlanes& b, float subpixels) {
        Difference d;
        for (std::size_t k = 0; k < a.z.size(); ++k) {
            d.covered += a.z[k] > 0;
            if ((a.z[k] > 0) != (b.z[k] > 0)) ++d.coverage;
            if (!(a.z[k] > 0 && b.z[k] > 0)) continue;
            d.z += std::fabs(a.z[k] - b.z[k]) > 1e-6F + subpixels / 256 * slope(a, k);
            int most = 0;
            for (const unsigned shift : {0U, 8U, 16U})
                most = std::max(most, std::abs(static_cast<int>(a.colours[k] >> shift & 255U) -
                                               static_cast<int>(b.colours[k] >> shift & 255U)));
            d.colour += most > 2;
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
    void compare(const ViewSurface& surface, const ViewCamera& camera, const std::string& what) {
        const PicturePlanes plain = plain_picture(surface, camera),
                            cpu = must(make_cpu_painter()->paint(surface, camera));
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
            const auto viewpoint = parse_viewpoint(words);
            compare(surface, make_view(*viewpoint, shown.scene, subject_of(field).middle, 480, 320), words);
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
    const ViewSurface surface = make_view_surface(field, {});
    const ViewCamera camera =
        make_view({false, 20, 8, 1, std::nullopt}, shown->scene, subject_of(field).middle, 480, 320);
    const PicturePlanes cpu = plain_picture(surface, camera);
    expect_alike(cpu, must(must(make_raster_painter(gpu))->paint(surface, camera)), 0, "raster");
    // Lone slivers, whose z triangle hardware finds less exactly: only where they are is compared.
    const Difference mesh =
        Difference::between(cpu, must(must(make_mesh_painter(gpu))->paint(surface, camera)), 0);
    EXPECT_GT(mesh.covered, 500U);
    EXPECT_LE(mesh.coverage, 1U);
}
TEST_F(Painters, DrawWhatACameraStoresAlike) {
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

TEST_F(Painters, DrawTheirOwnViewPixelByPixel) {
    const auto shown = shown_scene("globe", 96, 64);
    const HeightField field = shown->field();
    const ViewSurface surface = make_view_surface(field, {});
    const ViewCamera camera = own_view(shown->scene, 96, 64, 10);
    for (const auto& painter :
         {make_cpu_painter(), must(make_raster_painter(gpu)), must(make_mesh_painter(gpu))}) {
        const PicturePlanes planes = must(painter->paint(surface, camera));
        int drawn = 0;
        for (std::size_t k = 0; k < planes.z.size(); ++k) {
            if (!(planes.z[k] > 0)) continue;
            ++drawn;
            // On walls a rounding of a place is some depth.
            EXPECT_NEAR(planes.z[k] / 10, surface.q[k], 1e-5 * static_cast<double>(surface.q[k]))
                << painter->name() << " at " << k;
        }
        EXPECT_GT(drawn, 96 * 64 / 2);
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
        surface.tiles = classify_tiles(side, side, surface.q);
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

TEST_F(Painters, ShowTheClipsPictureAcrossDepthSteps) {
    // Cells for either kernel of raster.
    for (const auto& [side, scale] : {std::pair(40, 8), std::pair(6, 100)}) {
        const Step step(side);
        const ViewCamera camera = own_view(step.scene, scale * side, scale * side, 1);
        for (const auto& painter :
             {make_cpu_painter(), must(make_raster_painter(gpu)), must(make_mesh_painter(gpu))}) {
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
ViewSurface flat(int width, int height, float depth) {
    ViewSurface surface;
    surface.width = width;
    surface.height = height;
    const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    surface.q.assign(pixels, 1 / depth);
    surface.colours.assign(pixels, pack_colour(10, 200, 90));
    const TileGrid grid = TileGrid::of(width, height);
    for (int tile = 0; tile < grid.tiles_x * grid.tiles_y; ++tile)
        surface.tiles.whole.push_back(static_cast<std::uint32_t>(tile));
    return surface;
}

Scene scene_of(const ViewSurface& surface, double focal) {
    Scene scene;
    scene.width = surface.width;
    scene.height = surface.height;
    scene.camera = {focal, focal, surface.width / 2.0, surface.height / 2.0};
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

TEST_F(Painters, LoseNothingWhereCellsReachBeforeTheNearPlane) {
    const ViewSurface surface = flat(64, 64, 100);
    const Scene scene = scene_of(surface, 32);
    for (const double azimuth : {0.0, 88.0, -89.0}) {
        const Viewpoint grazing{false, azimuth, azimuth == 0.0 ? 89.0 : 0.0, 1, 120.0};
        const ViewCamera camera = make_view(grazing, scene, {0, 0, -100}, 300, 200);
        for (const auto& painter :
             {make_cpu_painter(), must(make_raster_painter(gpu)), must(make_mesh_painter(gpu))}) {
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

TEST_F(Painters, DrawACellThatFillsThePicture) {
    const ViewSurface surface = flat(2, 2, 100);
    const Scene scene = scene_of(surface, 4);
    compare(surface, own_view(scene, 900, 700, 1), "own");
    compare(surface, make_view({false, 30, 20, 3, std::nullopt}, scene, {0, 0, -100}, 900, 700), "orbit");
    const PicturePlanes planes =
        must(must(make_raster_painter(gpu))->paint(surface, own_view(scene, 900, 700, 1)));
    EXPECT_GT(planes.z[planes.index(450, 350)], 0.0F);
}

TEST_F(Painters, TrianglesThatShareEdgesNeitherOverlapNorLeaveGaps) {
    // Where every pixel of a flat surface is drawn, no pixel is missed; from anywhere.
    const ViewSurface surface = flat(40, 40, 100);
    const Scene scene = scene_of(surface, 20);
    for (const double azimuth : {0.0, 7.0, 33.0}) {
        const ViewCamera camera =
            make_view({false, azimuth, 11, 1.3, std::nullopt}, scene, {0, 0, -100}, 333, 222);
        const PicturePlanes planes = must(make_cpu_painter()->paint(surface, camera));
        for (int y = 90; y < 130; ++y)
            for (int x = 140; x < 190; ++x) ASSERT_GT(planes.z[planes.index(x, y)], 0.0F) << x << ", " << y;
        compare(surface, camera, "flat");
    }
}

TEST_F(Painters, DrawNothingOfAnEmptySurface) {
    ViewSurface surface = flat(40, 40, 100);
    const Scene scene = scene_of(surface, 20);
    const ViewCamera camera = own_view(scene, 60, 60, 1);
    for (const bool tiles : {true, false}) {
        surface.q.assign(surface.q.size(), 0.0F);
        if (!tiles)
            surface.tiles.whole.clear();
        else
            std::swap(surface.tiles.whole, surface.tiles.mixed);
        for (const auto& painter :
             {make_cpu_painter(), must(make_raster_painter(gpu)), must(make_mesh_painter(gpu))})
            for (const float z : must(painter->paint(surface, camera)).z)
                ASSERT_EQ(z, 0.0F) << painter->name();
    }
}

TEST_F(Painters, DrawPicturesOfAnySize) {
    const ViewSurface surface = flat(96, 64, 100);
    const Scene scene = scene_of(surface, 50);
    const int sizes[][2] = {{1, 1}, {2, 2}, {1, 700}, {700, 1}, {17, 33}};
    for (const auto& [width, height] : sizes)
        compare(surface, make_view({false, 20, 10, 1, std::nullopt}, scene, {0, 0, -100}, width, height),
                std::to_string(width) + "x" + std::to_string(height));
}

TEST_F(Painters, DrawLatticesOfAnySize) {
    const int sizes[][2] = {{1, 1}, {1, 9}, {9, 1}, {2, 2}, {16, 16}, {17, 17}, {18, 18}, {33, 2}};
    for (const auto& [width, height] : sizes) {
        const ViewSurface surface = flat(width, height, 100);
        const Scene scene = scene_of(surface, 40);
        const std::string what = std::to_string(width) + "x" + std::to_string(height);
        const ViewCamera camera = own_view(scene, 101, 77, 1);
        compare(surface, camera, what);
        std::size_t drawn = 0;
        for (const float z : must(make_cpu_painter()->paint(surface, camera)).z) drawn += z > 0;
        EXPECT_EQ(drawn > 0, width > 1 && height > 1) << what;
    }
}

TEST_F(Painters, KeepTheirWordFromSurfaceToSurface) {
    const auto painter = must(make_raster_painter(gpu));
    const auto large = shown_scene("globe", 200, 133);
    const auto small = shown_scene("step", 60, 40);
    for (const auto& shown : {large.get(), small.get(), large.get()}) {
        const HeightField field = shown->field();
        const ViewSurface surface = make_view_surface(field, {});
        const ViewCamera camera =
            make_view({false, 15, 5, 1, std::nullopt}, shown->scene, subject_of(field).middle, 240, 160);
        expect_alike(must(make_cpu_painter()->paint(surface, camera)), must(painter->paint(surface, camera)),
                     0, "again");
    }
}

TEST_F(Painters, DrawWhatTheyMadeOnTheGpuAlike) {
    const auto shown = shown_scene("globe", 203, 133);
    const auto raster = must(make_raster_painter(gpu)), mesh = must(make_mesh_painter(gpu));
    for (const double blend : {0.0, 0.35}) {
        const HeightField field = shown->field(blend);
        const ViewCamera camera =
            make_view({false, 25, 10, 1, std::nullopt}, shown->scene, subject_of(field).middle, 300, 200);
        const auto cpu = make_cpu_painter();
        const ViewSurface made = must(cpu->surface_of(field, shown->pair(blend), shown->raw_prev.colour));
        const PicturePlanes expected = must(cpu->paint(made, camera));
        for (SurfacePainter* painter : {raster.get(), mesh.get()}) {
            ViewSurface surface =
                must(painter->surface_of(field, shown->pair(blend), shown->raw_prev.colour));
            ASSERT_TRUE(surface.on_gpu) << painter->name();
            const float subpixels = painter == mesh.get() ? 2 : 0;
            expect_alike(must(cpu->paint(surface, camera)), must(painter->paint(surface, camera)), subpixels,
                         "its own surface");
            // q may differ by a rounding, and so may edges; from the GPU alone, for all it needs is there.
            surface.q.clear();
            surface.tiles = {};
            expect_alike(expected, must(painter->paint(surface, camera)), subpixels, "without the CPU's");
        }
    }
}

TEST_F(Painters, KeepSurfacesApart) {
    const auto globe = shown_scene("globe", 96, 64), step = shown_scene("step", 96, 64);
    const auto painter = must(make_raster_painter(gpu));
    const ViewCamera camera = own_view(globe->scene, 96, 64, 1);
    const ViewSurface first = must(painter->surface_of(globe->field(), globe->pair(), {}));
    const PicturePlanes before = must(painter->paint(first, camera));
    const ViewSurface second = must(painter->surface_of(step->field(), step->pair(), {}));
    EXPECT_NE(must(painter->paint(second, camera)).z, before.z);
    EXPECT_EQ(must(painter->paint(first, camera)).z, before.z);
}

TEST_F(Painters, TellWhatIsTooLargeOrLost) {
    const ViewSurface surface = flat(20, 20, 100);
    const Scene scene = scene_of(surface, 20);
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

}  // namespace
}  // namespace touchable::test
