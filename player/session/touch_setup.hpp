#pragma once

// What a run is made of, in words that options, a window and a recording share; and a live run with a
// watcher.
//
// SessionOptions are everything that a person can say of a run; setup_from_options makes a TouchSetup of
// them: the clip, its scene, a builder (BuilderChoice; `auto` picks by what the run needs and what the
// machine has), hands, guard, solver. setup_from_recording makes the same of a recording, for its replay.
// RunGpu is the one GPU that builder and window share. Errors hint at the Setting that was wrong.
// run_settings is the table of what a person can set of a run by a word or a number, whatever sets it.
//
// open_port opens a setup's hand: a device, a pointer, a script. A WatchedSession is what a window runs: a
// LiveSession and its threads. `look` shows the frames, the blend and the tick that the hand holds, and what
// fingers felt; figures count ticks and late frames; commands take effect with the next tick.
//
// The thread that makes a setup owns it until a session takes it. The window's thread calls a session's
// `ask`, `look` and `stop`; what stands under "Any thread" is any thread's. Only `stop` waits for the haptic
// thread.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/mat4x4.hpp>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string_view>
#include <thread>

#include "device/hand.hpp"
#include "device/haptic_device.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/gpu/gpu_device.hpp"
#include "engine/scene/filter_codes.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/surface_builder.hpp"
#include "haptics_cpu/haptic_loop.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "player/run/run_files.hpp"
#include "player/run/touch_session.hpp"
#include "player/session/clip_choice.hpp"

namespace touchable {

/// The GPU of a run: opened when it is first needed, one for builder and pictures, and anew where it was
/// lost. Safe from any thread.
class RunGpu {
public:
    /// `request` as in choose_gpu, `window_extensions` as in GpuOptions.
    explicit RunGpu(std::string request, std::vector<std::string> window_extensions = {})
        : request_(std::move(request)), window_extensions_(std::move(window_extensions)) {}
    Result<std::shared_ptr<GpuDevice>> open();
    /// The same, once `measure` (measure_builders, measure_painters) has measured it; opened anew where that
    /// has lost it.
    Result<std::shared_ptr<GpuDevice>> open_measured(
        const std::function<void(const std::shared_ptr<GpuDevice>&)>& measure);
    /// Of the device that is open (VulkanDevice::take_new_programs).
    std::optional<ProgramsToKeep> take_new_programs();
    /// The name that the GPU gives; empty before it is open.
    std::string name() const;

private:
    Result<std::shared_ptr<GpuDevice>> open_if_needed();

    const std::string request_;
    const std::vector<std::string> window_extensions_;
    mutable std::mutex mutex_;
    std::shared_ptr<GpuDevice> device_;
    std::optional<GpuFacts::Measured> measured_;
};

/// `--builder` and what goes with it: as typed, or as a run has it.
struct BuilderChoice {
    /// What decides which builder costs least: the forces are the same with any.
    struct Load {
        Scene scene;        ///< as the run applies it
        bool moves = true;  ///< the clip has more than one frame
        int fingers = 1;
        bool live = false;  ///< ticks are due every millisecond of the wall clock
        /// A GPU draws the frames, and is open for that: what it builds it draws where it lies.
        bool drawn = false;
    };

    std::string name = "cpu";
    std::string why{};  ///< one line: why auto, or another than was asked for; empty: asked for by name
    std::string gpu = "auto";   ///< as in choose_gpu; for the vulkan builder and for pictures
    bool gpu_fallback = false;  ///< the GPU was not asked for: the cpu builder where there is no such GPU

