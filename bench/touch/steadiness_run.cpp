// SPDX-License-Identifier: Apache-2.0
#include "bench/touch/steadiness_run.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <memory>
#include <vector>

#include "bench/touch/force_spectrum.hpp"
#include "bench/touch/noisy_scene.hpp"
#include "bench/touch/solver_ticks.hpp"
#include "engine/base/hand_thresholds.hpp"
#include "engine/surface/surface_builder.hpp"
#include "haptics_cpu/touch_solver.hpp"

namespace touchable {
namespace {

using Forces = std::vector<glm::dvec3>;  // one finger's forces, tick by tick

constexpr double depth_under = 3;                // mm
constexpr int first_tick = 400, ticks = 2048;    // after the filter has settled
constexpr double least_hz = 20, tick_hz = 1000;  // the band ends at half of it
constexpr double ghost_mm = 15, moving_mm = 1;
// Rows that the ball never reaches, away from the border; a finger every 24 pixels.
constexpr int rows[] = {16, 36, 204, 224}, first_column = 28, column_step = 24, columns = 12;

Scene scene_of(const SteadinessRun& run) {
    Scene scene = noisy_scene();
    scene.interpolation = run.interpolation;
    scene.filter.temporal = run.temporal;
    scene.filter.temporal_noise = scene.filter.temporal_noise.times(run.noise_factor);
    return scene;
}

Result<std::vector<SurfaceFrame>> frames_of(const Scene& scene, const TrueDepth& truth, int count) {
    std::vector<SurfaceFrame> frames(static_cast<std::size_t>(count));
    const auto builder = make_cpu_builder(scene);
    for (int n = 0; n < count; ++n)
        if (auto built = builder->build(noisy_frame(scene, truth, n), frames[static_cast<std::size_t>(n)]);
            !built)
            return built.error();
    return frames;
}

glm::dvec3 goal_under(const Scene& scene, const glm::dvec2& pixel) {
    const double depth = ball_and_wall(pixel.x, pixel.y, 0) + depth_under;
    return {depth * (pixel.x - scene.camera.cx) / scene.camera.fx,
            -depth * (pixel.y - scene.camera.cy) / scene.camera.fy, -depth};
}

Result<std::vector<Forces>> forces_at_rest(const Scene& scene, const std::vector<SurfaceFrame>& frames) {
    const auto solver = TouchSolver::create(scene, {});
    if (!solver) return solver.error();
    std::vector<glm::dvec3> goals;
    for (const int row : rows)
        for (int column = 0; column < columns; ++column)
            goals.push_back(goal_under(scene, {first_column + column_step * column, row}));
    std::vector<FingerState> fingers(goals.size());
    std::vector<Contact> contacts(goals.size());
    std::vector<Forces> forces(goals.size());
    for (int tick = 0; tick < first_tick + ticks; ++tick) {
        const FramePair pair = frames_around(scene.rate, frames, std::int64_t{tick} * 1'000'000);
        solver->tick(HeightField(scene, pair), goals, fingers, contacts);
        for (std::size_t k = 0; tick >= first_tick && k < forces.size(); ++k)
            forces[k].push_back(contacts[k].force);
    }
    return forces;
}

void add_rest(const std::vector<Forces>& fingers, Figures& figures) {
    double power = 0, greatest_step = 0, angles = 0;
    for (const Forces& forces : fingers) {
        glm::dvec3 sum(0.0);
        std::vector<double> parts[3];
        for (std::size_t n = 0; n < forces.size(); ++n) {
            sum += forces[n];
            for (int axis = 0; axis < 3; ++axis) parts[axis].push_back(forces[n][axis]);
            if (n > 0) greatest_step = std::max(greatest_step, glm::distance(forces[n], forces[n - 1]));
        }
        for (const auto& part : parts) power += band_power(part, tick_hz, least_hz, tick_hz / 2);
        double squares = 0;
        for (const glm::dvec3& force : forces)
            squares += degrees_between(force, sum) * degrees_between(force, sum);
        angles += squares / static_cast<double>(forces.size());
    }
    const auto count = static_cast<double>(fingers.size());
    figures.push_back({"force_band_mn", 1000 * std::sqrt(power / count), "mN"});
    figures.push_back({"force_step_n_max", greatest_step, "N"});
    figures.push_back({"force_jitter_deg", std::sqrt(angles / count), "deg"});
}

/// For pixels whose true depth changes from frame to frame: mean lag of the shown surface towards its
/// previous position, and number of pixels far from the truth.
struct Movers {
    double lag = 0, ghosts = 0, count = 0;

    void look_at(const Scene& scene, const std::vector<SurfaceFrame>& frames, const TrueDepth& truth) {
        for (std::size_t n = 10; n < frames.size(); ++n) {
            const auto time = [&](std::size_t frame) {
                return static_cast<double>(scene.rate.time_ns(static_cast<std::int64_t>(frame))) * 1e-9;
            };
            for (int y = 0; y < scene.height; ++y)
                for (int x = 0; x < scene.width; ++x) {
                    const double now = truth(x, y, time(n)), moved = now - truth(x, y, time(n - 1));
                    const DepthSample shown = sample_of(frames[n], x, y);
                    if (!shown.valid || !(std::fabs(moved) > moving_mm)) continue;
                    const double off = shown.depth - now;
                    lag += moved > 0 ? -off : off;
                    ghosts += std::fabs(off) > ghost_mm;
                    ++count;
                }
        }
    }
};

/// Lag of an approaching wall 1 m away: how far behind its true position it is shown.
Result<double> approach_lag(Scene scene, double speed) {
    scene.width = 96;
    scene.height = 64;
    const auto truth = [speed](double, double, double t) { return 1000 - speed * (t - 0.5); };
    const auto frames = frames_of(scene, truth, 30);
    if (!frames) return frames.error();
    double sum = 0, count = 0;
    for (std::size_t n = 10; n < frames->size(); ++n)
        for (int y = 0; y < scene.height; ++y)
            for (int x = 0; x < scene.width; ++x) {
                const DepthSample shown = sample_of((*frames)[n], x, y);
                if (!shown.valid) continue;
                sum +=
                    shown.depth -
                    truth(0, 0, static_cast<double>(scene.rate.time_ns(static_cast<std::int64_t>(n))) * 1e-9);
                ++count;
            }
    return sum / count;
}

}  // namespace

Result<void> measure_steadiness(const SteadinessRun& run, Figures& figures) {
    const Scene scene = scene_of(run);
    const auto frames = frames_of(scene, ball_and_wall, run.frames);
    if (!frames) return frames.error();
    const auto forces = forces_at_rest(scene, *frames);
    if (!forces) return forces.error();
    add_rest(*forces, figures);
    Movers movers;
    movers.look_at(scene, *frames, ball_and_wall);
    if (!(movers.count > 0)) return Error{ErrorKind::check, run.name + ": nothing moves"};
    figures.push_back({"lag_mm", movers.lag / movers.count, "mm"});
    figures.push_back({"ghost_pct", 100 * movers.ghosts / movers.count, "%"});
    for (const int speed : {5, 10, 20, 40, 80, 160}) {
        const auto lag = approach_lag(scene, speed);
        if (!lag) return lag.error();
        figures.push_back({"lag_mm_" + std::to_string(speed), *lag, "mm"});
    }
    return {};
}

}  // namespace touchable
