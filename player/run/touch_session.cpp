// SPDX-License-Identifier: Apache-2.0
#include "player/run/touch_session.hpp"

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

// Quantiles of a clip's depths that count as nearest and deepest; depths beyond may be noise.
constexpr double nearest_share = 0.02, deepest_share = 0.98;
constexpr double clearance = 0.02;  // device metres

/// Fits the picture between the nearest and the deepest depths that count, plus a fifth of their range in
/// front.
Workspace fitted(const Scene& scene, std::vector<double>& depths, double median, const glm::dvec3& reach) {
    const double near = quantile(depths, nearest_share), far = quantile(depths, deepest_share);
    const double wide = scene.width / scene.camera.fx * median,
                 high = scene.height / scene.camera.fy * median;
    const double least_room = 0.05 * wide, room = std::max(0.2 * (far - near), least_room);
    const double deep = far - near + 2 * room;
    const double scale = std::min({2 * reach.x / wide, 2 * reach.y / high, 2 * reach.z / deep});
    return {scale, {0, 0, -(near + far) / 2}};
}

class HandPort final : public HapticPort {
public:
    explicit HandPort(Hand& hand) : hand_(hand) {}
    bool read_goals(std::int64_t tick, const HeightField& field, std::span<glm::dvec3> goals) override {
        hand_.goals_at(tick, FieldProbe(field), goals);
        return true;
    }
    bool hops(std::size_t finger) const override { return hand_.hops(finger); }
    bool write_forces(std::span<const glm::dvec3>) override { return true; }

private:
    Hand& hand_;
};

class DevicePort : public HapticPort {
public:
    DevicePort(HapticDevice& device, const Workspace& workspace) : workspace_(workspace), device_(device) {}
    bool read_goals(std::int64_t, const HeightField& field, std::span<glm::dvec3> goals) override {
        if (!device_.read_positions(goals)) return false;
        for (glm::dvec3& goal : goals) goal = workspace_.to_scene(goal);
        device_.keep_clear(field, workspace_, goals);
        return true;
    }
    bool write_forces(std::span<const glm::dvec3> newtons) override { return device_.write_forces(newtons); }

protected:
    const Workspace workspace_;

private:
    HapticDevice& device_;
};

class SimulatedPort final : public DevicePort {
public:
    SimulatedPort(Hand& hand, SimulatedDevice& device, const Workspace& workspace)
        : DevicePort(device, workspace), hand_(hand), device_(device) {}
    bool read_goals(std::int64_t tick, const HeightField& field, std::span<glm::dvec3> goals) override {
        hand_.goals_at(tick, FieldProbe(field), goals);
        const bool first = ticks_passed_ < 0;
        for (std::size_t finger = 0; finger < goals.size(); ++finger) {
            const glm::dvec3 meant = workspace_.to_device(goals[finger]);
            if (first)
                device_.put(static_cast<int>(finger), meant);
            else
                device_.intend(static_cast<int>(finger), meant);
        }
        if (first) ticks_passed_ = tick;
        for (; ticks_passed_ < tick; ++ticks_passed_) device_.pass_tick();
        return DevicePort::read_goals(tick, field, goals);
    }
    bool hops(std::size_t finger) const override { return hand_.hops(finger); }

private:
    Hand& hand_;
    SimulatedDevice& device_;
    std::int64_t ticks_passed_ = -1;
};

}  // namespace

Workspace clip_workspace(const Scene& scene, const SurfaceFrame& first) {
    std::vector<double> depths = valid_depths(scene, first);
    return default_workspace(scene, quantile(depths, 0.5));
}

Workspace held_workspace(const Scene& scene, const SurfaceFrame& first, const glm::dvec3& reach) {
    std::vector<double> depths = valid_depths(scene, first);
    const double median = quantile(depths, 0.5);
    const bool has_reach = reach.x > 0 && reach.y > 0 && reach.z > 0;
    Workspace workspace = has_reach ? fitted(scene, depths, median, reach)
                                    : default_workspace(scene.width, scene.camera.fx, median);
    workspace.metres_per_scene_unit = scene.device_metres_per_unit.value_or(workspace.metres_per_scene_unit);
    if (!has_reach)
        workspace.origin.z = clearance / workspace.metres_per_scene_unit - quantile(depths, nearest_share);
    return workspace;
}

