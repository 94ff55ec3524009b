// SPDX-License-Identifier: Apache-2.0
#include "bench/real/recording.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bench/real/built_frames.hpp"
#include "bench/real/depth_forms.hpp"
#include "bench/real/other_filters.hpp"
#include "bench/real/pressing.hpp"
#include "bench/real/sensor_models.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/formats/open_clip.hpp"

namespace touchable {
namespace {

constexpr int patch_reach = 15;

std::filesystem::path scene_file(const char* name) {
    return std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "tests/scenes" / name;
}

}  // namespace

CameraRecording cube_recording(const std::filesystem::path& data) {
    // Stereo with a base of 50 mm, a focal length of 384 pixels and noise of 0.08 pixels (sensor_models.hpp).
    constexpr double quadratic = 0.08 / (50 * 384);
    return {"cube",         data / "visp_cube_realsense", scene_file("visp_cube_realsense.json"),
            {0, quadratic}, {0.58, 1.4 * quadratic},      600,
            d435(384)};
}

CameraRecording castel_recording(const std::filesystem::path& data) {
    return {
        "castel", data / "castel_sr300", scene_file("castel_sr300.json"), sr300().stated_noise, {0.6, 0}, 600,
        sr300()};
}

CameraRecording redwood_recording(const std::filesystem::path& data) {
    const SensorModel kinect = kinect_v1();
    return {"redwood",
            data / "stills/redwood5",
            scene_file("redwood5.json"),
            kinect.stated_noise,
            {0, 0.45 * kinect.disparity_step},
            2840,
            kinect};
}

Result<void> RecordingPatches::read(bool quick) {
    auto reader = open_clip(recording_.clip, recording_.scene_file);
    if (!reader) return reader.error();
    Scene scene = (*reader)->scene();
    scene.default_properties = {600, 0, 0};
    scene.filter = {};
    scene.filter.temporal_noise = recording_.noise;
    double squares = 0, depth_sum = 0, count = 0;
    for (;;) {
        auto raw = (*reader)->next();
        if (!raw) return raw.error();
        if (!*raw) break;
        const DepthMap map = depths_of(**raw, scene);
        planes_.push_back(flat_places(map, quick ? 16 : 8, patch_reach, recording_.flat));
        std::erase_if(planes_.back(),
                      [&](const DepthPlane& plane) { return 1 / plane.at > recording_.farthest_mm; });
        for (const DepthPlane& plane : planes_.back()) {
            const double error = standard_error_deg(map, plane, patch_reach);
            squares += error * error;
            depth_sum += 1 / plane.at;
            ++count;
        }
        raws_.push_back(std::move(**raw));
    }
    if (!(count > 0)) return Error{ErrorKind::check, recording_.name + ": no flat patch"};
    plane_error_deg_ = std::sqrt(squares / count);
    depth_ = depth_sum / count;
    scene_ = std::move(scene);
    return {};
}

Result<void> RecordingPatches::measure(const FilterChoice& choice, bool quick, Figures& figures) {
    if (!scene_)
        if (auto done = read(quick); !done) return done;
    const Scene scene = choice.of(raws_, *scene_);
    const auto frames = built(scene, raws_, true);
    if (!frames) return frames.error();
    PressErrors errors(trusted_to(scene.filter, measured_depth(raws_, *scene_)));
    for (std::size_t n = 0; n < frames->size(); ++n)
        if (auto done = errors.press(scene, (*frames)[n], planes_[n]); !done) return done;
    errors.report(figures);
    figures.push_back({"plane_error_deg", plane_error_deg_, "deg"});
    if (auto done = measure_cost(scene, raws_, quick ? 10 : 50, figures); !done) return done;
    figures.push_back({"depth_mm", depth_, "mm"});
    figures.push_back({"level_mm", scene.filter.levels.at(depth_), "mm"});
    return {};
}

Result<void> RecordingPatches::measure_forms(bool quick, Figures& figures) {
    if (!scene_)
        if (auto done = read(quick); !done) return done;
    double best = 180, worst = 0;
    for (const DepthForm& form : depth_forms()) {
        auto found = opened(form, *scene_, raws_);
        if (!found) return found.error();
        if (found->frames.size() != raws_.size())
            return Error{ErrorKind::check, recording_.name + ": frames are missing as " + form.name};
        found->scene.default_properties = scene_->default_properties;
        const Scene scene = chosen_filters(found->frames, found->scene);
        const auto frames = built(scene, found->frames);
        if (!frames) return frames.error();
        PressErrors errors;
        for (std::size_t n = 0; n < frames->size(); ++n)
            if (auto done = errors.press(scene, (*frames)[n], planes_[n]); !done) return done;
        const double angle = errors.angle_deg_rms();
        figures.push_back({std::string("force_angle_deg_") + form.name, angle, "deg"});
        best = std::min(best, angle);
        worst = std::max(worst, angle);
    }
    figures.push_back({"forms_apart_deg", worst - best, "deg"});
    return {};
}

Result<void> RecordingPatches::measure_details(bool quick, Figures& figures) {
    if (!scene_)
        if (auto done = read(quick); !done) return done;
    add_details(raws_, *scene_, figures);
    return {};
}

Result<double> RecordingPatches::force_angle_deg(const Filtering& filtering, std::size_t first,
                                                 std::size_t step) const {
    std::vector<RawFrame> raws;
    for (std::size_t n = first; n < raws_.size(); n += step) raws.push_back(raws_[n]);
    const auto frames = built(filtering, raws);
    if (!frames) return frames.error();
    PressErrors errors;
    for (std::size_t n = 0; n < frames->size(); ++n)
        if (auto done = errors.press(filtering.scene, (*frames)[n], planes_[first + step * n]); !done)
            return done.error();
    return errors.angle_deg_rms();
}

Result<void> RecordingPatches::compare(bool quick, Figures& figures) {
    if (!scene_)
        if (auto done = read(quick); !done) return done;
    const auto degrees = [this](const Filtering& filtering) { return force_angle_deg(filtering, 0, 1); };
    return compare_with_others(recording_.model, {*scene_, raws_, degrees, nullptr}, figures);
}

Result<void> RecordingPatches::measure_left_out(bool quick, Figures& figures) {
    if (!scene_)
        if (auto done = read(quick); !done) return done;
    double chosen_squares = 0, best_squares = 0;
    for (const std::size_t left_out : {0U, 1U}) {
        std::vector<RawFrame> seen;
        for (std::size_t n = 1 - left_out; n < raws_.size(); n += 2) seen.push_back(raws_[n]);
        const Scene chosen = chosen_filters(seen, *scene_);
        const auto angle = force_angle_deg(chosen, left_out);
        if (!angle) return angle.error();
        double best = *angle;
        const auto measured = measured_depth(seen, *scene_);
        if (!measured) return Error{ErrorKind::check, recording_.name + ": no depth"};
        for (const TriedFilters& tried : measured->tried) {
            if (tried.temporal != chosen.filter.temporal) continue;
            Scene scene = chosen;
            scene.filter.median = tried.median;
            scene.filter.terraces = tried.terraces ? TerraceRemoval::on : TerraceRemoval::off;
            scene.filter.levels = tried.levels;
            if (tried.temporal) scene.filter.temporal_noise = stated_noise(measured->noise, tried.median);
            const auto with = force_angle_deg(scene, left_out);
            if (!with) return with.error();
            best = std::min(best, *with);
        }
        chosen_squares += *angle * *angle;
        best_squares += best * best;
    }
    figures.push_back({"force_angle_deg_chosen", std::sqrt(chosen_squares / 2), "deg"});
    figures.push_back({"force_angle_deg_best", std::sqrt(best_squares / 2), "deg"});
    figures.push_back({"times_best", std::sqrt(chosen_squares / best_squares), ""});
    return {};
}

}  // namespace touchable
