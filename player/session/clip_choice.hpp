// SPDX-License-Identifier: Apache-2.0
#pragma once

// Selects the clip that a run touches (a file, a stream or a camera) and the user's settings for it.
//
// A ClipChoice holds all of that as plain values. open_chosen opens it: a ClipReader with its decorators
// (part, far plane, relief, materials, holes filled), the scene, and the filters that the scene leaves open,
// which settle_filters chooses from the first frames. filters_in_words and the functions beside it describe
// the choice to the user. read_live_camera reads words like "v4l2:/dev/video0", and ClipChoice::choose sets
// that camera as the clip; a CameraCapture writes the camera's film beside a recording. A SharedClip lets
// several sessions of a window read one clip that is opened and decoded once.
//
// Opening may take long; a stop request to its thread (stop_requested) cancels it.
// Threads: several may use a SharedClip, one everything else unless marked "any thread".

#include <atomic>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <thread>

#include "engine/authoring/materials.hpp"
#include "engine/authoring/recorded_clip.hpp"
#include "engine/authoring/segments.hpp"
#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/base/threads.hpp"
#include "engine/camera/camera.hpp"
#include "engine/clip/clip.hpp"
#include "engine/clip/readers.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/depth_estimator.hpp"

namespace touchable {

/// Measurements of a clip's first frames and the filters chosen from them.
struct ChosenFilters {
    UnstatedFilters chosen{};               ///< filters chosen here; the scene states the others
    std::optional<MeasuredDepth> measured;  ///< nothing: no pixel is valid
    std::string damage{};                   ///< why the frames ended early; empty: complete
};
/// Measures only; `chosen` stays empty. The reader must be at the beginning and is rewound afterwards.
Result<ChosenFilters> measure_depth(std::unique_ptr<ClipReader>& reader, const Scene& scene);
/// Chooses the scene's unstated filters (choose_filters) and measures the levels that terrace removal needs.
/// Returns nothing, without reading a frame, if nothing is open. `known`: an earlier measurement; nothing:
/// measure now.
Result<std::optional<ChosenFilters>> settle_filters(std::unique_ptr<ClipReader>& reader,
                                                    const UnstatedFilters& unstated, Scene& scene,
                                                    const std::optional<ChosenFilters>& known = {});

/// Of depth too far away (MeasuredDepth::trusted_to).
inline constexpr const char* not_trusted_words = "its force cannot be trusted";
/// Whether error bars (ErrorSigns) hold at this depth, scene units.
inline bool error_bars_hold(const MeasuredDepth& measured, const FilterSettings& filter, double depth) {
    return depth <= measured.error_bars_to(filter);
}

/// MeasuredDepth::error_bars_to; 0: nothing was measured.
inline double error_bars_to(const std::optional<ChosenFilters>& chosen, const FilterSettings& filter) {
    return chosen && chosen->measured ? chosen->measured->error_bars_to(filter) : 0;
}

/// The filters of a scene and the reason for each: "terraces (levels 11.4 mm apart at 2 m), temporal for 3.2
/// mm (noise 2.1 mm), no median (roughness 0.1 mm, 0.02 of a pixel's width)"; "stated" is the reason of
/// filters that were not chosen.
std::string filters_in_words(const Scene& scene, const std::optional<ChosenFilters>& chosen);
/// "12.3 mm apart at 1.86 m (kappa 3.47)".
std::string levels_in_words(const MeasuredDepth& measured, double metres_per_unit);
/// "2.1 mm from frame to frame, 5 mm at edges; roughness 0.31 mm", or that none was found.
std::string noise_in_words(const MeasuredDepth& measured, double metres_per_unit);

/// Writes a camera's frames to a clip (the film), so that a run can be replayed without the camera: frame n
/// of the clip is the n-th frame passed to `keep`. Depth is lossless. A thread of its own writes it. If the
/// disk becomes full the film ends there and later frames are dropped.
class CameraCapture : NonCopyable {
public:
    /// The camera's number and time of a frame.
    struct Frame {
        std::int64_t number = 0, time_ns = 0;
        bool operator==(const Frame&) const = default;
    };
    using Frames = std::vector<Frame>;

    /// `described`: the camera.
    explicit CameraCapture(SceneDescription described) : described_(std::move(described)) {}
    /// Without `finish` no file is left.
    ~CameraCapture() { stop(); }

    /// Opens the file and writes the frames kept so far to it. Call once.
    Result<void> open(const std::filesystem::path& file, Existing existing);
    /// Called by the reading thread. Blocks while the disk is far behind; the camera's frames meanwhile are
    /// lost.
    Result<void> keep(const RawFrame& frame);
    /// Why the film gets no more frames. Any thread.
    std::optional<Error> fault() const;
    /// Call in place of `open` to keep nothing.
    void give_up(const Error& why);
    /// Completes the film after the last `keep`. After a fault there may be no film and no frames.
    Result<void> finish();

