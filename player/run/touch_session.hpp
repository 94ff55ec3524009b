// SPDX-License-Identifier: Apache-2.0
#pragma once

// A run over a clip, tick by tick, in virtual time or in real time: this module's main interface.
// docs/install.md has a complete example.
//
// A SurfaceFeed reads frames of a clip for a TouchRun (engine/run); a TouchSession takes a goal for each finger,
// has the tick solved and passes it to TouchSinks (files, TouchFigures, recordings). clip_workspace places a
// device over a clip. The same inputs give the same forces to the bit, whatever the machine.
//
// A LiveSession is the same run in real time, on threads of its own (docs/architecture.md, Threads). The
// haptic thread, which reads goals from a HapticPort (`make_port`), waits for no other thread; it queues its
// ticks for the thread that calls `run`, which passes them to the sinks. LiveFacts counts late frames and
// lost ticks.
//
// Threads: one uses a session, except for LiveSession's members marked "any thread", and one other may give
// commands to the clip's clock. Errors are user-readable lines; a stop ends a run between two ticks.

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
#include "engine/run/touch_run.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "haptics_cpu/haptic_loop.hpp"
#include "haptics_cpu/height_field.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "player/run/figures.hpp"
#include "player/run/surface_feed.hpp"

namespace touchable {

class FeedThreads;

/// Workspace of a simulated device over a clip with frame 0 `first`: `default_workspace`, with the scene's
/// `device_metres_per_unit` if given.
Workspace clip_workspace(const Scene& scene, const SurfaceFrame& first);

/// Workspace of a device held by the user. If `reach` (metres to each side) is > 0, the picture and nearly
/// all of its depths lie within reach, with a fifth of their range free in front. Otherwise the picture is as
/// wide as in `default_workspace`, and the centre is free: 0.02 m of device space in front of nearly all
/// depths. The scale is the scene's `device_metres_per_unit` if given.
Workspace held_workspace(const Scene& scene, const SurfaceFrame& first, const glm::dvec3& reach);

/// Gives a hand the same surface that the solver uses.
class FieldProbe final : public SurfaceProbe {
public:
    explicit FieldProbe(const HeightField& field) : field_(field) {}

    int width() const override { return field_.width(); }
    int height() const override { return field_.height(); }
    std::optional<double> depth_under(double x, double y) const override;
    glm::dvec3 unproject(double x, double y, double planar_depth) const override {
        return touchable::unproject(field_.scene().camera, x, y, planar_depth);
    }
    glm::dvec3 project(const glm::dvec3& point) const override;

private:
    const HeightField& field_;
};

/// A run without a stated length lasts at least this long; after the clip's end its surface stands still.
inline constexpr std::int64_t shortest_run_ns = 3'000'000'000;

/// All settings of a run except the clip and the hand.
struct TouchSessionSettings {
    /// Status of a running live run.
    struct LiveStatus {
        bool is_camera = false;
        std::int64_t frames = 0;  ///< of a clip: late frames; of a camera: frames that fingers felt
        bool has_ended = false;   ///< no more frames will come
    };

    int fingers = 1;
    TouchSettings touch;
    GuardSettings guard;
    /// Nothing: as long as the hand's motion, or if that is endless as the clip, at least 3 s.
    std::optional<std::int64_t> ticks;
    /// Commands to the clip's clock (PlaybackClock), with their ticks; must pass validate(commands).
    std::vector<PlaybackCommand> playback;
    /// Live run: called every few milliseconds by the thread that passes ticks to the sinks; for a clip only
    /// if its log is closed.
    std::function<void(const LiveStatus&)> on_status;
    /// Live run: whether its hand has ended, which ends the run; null: never.
    std::function<bool()> hand_is_over;
    /// What a replay or a measurement gives of a tick.
    struct GivenTick {
        std::int64_t time_ns = 0;         ///< must not go backward
        std::optional<FramePair> pair{};  ///< nothing: the frames around its moment on the clip's clock
        bool after_gap = false;           ///< TouchRun::meet
    };
    /// Default: tick k is at k ms.
    std::function<Result<GivenTick>(std::int64_t)> given_tick;
};

/// Offline touch: hand -> solver -> guard at 1 kHz of virtual time over a clip. After the clip's end its last
/// surface stands still. The same inputs give the same forces on any machine, fast or slow.
class TouchSession {
public:
    /// All references must outlive the session.
    TouchSession(SurfaceFeed& feed, Hand& hand, const TouchSolver& solver,
                 const TouchSessionSettings& settings);

