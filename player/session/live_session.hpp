#pragma once

#include <optional>
#include <span>

#include "haptics_cpu/haptic_loop.hpp"
#include "player/session/camera_figures.hpp"
#include "player/session/touch_session.hpp"

namespace touchable {

/// How a live session went.
struct LiveFacts {
    LoopFacts loop;
    std::int64_t late_frames = 0;         ///< not built yet when the surface first needed them
    std::optional<CameraFacts> camera{};  ///< of a live source, which has no late frames
    bool interrupted = false;             ///< a person ended it
    std::optional<Error>
        failure;  ///< what else ended it too early: the device, or a frame that cannot be read
};

/// Touch on the wall clock: decoding, building and the haptic loop each on a thread of its own, the sinks on
/// the caller's. Which frames a tick found is part of what a recording keeps, so that the session replays
/// exactly.
class LiveSession {
public:
    /// All references outlive the session; `feed` has published its first frame. `port` is where goals come
    /// from and forces go, `hand` says how long that lasts.
    LiveSession(const Scene& scene, SurfaceFeed& feed, Hand& hand, HapticPort& port,
                const TouchSolver& solver, const TouchSessionSettings& settings);

    /// To the end, or until the person asks to stop, which is how most sessions end, or until the device or
    /// the clip fails. What was touched until then counts: an error only where no tick was run by then, or
    /// where the sinks have not got all.
    Result<void> run(std::span<TouchSink* const> sinks);
    const LiveFacts& facts() const { return facts_; }

private:
    const Scene& scene_;
    SurfaceFeed& feed_;
    Hand& hand_;
    HapticPort& port_;
    const TouchSolver& solver_;
    TouchSessionSettings settings_;
    LiveFacts facts_;
};

}  // namespace touchable
