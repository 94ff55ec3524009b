#pragma once

// A run over a clip, tick by tick, in virtual time or in real time: the front door of this module.
// docs/install.md has a whole example.
//
// A SurfaceFeed reads frames of a clip, builds them and publishes them to a SurfaceTimeline; a PlaybackClock
// (playback.hpp) says which moment of the clip a tick meets; a TouchSession takes a goal for each finger,
// makes the tick and hands it to TouchSinks (files, figures, recordings). clip_workspace says how a device
// lies in a clip. The same inputs give the same forces to the bit, whatever the machine.
//
// A LiveSession is the same run in real time, on threads of its own (docs/architecture.md, Threads). The
// haptic thread, which asks a HapticPort (`make_port`) for goals, waits for none of the others and hands its
// ticks to the thread that calls `run`, which gives them to the sinks. Its figures say what was late, left
// out or missing.
//
// A session is one thread's, but for what a LiveSession lets any thread ask, and for the one other thread
// that may give commands to the clip's clock. Errors are lines for a person; a stop ends a run between two
// ticks.

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "device/hand.hpp"
#include "device/haptic_device.hpp"
#include "engine/clip/clip.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "haptics_cpu/haptic_loop.hpp"
#include "haptics_cpu/height_field.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "player/run/playback.hpp"
#include "player/run/surface_feed.hpp"

namespace touchable {

class FeedThreads;

/// Where a simulated device stands over a clip whose frame 0 is `first`: `default_workspace`, at the scene's
/// `device_metres_per_unit` where that is given.
Workspace clip_workspace(const Scene& scene, const SurfaceFrame& first);

/// Where a device stands that a person holds. Of one that reaches so far to each side (`reach`, metres, > 0)
/// the picture and nearly all of its depths lie within reach, with a fifth in front of them to come from. Of
/// others the picture is as wide as `default_workspace` says, and the centre is free: 0.02 m of device space
/// before nearly all depths. The scale is the scene's `device_metres_per_unit` where that is given.
Workspace held_workspace(const Scene& scene, const SurfaceFrame& first, const glm::dvec3& reach);

/// Shows a hand the same surface the solver sees.
class FieldProbe final : public SurfaceProbe {
public:
    explicit FieldProbe(const HeightField& field) : field_(field) {}

    int width() const override { return field_.width(); }
    int height() const override { return field_.height(); }
    std::optional<double> depth_under(double x, double y) const override;
    glm::dvec3 unproject(double x, double y, double planar_depth) const override;
    glm::dvec3 project(const glm::dvec3& point) const override;

private:
    const HeightField& field_;
};

/// What is given every tick: figures, a file of forces, a recording, a comparison.
class TouchSink {
public:
    virtual ~TouchSink() = default;
    virtual Result<void> take(const TouchTick& tick) = 0;
};

inline constexpr std::int64_t tick_ns = 1'000'000;
/// A run without a length of its own lasts at least this long; a clip that has ended stands still.
inline constexpr std::int64_t shortest_run_ns = 3'000'000'000;

/// Everything about a run but the clip and the hand.
struct TouchSessionSettings {
    /// How a live run goes, while it does.
    struct LiveStatus {
        bool is_camera = false;
        std::int64_t frames = 0;  ///< of a clip: that came late; of a camera: that fingers felt
        bool has_ended = false;   ///< no more frames come
    };

    int fingers = 1;
    TouchSettings touch;
    GuardSettings guard;
    /// Nothing: as long as the hand's motion, or where that has no end as the clip, but 3 s at least.
    std::optional<std::int64_t> ticks;
    /// What was asked of the clip's clock (PlaybackClock), at which ticks.
    std::vector<PlaybackCommand> playback;
    /// Of a live run without commands: called every few milliseconds, by the thread that gives ticks to the
    /// sinks. Nothing: not called.
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

// Where a run's goals come from, and where its forces go. What they are made of outlives them.

/// A scripted or recorded hand in place of a device; its forces go nowhere.
std::unique_ptr<HapticPort> make_port(Hand& hand);
/// A device that a person holds, and that is open: its handles are the fingers.
std::unique_ptr<HapticPort> make_port(HapticDevice& device, const Workspace& workspace);
/// A hand that holds a simulated device: the hand's goals are where it means the handles to be, the handles'
/// places are the goals that are touched with, and their forces move them. At the first tick the handles are
/// where they are meant to be. A tick that is skipped passes for the device all the same. The device is open,
/// with as many fingers as the hand.
std::unique_ptr<HapticPort> make_port(Hand& hand, SimulatedDevice& device, const Workspace& workspace);

// ---- In real time

/// How a live session went.
struct LiveFacts {
    /// What became of a camera's frames in a live run.
    struct Camera {
        std::int64_t frames_shown = 0;  ///< that fingers felt
        Spread exposure_to_force_ms;    ///< from taking a frame to the first force that it made
    };

    HapticLoop::Facts loop;
    std::int64_t late_frames = 0;    ///< not built yet when the surface first needed them
    std::optional<Camera> camera{};  ///< of a live source, which has no late frames
    bool interrupted = false;        ///< a person ended it
    bool sinks_fell_behind = false;  ///< ticks were lost, and that is why `run` failed
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
    /// The same by a log of commands in place of the settings' own. One that is open, because commands may
    /// come, makes a session without an end of its own.
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
    /// Why its clip goes no further, where the log is open: the last surface stands still, and is touched.
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
