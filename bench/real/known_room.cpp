#include "bench/real/known_room.hpp"

#include <algorithm>
#include <string>

#include "bench/real/built_frames.hpp"
#include "bench/real/edges.hpp"
#include "bench/real/resting.hpp"
#include "engine/formats/open_clip.hpp"

namespace touchable {
namespace {

constexpr int smooth_reach = 4;
constexpr std::size_t resting_fingers = 48;
constexpr int settled_frames = 8, resting_frames = 41;
constexpr int approach_frames = 16;
constexpr double approach_m_per_s = 0.3;
/// Largest residual of a place smooth enough to have a normal. The stills' rounding to whole millimetres
/// alone causes 0.29 mm.
constexpr double smooth_mm = 0.4;

/// Replaces depths in smooth 9x9 windows by their plane's, which removes steps of whole millimetres.
DepthMap without_steps(const DepthMap& stored) {
    DepthMap smooth = stored;
    for (const DepthPlane& plane : flat_places(stored, 1, smooth_reach, {smooth_mm, 0}))
        smooth.depths[smooth.index(plane.x, plane.y)] = 1 / plane.at;
    return smooth;
}

/// True depths of a still of the room, from 1 on.
Result<DepthMap> truth_of(const std::filesystem::path& data, int still) {
    auto reader = open_clip(data / "stills/icl_nuim5",
                            std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "tests/scenes/icl_nuim5.json");
    if (!reader) return reader.error();
    for (int n = 1;; ++n) {
        const auto raw = (*reader)->next();
        if (!raw) return raw.error();
        if (!*raw) return input_error("icl_nuim5: no still " + std::to_string(still));
        if (n == still) return without_steps(depths_of(**raw, (*reader)->scene()));
    }
}

double median_depth(const DepthMap& map) {
    std::vector<double> depths = map.depths;
    const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
    std::nth_element(depths.begin(), middle, depths.end());
    return *middle;
}

/// Mean over smooth places of shown depth less true depth.
struct MeanOff {
    double sum = 0, count = 0;

