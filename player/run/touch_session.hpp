#pragma once

// A run over a clip, tick by tick, in virtual time: the front door of this module. docs/linking.md has a
// whole example.
//
// A SurfaceFeed reads frames of a clip, builds them and publishes them to a SurfaceTimeline; a PlaybackClock
// (playback.hpp) says which moment of the clip a tick meets; a TouchSession takes a goal for each finger,
// makes the tick and hands it to TouchSinks (files, figures, recordings). A DevicePort is a HapticDevice as
// the solver's hand. clip_workspace says how a device lies in a clip. The same inputs give the same forces to
// the bit, whatever the machine.
//
// A session is one thread's. Errors are lines for a person; a stop ends a run between two ticks.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "device/hand.hpp"
#include "device/haptic_device.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "haptics_cpu/haptic_loop.hpp"
#include "haptics_cpu/height_field.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "player/run/playback.hpp"
#include "player/run/surface_feed.hpp"

namespace touchable {

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

/// A scripted or recorded hand in place of a device; nobody feels the forces.
class HandPort final : public HapticPort {
public:
    explicit HandPort(Hand& hand) : hand_(hand) {}
    bool read_goals(std::int64_t tick, const HeightField& field, std::span<glm::dvec3> goals) override;
    bool write_forces(std::span<const glm::dvec3>) override { return true; }

private:
    Hand& hand_;
};

/// A device that a person holds: its handles are the fingers.
class DevicePort final : public HapticPort {
public:
    /// The device outlives the port, and is open.
    DevicePort(HapticDevice& device, const Workspace& workspace) : device_(device), workspace_(workspace) {}
    bool read_goals(std::int64_t tick, const HeightField& field, std::span<glm::dvec3> goals) override;
    bool write_forces(std::span<const glm::dvec3> newtons) override { return device_.write_forces(newtons); }

private:
    HapticDevice& device_;
    Workspace workspace_;
};

/// A hand that holds a simulated device: the hand's goals are where it means the handles to be, the handles'
/// places are the goals that are touched with, and their forces move them. At the first tick the handles are
/// where they are meant to be. A tick that is skipped passes for the device all the same.
class SimulatedPort final : public HapticPort {
public:
    /// Both outlive the port; the device is open, with as many fingers as the hand.
    SimulatedPort(Hand& hand, SimulatedDevice& device, const Workspace& workspace);
    bool read_goals(std::int64_t tick, const HeightField& field, std::span<glm::dvec3> goals) override;
    bool write_forces(std::span<const glm::dvec3> newtons) override { return device_.write_forces(newtons); }

private:
    Hand& hand_;
    SimulatedDevice& device_;
    Workspace workspace_;
    std::int64_t ticks_passed_ = -1;
};

}  // namespace touchable
