#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "device/hand.hpp"
#include "device/simulated_device.hpp"
#include "engine/scene/temporal.hpp"
#include "haptics_cpu/workspace.hpp"
#include "player/run/device_tick_log.hpp"
#include "player/run/recording.hpp"
#include "player/run/touch_session.hpp"
#include "player/session/session_options.hpp"

namespace touchable {

/// Everything a session runs on, made from options or from a recording.
struct TouchSetup {
    ClipChoice clip;
    Scene scene;                           ///< as this run applies it
    std::vector<Remark> notes;             ///< of the clip (remarks_of)
    std::optional<ChosenFilters> filters;  ///< nothing: all were stated
    BuilderChoice builder;                 ///< not auto any more
    std::string builder_why;  ///< why auto, or another than was asked for; empty: it was asked for by name
    std::shared_ptr<RunGpu> gpu;  ///< of builder and picture
    std::unique_ptr<SurfaceFeed> feed;
    std::string hand_words;                     ///< as on the command line
    std::unique_ptr<Hand> hand;                 ///< nothing: a person holds `held_device`
    std::string camera_words;                   ///< as on the command line; empty: no camera
    std::shared_ptr<CameraCapture> film;        ///< of a camera that is plugged in and recorded; else nothing
    std::string device_words;                   ///< as on the command line; empty: no device
    std::unique_ptr<SimulatedDevice> device;    ///< that the hand holds
    std::shared_ptr<HapticDevice> held_device;  ///< that a person holds
    std::shared_ptr<HandControl> control;       ///< of that device; nothing: it is there as it is
    /// Of a device that has motors; nullptr: no force reaches a person's hand, and what is told is the
    /// scene's.
    const HandControl* exerting_control() const {
        return control && held_device->capabilities().axes_driven > 0 ? control.get() : nullptr;
    }
    double hand_scale = 1;                      ///< of that device, as SessionOptions has it
    std::unique_ptr<DeviceTickLog> device_log;  ///< of that device; nothing: nobody wants one
    Workspace workspace;
    std::optional<TouchSolver> solver;
    TouchSessionSettings settings;
    std::vector<DroppedFrames> dropped{};  ///< that a recorded run left out
    /// That a filter with a memory sees before an epoch's first frame.
    int warm_up_frames = temporal_warm_up_frames;
    bool live = false;  ///< on the wall clock, or recorded so

    /// How long the run was asked to be, or its hand's motion is; nothing: neither has an end.
    std::optional<std::int64_t> ticks() const {
        return settings.ticks || !hand ? settings.ticks : hand->ticks();
    }
};

Result<std::unique_ptr<TouchSetup>> setup_from_options(const SessionOptions& options);
/// The run of `part`, which outlives the setup: by `options.builder`, and over the clip and scene file of
/// `options.clip` where they are given. `gpu`: that of the part before; nothing: its own.
Result<std::unique_ptr<TouchSetup>> setup_from_recording(const RecordedPart& part,
                                                         const SessionOptions& options,
                                                         std::shared_ptr<RunGpu> gpu = nullptr);

}  // namespace touchable
