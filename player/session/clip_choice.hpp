#pragma once

// Which clip a run touches, and as what: a file, a stream or a camera, and what a person says of it.
//
// A ClipChoice is all of that in plain values. open_chosen opens it: a ClipReader with its readers around it
// (part, far plane, relief, materials, holes filled), the scene, and the filters that the scene leaves open,
// which settle_filters chooses by the first frames. filters_in_words and the functions beside it say to a
// person what was chosen. read_live_camera reads words like "v4l2:/dev/video0", and ClipChoice::take touches
// that camera; a CameraCapture writes the camera's film beside a recording. A SharedClip lets several
// sessions of a window read one clip that is opened and decoded once.
//
// Opening may take long; it ends once its thread is asked to stop (stop_requested). A SharedClip may be used
// by several threads, everything else by one, but for what says "any thread".

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
#include "engine/camera/camera.hpp"
#include "engine/clip/clip.hpp"
#include "engine/clip/readers.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/depth_estimator.hpp"

namespace touchable {

/// What the first frames say of a clip, and the filters that were chosen by it.
struct ChosenFilters {
    UnstatedFilters chosen{};               ///< which were; the others are what the scene states
    std::optional<MeasuredDepth> measured;  ///< nothing: no pixel is valid
    std::string damage{};                   ///< why the frames ended early; empty: they did not
};
/// Measures and chooses nothing (`chosen` stays empty). Needs a reader at the beginning, and leaves one that
/// is there again.
Result<ChosenFilters> measure_depth(std::unique_ptr<ClipReader>& reader, const Scene& scene);
/// Settles in the scene what is unstated (choose_filters), and levels that terrace removal needs. Nothing
/// where nothing is open: then no frame is read. `known`: what was measured before; nothing: measure now.
Result<std::optional<ChosenFilters>> settle_filters(std::unique_ptr<ClipReader>& reader,
                                                    const UnstatedFilters& unstated, Scene& scene,
                                                    const std::optional<ChosenFilters>& known = {});

/// The filters of a scene and the reason for each: "terraces (levels 11.4 mm apart at 2 m), temporal for 3.2
/// mm (noise 2.1 mm), no median (roughness 0.1 mm, 0.02 of a pixel's width)"; "stated" is the reason of those
/// that were not chosen.
std::string filters_in_words(const Scene& scene, const std::optional<ChosenFilters>& chosen);
/// "12.3 mm apart at 1.86 m (kappa 3.47)".
std::string levels_in_words(const MeasuredDepth& measured, double metres_per_unit);
/// "2.1 mm from frame to frame, 5 mm at edges; roughness 0.31 mm", or that none was found.
std::string noise_in_words(const MeasuredDepth& measured, double metres_per_unit);

/// Keeps what a camera gave as a clip, so that what was felt can be repeated without it: frame n of the clip
/// is the n-th that was given. Depth keeps every value. It is written by a thread of its own. Where its disk
/// becomes full it ends there, and what is given after that is not kept.
class CameraCapture : NonCopyable {
public:
    /// A frame that a camera gave.
    struct Frame {
        std::int64_t number = 0, time_ns = 0;
        bool operator==(const Frame&) const = default;
    };
    using Frames = std::vector<Frame>;

    /// `described`: the camera.
    explicit CameraCapture(SceneDescription described) : described_(std::move(described)) {}
    ~CameraCapture();  ///< without `finish` nothing is left behind

    /// Where it goes, and that of frames that were kept before. Once.
    Result<void> open(const std::filesystem::path& file, Existing existing);
    /// By the thread that reads. Waits while the disk is far behind; the camera's frames meanwhile are lost.
    Result<void> keep(const RawFrame& frame);
    /// Why it gets no more frames; any thread.
    std::optional<Error> fault() const;
    /// In place of `open`: nothing is kept.
    void give_up(const Error& why);
    /// Completes it, once no more is kept. Where it has a fault there may be none, without any frame.
    Result<void> finish();

