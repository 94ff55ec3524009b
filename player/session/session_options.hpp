#pragma once

#include <cstdint>
#include <functional>
#include <glm/mat4x4.hpp>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "device/hand_control.hpp"
#include "device/haptic_device.hpp"
#include "engine/base/result.hpp"
#include "haptics_cpu/guard_settings.hpp"
#include "haptics_cpu/touch_solver.hpp"
#include "haptics_cpu/workspace.hpp"
#include "player/run/playback_clock.hpp"
#include "player/session/builder_choice.hpp"
#include "player/session/clip_choice.hpp"
#include "player/session/run_gpu.hpp"

namespace touchable {

/// What a run is made of: what is touched, by whom, and how forces come about.
struct SessionOptions {
    ClipChoice clip;
    std::string hand = "wander";  ///< as make_hand reads it
    int fingers = 1;
    std::vector<PlaybackCommand> playback;  ///< what is asked of the clip's clock; `validate` passes them
    /// In place of `playback`, asked for once all but the first frames is there; nothing: `playback` it is.
    std::function<std::vector<PlaybackCommand>()> late_playback;
    std::optional<std::int64_t> ticks;  ///< nothing: the hand's length, or the clip's and at least 3 s
    BuilderChoice builder{.name = "auto"};
    TouchMetric metric = TouchMetric::world;
    double stribeck_speed = 0;  ///< m/s; 0: friction does not depend on speed
    GuardSettings guard;
    bool live = false;          ///< on the wall clock, in real time
    bool start_buried = false;  ///< live: force from the start for a finger that begins inside, too
    bool recorded = false;      ///< frames are hashed, so that a replay knows whether it has the same
    /// Live source: as GuardSettings has it; nothing: 250 ms of a stream, never of a camera.
    std::optional<std::int64_t> stale_after_ns;
    std::optional<std::string> camera;  ///< live: what `clip` is as a camera, in words; nothing: it is a clip
    int stream_latency_ms = 200;        ///< of a stream: the longest that framesets wait for others' sake
    std::optional<std::string> device;  ///< live: what the hand holds; nothing: the hand itself is the finger
    /// Live: a device whose handles are the fingers, and no hand; it is opened when the session begins.
    std::shared_ptr<HapticDevice> held_device;
    /// Of that device: asks for its forces, repositions it. Nothing: it is there as it is, with all forces.
    std::shared_ptr<HandControl> control;
    std::optional<glm::dmat4> world_from_camera;  ///< rigid, metres: that device's places are the world's
    double hand_scale = 1;                        ///< a finger's way for that of the hand, of the fitted one
    bool device_log = false;                      ///< ticks are kept as that device had them
    /// Where that device is, before `hand_scale`; nothing: where the clip's first frame puts it.
    std::optional<Workspace> workspace;
    /// That others of the program use as well; nothing: the run opens one of its own if it needs one.
    std::shared_ptr<RunGpu> gpu;
    bool watched = false;  ///< live: somebody looks at what the hand holds, and wants its colour
    /// Whoever waits for the setup may want it no more: it is then an error of kind interrupted, soon.
    std::stop_token given_up{};
};

/// Refuses (ErrorKind::usage) what no run can be made of, whatever the clip, in the options' names.
Result<void> validate(const SessionOptions& options);

/// Refuses a guard that is no good to a hand on a device, likewise.
Result<void> check_guard(const GuardSettings& guard);

}  // namespace touchable