    bool names_gpu() const { return gpu != "auto"; }
};

/// The vulkan builder works on `gpu`, which others do not open. Refused (ErrorKind::gpu), saying what is
/// missing, where it was asked for and there is no such GPU; (ErrorKind::usage) the lazy builder with a
/// temporal filter. A GPU that is lost in the middle is no error: the cpu builder goes on, and a warning on
/// stderr says so.
Result<std::unique_ptr<SurfaceBuilder>> make_builder(const BuilderChoice& choice, const Scene& scene,
                                                     RunGpu& gpu);

/// CPU time of whole frames by the CPU builder, but for hole filling, which depends on the holes, and of what
/// the lazy builder adds to ticks, all threads: ms for each second of the clip (docs/measurements.md, where
/// the constants come from).
double whole_frames_ms_per_second(const BuilderChoice::Load& load);
double lazy_ms_per_second(const BuilderChoice::Load& load);

/// What `--builder auto` is: cpu, lazy or vulkan, and why. `gpu_is_fast`, which opens a device, is asked only
/// where whole frames cost so much that this pays: whether there is a GPU, not a software Vulkan nor one that
/// was measured to be slow (is_fast_builder). Its name and why alone say something: a GPU's name and the
/// fallback are the caller's.
BuilderChoice pick_builder(const BuilderChoice::Load& load, const std::function<bool()>& gpu_is_fast);

/// Whether a GPU builds a frame in no more than twice the CPU's time, which the CPU then has for other
/// things; or it was not measured. A software Vulkan has the CPU's time only.
bool is_fast_builder(const GpuFacts& facts);

/// What a person wants of the clip's clock, one command a line: "SECONDS play", "pause", "rate X", "seek
/// SECONDS", "step", "loop SECONDS SECONDS" or "unloop", in the order of their times (docs/touch.md).
/// Empty lines and what follows '#' say nothing. Refuses (ErrorKind::input), with `name` and the line, all
/// else.
Result<std::vector<PlaybackCommand>> parse_playback(std::string_view text, const std::string& name);
/// The same of a file.
Result<std::vector<PlaybackCommand>> read_playback(const std::filesystem::path& file);

/// What a person may have set to give these commands.
Hints settings_of(const std::vector<PlaybackCommand>& commands);
/// The commands as such lines, with ", " between them.
std::string in_words(const std::vector<PlaybackCommand>& commands);

/// What a run is made of: what is touched, with what, and how forces come about.
struct SessionOptions {
    ClipChoice clip;
    std::string hand = "wander";  ///< as make_hand reads it
    int fingers = 1;
    std::vector<PlaybackCommand> playback;  ///< what is asked of the clip's clock; `validate` passes them
    /// In place of `playback`, asked for once all but the first frames is there; nothing: `playback` it is.
    std::function<std::vector<PlaybackCommand>()> late_playback;
    std::optional<std::int64_t> ticks;  ///< nothing: the hand's length, or the clip's and at least 3 s
    BuilderChoice builder{.name = "auto"};
    TouchSettings touch;  ///< but for its scale, which the clip or the hand has
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
    /// Asks for that device's forces, repositions it. Nothing: it is there as it is, with all forces.
    std::shared_ptr<HandControl> control;
    std::optional<glm::dmat4> world_from_camera;  ///< rigid, metres: that device's places are the world's
    double hand_scale = 1;                        ///< a finger's way for that of the hand, of the fitted one
    bool device_log = false;                      ///< ticks are kept as that device had them
    /// Where that device is, before `hand_scale`; nothing: where the clip's first frame puts it.
    std::optional<Workspace> workspace;
    /// Shared with the rest of the program; nothing: the run opens one of its own if it needs one.
    std::shared_ptr<RunGpu> gpu;
    bool watched = false;  ///< live: what the hand holds is shown, with its colour
    bool drawn = false;    ///< by `gpu`, which is opened for that
};

/// Refuses (ErrorKind::usage) what no run can be made of, whatever the clip, in the options' names.
Result<void> validate(const SessionOptions& options);

/// Refuses (ErrorKind::usage) a guard that is no good to a hand on a device.
Result<void> check_guard(const GuardSettings& guard);

/// Everything a session runs on, made from options or from a recording.
struct TouchSetup {
    ClipChoice clip;
    Scene scene;                           ///< as this run applies it
    std::vector<Remark> notes;             ///< of the clip (remarks_of)
    std::optional<ChosenFilters> filters;  ///< nothing: all were stated
    BuilderChoice builder;                 ///< not auto any more
    std::shared_ptr<RunGpu> gpu;           ///< of builder and picture
    std::unique_ptr<SurfaceFeed> feed;
    std::string hand_words;                     ///< as on the command line
    std::unique_ptr<Hand> hand;                 ///< nothing: a person holds `held_device`
    std::string camera_words;                   ///< as on the command line; empty: no camera
    std::shared_ptr<CameraCapture> film;        ///< of a camera that is plugged in and recorded; else nothing
    std::string device_words;                   ///< as on the command line; empty: no device
    std::unique_ptr<SimulatedDevice> device;    ///< that the hand holds
    std::shared_ptr<HapticDevice> held_device;  ///< that a person holds
    std::shared_ptr<HandControl> control;       ///< of that device; nothing: it is there as it is
    /// The control of a device that has motors; nullptr: no force reaches a person's hand, and what is
    /// reported is the scene's force.
    const HandControl* exerting_control() const {
        return control && held_device->capabilities().axes_driven > 0 ? control.get() : nullptr;
    }
    double hand_scale = 1;                      ///< of that device, as SessionOptions has it
    std::unique_ptr<DeviceTickLog> device_log;  ///< of that device; nothing: none is kept
    Workspace workspace;
    std::optional<TouchSolver> solver;
    TouchSessionSettings settings;
    std::vector<DroppedFrames> dropped{};  ///< that a recorded run left out
    /// How many frames a filter with a memory sees before an epoch's first.
    int warm_up_frames = temporal_warm_up_frames;
    bool live = false;  ///< on the wall clock, or recorded so

