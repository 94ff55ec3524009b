#pragma once

// Parts of a run, in types shared by options, a window and a recording; and a live run with a watcher.
//
// SessionOptions holds every setting of a run; setup_from_options makes a TouchSetup from it: the clip, its
// scene, a builder (BuilderChoice; `auto` picks by the run's needs and the machine), hands, guard, solver.
// setup_from_recording makes the same from a recording, for its replay. RunGpu is the one GPU that builder
// and window share. Errors name the wrong Setting as a hint. run_settings is the table of all settings that
// take a word or a number.
//
// open_port opens a setup's hand: a device, a pointer, a script. A window runs a WatchedSession: a
// LiveSession and its threads. `look` returns the frames, the blend and the tick that the hand holds, and the
// fingers' contacts and forces; figures count ticks and late frames; commands take effect at the next tick.
//
// Threads: the one that makes a setup owns it until a session takes it. The window's calls a session's `ask`,
// `look` and `stop`; any may call members under "Any thread". Only `stop` waits for the haptic thread.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/mat4x4.hpp>
#include <limits>
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

/// The GPU of a run, shared by builder and pictures: opened on first use, reopened after a loss. Thread-safe.
class RunGpu {
public:
    /// `request` as in choose_gpu, `window_extensions` as in GpuOptions.
    explicit RunGpu(std::string request, std::vector<std::string> window_extensions = {})
        : request_(std::move(request)), window_extensions_(std::move(window_extensions)) {}
    Result<std::shared_ptr<GpuDevice>> open();
    /// As `open`, after `measure` (measure_builders, measure_painters) has measured it; reopened if measuring
    /// lost it.
    Result<std::shared_ptr<GpuDevice>> open_measured(
        const std::function<void(const std::shared_ptr<GpuDevice>&)>& measure);
    /// VulkanDevice::take_new_programs of the open device.
    std::optional<VulkanDevice::ProgramsToKeep> take_new_programs();
    /// The GPU's own name; empty before it is open.
    std::string name() const;

private:
    Result<std::shared_ptr<GpuDevice>> open_if_needed();

    const std::string request_;
    const std::vector<std::string> window_extensions_;
    mutable std::mutex mutex_;
    std::shared_ptr<GpuDevice> device_;
    std::optional<GpuFacts::Measured> measured_;
};

/// `--builder` and related options: as typed, or as resolved for a run.
struct BuilderChoice {
    /// Facts that decide which builder costs least; forces do not depend on the builder.
    struct Load {
        Scene scene;        ///< as the run applies it
        bool moves = true;  ///< the clip has more than one frame
        /// A GPU is open to draw the frames, so frames built there need no copy.
        bool drawn = false;
    };

    std::string name = "cpu";
    std::string why{};          ///< one line: why chosen by auto, or in place of the request; empty: as
                                ///< requested
    std::string gpu = "auto";   ///< as in choose_gpu; for the vulkan builder and for pictures
    bool gpu_fallback = false;  ///< no GPU was requested: fall back to the cpu builder without one

    bool names_gpu() const { return gpu != "auto"; }
};

/// The vulkan builder opens and uses `gpu`; other builders do not open it. Errors: ErrorKind::gpu with what
/// is missing if vulkan was requested and there is no such GPU; ErrorKind::usage for the lazy builder with a
/// temporal filter. A GPU lost during the run is no error: the cpu builder takes over, with a warning on
/// stderr.
Result<std::unique_ptr<SurfaceBuilder>> make_builder(const BuilderChoice& choice, const Scene& scene,
                                                     RunGpu& gpu);

/// CPU time, all threads, ms per second of the clip, of frames by the CPU builder, without hole filling,
/// which depends on the holes (constants: docs/measurements.md).
double whole_frames_ms_per_second(const BuilderChoice::Load& load);

/// Resolves `--builder auto`: cpu or vulkan, and why. `gpu_is_fast` opens a device, so it is called
/// only if whole frames cost enough for that to pay; it returns whether there is a GPU that is neither a
/// software Vulkan nor measured to be slow (is_fast_builder). Only name and why of the result are set; a
/// GPU's name and the fallback are the caller's.
BuilderChoice pick_builder(const BuilderChoice::Load& load, const std::function<bool()>& gpu_is_fast);

/// Whether a GPU builds a frame in at most twice the CPU's time (which frees the CPU), or was not measured.
/// Software Vulkan runs on the CPU, so false.
bool is_fast_builder(const GpuFacts& facts);