    void add(const SurfaceFrame& frame, const std::vector<DepthPlane>& smooth) {
        for (const DepthPlane& place : smooth) {
            const DepthSample shown = sample_of(frame, place.x, place.y);
            if (!shown.valid) continue;
            sum += shown.depth - 1 / place.at;
            ++count;
        }
    }
    double value() const { return sum / count; }
};

}  // namespace

std::vector<DepthPlane> KnownRoom::smooth_places(const DepthMap& truth, int step) const {
    return flat_places(truth, step, smooth_reach, {smooth_mm * factor_, 0});
}

Result<void> KnownRoom::make(bool quick) {
    Scene scene;
    for (const int still : quick ? std::vector{2, 4} : std::vector{2, 1, 3, 4, 5}) {
        auto truth = truth_of(data_, still);
        if (!truth) return truth.error();
        Room room{scaled(std::move(truth).value(), factor_), {}, {}};
        scene = scene_of(model_, room.truth.width, room.truth.height, room.truth.camera);
        room.smooth = smooth_places(room.truth, quick ? 16 : 8);
        for (int n = 0; n < (rooms_.empty() ? resting_frames : settled_frames); ++n)
            room.stored.push_back(stored_frame(model_, scene, room.truth, n));
        rooms_.push_back(std::move(room));
    }
    const std::vector<DepthPlane> places = smooth_places(rooms_[0].truth, 8);
    if (places.size() < resting_fingers) return Error{ErrorKind::check, "icl_nuim5: nothing is smooth"};
    for (std::size_t k = 0; k < resting_fingers; ++k)
        resting_places_.push_back(places[k * places.size() / resting_fingers]);
    scene_ = std::move(scene);
    return make_approach();
}

Result<void> KnownRoom::make_approach() {
    for (int n = 0; n < approach_frames; ++n) {
        const double seconds = static_cast<double>(scene_->rate.time_ns(n)) * 1e-9;
        auto truth = seen_from(rooms_[0].truth, 1000 * approach_m_per_s * seconds);
        if (!truth) return truth.error();
        approach_stored_.push_back(stored_frame(model_, *scene_, *truth, n));
        std::vector<DepthPlane> smooth = smooth_places(*truth, 8);
        approach_.push_back({std::move(truth).value(), std::move(smooth)});
    }
    return {};
}

Result<double> KnownRoom::lag(const Scene& scene, const std::vector<SurfaceFrame>& at_rest) const {
    const auto frames = built(scene, approach_stored_);
    if (!frames) return frames.error();
    MeanOff moving, still;
    for (std::size_t n = settled_frames; n < frames->size(); ++n)
        moving.add((*frames)[n], approach_[n].smooth);
    for (std::size_t n = settled_frames; n < at_rest.size(); ++n) still.add(at_rest[n], rooms_[0].smooth);
    return moving.value() - still.value();
}

Result<PressErrors> KnownRoom::pressed(const Scene& scene) const {
    PressErrors errors;
    for (const Room& room : rooms_) {
        const auto frames = built(scene, room.stored);
        if (!frames) return frames.error();
        if (auto done = errors.press(scene, frames->back(), room.smooth); !done) return done.error();
    }
    return errors;
}

Result<void> KnownRoom::search(bool quick, Figures& figures) {
    if (!scene_)
        if (auto done = make(quick); !done) return done;
    const auto chosen = pressed(chosen_filters(rooms_[0].stored, *scene_));
    if (!chosen) return chosen.error();
    const double depth = median_depth(rooms_[0].truth);
    const DepthLength least{0, model_.least_step(depth) / (depth * depth)};
    double best = 180, best_of_all = 180;
    for (const int median : {0, 3, 5})
        for (const double averaged : {0.0, 1.0, 1.5})
            for (const double level : {0.0, 0.1, 0.2, 0.3, 0.45, 0.7, 1.0, 1.2, 1.4}) {
                Scene scene = *scene_;
                scene.filter = {.median = median,
                                .terraces = level > 0 ? TerraceRemoval::on : TerraceRemoval::off,
                                .levels = least.times(level),
                                .temporal = averaged > 0,
                                .temporal_noise = model_.stated_noise.times(averaged)};
                const auto errors = pressed(scene);
                if (!errors) return errors.error();
                const double left = errors->angle_deg_rms();
                best_of_all = std::min(best_of_all, left);
                if (left >= best) continue;
                const auto keeps = keeps_edges(model_, scene.filter);
                if (!keeps) return keeps.error();
                if (*keeps) best = left;
            }
    figures.push_back({"force_angle_deg_chosen", chosen->angle_deg_rms(), "deg"});
    figures.push_back({"force_angle_deg_best", best, "deg"});
    figures.push_back({"force_angle_deg_best_of_all", best_of_all, "deg"});
    figures.push_back({"times_best", chosen->angle_deg_rms() / best, ""});
    return {};
}

Result<void> KnownRoom::measure(const FilterChoice& choice, bool quick, Figures& figures) {
    if (!scene_)
        if (auto done = make(quick); !done) return done;
    const Scene scene = choice.of(rooms_[0].stored, *scene_);
    const auto errors = pressed(scene);
    if (!errors) return errors.error();
    errors->report(figures);
    const auto at_rest = built(scene, rooms_[0].stored);
    if (!at_rest) return at_rest.error();
    if (auto done = measure_rest(scene, *at_rest, resting_places_, settled_frames, figures); !done)
        return done;
    const auto behind = lag(scene, *at_rest);
    if (!behind) return behind.error();
    figures.push_back({"lag_mm", *behind, "mm"});
    if (auto done = measure_cost(scene, rooms_[0].stored, quick ? 10 : 40, figures); !done) return done;
    const double depth = median_depth(rooms_[0].truth);
    const DepthLength& levels = scene.filter.levels;
    figures.push_back({"level_mm", levels.at(depth), "mm"});
    return {};
}

}  // namespace touchable