    const std::filesystem::path& file() const { return file_; }
    /// All frames kept; valid after `finish`.
    const Frames& frames() const { return frames_; }
    /// The camera's number of the last frame kept; -1: none.
    std::int64_t last_frame() const { return frames_.empty() ? -1 : frames_.back().number; }

private:
    void write();
    void stop() { stop_thread(mutex_, ended_, changed_, thread_); }

    const SceneDescription described_;
    std::filesystem::path file_;
    Frames frames_;
    std::unique_ptr<ClipWriter> writer_;
    std::thread thread_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<RawFrame> waiting_;  // guarded by mutex_, like the members below
    bool open_ = false, ended_ = false;
    std::optional<Error> failure_;
    std::size_t written_ = 0;  // frames
    bool is_broken_ = false;   // the failure left a file that cannot be completed
};

/// Path of the film of a recording's first, second ... part, beside it: "run.rec.mkv", "run.rec.2.mkv".
std::filesystem::path film_beside(std::filesystem::path record, int part = 1);

/// The camera; every frame read from it is also kept in `film`.
std::unique_ptr<ClipReader> with_film(std::unique_ptr<ClipReader> camera,
                                      std::shared_ptr<CameraCapture> film);

/// Replays a film with the numbers and times of its camera's frames. `file`: its name in messages.
Result<std::unique_ptr<ClipReader>> make_filmed_camera(std::unique_ptr<ClipReader> film,
                                                       CameraCapture::Frames frames,
                                                       const std::filesystem::path& file);

/// One clip shared by several runs, at once or in turn, such as a window's runs with different settings. The
/// clip is opened once. Its newest frames are cached, so that a run that begins where another run is decodes
/// nothing. The clip stays open until this object and the last reader are gone. For a camera use
/// SharedCamera.
class SharedClip : public std::enable_shared_from_this<SharedClip> {
public:
    using Open = std::function<Result<std::unique_ptr<ClipReader>>()>;
    /// A run's own reader, at the clip's beginning. The first call opens the clip, which must not be a live
    /// source, with `open_clip`; later calls do so only if that failed. One call at a time. Several readers
    /// may read at once, each on its own thread.
    Result<std::unique_ptr<ClipReader>> open(const Open& open_clip);
    /// The first frames have been measured (DepthEstimator), so they are cached no longer than others.
    void forget_first_frames() {
        keeps_first_ = false;  // the next read frees them, possibly much later
    }

    /// The measured range of the clip's relief: valid for every amount and height. Any thread.
    using Bands = decltype(ReliefSettings::bands);
    std::optional<ReliefRange> relief_range(const Bands& bands) const;
    void keep_relief_range(const Bands& bands, const ReliefRange& range) {
        const std::lock_guard lock(relief_mutex_);
        relief_ranges_[bands] = range;
    }

private:
    class Reader;
    Result<std::optional<RawFrame>> frame(std::int64_t number, bool is_from_the_beginning);
    const RawFrame* kept(std::int64_t number, bool is_from_the_beginning) const;
    void keep(const RawFrame& frame);

    std::unique_ptr<ClipReader> clip_;
    std::mutex mutex_;
    // Guarded by mutex_, as is reading from the clip.
    std::optional<std::int64_t> position_;  // number of the clip's next frame; nothing: unknown
    std::deque<RawFrame> newest_;           // the frames read last
    std::size_t newest_bytes_ = 0;
    std::vector<RawFrame> first_;  // from 0 on
    std::size_t first_bytes_ = 0;
    std::atomic<bool> keeps_first_{true};
    mutable std::mutex relief_mutex_;
    std::map<Bands, ReliefRange> relief_ranges_;  // guarded by relief_mutex_
};

/// Relief to be made from a clip's colour.
struct ReliefChoice {
    ReliefSettings settings{};
    double height_mm = 0.5;    ///< from the deepest to the highest
    bool is_of_world = false;  ///< height_mm is in the recorded world, not in the hand
};

/// The clip with relief in place of its own heights (with_relief). `clip` is at its beginning; a live source
/// is refused (ErrorKind::usage). `shared`: caches the measured range; nullptr: no cache.
Result<std::unique_ptr<ClipReader>> with_chosen_relief(std::unique_ptr<ClipReader> clip,
                                                       const ReliefChoice& choice,
                                                       SharedClip* shared = nullptr);

/// A clip and the user's settings that override its own. An empty optional: the clip's own.
struct ClipChoice {
    /// A camera as named by the user: plugged in, a program that sends frames, a stream, or a recording
    /// played as a camera.
    struct LiveCamera {
        std::optional<PluggedChoice> plugged{};
        std::filesystem::path recording;
        CameraDelivery delivery;
    };
    /// The user's filter settings. Filters neither stated nor to be measured keep the clip's own settings.
    struct Filters {
        FilterSettings settings{};  ///< values of the stated filters; levels and terrace_noise are ignored
        FilterSet stated{}, measured{};  ///< no filter is in both; a detail opens smoothing not stated here

