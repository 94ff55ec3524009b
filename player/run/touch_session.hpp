#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "device/hand.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "player/run/playback_clock.hpp"
#include "player/run/surface_feed.hpp"

namespace touchable {

/// Somebody who wants to know of every tick: figures, a file of forces, a recording, a comparison.
class TouchSink {
public:
    virtual ~TouchSink() = default;
    virtual Result<void> take(const TouchTick& tick) = 0;
};

inline constexpr std::int64_t tick_ns = 1'000'000;
/// A run without a length of its own lasts at least this long; a clip that has ended stands still.
inline constexpr std::int64_t shortest_run_ns = 3'000'000'000;

/// How a live run goes, while it does.
struct LiveStatus {
    bool is_camera = false;
    std::int64_t frames = 0;  ///< of a clip: that came late; of a camera: that fingers felt
    bool has_ended = false;   ///< no more frames come
};

/// Everything about a run but the clip and the hand.
struct TouchSessionSettings {
    int fingers = 1;
    TouchSettings touch;
    GuardSettings guard;
    /// Nothing: as long as the hand's motion, or where that has no end as the clip, but 3 s at least.
    std::optional<std::int64_t> ticks;
    /// What was asked of the clip's clock (PlaybackClock), at which ticks.
    std::vector<PlaybackCommand> playback;
    /// Of a live run that nobody gives commands: called every few milliseconds, by the thread that gives
    /// ticks to the sinks. Nothing: nobody looks.
    std::function<void(const LiveStatus&)> on_status;
    /// Of a live run: whether its hand has nothing more to tell, which ends it; nothing: it never has.
    std::function<bool()> hand_is_over;
    /// Time of a tick; k ms by default. Must not go backward.
    std::function<std::int64_t(std::int64_t)> time_of_tick;
    /// Whether the hand had been left alone before a tick (TouchStep::come_back); never by default.
    std::function<bool(std::int64_t)> is_after_gap;
    /// Frames of a tick; those around its moment on the clip's clock by default.
    std::function<Result<FramePair>(std::int64_t)> pair_of_tick;
};

/// Offline touch: hand -> solver -> guard at 1 kHz of virtual time over a clip. When the clip has ended its
/// last surface stands still. The same inputs give the same forces, however fast or slow the machine is.
class TouchSession {
public:
    /// All references outlive the session.
    TouchSession(const Scene& scene, SurfaceFeed& feed, Hand& hand, const TouchSolver& solver,
                 const TouchSessionSettings& settings);

    /// To the end, or until the person asks to stop (an error then).
    Result<void> run(std::span<TouchSink* const> sinks);

private:
    bool is_over(std::int64_t tick);
    MediaMoment moment_of(std::int64_t tick);
    Result<void> tick(std::int64_t tick, std::span<TouchSink* const> sinks);

    const Scene& scene_;
    SurfaceFeed& feed_;
    Hand& hand_;
    TouchSessionSettings settings_;
    PlaybackClock clock_;
    TouchStep step_;
};

}  // namespace touchable