    /// How long the run was asked to be, or its hand's motion is; nothing: neither has an end.
    std::optional<std::int64_t> ticks() const {
        return settings.ticks || !hand ? settings.ticks : hand->ticks();
    }
};

/// Of what a setting is: which part of a window shows it, and on what it has an effect.
enum class SettingOf {
    felt,     ///< how forces come about
    device,   ///< a device that a person holds: without one it has no effect
    filters,  ///< how depth is cleaned: "filters", which sets all, and each of them
    relief,   ///< heights that are made of the clip's colour
    brush,    ///< what is painted in this window; it is never kept
    expert    ///< as felt, but options alone set it
};

/// A row of the table of a run's settings, which options, the window's panel, its commands and scripts, and
/// kept settings go by. The rows of filters come from `filter_settings`.
struct SessionSetting {
    std::string name;       ///< in commands and kept settings; behind "--" of an option
    const char* what = "";  ///< for a person who sees it for the first time
    SettingOf of = SettingOf::felt;
    SettingRange range{};  ///< in a window. An option takes any number: `validate` refuses what cannot be
    /// Sets a legal value (SettingRange::value_of) in the options of a run.
    std::function<void(double value, SessionOptions& options)> set{};
    /// The value that a run has; null: the setting has none of its own, as "filters".
    std::function<std::string(const TouchSetup& setup)> get{};
    std::string usual{};  ///< of a number: what a run has where nothing sets it; empty: see `what`
};
std::span<const SessionSetting> run_settings();
/// Those that a window has: all but the experts'.
std::span<const SessionSetting> session_settings();
/// One of those; null: none has that name.
const SessionSetting* session_setting(std::string_view name);

Result<std::unique_ptr<TouchSetup>> setup_from_options(const SessionOptions& options);
/// The run of `part`, which outlives the setup: by `options.builder`, and over the clip and scene file of
/// `options.clip` where they are given. `gpu`: that of the part before; nothing: its own.
Result<std::unique_ptr<TouchSetup>> setup_from_recording(const RecordedPart& part,
                                                         const SessionOptions& options,
                                                         std::shared_ptr<RunGpu> gpu = nullptr);

/// What a live session's haptic thread is plugged into: the hand, the device that it holds, or the one that a
/// person holds. Opens the device. `setup` outlives the port.
Result<std::unique_ptr<HapticPort>> open_port(TouchSetup& setup);

/// After a session: the reason that its device gives for having stopped.
void explain_failure(const TouchSetup& setup, LiveFacts& facts);

/// A tick as its fingers had it.
struct WatchedTick {
    struct Finger {
        glm::dvec3 goal{0.0};  ///< as the hand gave it
        Contact contact;       ///< the goal that was used, proxy, whether it touches, properties there
        GuardedForce force;    ///< as it was sent to the hand, and why it is not the spring's; no energy
    };
    std::int64_t tick = -1;
    std::vector<Finger> fingers;
};

/// What the hand was at, to be drawn.
struct WatchedMoment {
    SurfaceTimeline::HeldPair held;    ///< its frames stay whole until the next look
    std::optional<HeldPlanes> stored;  ///< of the pair's frame nearer in time, where its reader keeps them
    WatchedTick felt;                  ///< by every finger: of that tick or one a few later

