#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/vec2.hpp>
#include <optional>
#include <vector>

#include "engine/content/seeded_noise.hpp"
#include "haptics_cpu/touch_solver.hpp"
#include "player/draw/gpu_painting.hpp"
#include "shaders/cut_rule.h"
#include "tests/gpu/gpu_fixture.hpp"
#include "tests/view/shown.hpp"

namespace touchable::test {
namespace {

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

TEST_F(EyeAndHand, MeetTheSameSurfaceAtTheSameTime) {
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
