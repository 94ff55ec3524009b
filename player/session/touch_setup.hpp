// SPDX-License-Identifier: Apache-2.0
#pragma once

// Parts of a run, made from a person's options or from a recording.
//
// SessionOptions holds every setting of a run (run_settings.hpp is the table of those that take a word or a
// number); setup_from_options makes a TouchSetup from it: the clip, its scene, a builder
// (builder_choice.hpp), hands, guard, solver. recorded_facts makes the header of the run's recording, from
// which setup_from_recording makes the same parts for a replay. Errors name the wrong Setting as a hint.
// open_port opens a setup's hand: a device, a pointer, a script.
//
// Threads: the one that makes a setup owns it until a session takes it.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/mat4x4.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "device/hand.hpp"
#include "device/haptic_device.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/scene/scene.hpp"
#include "haptics_cpu/haptic_loop.hpp"
#include "player/run/run_files.hpp"
#include "player/run/touch_session.hpp"
#include "player/session/builder_choice.hpp"
#include "player/session/clip_choice.hpp"
#include "player/session/run_settings.hpp"

namespace touchable {

/// Settings of a run, with its clip and its hand or device. The clip or the hand sets the scale of `touch`.
struct SessionOptions : TouchSessionSettings {
    ClipChoice clip;
    std::string hand = "wander";  ///< as make_hand reads it
    /// Replaces `playback`; called after the feed is made, before the first frames are read. Null:
    /// `playback`.
    std::function<std::vector<PlaybackCommand>()> late_playback;
    BuilderChoice builder{.name = "auto"};
    bool live = false;          ///< on the wall clock, in real time
    bool start_buried = false;  ///< live: force from the start even for a finger that begins inside
    bool recorded = false;      ///< hash the frames, so that a replay can compare them
    /// Live source: as in GuardSettings; nothing: max(250 ms, 3 frames) for a stream, never for a camera.
    std::optional<std::int64_t> stale_after_ns;
    std::optional<std::string> camera;  ///< live: the camera's description; nothing: `clip` is no camera
    std::optional<std::string> device;  ///< live: device held by the hand; nothing: the hand is the finger
    /// Live: a device held by the user: its handles are the fingers, there is no hand. Opened by the session.
    std::shared_ptr<HapticDevice> held_device;
    /// Enables that device's forces and repositions it. Null: device as it is, full forces.
    std::shared_ptr<HandControl> control;
    std::optional<glm::dmat4> world_from_camera;  ///< rigid, metres: device positions are world positions
    double hand_scale = 1;                        ///< scale of finger motion relative to the fitted workspace
    bool device_log = false;                      ///< keep a log of that device's ticks
    /// That device's workspace, before `hand_scale`; nothing: fitted to the clip's first frame.
    std::optional<Workspace> workspace;
    /// Shared with the rest of the program; nothing: the run opens one of its own if it needs one.
    std::shared_ptr<RunGpu> gpu;
    bool watched = false;  ///< live: a watcher shows the held frames, with colour
    bool drawn = false;    ///< `gpu` draws the pictures and is opened for that
};

/// Refuses (ErrorKind::usage) options that are invalid for every clip; messages use the options' names.
Result<void> validate(const SessionOptions& options);

/// Refuses (ErrorKind::usage) guard settings that are invalid or harmful to a hand on a device.
Result<void> check_guard(const GuardSettings& guard);

/// All parts of a session, made from options or from a recording.
struct TouchSetup {
    /// As applied: the builder is resolved, never auto, `gpu` is there, `live` also says that the recorded
    /// run was; hand and device are as on the command line, or name the user's.
    SessionOptions options;
    Scene scene;                           ///< as applied in this run
    std::vector<Remark> notes;             ///< the clip's (remarks_of)
    std::optional<ChosenFilters> filters;  ///< nothing: all filters were stated
    std::unique_ptr<SurfaceFeed> feed;
    std::unique_ptr<Hand> hand;               ///< null: the user holds a device
    std::shared_ptr<CameraCapture> film;      ///< of a recorded plugged-in camera; else null
    std::unique_ptr<SimulatedDevice> device;  ///< held by the hand
    /// The control of a device with motors; nullptr: no force reaches the user's hand, and the reported force
    /// is the scene's.
    const HandControl* exerting_control() const {
        const bool has_motors = options.control && options.held_device->capabilities().axes_driven > 0;
        return has_motors ? options.control.get() : nullptr;
    }
    std::unique_ptr<DeviceTickLog> device_log;  ///< of the user's device; null: no log
    Workspace workspace;
    std::optional<TouchSolver> solver;
    std::vector<FrameRun> dropped{};  ///< left out by the recorded run
    /// The frames that the recorded run's planes_hash covers; nothing: not stated.
    std::optional<std::vector<FrameRun>> recorded_frames{};
    /// Frames that a temporal filter reads before an epoch's first frame.
    int warm_up_frames = temporal_warm_up_frames;

    /// The run's stated length, or that of its hand's motion; nothing: endless.
    std::optional<std::int64_t> ticks() const {
        return options.ticks || !hand ? options.ticks : hand->ticks();
    }
};

Result<std::unique_ptr<TouchSetup>> setup_from_options(const SessionOptions& options);
/// The run of `part`, which must outlive the setup, with `options.builder` and, if given, the clip and files
/// of `options.clip`. `gpu`: the previous part's; null: the run opens its own.
Result<std::unique_ptr<TouchSetup>> setup_from_recording(const RecordedPart& part,
                                                         const SessionOptions& options,
                                                         std::shared_ptr<RunGpu> gpu = nullptr);

/// The recording's header of a run that has ended (docs/touch.md).
nlohmann::ordered_json recorded_facts(const TouchSetup& setup, const std::string& force_hash);

/// Fills in the setup's plain values from a recording header (opens nothing) and returns the scene that was
/// touched. A member that is missing, of another kind or out of range is an error of kind input that begins
/// with `name`.
Result<SceneDescription> read_recorded_facts(const nlohmann::ordered_json& facts, const std::string& name,
                                             TouchSetup& setup);

/// Whether the clip's frames are others than those of the recording that was replayed.
bool has_other_frames(const RecordedPart& recording, const TouchSetup& setup);

/// The port of a live session's haptic thread: to the hand, the device it holds, or the user's device. Opens
/// the device. `setup` must outlive the port.
Result<std::unique_ptr<HapticPort>> open_port(TouchSetup& setup);

/// After a session: stores the device's reason for a failure in `facts`.
void explain_failure(const TouchSetup& setup, LiveFacts& facts);

}  // namespace touchable
