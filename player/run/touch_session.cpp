#include "player/run/touch_session.hpp"

#include "engine/base/stop_request.hpp"
#include "engine/base/try.hpp"
#include "player/run/field_probe.hpp"

namespace touchable {

TouchSession::TouchSession(const Scene& scene, SurfaceFeed& feed, Hand& hand, const TouchSolver& solver,
                           const TouchSessionSettings& settings)
    : scene_(scene),
      feed_(feed),
      hand_(hand),
      settings_(settings),
      clock_(scene.rate, settings.playback),
      step_(solver, settings.guard, settings.fingers) {
    if (!settings_.time_of_tick) settings_.time_of_tick = [](std::int64_t tick) { return tick * tick_ns; };
}

MediaMoment TouchSession::moment_of(std::int64_t tick) {
    return clock_.at(settings_.time_of_tick(tick) / tick_ns);
}

bool TouchSession::is_over(std::int64_t tick) {
    const auto ticks = settings_.ticks ? settings_.ticks : hand_.ticks();
    if (ticks) return tick >= *ticks;
    const auto& playback = settings_.playback;
    const std::int64_t time_ns = settings_.time_of_tick(tick);
    if (!playback.empty() && time_ns / tick_ns < playback.back().tick) return false;
    const MediaMoment moment = moment_of(tick), end = feed_.end();
    return feed_.ended() && moment.epoch == end.epoch && moment.time_ns >= end.time_ns &&
           time_ns >= shortest_run_ns;
}

Result<void> TouchSession::run(std::span<TouchSink* const> sinks) {
    for (std::int64_t tick = 0; !is_over(tick); ++tick) {
        if (stop_requested()) return interrupted_error();
        if (auto done = this->tick(tick, sinks); !done.ok()) return done;
    }
    return {};
}

Result<void> TouchSession::tick(std::int64_t tick, std::span<TouchSink* const> sinks) {
    const std::int64_t time_ns = settings_.time_of_tick(tick);
    TRY_ASSIGN(const auto pair,
               settings_.pair_of_tick ? settings_.pair_of_tick(tick) : feed_.pair_at(moment_of(tick)));
    // A clip whose length only reading tells may turn out to have ended before this tick.
    if (is_over(tick)) return {};
    const HeightField field(scene_, pair);
    hand_.goals_at(tick, FieldProbe(field), step_.goals());
    if (settings_.is_after_gap && settings_.is_after_gap(tick)) step_.come_back();
    const TouchTick done = step_.run(time_ns / tick_ns, time_ns, scene_, pair);
    for (TouchSink* sink : sinks)
        if (auto taken = sink->take(done); !taken.ok()) return taken;
    return {};
}

}  // namespace touchable
