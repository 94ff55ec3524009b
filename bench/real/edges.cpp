// SPDX-License-Identifier: Apache-2.0
#include "bench/real/edges.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>
#include <vector>

#include "bench/real/built_frames.hpp"
#include "engine/base/same_bits.hpp"

namespace touchable {
namespace {

constexpr int edges_width = 320, edges_height = 240, edges_frames = 16;
constexpr int first_row = 30, end_row = 210;  // rows that are evaluated
constexpr int pen_left = 80, pen_right = 85;  // columns; end exclusive
constexpr int low_pen_left = 40, low_pen_right = 45;
constexpr int bare_left = 92, bare_right = 132;  // bare wall, out of reach of filters from any object
constexpr int step_left = 140, step_right = 200;
constexpr int box_left = 235, box_right = 290, box_top = 60, box_bottom = 180;
constexpr double pen_steps = 10, low_pen_steps = 4, step_steps = 4;

/// A scene of objects whose heights are multiples of a step in 1/depth.
struct EdgesScene {
    DepthMap truth;
    double step = 0;       // 1/mm
    double middle = 1000;  // mm; distance of the wall's middle

    double wall(int x, int y) const {
        return (1 - 0.4 * truth.camera.u(x) + 0.2 * truth.camera.v(y)) / middle;
    }
    double box(int x, int y) const {
        const double depth = 1 / wall(x, y);
        return 1 / (depth - 300);
    }
    static bool in_box(int x, int y) {
        return x >= box_left && x < box_right && y >= box_top && y < box_bottom;
    }
    double inverse_depth(int x, int y) const {
        if (x >= pen_left && x < pen_right) return wall(x, y) + pen_steps * step;
        if (x >= low_pen_left && x < low_pen_right) return wall(x, y) + low_pen_steps * step;
        if (x >= step_left && x < step_right) return wall(x, y) + step_steps * step;
        return in_box(x, y) ? box(x, y) : wall(x, y);
    }
};

EdgesScene edges_scene(double step, double middle = 1000) {
    EdgesScene scene{{edges_width, edges_height, {edges_focal_length, edges_focal_length, 159.5, 119.5}, {}},
                     step,
                     middle};
    for (int y = 0; y < edges_height; ++y)
        for (int x = 0; x < edges_width; ++x) scene.truth.depths.push_back(1 / scene.inverse_depth(x, y));
    return scene;
}

/// Height of the surface above the wall in a column, in steps, mean over the rows.
double relief(const EdgesScene& edges, const SurfaceFrame& frame, int x) {
    double sum = 0, count = 0;
    for (int y = first_row; y < end_row; ++y) {
        const DepthSample shown = sample_of(frame, x, y);
        if (!shown.valid) continue;
        sum += (1 / shown.depth - edges.wall(x, y)) / edges.step;
        ++count;
    }
    return sum / count;
}

/// Height of a pen's three middle columns, per cent of the true height.
double pen_pct(const EdgesScene& edges, const SurfaceFrame& frame, int left, double steps) {
    double sum = 0;
    for (int x = left + 1; x < left + 4; ++x) sum += relief(edges, frame, x);
    return 100 * sum / 3 / steps;
}

/// Width of the step in columns, from a quarter to three quarters of its height.
double step_px(const EdgesScene& edges, const SurfaceFrame& frame) {
    const auto height = [&](int x) { return relief(edges, frame, x) / step_steps; };
    int high = step_left;
    while (high + 1 < step_right && height(high) < 0.75) ++high;
    int low = high - 1;
    while (low > pen_right && height(low) > 0.25) --low;
    const auto crossing = [&](int x, double share) {  // between columns x and x + 1
        const double here = height(x), next = height(x + 1);
        return x + std::clamp((share - here) / (next - here), 0.0, 1.0);
    };
    return crossing(high - 1, 0.75) - crossing(low, 0.25);
}

/// Pixels two to eight away from the box's silhouette that are on neither side: farther from both than three
/// levels and five times the noise.
double bleed_px(const EdgesScene& edges, const SurfaceFrame& frame, const SensorModel& model) {
    const auto near_silhouette = [](int x, int y, int reach) {
        const auto inside = EdgesScene::in_box(x, y);
        for (int dy = -reach; dy <= reach; ++dy)
            for (int dx = -reach; dx <= reach; ++dx)
                if (EdgesScene::in_box(x + dx, y + dy) != inside) return true;
        return false;
    };
    int pixels = 0;
    for (int y = box_top - 8; y < box_bottom + 8; ++y)
        for (int x = box_left - 8; x < box_right + 8; ++x) {
            if (!near_silhouette(x, y, 8) || near_silhouette(x, y, 1)) continue;
            const DepthSample shown = sample_of(frame, x, y);
            const auto is_on = [&](double q) {
                const double depth = 1 / q;
                return shown.valid &&
                       std::fabs(shown.depth - depth) <= 3 * model.level(depth) + 5 * model.sigma(depth);
            };
            pixels += !is_on(edges.wall(x, y)) && !is_on(edges.box(x, y));
        }
    return pixels;
}

/// Direction figures of the bare wall's faces.
void add_direction(const EdgesScene& edges, const SurfaceFrame& frame, Figures& figures) {
    const Camera& camera = edges.truth.camera;
    const auto point = [&](int x, int y) {
        const DepthSample shown = sample_of(frame, x, y);
        return shown.valid ? shown.depth * glm::dvec3(camera.u(x), camera.v(y), 1) : glm::dvec3(0);
    };
    const glm::dvec3 normal = glm::normalize(glm::dvec3(-0.4, 0.2, 1));
    double squares = 0, over = 0, faces = 0;
    for (int y = first_row; y < end_row; ++y)
        for (int x = bare_left; x < bare_right; ++x) {
            const glm::dvec3 here = point(x, y), right = point(x + 1, y), below = point(x, y + 1);
            if (here.z == 0 || right.z == 0 || below.z == 0) continue;
            const double cosine = glm::dot(glm::normalize(glm::cross(below - here, right - here)), normal);
            const double off = std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / pi;
            squares += off * off;
            over += off > 20;
            ++faces;
        }
    figures.push_back({"face_angle_deg_rms", std::sqrt(squares / faces), "deg"});
    figures.push_back({"over_20deg_pct", 100 * over / faces, "%"});
}

std::vector<RawFrame> stored_frames(const SensorModel& model, const EdgesScene& edges, const Scene& scene) {
    std::vector<RawFrame> raws;
    for (int n = 0; n < edges_frames; ++n) raws.push_back(stored_frame(model, scene, edges.truth, n));
    return raws;
}

Result<void> add_figures(const SensorModel& model, const EdgesScene& edges, const Scene& scene,
                         const std::string& suffix, Figures& figures) {
    const auto frames = built(scene, stored_frames(model, edges, scene));
    if (!frames) return frames.error();
    const SurfaceFrame& last = frames->back();
    figures.push_back({"pen_pct" + suffix, pen_pct(edges, last, pen_left, pen_steps), "%"});
    figures.push_back({"low_pen_pct" + suffix, pen_pct(edges, last, low_pen_left, low_pen_steps), "%"});
    figures.push_back({"step_px" + suffix, step_px(edges, last), "px"});
    figures.push_back({"bleed_px" + suffix, bleed_px(edges, last, model), "px"});
    return {};
}

}  // namespace

Result<void> measure_edges(const SensorModel& model, const FilterChoice& choice, Figures& figures) {
    const EdgesScene edges = edges_scene(model.disparity_step);
    const Scene unfiltered = scene_of(model, edges_width, edges_height, edges.truth.camera);
    for (const bool noisy : {false, true}) {
        const SensorModel seen_by = noisy ? model : without_noise(model);
        const Scene scene = choice.of(stored_frames(seen_by, edges, unfiltered), unfiltered);
        if (auto done = add_figures(seen_by, edges, scene, noisy ? "_noisy" : "", figures); !done)
            return done;
    }
    return {};
}

Result<void> measure_least_steps(const SensorModel& model, Figures& figures) {
    const EdgesScene edges = edges_scene(model.least_step(1000) / 1e6);
    const Scene unfiltered = scene_of(model, edges_width, edges_height, edges.truth.camera);
    const Scene scene = chosen_filters(stored_frames(model, edges, unfiltered), unfiltered);
    if (auto done = add_figures(without_noise(model), edges, scene, "", figures); !done) return done;
    return add_figures(model, edges, scene, "_noisy", figures);
}

Result<void> measure_low_relief(const SensorModel& model, double middle, double pen, Figures& figures) {
    const EdgesScene edges = edges_scene(pen / low_pen_steps / (middle * middle), middle);
    const Scene unfiltered = scene_of(model, edges_width, edges_height, edges.truth.camera);
    const std::vector<RawFrame> raws = stored_frames(model, edges, unfiltered);
    const Scene scene = chosen_filters(raws, unfiltered);
    const auto frames = built(scene, raws);
    if (!frames) return frames.error();
    const SurfaceFrame& last = frames->back();
    figures.push_back({"low_pen_pct", pen_pct(edges, last, low_pen_left, low_pen_steps), "%"});
    figures.push_back({"step_px", step_px(edges, last), "px"});
    add_direction(edges, last, figures);
    const double depth = 1 / edges.wall(bare_left, (first_row + end_row) / 2);
    figures.push_back(
        {"level_mm", scene.filter.terraces == TerraceRemoval::on ? scene.filter.levels.at(depth) : 0, "mm"});
    figures.push_back({"median", static_cast<double>(scene.filter.median), ""});
    return {};
}

Result<double> kept_relief_pct(const SensorModel& model, const MakeFiltering& filtering) {
    const EdgesScene edges = edges_scene(model.least_step(1000) / 1e6);
    const Scene unfiltered = scene_of(model, edges_width, edges_height, edges.truth.camera);
    const std::vector<RawFrame> raws = stored_frames(model, edges, unfiltered);
    const auto frames = built(filtering(raws, unfiltered), raws);
    if (!frames) return frames.error();
    return pen_pct(edges, frames->back(), low_pen_left, low_pen_steps);
}

Result<bool> keeps_edges(const SensorModel& model, const FilterSettings& filter) {
    const EdgesScene edges = edges_scene(model.least_step(1000) / 1e6);
    Scene scene = scene_of(model, edges_width, edges_height, edges.truth.camera);
    scene.filter = filter;
    const auto frames = built(scene, stored_frames(without_noise(model), edges, scene));
    if (!frames) return frames.error();
    const SurfaceFrame& last = frames->back();
    return pen_pct(edges, last, low_pen_left, low_pen_steps) >= least_low_pen_pct &&
           step_px(edges, last) <= most_step_px;
}

}  // namespace touchable
