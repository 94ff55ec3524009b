#pragma once

// The same run in real time: decoding, building, a tick every millisecond, and what is written, each on a
// thread of its own (docs/mechanisms.md, Threads).
//
// A LiveSession is begun with what a TouchSession has; the haptic thread waits for none of the others, and
// hands its ticks to the thread that calls `run`, which gives them to the sinks. Its figures say what was
// late, left out or missing.
//
// One thread makes a session and calls `run`; `stop` and the figures are any thread's; one other thread gives
// commands to the clip's clock.

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>

#include "engine/clip/clip.hpp"
#include "haptics_cpu/haptic_loop.hpp"
#include "player/run/playback.hpp"
#include "player/run/surface_feed.hpp"
#include "player/run/touch_session.hpp"

namespace touchable {

/// What became of a camera's frames in a live run.
struct CameraFacts {
    std::int64_t frames_shown = 0;  ///< that fingers felt
    Spread exposure_to_force_ms;    ///< from taking a frame to the first force that it made
};

/// Finds that out tick by tick.
class CameraFigures final : public TouchSink {
public:
    /// `source` outlives it. `first`: of the frames that the run waits for; those before it were there when
    /// it began.
    CameraFigures(const ClipReader& source, std::int64_t first) : source_(source), newest_(first - 1) {}
    Result<void> take(const TouchTick& tick) override;
    std::int64_t frames_shown() const { return shown_; }
    CameraFacts facts() const;

private:
    const ClipReader& source_;
    std::int64_t newest_;  // that was felt
    std::int64_t shown_ = 0;
    TimeSpread latency_ms_;
};

class FeedThreads;

/// How a live session went.
struct LiveFacts {
    LoopFacts loop;
    std::int64_t late_frames = 0;         ///< not built yet when the surface first needed them
    std::optional<CameraFacts> camera{};  ///< of a live source, which has no late frames
    bool interrupted = false;             ///< a person ended it
    bool sinks_fell_behind = false;       ///< ticks were lost, and that is why `run` failed
    std::optional<Error>
        failure;  ///< what else ended it too early: the device, or a frame that cannot be read
};

/// Of a live run whose ticks did not wait for what is written of it (`files`), or, where that is empty, for
/// the program.
Error fell_behind_error(const std::string& files, std::int64_t ticks_missing);

/// Touch on the wall clock: decoding, building and the haptic loop each on a thread of its own, the sinks on
/// the caller's. Which frames a tick found is part of what a recording keeps, so that the session replays
/// exactly.
class LiveSession {
public:
    /// All references outlive the session; `feed` has published its first frame. `port` is where goals come
    /// from and forces go. It lasts `settings.ticks`, otherwise as long as the clip, 3 s at least.
    LiveSession(const Scene& scene, SurfaceFeed& feed, HapticPort& port, const TouchSolver& solver,
                const TouchSessionSettings& settings);
    /// Likewise, by a log of commands in place of the settings' own. One that is open, because somebody is
    /// there to give commands, makes a session without an end of its own.
    LiveSession(const Scene& scene, SurfaceFeed& feed, HapticPort& port, const TouchSolver& solver,
                const TouchSessionSettings& settings, std::shared_ptr<PlaybackLog> log);

    /// To the end, or until the person asks to stop, which is how most sessions end, or until the device or
    /// the clip fails; where the log is open, the hand outlasts the clip. What was touched until then counts:
    /// an error only where no tick was run by then, or where ticks were lost. What a sink refuses ends it
    /// too.
    Result<void> run(std::span<TouchSink* const> sinks);

    // While it runs, any thread.
    /// The hand is unpowered after the tick in progress, whatever a sink is at; then `run` returns as soon as
    /// that is done.
    void stop();
    /// What the clip's clock is doing, as of the newest tick.
    PlaybackState playback() const { return board_.read(); }
    std::int64_t late_frames() const { return late_frames_.load(std::memory_order_relaxed); }
    /// End of the clip's last frame, once it has been met; 0 before.
    std::int64_t clip_end_ns() const { return clip_end_ns_.load(std::memory_order_relaxed); }
    /// Why its clip goes no further, where somebody watches: the last surface stands still, and is touched.
    std::optional<Error> clip_failure() const {
        const std::lock_guard lock(failure_mutex_);
        return clip_failure_;
    }

    /// After `run`.
    const LiveFacts& facts() const { return facts_; }

private:
    bool is_over(const HapticLoop& loop, const std::optional<MediaMoment>& end) const;
    bool outlasts(const FeedThreads& threads);
    void set_loop(HapticLoop* loop);
    Result<void> conclude(const HapticLoop& loop, const Result<void>& taken);

    const Scene& scene_;
    SurfaceFeed& feed_;
    HapticPort& port_;
    const TouchSolver& solver_;
    TouchSessionSettings settings_;
    std::shared_ptr<PlaybackLog> log_;
    PlaybackBoard board_;
    std::atomic<bool> stopping_{false};
    std::mutex loop_mutex_;
    HapticLoop* loop_ = nullptr;  // that `run` has
    std::atomic<std::int64_t> late_frames_{0}, clip_end_ns_{0};
    mutable std::mutex failure_mutex_;
    std::optional<Error> clip_failure_;
    LiveFacts facts_;
};

}  // namespace touchable
