#pragma once

// What a run is made of, in words that options, a window and a recording share.
//
// SessionOptions are everything that a person can say of a run; setup_from_options makes a TouchSetup of
// them: the clip, its scene, a builder (BuilderChoice; `auto` picks by what the run needs and what the
// machine has), hands, guard, solver. setup_from_recording makes the same of a recording, for its replay.
// RunGpu is the one GPU that builder and window share. Errors hint at the Setting that was wrong.
//
// The thread that makes a setup owns it until a session takes it.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/mat4x4.hpp>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "device/hand.hpp"
#include "device/haptic_device.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/gpu/gpu_device.hpp"
#include "engine/scene/filter_codes.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/surface_builder.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "player/run/force_table.hpp"
#include "player/run/output_file.hpp"
#include "player/run/recording.hpp"
#include "player/run/touch_session.hpp"
#include "player/session/clip_choice.hpp"

namespace touchable {

/// The GPU of a run: opened when it is first needed, one for all who need it, and anew where it was lost.
/// Safe from any thread.
class RunGpu {
public:
    /// `request` as in choose_gpu, `window_extensions` as in GpuOptions.
    explicit RunGpu(std::string request, std::vector<std::string> window_extensions = {})
        : request_(std::move(request)), window_extensions_(std::move(window_extensions)) {}
    Result<std::shared_ptr<GpuDevice>> open();
    /// What it calls itself; empty before it is open.
    std::string name() const;

private:
    const std::string request_;
    const std::vector<std::string> window_extensions_;
    mutable std::mutex mutex_;
    std::shared_ptr<GpuDevice> device_;
};

/// `--builder` and what goes with it, as typed.
struct BuilderChoice {
    std::string name = "cpu";
    std::string gpu = "auto";   ///< as in choose_gpu; for the vulkan builder and for pictures
    bool gpu_fallback = false;  ///< nobody asked for the GPU: the cpu builder where it will not do after all

    bool names_gpu() const { return gpu != "auto"; }
};

/// The vulkan builder works on `gpu`, which others do not open. Refused (ErrorKind::gpu), saying what is
/// missing, where it was asked for and there is no such GPU; (ErrorKind::usage) the lazy builder with a
/// temporal filter. A GPU that is lost in the middle is no error: the cpu builder goes on, and a warning on
/// stderr says so.
Result<std::unique_ptr<SurfaceBuilder>> make_builder(const BuilderChoice& choice, const Scene& scene,
                                                     RunGpu& gpu);

/// What decides which builder costs least: the forces are the same with any.
struct TouchLoad {
    Scene scene;        ///< as the run applies it
    bool moves = true;  ///< the clip has more than one frame
    int fingers = 1;
    bool live = false;  ///< ticks are due every millisecond of the wall clock
};

/// CPU time of whole frames by the CPU builder, but for hole filling, which depends on the holes, and of what
/// the lazy builder adds to ticks, all threads: ms for each second of the clip (docs/gpu-vs-cpu.md, where the
/// constants come from).
double whole_frames_ms_per_second(const TouchLoad& load);
double lazy_ms_per_second(const TouchLoad& load);

struct BuilderPick {
    std::string name;  ///< "cpu", "lazy" or "vulkan"
    std::string why;   ///< for a person, one line
};

/// What `--builder auto` is. `has_gpu`, which opens a device, is asked only where whole frames cost so much
/// that this pays: whether there is a GPU, and not a software Vulkan.
BuilderPick pick_builder(const TouchLoad& load, const std::function<bool()>& has_gpu);

/// What a person wants of the clip's clock, one command a line: "SECONDS play", "pause", "rate X", "seek
/// SECONDS", "step", "loop SECONDS SECONDS" or "unloop", in the order of their times (docs/playback.md).
/// Empty lines and what follows '#' say nothing. Refuses (ErrorKind::input), with `name` and the line, all
/// else.
Result<std::vector<PlaybackCommand>> parse_playback(std::string_view text, const std::string& name);
/// Likewise, of a file.
Result<std::vector<PlaybackCommand>> read_playback(const std::filesystem::path& file);

/// What a person may have set to give these commands.
Hints settings_of(const std::vector<PlaybackCommand>& commands);
/// As such lines, with ", " between them.
std::string in_words(const std::vector<PlaybackCommand>& commands);

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

/// How long it takes, in ticks: milliseconds.
inline constexpr std::int64_t standard_stroke_ticks = 3000;

/// What one finger did, and what it felt.
struct Stroke {
    ForceTable forces;
    double metres_per_scene_unit = 0;
};

/// Of one that wanders over a clip, always on the same way. The clip has the filters that it states, or that
/// its first frames ask for, here and below.
Result<Stroke> standard_stroke(std::unique_ptr<ClipReader> clip);
/// What the same hand feels of two clips that show the same: the very goals of a stroke over the first are
/// repeated over the second, at the same scale.
Result<ForceComparison> compare_by_stroke(const Stroke& first, std::unique_ptr<ClipReader> second);

}  // namespace touchable