/// Reads commands to the clip's clock, one per line: "SECONDS play", "pause", "rate X", "seek SECONDS",
/// "step", "loop SECONDS SECONDS" or "unloop", in the order of their times (docs/touch.md). Empty lines and
/// text after '#' are ignored. Anything else is refused (ErrorKind::input) with `name` and the line.
Result<std::vector<PlaybackCommand>> parse_playback(std::string_view text, const std::string& name);
/// As parse_playback, from a file.
Result<std::vector<PlaybackCommand>> read_playback(const std::filesystem::path& file);

/// The commands as parse_playback's lines, joined by ", ".
std::string in_words(const std::vector<PlaybackCommand>& commands);

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
    std::vector<DroppedFrames> dropped{};  ///< left out by the recorded run
    /// The frames that the recorded run's planes_hash covers; nothing: not stated.
    std::optional<std::vector<FrameRun>> recorded_frames{};
    /// Frames that a temporal filter reads before an epoch's first frame.
    int warm_up_frames = temporal_warm_up_frames;

    /// The run's stated length, or that of its hand's motion; nothing: endless.
    std::optional<std::int64_t> ticks() const {
        return options.ticks || !hand ? options.ticks : hand->ticks();
    }
};

/// Group of a setting: the part of a window that shows it and what it affects.
enum class SettingOf {
    felt,     ///< how forces come about
    device,   ///< a device held by the user; no effect without one
    filters,  ///< how depth is cleaned: "filters", which sets all, and each of them
    relief,   ///< heights that are made of the clip's colour
    brush,    ///< what is painted in this window; never saved
    expert    ///< as felt, but set by options only
};

/// A row of the table of a run's settings, used by options, the window's panel, its commands and scripts, and
/// saved settings. The filters' rows come from `filter_settings`.
struct SessionSetting {
    std::string name;       ///< in commands and saved settings; with "--" as an option
    const char* what = "";  ///< description for a first-time user
    SettingOf of = SettingOf::felt;
    SettingRange range{};  ///< in a window
    /// Sets a legal value (SettingRange::value_of) in the options of a run.
    std::function<void(double value, SessionOptions& options)> set{};
    /// The run's value; null: the setting has no value of its own, like "filters".
    std::function<std::string(const TouchSetup& setup)> get{};
    std::string usual{};  ///< a number's default; empty: see `what`
    /// Range of an option's number; by default any that `validate` allows.
    struct {
        double least = std::numeric_limits<double>::lowest(), most = std::numeric_limits<double>::max();
    } typed{};
};
std::span<const SessionSetting> run_settings();
/// The settings in a window: all but SettingOf::expert.
std::span<const SessionSetting> session_settings();
/// What the setting "detail" does, for a new user.
inline constexpr const char* detail_words =
    "How much relief filters keep of noisy depth: all as recorded, noise too (1), or smooth (0). Left out: as "
    "much as can be kept with hardly more noise than with the smoothest.";
/// The session setting with that name; null: none.
const SessionSetting* session_setting(std::string_view name);

Result<std::unique_ptr<TouchSetup>> setup_from_options(const SessionOptions& options);
/// The run of `part`, which must outlive the setup, with `options.builder` and, if given, the clip and files
/// of `options.clip`. `gpu`: the previous part's; null: the run opens its own.
Result<std::unique_ptr<TouchSetup>> setup_from_recording(const RecordedPart& part,
                                                         const SessionOptions& options,
                                                         std::shared_ptr<RunGpu> gpu = nullptr);

/// The port of a live session's haptic thread: to the hand, the device it holds, or the user's device. Opens
/// the device. `setup` must outlive the port.
Result<std::unique_ptr<HapticPort>> open_port(TouchSetup& setup);

/// After a session: stores the device's reason for a failure in `facts`.
void explain_failure(const TouchSetup& setup, LiveFacts& facts);

/// A tick's goals, contacts and forces, per finger.
struct WatchedTick {
    struct Finger {
        glm::dvec3 goal{0.0};  ///< as given by the hand
        Contact contact;       ///< the goal used, proxy, whether it touches, local properties
        GuardedForce force;    ///< as sent to the hand, and why it differs from the spring's; no energy
    };
    std::int64_t tick = -1;
    std::vector<Finger> fingers;
};

/// What the hand touches at a tick, for drawing.
struct WatchedMoment {
    SurfaceTimeline::HeldPair held;    ///< its frames stay valid until the next look
    std::optional<HeldPlanes> stored;  ///< of the pair's frame nearer in time, if kept by its reader
    WatchedTick felt;                  ///< all fingers, at that tick or a few later