    PlaneView colour() const { return stored ? stored->colour : PlaneView{}; }  ///< empty: it has none
};

/// How a session goes while it does.
struct WatchedFigures {
    struct Ticks {
        std::int64_t ticks = 0;
        std::int64_t late = 0;   ///< that began a millisecond or more too late
        double solve_us = 0;     ///< of the newest
        double late_us_p99 = 0;  ///< of all, in steps of 10; 1000 stands for all that were later
    };
    FeedFigures feed;
    Ticks ticks;                   ///< those so far
    std::int64_t late_frames = 0;  ///< but for the two that an epoch begins with
};

/// A live session on threads of its own, beside a watcher who also commands its clip's clock. It goes on
/// until it is stopped, or the device fails: where the clip ends or fails, its surface stands still. Nothing
/// here keeps the haptic thread waiting.
class WatchedSession : NonCopyable {
public:
    /// As many commands as a session takes: one every tenth of a second for an hour and a half.
    static constexpr std::size_t most_commands = 65536;

    /// Begins at once. `setup` was made for a live run that is watched. `sinks` get every tick, on the
    /// session's own thread, and outlive it. Refused (ErrorKind::usage): commands known before that are not
    /// of tick 0, which are those of a run without a watcher.
    static Result<std::unique_ptr<WatchedSession>> start(std::unique_ptr<TouchSetup> setup,
                                                         std::vector<TouchSink*> sinks);
    ~WatchedSession();  ///< stops it

    /// Zero force, threads ended, the device closed, and the setup as after any run: its settings have all
    /// commands.
    void stop();
    bool running() const { return running_.load(std::memory_order_acquire); }

    // The watcher's, one thread.
    /// Takes effect with the next tick. Refused (ErrorKind::usage): what `validate` refuses, moments beyond
    /// the clip's end, anything of a camera, after the end, and once there are `most_commands`.
    Result<void> ask(PlaybackVerb verb, std::int64_t first = 0, std::int64_t second = 0);
    /// Whether a command is still to take effect; after the end it never will.
    bool is_asked() const { return log_->is_waiting(); }
    /// How many have taken effect so far.
    std::size_t commands() const { return log_->size(); }
    /// What the hand was at last; nothing before the first tick. Waits for nothing but a copy of the same.
    const WatchedMoment* look();

    // Any thread.
    PlaybackState playback() const;
    /// The clip's clock, as every tick has met it.
    PlaybackClock clock() const { return {setup_->scene.rate, log_}; }
    WatchedFigures figures() const;
    /// As LiveSession::clip_failure.
    std::optional<Error> clip_failure() const { return live_->clip_failure(); }
    /// As ClipReader::remarks.
    std::vector<std::string> remarks() const { return setup_->feed->reader().remarks(); }
    /// Frames with which the clip showed something else all at once, of those that came by.
    std::set<std::int64_t> cuts() const { return setup_->feed->cuts(); }

    // After the end.
    const LiveFacts& facts() const { return facts_; }
    /// Why it ended, if not because it was to.
    std::optional<Error> failure() const;
    TouchSetup& setup() { return *setup_; }

private:
    class Ticks;
    WatchedSession(std::unique_ptr<TouchSetup> setup, std::vector<TouchSink*> sinks);
    void run();
    void close_devices();

    std::unique_ptr<TouchSetup> setup_;
    std::optional<std::int64_t> clip_end_ns_;
    std::shared_ptr<PlaybackLog> log_;
    std::unique_ptr<HapticPort> port_;
    std::optional<LiveSession> live_;
    std::unique_ptr<Ticks> ticks_;
    std::vector<TouchSink*> sinks_;
    WatchedMoment seen_;
    std::atomic<bool> running_{false};
    // Of the session's thread, until it has ended.
    Result<void> ran_;
    LiveFacts facts_;
    std::thread thread_;
};

/// What one finger did, and what it felt.
struct Stroke {
    ForceTable forces;
    double metres_per_scene_unit = 0;
};

/// The stroke of a finger that wanders over a clip, always on the same way. The clip has the filters that it
/// states, or that its first frames ask for, here and below.
Result<Stroke> standard_stroke(std::unique_ptr<ClipReader> clip);
/// What the same hand feels of two clips that show the same: the very goals of a stroke over the first are
/// repeated over the second, at the same scale.
Result<ForceComparison> compare_by_stroke(const Stroke& first, std::unique_ptr<ClipReader> second);

}  // namespace touchable
