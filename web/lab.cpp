// SPDX-License-Identifier: Apache-2.0
// The lab hour of the page (lab.html): the experiments of `touchable-bench paper`, by its own code, in the
// worker of a browser.
//
// `lab_clip` makes a clip from a seed; `lab_sweep` and `lab_scratch` touch it, and `lab_surface` measures it.
// A function that fails returns 0, and `lab_text` says why; otherwise `lab_text` has its figures, one a line:
// name, tabulator, value. Nothing is timed. Figures and force hashes are the same bits as natively.

#include <cmath>
#include <glm/geometric.hpp>
#include <memory>
#include <string>

#include "bench/paper/scratch_run.hpp"
#include "bench/paper/sweep_run.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "haptics_cpu/height_field.hpp"

#define EXPORTED(name) __attribute__((export_name(#name)))

namespace touchable {
namespace {

std::shared_ptr<const PaperClip> lab_content;
Figures lab_figures;
std::string lab_said;

int answered(const Result<void>& result) {
    lab_said.clear();
    for (const Figure& figure : std::exchange(lab_figures, {}))
        lab_said +=
            figure.metric + "\t" + (figure.name ? *figure.name : formatted("%.17g", figure.value)) + "\n";
    if (!result) lab_said = result.error().message;
    return result ? 1 : 0;
}

Result<void> make_clip(int content, double noise_levels, int frames, int seed) {
    lab_content.reset();  // before the next one, for its memory
    if (content == 0) return assign(lab_content, make_globe_clip());
    lab_content = make_chest_clip(noise_levels, frames, seed);
    return {};
}

/// Normal of the face at a pixel, of the depths of three neighbours; towards the camera.
glm::dvec3 normal_at(const Camera& camera, int x, int y, auto&& planar) {
    const auto point = [&](int px, int py) { return unproject(camera, px, py, planar(px, py)); };
    const glm::dvec3 at = point(x, y);
    return glm::normalize(glm::cross(point(x, y + 1) - at, point(x + 1, y) - at));
}

/// What a filter leaves of the noise, where hands scratch: errors of the last frame's depth and normals
/// against the true surface, RMS. With `temporal` the frames before are averaged into it.
Result<void> measure_surface(const PaperFilter& filter) {
    constexpr int half_side = 40;  // pixels: 2 cm of the hand's path to each side
    TRY_ASSIGN(const auto played, PlayedClip::make(lab_content, filter));
    const Scene& scene = played->scene();
    const Camera& camera = scene.camera;
    const std::int64_t last = static_cast<std::int64_t>(lab_content->frames.size()) - 1;
    const HeightField field(scene, played->pair_at(scene.rate.time_ns(last)));
    const auto planar_of = [&](int x, int y, double depth) {
        return planar_depth(camera, scene.depth.semantics, x, y, depth);
    };
    const auto seen = [&](int x, int y) { return planar_of(x, y, field.vertex(x, y).depth); };
    const auto truth = [&](int x, int y) { return planar_of(x, y, lab_content->depth(x, y)); };
    double depths = 0, angles = 0, count = 0;
    const int middle_x = scene.width / 2, middle_y = scene.height / 2;
    for (int y = middle_y - half_side; y < middle_y + half_side; ++y)
        for (int x = middle_x - half_side; x < middle_x + half_side; ++x, ++count) {
            const double off = seen(x, y) - truth(x, y);
            const glm::dvec3 n = normal_at(camera, x, y, seen), t = normal_at(camera, x, y, truth);
            const double angle = std::atan2(glm::length(glm::cross(n, t)), glm::dot(n, t));
            depths += off * off;
            angles += angle * angle;
        }
    constexpr double degrees = 180 / pi;
    lab_figures.push_back({"depth_mm_rms", 1000 * scene.metres_per_unit * std::sqrt(depths / count), "mm"});
    lab_figures.push_back({"normal_deg_rms", degrees * std::sqrt(angles / count), "deg"});
    return {};
}

TouchCase setup_of(int is_world) {
    return {.metric = is_world != 0 ? TouchMetric::world : TouchMetric::pixel};
}
PaperFilter filter_of(int median, int terraces, int temporal, int lazy) {
    return {median, terraces != 0, temporal != 0, lazy != 0};
}

}  // namespace

/// `content`: 0 the globe (noise and frames are its own), 1 the chest, whose first frame has noise `seed`.
EXPORTED(lab_clip) int lab_clip(int content, double noise_levels, int frames, int seed) {
    return answered(make_clip(content, noise_levels, frames, seed));
}
/// Table I: hand `path` of fast_hands, `speed` times as fast.
EXPORTED(lab_sweep)
int lab_sweep(int is_world, int median, int terraces, int lazy, int path, double speed, int seconds) {
    SweepRun run{setup_of(is_world), filter_of(median, terraces, 0, lazy), fast_hands[path], seconds};
    run.path.hz_x *= speed;
    run.path.hz_y *= speed;
    run.path.turn_hz *= speed;
    return answered(count_primitives(lab_content, run, lab_figures));
}
/// Fig. 19: hand `hand` of scratch_hands, which presses with `newtons`.
EXPORTED(lab_scratch)
int lab_scratch(int is_world, int median, int terraces, int temporal, int hand, double newtons) {
    ScratchRun run{setup_of(is_world), filter_of(median, terraces, temporal, 0), scratch_hands[hand]};
    run.hand.press_n = newtons;
    return answered(measure_scratch(lab_content, run, lab_figures));
}
EXPORTED(lab_surface) int lab_surface(int median, int terraces, int temporal) {
    return answered(measure_surface(filter_of(median, terraces, temporal, 0)));
}
EXPORTED(lab_text) const char* lab_text() {
    return lab_said.c_str();
}

}  // namespace touchable