    /// Runs to the end or until a stop request (an error then).
    Result<void> run(std::span<TouchSink* const> sinks);

private:
    bool is_over(std::int64_t tick);
    Result<void> tick(std::int64_t tick, std::span<TouchSink* const> sinks);

    SurfaceFeed& feed_;
    Hand& hand_;
    TouchSessionSettings settings_;
    TouchRun run_;
};

/// For people: no frame has come from a live source for `silent_ns`, and why; empty: frames come. They do
/// while none is older than `stale_after_ns` (GuardSettings; 0: any age), and the stream has not ended.
std::string silence_in_words(std::int64_t silent_ns, std::int64_t stale_after_ns, const ClipReader& source);

// Sources of a run's goals and targets of its forces. Their arguments must outlive them.

/// A scripted or recorded hand in place of a device; its forces are discarded.
std::unique_ptr<HapticPort> make_port(Hand& hand);
/// An open device held by the user: its handles are the fingers.
std::unique_ptr<HapticPort> make_port(HapticDevice& device, const Workspace& workspace);
/// A hand that holds a simulated device: the hand's goals are its intended handle positions, the actual
/// handle positions are the goals used for touch, and forces move the handles. At the first tick the handles
/// are at the hand's goals. A skipped tick still advances the device. The device is open and has as many
/// fingers as the hand.
std::unique_ptr<HapticPort> make_port(Hand& hand, SimulatedDevice& device, const Workspace& workspace);

// ---- In real time

/// Result of a live session.
struct LiveFacts {
    /// Statistics of a camera's frames in a live run.
    struct Camera {
        std::int64_t frames_shown = 0;  ///< frames that fingers felt
        Spread exposure_to_force_ms;    ///< from a frame's exposure to its first force
    };

    HapticLoop::Facts loop;
    std::int64_t late_frames = 0;    ///< frames not built when the surface first needed them
    std::optional<Camera> camera{};  ///< for a live source, which has no late frames
    bool interrupted = false;        ///< ended by a stop request
    bool sinks_fell_behind = false;  ///< `run` failed because ticks were lost
    std::optional<Error> failure;    ///< other reason for an early end: the device, or an unreadable frame
};

/// Error of a live run that was faster than its output (`files`), or than this machine if `files` is empty.
Error fell_behind_error(const std::string& files, std::int64_t ticks_missing);

/// Touch on the wall clock: decoding, building and the haptic loop each have a thread, the sinks use the
/// caller's. A recording keeps each tick's frames, so that the session replays exactly.
class LiveSession {
public:
    /// All references must outlive the session; `feed` has published its first frame. `port` supplies goals
    /// and takes forces. The session lasts `settings.ticks`, otherwise as long as the clip, at least 3 s.
    /// `log`: replaces the settings' commands; with an open one, to which commands may come, the session does
    /// not end by itself.
    LiveSession(SurfaceFeed& feed, HapticPort& port, const TouchSolver& solver,
                const TouchSessionSettings& settings, std::shared_ptr<PlaybackLog> log = nullptr);

    /// Runs to the end, until a stop request (the usual end), or until the device, a sink or the clip fails;
    /// with an open log the hand outlasts the clip. Ticks until then count: an error is returned only if no
    /// tick was run or ticks were lost.
    Result<void> run(std::span<TouchSink* const> sinks);
    /// Instead of `run`: the next tick, on the caller's thread and in virtual time. Reads the frames that it
    /// needs, so none is late. For a clip, and an open log.
    Result<void> run_tick(std::span<TouchSink* const> sinks);

    // Any thread, during `run`.
    /// Unpowers the hand after the tick in progress, without waiting for a sink; `run` returns once the sink
    /// is done.
    void stop();
    /// State of the clip's clock at the newest tick.
    PlaybackState playback() const { return run_.playback(); }
    std::int64_t late_frames() const { return late_frames_.load(std::memory_order_relaxed); }
    /// End of the clip's last frame once it was reached, ns; 0 before.
    std::int64_t clip_end_ns() const { return clip_end_ns_.load(std::memory_order_relaxed); }
    /// With an open log: why the clip stopped; its last surface stands still and can be touched.
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

    SurfaceFeed& feed_;
    HapticPort& port_;
    TouchSessionSettings settings_;
    TouchRun run_;
    std::int64_t next_tick_ = 0;  // of run_tick
    std::atomic<bool> stopping_{false};
    std::mutex loop_mutex_;
    HapticLoop* loop_ = nullptr;  // the loop of `run`
    std::atomic<std::int64_t> late_frames_{0}, clip_end_ns_{0};
    mutable std::mutex failure_mutex_;
    std::optional<Error> clip_failure_;
    LiveFacts facts_;
};

}  // namespace touchable