    PlaneView colour() const { return stored ? stored->colour : PlaneView{}; }  ///< empty: no colour
};

/// Figures of a running session.
struct WatchedFigures {
    struct Ticks {
        std::int64_t ticks = 0;
        std::int64_t late = 0;   ///< ticks that began a millisecond or more late
        double solve_us = 0;     ///< of the newest tick, us
        double late_us_p99 = 0;  ///< 99th percentile of all ticks, us, in steps of 10; 1000: that or later
    };
    FeedFigures feed;
    Ticks ticks;                   ///< so far
    std::int64_t late_frames = 0;  ///< except the two that begin an epoch
};

/// A live session on its own threads, with a watcher that draws it and commands the clip's clock. Runs until
/// stopped or until the device fails; when the clip ends or fails, its surface stands still. Never blocks the
/// haptic thread.
class WatchedSession : NonCopyable {
public:
    /// Limit of commands in a session: one every tenth of a second for an hour and a half.
    static constexpr std::size_t most_commands = 65536;

    /// Begins at once. `setup` was made for a watched live run. `sinks` get every tick on the session's own
    /// thread and must outlive it. Refused (ErrorKind::usage): playback commands of later ticks than 0, which
    /// only a run without a watcher takes.
    /// `stepped`: in virtual time, on the watcher's thread, which runs the ticks.
    static Result<std::unique_ptr<WatchedSession>> start(std::unique_ptr<TouchSetup> setup,
                                                         std::vector<TouchSink*> sinks, bool stepped = false);
    ~WatchedSession();  ///< calls stop

    /// Sends zero force, ends the threads, closes the device; the setup's settings then hold all commands.
    void stop();
    bool running() const { return running_.load(std::memory_order_acquire); }

    // One thread, the watcher's.
    /// Stepped: runs the next tick (LiveSession::run_tick); no effect after the end.
    void run_tick();
    /// Takes effect at the next tick. Refused (ErrorKind::usage): invalid commands, moments beyond the clip's
    /// end, any command to a camera or after the end, and more than `most_commands`.
    Result<void> ask(PlaybackVerb verb, std::int64_t first = 0, std::int64_t second = 0);
    /// Whether a command has yet to take effect; after the end it never will.
    bool is_asked() const { return log_->is_waiting(); }
    /// Number of commands that have taken effect.
    std::size_t commands() const { return log_->size(); }
    /// What the hand touched last; nullptr before the first tick. Waits only for a tick being copied.
    const WatchedMoment* look();

    // Any thread.
    PlaybackState playback() const;
    /// The clip's clock as applied to every tick.
    PlaybackClock clock() const { return {setup_->scene.rate, log_}; }
    WatchedFigures figures() const;
    /// As LiveSession::clip_failure.
    std::optional<Error> clip_failure() const { return live_->clip_failure(); }
    /// As ClipReader::remarks.
    std::vector<std::string> remarks() const { return setup_->feed->reader().remarks(); }
    /// silence_in_words, of the source at that moment.
    std::string silence(const WatchedMoment& moment) const;
    /// First frames after a cut, among the frames read so far.
    std::set<std::int64_t> cuts() const { return setup_->feed->cuts(); }

    // After the end.
    const LiveFacts& facts() const { return facts_; }
    /// Why it ended, unless stopped.
    std::optional<Error> failure() const { return ran_ ? facts_.failure : std::optional(ran_.error()); }
    TouchSetup& setup() { return *setup_; }

private:
    class Ticks;
    WatchedSession(std::unique_ptr<TouchSetup> setup, std::vector<TouchSink*> sinks);
    void run();
    void note_end();
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
    bool is_stopped_ = false;
    // Owned by the session's thread until it has ended.
    Result<void> ran_;
    LiveFacts facts_;
    std::thread thread_;
};

/// One finger's goals and forces.
struct Stroke {
    ForceTable forces;
    double metres_per_scene_unit = 0;
};

/// The stroke of a finger that wanders over a clip, always along the same path. Here and below the clip has
/// the filters it states, or those chosen from its first frames.
Result<Stroke> standard_stroke(std::unique_ptr<ClipReader> clip);
/// Compares the forces of two clips of the same scene: repeats the goals of a stroke over the first on the
/// second, at the same scale.
Result<ForceComparison> compare_by_stroke(const Stroke& first, std::unique_ptr<ClipReader> second);

}  // namespace touchable