        /// Every filter of `--filters`, off.
        static Filters off();
        /// Sets one filter from a typed word; false: invalid word.
        bool state(const FilterSetting& setting, std::string_view word) {
            stated.*setting.open = true;
            return setting.read(word, settings);
        }
    };
    /// A clip at its beginning.
    struct Opened {
        std::unique_ptr<ClipReader> reader;
        Scene scene;                            ///< as the run applies it
        std::optional<ChosenFilters> chosen{};  ///< nothing: all filters were stated
    };

    std::filesystem::path file;
    std::optional<std::filesystem::path> scene_file;
    SourceDescription camera;         ///< of pictures without a scene file
    StillMaps maps;                   ///< in place of what it has itself
    Filters filters, single_filters;  ///< all at once; single filters, applied after
    std::optional<FrameInterpolation> interpolation;
    DepthAlignment alignment = DepthAlignment::automatic;  ///< of depth without a scale
    bool fill_from_motion = false;                         ///< fill holes from frames that saw behind them
    std::optional<ReliefChoice> relief;  ///< made from the clip's colour, replaces its heights
    /// Materials of its segments, replacing the clip's own; null: the clip's own.
    std::shared_ptr<const PaintedSegments> painted;
    std::optional<ChosenFilters> measured;    ///< earlier measure_depth result; nothing: measure again
    std::optional<CameraDelivery> as_camera;  ///< plays the clip as a camera
    std::optional<PluggedChoice> plugged;     ///< the clip is a camera; `file` is its name
    // Kept open between runs; null: each run opens its own.
    std::shared_ptr<SharedCamera> shared_camera;  ///< of `plugged`
    std::shared_ptr<SharedClip> shared_clip;      ///< for a clip that is not a camera; as first opened
    std::optional<CameraCapture::Frames> filmed;  ///< the clip is a camera's film; these are the frames

    /// Sets the camera as the clip to touch.
    void choose(const LiveCamera& camera);
    bool is_camera() const { return plugged || as_camera; }
    /// From now on this choice and its copies open the clip once; no effect for a camera.
    void share_clip() {
        if (!is_camera() && !shared_clip) shared_clip = std::make_shared<SharedClip>();
    }
    /// The clip, from its beginning.
    Result<std::unique_ptr<ClipReader>> open(Colour colour = Colour::wanted) const;

private:
    /// The clip without relief and painted materials.
    Result<std::unique_ptr<ClipReader>> open_stored(Colour colour) const {
        if (!shared_clip) return open_anew(colour);
        return shared_clip->open([this, colour] { return open_anew(colour); });
    }
    Result<std::unique_ptr<ClipReader>> open_anew(Colour colour) const;
};

/// What read_live_camera takes, without keys: "v4l2:/dev/videoN", ...
std::vector<std::string> camera_words();
/// Reads "v4l2:NODE[,key=value...]", "pipe:CMD", "tcp://HOST:PORT", "stream:ADDRESS" or
/// "replay:PATH[,key=value...]" (docs/streaming.md); PATH ends with the first comma. Starts and opens
/// nothing. Other text is refused (ErrorKind::usage) with the valid forms.
Result<ClipChoice::LiveCamera> read_live_camera(const std::string& words);

/// Opens the clip; colour is decoded only if wanted. Settings that the clip does not allow are refused
/// (ErrorKind::usage).
Result<ClipChoice::Opened> open_chosen(const ClipChoice& choice, Colour colour);

/// The same clip with the depth that its filters leave (with_filtered_depth), and the scene of that.
Result<ClipChoice::Opened> open_filtered(const ClipChoice& choice, Colour colour);

/// The segments of all frames of a clip. Uses its own reader, so that it does not make a run over the clip
/// seek. `progress`: as in read_segments. A camera is refused (ErrorKind::usage). Takes long.
Result<SegmentStore> read_chosen_segments(const ClipChoice& choice,
                                          const std::function<void(std::int64_t frame)>& progress);

/// The user's clip settings on which segments depend, as text: equal text, equal segments. Empty: none set.
std::string segments_depend_on(const ClipChoice& choice);

}  // namespace touchable