    const std::filesystem::path& file() const { return file_; }
    /// All that were kept; once it is finished.
    const Frames& frames() const { return frames_; }
    /// The number of the last of them; -1: there is none.
    std::int64_t last_frame() const { return frames_.empty() ? -1 : frames_.back().number; }

private:
    void write();
    void stop();

    const SceneDescription described_;
    std::filesystem::path file_;
    Frames frames_;
    std::unique_ptr<ClipWriter> writer_;
    std::thread thread_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<RawFrame> waiting_;  // guarded by mutex_, as are those below
    bool open_ = false, ended_ = false;
    std::optional<Error> failure_;
    std::size_t written_ = 0;  // frames
    bool is_broken_ = false;   // by the failure: it cannot be completed
};

/// Where the film of a recording's first, second ... part is: beside it, "run.rec.mkv", "run.rec.2.mkv".
std::filesystem::path film_beside(std::filesystem::path record, int part = 1);

/// A camera whose frames are kept as they are given.
std::unique_ptr<ClipReader> with_film(std::unique_ptr<ClipReader> camera,
                                      std::shared_ptr<CameraCapture> film);

/// A film in place of its camera: its frames have the camera's numbers and times. `file`: as messages call
/// it.
Result<std::unique_ptr<ClipReader>> make_filmed_camera(std::unique_ptr<ClipReader> film,
                                                       CameraCapture::Frames frames,
                                                       const std::filesystem::path& file);

/// One clip for several runs over it, at once or one after the other, such as those of one window by other
/// settings. The clip is opened once. Its newest frames are kept, so that a run that begins where another one
/// is decodes nothing. The clip stays open until this and the last reader are gone. Of a camera it is
/// SharedCamera.
class SharedClip : public std::enable_shared_from_this<SharedClip> {
public:
    using Open = std::function<Result<std::unique_ptr<ClipReader>>()>;
    /// A reader of its own for a run, at the clip's beginning. The first call opens the clip, which must not
    /// be a live source, by `open_clip`; later ones do so only where that failed. One call at a time. Several
    /// readers may read at once, each on a thread.
    Result<std::unique_ptr<ClipReader>> open(const Open& open_clip);
    /// What the first frames can tell (DepthEstimator) is known: they are kept no longer than others.
    void forget_first_frames() {
        keeps_first_ = false;  // the next read lets go of them: it may take long until then
    }

    /// What was learned of the clip's relief: another amount or height needs no second look. Any thread.
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
    // Guarded by it, as is reading from the clip.
    std::optional<std::int64_t> position_;  // the frame that the clip gives next; nothing: not known
    std::deque<RawFrame> newest_;           // of those that were read, the last
    std::size_t newest_bytes_ = 0;
    std::vector<RawFrame> first_;  // from 0 on
    std::size_t first_bytes_ = 0;
    std::atomic<bool> keeps_first_{true};
    std::atomic<int> readers_{0};
    mutable std::mutex relief_mutex_;
    std::map<Bands, ReliefRange> relief_ranges_;  // guarded by that
};

/// Relief that a person wants of a clip's colour.
struct ReliefChoice {
    ReliefSettings settings{};
    double height_mm = 0.5;    ///< from the deepest to the highest
    bool is_of_world = false;  ///< of what was recorded, not of the hand
};

/// The clip with relief in place of its own heights (with_relief). `clip` is at its beginning, and no live
/// source (ErrorKind::usage). `shared`: remembers what was learned of that clip; nullptr: nothing does.
Result<std::unique_ptr<ClipReader>> with_chosen_relief(std::unique_ptr<ClipReader> clip,
                                                       const ReliefChoice& choice,
                                                       SharedClip* shared = nullptr);

/// Filters as a person wants them. What is neither stated nor to be measured is the clip's own.
struct FiltersChoice {
    FilterSettings settings{};       ///< of those that are stated; levels and terrace_noise do not count
    FilterSet stated{}, measured{};  ///< no filter is in both