std::optional<double> FieldProbe::depth_under(double x, double y) const {
    const double right = field_.width() - 1, bottom = field_.height() - 1;
    if (!(x >= 0 && y >= 0 && x <= right && y <= bottom)) return std::nullopt;
    const Place at = face_under(x, y);
    // At the picture's last column and row the place is on its cell's near edge; no cell lies beyond.
    for (const int di : {0, 1})
        for (const int dj : {0, 1}) {
            if ((di == 1 && at.a == 0) || (dj == 1 && at.b == 0)) continue;
            if (!field_.vertex(at.i + di, at.j + dj).valid) return std::nullopt;
        }
    return surface_depth(field_, at);
}

glm::dvec3 FieldProbe::project(const glm::dvec3& point) const {
    const auto image = touchable::project(field_.scene().camera, point);
    return image ? glm::dvec3{image->x, image->y, image->planar_depth} : glm::dvec3(0.0);
}

TouchSession::TouchSession(SurfaceFeed& feed, Hand& hand, const TouchSolver& solver,
                           const TouchSessionSettings& settings)
    : feed_(feed),
      hand_(hand),
      settings_(settings),
      run_(feed.queue(), std::make_shared<PlaybackLog>(settings.playback), solver, settings.guard,
           settings.fingers) {}

bool TouchSession::is_over(std::int64_t tick) {
    const auto ticks = settings_.ticks ? settings_.ticks : hand_.ticks();
    if (ticks) return tick >= *ticks;
    const auto& playback = settings_.playback;
    if (!playback.empty() && tick < playback.back().tick) return false;
    const MediaMoment moment = run_.moment_at(tick), end = feed_.end();
    return feed_.ended() && moment.epoch == end.epoch && moment.time_ns >= end.time_ns &&
           tick * tick_ns >= shortest_run_ns;
}

Result<void> TouchSession::run(std::span<TouchSink* const> sinks) {
    feed_.work_ahead();
    for (std::int64_t tick = 0; !is_over(tick); ++tick) {
        if (stop_requested()) return interrupted_error();
        TRY(this->tick(tick, sinks));
    }
    return {};
}

Result<void> TouchSession::tick(std::int64_t tick, std::span<TouchSink* const> sinks) {
    TouchSessionSettings::GivenTick given{tick * tick_ns};
    if (settings_.given_tick) TRY(assign(given, settings_.given_tick(tick)));
    if (!given.pair) TRY(assign(given.pair, feed_.pair_at(run_.moment_at(given.time_ns / tick_ns))));
    // A clip of unknown length may turn out to have ended before this tick.
    if (is_over(tick)) return {};
    run_.meet(given.time_ns / tick_ns, given.time_ns, *given.pair, given.after_gap);
    hand_.goals_at(tick, FieldProbe(run_.field()), run_.goals());
    for (std::size_t k = 0; k < run_.hops().size(); ++k) run_.hops()[k] = hand_.hops(k);
    const TouchTick done = run_.solve();
    for (TouchSink* sink : sinks) TRY(sink->consume(done));
    return {};
}

std::string silence_in_words(std::int64_t silent_ns, std::int64_t stale_after_ns, const ClipReader& source) {
    const std::string again = source.stream_figures().value_or(StreamFigures()).reconnects,
                      why = again.empty() ? "" : "the stream has ended: " + again;
    if (stale_after_ns <= 0 || silent_ns <= stale_after_ns) return why;
    return formatted("no frame for %.1f s: the surface goes soft", 1e-9 * static_cast<double>(silent_ns)) +
           (why.empty() ? "" : "; " + why);
}

std::unique_ptr<HapticPort> make_port(Hand& hand) {
    return std::make_unique<HandPort>(hand);
}

std::unique_ptr<HapticPort> make_port(HapticDevice& device, const Workspace& workspace) {
    return std::make_unique<DevicePort>(device, workspace);
}

std::unique_ptr<HapticPort> make_port(Hand& hand, SimulatedDevice& device, const Workspace& workspace) {
    return std::make_unique<SimulatedPort>(hand, device, workspace);
}

}  // namespace touchable
