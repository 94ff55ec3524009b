// SPDX-License-Identifier: Apache-2.0
#include "bench/real/known_room.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <string>

#include "bench/real/built_frames.hpp"
#include "bench/real/edges.hpp"
#include "bench/real/other_filters.hpp"
#include "bench/real/resting.hpp"
#include "engine/formats/open_clip.hpp"

namespace touchable {
namespace {

constexpr int smooth_reach = 4;
constexpr std::size_t resting_fingers = 48;
constexpr int settled_frames = 8, resting_frames = 41;
constexpr int approach_frames = 16, barred_frames = 24;
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

DepthMap every(int apart, const DepthMap& map) {
    if (apart == 1) return map;
    const Camera& camera = map.camera;
    DepthMap some{map.width / apart,
                  map.height / apart,
                  {camera.fx / apart, camera.fy / apart, camera.cx / apart, camera.cy / apart},
                  {}};
    for (int y = 0; y < some.height; ++y)
        for (int x = 0; x < some.width; ++x) some.depths.push_back(map.at(apart * x, apart * y));
    return some;
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
    if (auto done = make_rooms(quick, resting_frames, settled_frames); !done) return done;
    const std::vector<DepthPlane> places = smooth_places(rooms_[0].truth, 8);
    if (places.size() < resting_fingers) return Error{ErrorKind::check, "icl_nuim5: nothing is smooth"};
    for (std::size_t k = 0; k < resting_fingers; ++k)
        resting_places_.push_back(places[k * places.size() / resting_fingers]);
    return make_approach();
}

Result<void> KnownRoom::make_rooms(bool quick, int frames_of_first, int frames_of_others) {
    Scene scene;
    for (const int still : quick ? std::vector{2, 4} : std::vector{2, 1, 3, 4, 5}) {
        auto truth = truth_of(data_, still);
        if (!truth) return truth.error();
        Room room{every(model_.every_px, scaled(std::move(truth).value(), factor_)), {}, {}};
        scene = scene_of(model_, room.truth.width, room.truth.height, room.truth.camera);
        room.smooth = smooth_places(room.truth, quick ? 16 : 8);
        for (int n = 0; n < (rooms_.empty() ? frames_of_first : frames_of_others); ++n)
            room.stored.push_back(stored_frame(model_, scene, room.truth, n));
        rooms_.push_back(std::move(room));
    }
    scene_ = std::move(scene);
    return {};
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

Result<double> KnownRoom::lag(const Filtering& filtering, const std::vector<SurfaceFrame>& at_rest) const {
    const auto frames = built(filtering, approach_stored_);
    if (!frames) return frames.error();
    MeanOff moving, still;
    for (std::size_t n = settled_frames; n < frames->size(); ++n)
        moving.add((*frames)[n], approach_[n].smooth);
    for (std::size_t n = settled_frames; n < at_rest.size(); ++n) still.add(at_rest[n], rooms_[0].smooth);
    return moving.value() - still.value();
}

Result<PressErrors> KnownRoom::pressed(const Filtering& filtering, double trusted_to) const {
    PressErrors errors(trusted_to);
    for (const Room& room : rooms_) {
        const auto frames = built(filtering, room.stored);
        if (!frames) return frames.error();
        if (auto done = errors.press(filtering.scene, frames->back(), room.smooth); !done)
            return done.error();
    }
    return errors;
}

/// A picture's depth with each hole filled by the pixel to its left, or above: as in-painted data sets are.
RawFrame KnownRoom::filled(const RawFrame& raw) const {
    auto codes = std::make_shared<std::vector<std::uint16_t>>();
    const int width = scene_->width;
    for (int y = 0; y < scene_->height; ++y)
        for (int x = 0; x < width; ++x) {
            const std::uint16_t code = stored_code(raw.depth, scene_->depth, x, y);
            if (scene_->depth.is_valid(code) || codes->empty())
                codes->push_back(code);
            else
                codes->push_back(x > 0 || y == 0 ? codes->back() : *(codes->end() - width));
        }
    RawFrame whole;
    whole.depth = plane_of_codes(codes->data(), width, scene_->height);
    whole.storage = std::move(codes);
    return whole;
}

Result<double> KnownRoom::best_by_hand(const Scene& scene, std::span<const double> averaging,
                                       std::span<const double> levels, const Press& press,
                                       double* best_of_all) const {
    const double depth = median_depth(rooms_[0].truth);
    const DepthLength least{0, model_.least_step(depth) / (depth * depth)};
    double best = 180;
    for (const int median : {0, 3, 5})
        for (const double averaged : averaging)
            for (const double level : levels) {
                Scene by_hand = scene;
                by_hand.filter = {.median = median,
                                  .terraces = level > 0 ? TerraceRemoval::on : TerraceRemoval::off,
                                  .levels = least.times(level),
                                  .temporal = averaged > 0,
                                  .temporal_noise = model_.stated_noise.times(averaged)};
                const auto left = press(by_hand);
                if (!left) return left.error();
                *best_of_all = std::min(*best_of_all, *left);
                if (*left >= best) continue;
                const auto keeps = keeps_edges(model_, by_hand.filter);
                if (!keeps) return keeps.error();
                if (*keeps) best = *left;
            }
    return best;
}

Result<void> KnownRoom::search(bool quick, Figures& figures) {
    if (!scene_)
        if (auto done = make(quick); !done) return done;
    const Press press = [&](const Scene& scene) -> Result<double> {
        const auto errors = pressed(scene);
        if (!errors) return errors.error();
        return errors->angle_deg_rms();
    };
    const auto chosen = press(chosen_filters(rooms_[0].stored, *scene_));
    if (!chosen) return chosen.error();
    double best_of_all = 180;
    const auto best =
        best_by_hand(*scene_, std::array{0.0, 1.0, 1.5},
                     std::array{0.0, 0.1, 0.2, 0.3, 0.45, 0.7, 1.0, 1.2, 1.4}, press, &best_of_all);
    if (!best) return best.error();
    figures.push_back({"force_angle_deg_chosen", *chosen, "deg"});
    figures.push_back({"force_angle_deg_best", *best, "deg"});
    figures.push_back({"force_angle_deg_best_of_all", best_of_all, "deg"});
    figures.push_back({"times_best", *chosen / *best, ""});
    return {};
}

Result<KnownRoom::Searched> KnownRoom::search_quickly() {
    if (!scene_)
        if (auto done = make_rooms(true, settled_frames, settled_frames); !done) return done.error();
    constexpr std::array levels{0.0, 0.2, 0.45, 0.7, 1.0, 1.4};
    const Press film = [&](const Scene& scene) -> Result<double> {
        const auto errors = pressed(scene);
        if (!errors) return errors.error();
        return errors->angle_deg_rms();
    };
    Scene off = *scene_;
    off.filter = {};
    Searched found;
    const auto add = [&](const Scene& chosen, std::span<const double> averaging, const Press& press,
                         Judged& judged) -> Result<void> {
        const auto with = press(chosen), without = press(off);
        if (!with || !without) return with ? without.error() : with.error();
        double best_of_all = 180;
        const auto best = best_by_hand(*scene_, averaging, levels, press, &best_of_all);
        if (!best) return best.error();
        judged = {*with, *without, *best};
        return {};
    };
    const Room& room = rooms_[0];
    const auto measured = measured_depth(room.stored, *scene_);
    if (auto done = add(chosen_filters(measured, *scene_), std::array{0.0, 1.5}, film, found.film); !done)
        return done.error();
    if (measured) found.details = frontier(measured->tried, measured->is_noisy(scene_->width)).size();
    const std::vector<RawFrame> still{filled(room.stored[0])};
    const Press press_still = [&](const Scene& scene) -> Result<double> {
        const auto frames = built(scene, still);
        if (!frames) return frames.error();
        PressErrors errors;
        if (auto done = errors.press(scene, frames->back(), room.smooth); !done) return done.error();
        return errors.angle_deg_rms();
    };
    if (auto done = add(chosen_filters(still, *scene_), std::array{0.0}, press_still, found.still); !done)
        return done.error();
    return found;
}

Result<std::vector<BarPlace>> KnownRoom::press_with_bars(bool still, bool quick) {
    if (!scene_)
        if (auto done = make_rooms(quick, barred_frames, barred_frames); !done) return done.error();
    PressErrors errors;
    for (const Room& room : rooms_) {
        std::vector<RawFrame> stored = room.stored;
        if (still) stored.resize(1);
        const Scene scene = chosen_filters(stored, *scene_);
        const auto frames = built(scene, stored, true);
        if (!frames) return frames.error();
        const std::size_t first = still ? 0 : 2 * settled_frames, every = still ? 3 : barred_frames;
        for (std::size_t n = first; n < frames->size(); ++n) {
            std::vector<DepthPlane> some;
            for (std::size_t k = n % every; k < room.smooth.size(); k += every)
                some.push_back(room.smooth[k]);
            if (auto done = errors.press(scene, (*frames)[n], some); !done) return done.error();
        }
    }
    return errors.places();
}

Result<double> KnownRoom::choose_again() {
    if (!scene_)
        if (auto done = make_rooms(true, settled_frames, settled_frames); !done) return done.error();
    constexpr int seeds = 5, far_later = 1000;
    const Room& room = rooms_[0];
    std::vector<Scene> chosen{chosen_filters(room.stored, *scene_)};
    for (int seed = 1; seed <= seeds; ++seed) {
        std::vector<RawFrame> others;
        for (int n = 0; n < settled_frames; ++n)
            others.push_back(stored_frame(model_, *scene_, room.truth, far_later * seed + n));
        chosen.push_back(chosen_filters(others, *scene_));
    }
    std::vector<RawFrame> shorter = room.stored, smaller = room.stored;
    shorter.resize(settled_frames / 2);
    chosen.push_back(chosen_filters(shorter, *scene_));
    Scene part = *scene_;
    part.width /= 2;
    part.height /= 2;
    for (RawFrame& raw : smaller) {
        raw.depth.width = part.width;
        raw.depth.height = part.height;
    }
    chosen.push_back(chosen_filters(smaller, part));
    chosen.push_back(chosen_filters(rooms_[1].stored, *scene_));
    double first = 0, most = 1;
    for (const Scene& choice : chosen) {
        Scene scene = *scene_;
        scene.filter = choice.filter;
        const auto frames = built(scene, room.stored);
        if (!frames) return frames.error();
        PressErrors errors;
        if (auto done = errors.press(scene, frames->back(), room.smooth); !done) return done.error();
        if (first == 0) first = errors.angle_deg_rms();
        most = std::max(most, errors.angle_deg_rms() / first);
    }
    return most;
}

Result<PressErrors> KnownRoom::press_chosen() {
    if (!scene_)
        if (auto done = make_rooms(true, settled_frames, settled_frames); !done) return done.error();
    const auto measured = measured_depth(rooms_[0].stored, *scene_);
    const Scene chosen = chosen_filters(measured, *scene_);
    return pressed(chosen, trusted_to(chosen.filter, measured));
}

Result<void> KnownRoom::measure_details(Figures& figures) {
    if (!scene_)
        if (auto done = make_rooms(true, settled_frames, settled_frames); !done) return done;
    add_details(rooms_[0].stored, *scene_, figures);
    return {};
}

Result<void> KnownRoom::compare(bool quick, Figures& figures) {
    if (!scene_)
        if (auto done = make(quick); !done) return done;
    const auto degrees = [this](const Filtering& filtering) -> Result<double> {
        const auto errors = pressed(filtering);
        if (!errors) return errors.error();
        return errors->angle_deg_rms();
    };
    const auto lag_mm = [this](const Filtering& filtering) -> Result<double> {
        const auto at_rest = built(filtering, rooms_[0].stored);
        if (!at_rest) return at_rest.error();
        return lag(filtering, *at_rest);
    };
    return compare_with_others(model_, {*scene_, rooms_[0].stored, degrees, lag_mm}, figures);
}

Result<void> KnownRoom::measure(const FilterChoice& choice, bool quick, Figures& figures) {
    if (!scene_)
        if (auto done = make(quick); !done) return done;
    const Scene scene = choice.of(rooms_[0].stored, *scene_);
    const auto errors = pressed(scene, trusted_to(scene.filter, measured_depth(rooms_[0].stored, *scene_)));
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