    /// All that `--filters` knows, off.
    static FiltersChoice off();
    /// States one by the word that a person typed, or refuses that by false.
    bool state(const FilterSetting& setting, std::string_view word) {
        stated.*setting.open = true;
        return setting.read(word, settings);
    }
};

/// A clip, and what a person wants of it instead of what it says itself. Nothing: the clip's own.
struct ClipChoice {
    /// A camera, as a person names one: one that is plugged in, a program that sends its frames, a stream, or
    /// a recording that behaves like one.
    struct LiveCamera {
        std::optional<PluggedChoice> plugged{};
        std::filesystem::path recording;
        CameraDelivery delivery;
    };
    /// A clip at its beginning.
    struct Opened {
        std::unique_ptr<ClipReader> reader;
        Scene scene;                            ///< as the run applies it
        std::optional<ChosenFilters> chosen{};  ///< nothing: all filters were stated
    };

    std::filesystem::path file;
    std::optional<std::filesystem::path> scene_file;
    std::optional<SourceDescription> camera;  ///< of pictures without a scene file
    StillMaps maps;                           ///< in place of what it has itself
    FiltersChoice filters, single_filters;    ///< all at once; one by one, which count last
    std::optional<FrameInterpolation> interpolation;
    DepthAlignment alignment = DepthAlignment::automatic;  ///< of depth without a scale
    bool fill_from_motion = false;                         ///< holes, from frames that saw what is behind
    std::optional<ReliefChoice> relief;  ///< made of its colour, in place of the heights that it has
    /// What its segments feel like, in place of what it says itself; null: as it says.
    std::shared_ptr<const PaintedSegments> painted;
    std::optional<ChosenFilters>
        measured;  ///< what its first frames said before (measure_depth); nothing: look again
    std::optional<CameraDelivery> as_camera;  ///< the clip is the recording that behaves like one
    std::optional<PluggedChoice> plugged;     ///< the clip is a camera, and `file` its name
    // What stays open from run to run; nothing: each opens its own.
    std::shared_ptr<SharedCamera> shared_camera;  ///< of `plugged`
    std::shared_ptr<SharedClip> shared_clip;      ///< of a clip that is no camera; as it was first opened
    std::optional<CameraCapture::Frames> filmed;  ///< the clip is the film of a camera that gave these frames

    /// What is touched is a camera.
    void take(const LiveCamera& camera);
    bool is_camera() const { return plugged || as_camera; }
    /// From now on, and for copies of this choice, the clip is opened once; does nothing of a camera.
    void share_clip() {
        if (!is_camera() && !shared_clip) shared_clip = std::make_shared<SharedClip>();
    }
    /// The clip, from its beginning.
    Result<std::unique_ptr<ClipReader>> open(Colour colour = Colour::wanted) const;

private:
    Result<std::unique_ptr<ClipReader>> open_relief(Colour colour) const;
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
/// nothing. Refuses (ErrorKind::usage) what is no such description, and names what would be right.
Result<ClipChoice::LiveCamera> read_live_camera(const std::string& words);

/// Opens the clip; colour is decoded only where it is wanted. Refused (ErrorKind::usage) where what is wanted
/// does not go with the clip.
Result<ClipChoice::Opened> open_chosen(const ClipChoice& choice, Colour colour);

/// The segments of all frames of a clip, by a reader of its own, so that a run over it is not led to and
/// fro. `progress` as read_segments has it. Refused (ErrorKind::usage) of a camera. Takes long.
Result<SegmentStore> read_chosen_segments(const ClipChoice& choice,
                                          const std::function<void(std::int64_t frame)>& progress);

/// What a person said of the clip on which its segments depend, so that they are the same where it is; empty:
/// nothing.
std::string segments_depend_on(const ClipChoice& choice);

}  // namespace touchable
