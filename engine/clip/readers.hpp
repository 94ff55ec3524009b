#pragma once

// What readers of clips are made of: readers around a reader, and the parts of a live one.
//
// A reader around another one takes it over and is itself a clip: a part of it, with planes that stay the
// same under every frame, with a far plane that was found in its frames, with depth of one scale, or as a
// camera would give it. part_of_clip, with_far_plane and with_aligned_depth hand the clip on unchanged
// where nothing is to be done; a class of another module derives from ReaderAround, or from ChangedClip,
// and overrides what it changes. Prefetch keeps the first frames that it read (up to 512 MiB), so that they
// are not decoded twice.
//
// A LiveReader is the base of every source whose frames come as they are taken: a camera, a program that
// sends framesets, a stream. Its sources turn bytes into frames; numbers, times, waiting, stopping, and what
// a person reads of it are here.
//
// As every reader, each is used by one thread at a time; what may be called from any thread says so.

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <span>
#include <utility>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"

namespace touchable {

/// A reader around another one, which it is like but for what a class derived from this changes.
class ReaderAround : public ClipReader {
public:
    const Scene& scene() const override { return reader_->scene(); }
    UnstatedFilters unstated_filters() const override { return reader_->unstated_filters(); }
    const std::vector<TrackInfo>& tracks() const override { return reader_->tracks(); }
    std::optional<std::int64_t> frame_count() const override { return reader_->frame_count(); }
    const std::vector<std::string>& notes() const override { return reader_->notes(); }
    std::span<const Camera> frame_cameras() const override { return reader_->frame_cameras(); }
    Result<std::optional<RawFrame>> next() override { return reader_->next(); }
    Result<void> rewind() override { return seek(0); }
    Result<void> seek(std::int64_t frame) override { return reader_->seek(frame); }
    std::int64_t access_point(std::int64_t frame) const override { return reader_->access_point(frame); }
    void leave_out_colour() override { reader_->leave_out_colour(); }
    bool is_live() const override { return reader_->is_live(); }
    Result<void> begin(std::chrono::steady_clock::time_point zero) override { return reader_->begin(zero); }
    std::int64_t taken_before(std::int64_t frame) const override { return reader_->taken_before(frame); }
    std::optional<std::int64_t> taken_at(std::int64_t frame) const override {
        return reader_->taken_at(frame);
    }
    std::vector<std::string> remarks() const override { return reader_->remarks(); }
    std::optional<StreamFigures> stream_figures() const override { return reader_->stream_figures(); }

protected:
    explicit ReaderAround(std::shared_ptr<ClipReader> reader) : reader_(std::move(reader)) {
        for (const auto& input : reader_->inputs()) add_input(input);
    }
    ClipReader& inner() const { return *reader_; }

private:
    std::shared_ptr<ClipReader> reader_;
};

/// A reader around another one that tells of itself what a class derived from this changes: scene, tracks and
/// notes begin as the other's.
class ChangedClip : public ReaderAround {
public:
    const Scene& scene() const override { return scene_; }
    const std::vector<TrackInfo>& tracks() const override { return tracks_; }
    const std::vector<std::string>& notes() const override { return notes_; }

protected:
    explicit ChangedClip(std::unique_ptr<ClipReader> clip)
        : ReaderAround(std::move(clip)),
          scene_(inner().scene()),
          tracks_(inner().tracks()),
          notes_(inner().notes()) {}
    /// Puts a track where the order of roles has it, in place of the one of its role. Whether there was one.
    bool replace_track(PlaneRole role, TrackInfo track);
    /// Forgets what was said of a plane that is not there any more, or of there being none.
    void forget_notes_of(PlaneRole role);

    Scene scene_;
    std::vector<TrackInfo> tracks_;
    std::vector<std::string> notes_;
};

/// Which frames and pixels of a clip.
struct ClipPart {
    /// Columns x to x + width - 1, rows y to y + height - 1.
    struct Crop {
        int x = 0, y = 0, width = 0, height = 0;
    };

    std::int64_t first = 0;
    std::optional<std::int64_t> last{};  ///< inclusive; nothing: the clip's last
    std::int64_t every = 1;              ///< the first, and then each so many frames later
    std::optional<Crop> crop{};

    bool is_whole() const { return first == 0 && !last && every == 1 && !crop; }
};

/// A reader of a part of a clip, as a clip: its frames are numbered from 0, at the rate that is left of the
/// clip's; where it is cropped the camera's principal point moves, so that every pixel that is left stays
/// where it was in the world. Refused (ErrorKind::usage) where the clip has no such frame or pixel.
Result<std::unique_ptr<ClipReader>> part_of_clip(std::unique_ptr<ClipReader> clip, const ClipPart& part);

/// A picture that serves all frames of a clip.
struct StillPlane {
    PlaneRole role = PlaneRole::haptic;
    Plane plane;                                 ///< of any size: as stored, or resampled already
    TrackInfo info;                              ///< how it is stored
    std::vector<std::filesystem::path> files{};  ///< that it was read from, the one that was named first
    std::vector<std::string> notes{};
    /// Where it changes: the plane in a frame, which fits the scene, by its number and time.
    std::function<Result<Plane>(std::int64_t frame, std::int64_t time_ns)> at{};
};

/// The clip with these planes under every frame, in place of its own of their roles. `scene` is the clip's
/// but for what the planes mean: haptic ranges, height coding and what makes room for heights. Refused where
/// that cannot be, or a plane does not fit it.
Result<std::unique_ptr<ClipReader>> with_still_planes(std::unique_ptr<ClipReader> clip,
                                                      std::vector<StillPlane> planes, const Scene& scene);

/// A clip of which the next frames, so far its first ones, were read already: `next` gives them before it
/// reads on.
std::unique_ptr<ClipReader> with_prefetched_frames(std::unique_ptr<ClipReader> clip,
                                                   std::vector<RawFrame> frames);

/// Looks ahead in a clip that is at its beginning, and keeps its first frames for when it is played.
class Prefetch {
public:
    explicit Prefetch(std::unique_ptr<ClipReader> clip) : clip_(std::move(clip)) {}

    /// The next of the first frames.
    Result<std::optional<RawFrame>> next();
    /// A later one, which is not kept. After it no `next`.
    Result<std::optional<RawFrame>> at(std::int64_t frame);
    const ClipReader& clip() const { return *clip_; }
    /// The clip, at its beginning again. Once.
    Result<std::unique_ptr<ClipReader>> finish();

private:
    static constexpr std::size_t most_bytes = std::size_t{512} << 20;  // 25 frames of 1920x1080, all planes

    std::unique_ptr<ClipReader> clip_;
    std::vector<RawFrame> frames_;  // empty where they took too much memory
    std::size_t bytes_ = 0;
    std::int64_t number_ = 0;  // of the frame that `next` gives
    bool has_moved_ = false, is_damaged_ = false;
};

/// The frames of a clip that tell what is to be known of all of them: the first ones, and as many more that
/// are spread over the rest. However long a clip is, to know it takes no longer.
inline constexpr std::int64_t first_frames = 16, spread_frames = 16;
/// Their numbers, ascending, in a clip of `count` frames of which each can be read on its own.
std::vector<std::int64_t> telling_frames(std::int64_t count);

/// A clip at its beginning. Where its description leaves the far plane open
/// (SceneDescription::Unstated::far), so that it is the deepest code's so far, it is settled, and a note says
/// it; otherwise the clip is unchanged. The far plane is 5 % beyond the depth that at most one valid pixel in
/// 10 000 exceeds, in the frames that tell (telling_frames); of a clip that cannot seek, the first ones. What
/// lies beyond it is invalid. A later frame that is damaged tells nothing: the error comes when it is played.
/// An error where no depth is valid. Errors name `file`.
Result<std::unique_ptr<ClipReader>> with_far_plane(std::unique_ptr<ClipReader> clip, bool far_is_open,
                                                   const std::filesystem::path& file);

/// Whether depth without a scale gets one for all frames. Automatic: where it pumps, which some frames tell.
enum class DepthAlignment { automatic, on, off };

/// The clip with codes of one scale for all frames, of 16 bits: near and far are those of the whole clip.
/// All its frames are read once before, so that a frame is the same whichever frames were read before it;
/// where depth does not pump (automatic), and of a clip of one frame, it is the clip as it was. A note says
/// how far what stands still moved, before and after. Refused (`on`) where codes are not evenly spaced in
/// depth or in 1 / depth. The clip is at its beginning, before and after, with its colour.
Result<std::unique_ptr<ClipReader>> with_aligned_depth(std::unique_ptr<ClipReader> clip,
                                                       DepthAlignment wanted);

/// A frame as some thousand cells, in which noise is averaged out: 640x480 pixels are 80x60.
struct CellPicture {
    static constexpr std::int32_t per_code = 16, per_level = 16;
    static constexpr std::int32_t none = -1;
    /// A square of pixels.
    struct Cell {
        /// Mean code, sixteenths; none: of two surfaces, or with a pixel without depth.
        std::int32_t depth = none;
        std::int32_t luma = none;  ///< mean brightness, sixteenths of 255 levels; none: without colour
        bool is_textured = false;  ///< its brightness tells whether what is there moves
    };

    std::vector<Cell> cells;
    bool has_colour = false;
    std::uint16_t least = 0, most = 0;  ///< valid codes; 0 and 0 where there are none
};
CellPicture cell_picture(const RawFrame& frame, const DepthCoding& coding);

/// The time of std::chrono::steady_clock, ns.
inline std::int64_t steady_ns_of(std::chrono::steady_clock::time_point moment) {
    return std::chrono::nanoseconds(moment.time_since_epoch()).count();
}
inline std::int64_t steady_now_ns() {
    return steady_ns_of(std::chrono::steady_clock::now());
}

/// Frames of before a run are so far apart.
inline constexpr std::int64_t ns_before_a_run = 1000;

/// "3 of the stream's framesets came late", behind the other remarks; nothing where there is none of them.
void add_count(std::vector<std::string>& remarks, std::int64_t count, const std::string& of_what);

/// A source whose frames come as they are taken, as a clip without an end. A derived class makes frames of
/// the source's bytes: `take` looks what is there, `wait` waits for more. The rest is the same for every
/// source:
///
/// - Before a run each frame is given, in order, and one must come within the source's patience
///   (`nothing_came`). In a run the newest one is given, and waited for as long as the run lasts.
/// - Numbers: before a run one after the other. In it the source's count tells what was left out; where that
///   stands still, begins anew or leaps by more than a million, the next number follows.
/// - Times: of before a run `ns_before_a_run` apart. In a run they count from its time 0 and never go back;
///   what was taken before it is left out until the run's first frame has come.
/// - The end: a source that is `gone` gives no more frames, its last one stands still, and a remark says why;
///   before a run that is an error. A stop of the thread that reads (stop_requested) ends its waits within
///   20 ms. After a run another may begin.
///
/// One thread, but where ClipReader says that any may call.
class LiveReader : public ClipReader {
public:
    /// What its frames mean, and files that were read to know it.
    struct Meaning {
        Scene scene;
        UnstatedFilters unstated_filters{};
        std::vector<std::filesystem::path> inputs{};
    };

    const Scene& scene() const final { return scene_; }
    UnstatedFilters unstated_filters() const final { return unstated_filters_; }
    const std::vector<TrackInfo>& tracks() const final { return tracks_; }
    std::optional<std::int64_t> frame_count() const final { return std::nullopt; }
    const std::vector<std::string>& notes() const final { return notes_; }
    Result<std::optional<RawFrame>> next() final;
    Result<void> rewind() final { return seek(0); }
    Result<void> seek(std::int64_t frame) final;
    bool is_live() const final { return true; }
    Result<void> begin(std::chrono::steady_clock::time_point zero) final;
    std::int64_t taken_before(std::int64_t frame) const final;
    std::vector<std::string> remarks() const override;

protected:
    using Moment = std::chrono::steady_clock::time_point;
    /// A frame as the source has it.
    struct Taken {
        std::uint32_t count = 0;  ///< by the source, of 32 bits
        std::int64_t at_ns = 0;   ///< its time, of std::chrono::steady_clock
        std::int64_t way_ns = 0;  ///< how long before that it was taken (taken_before)
        RawFrame frame{};         ///< planes alone
    };
    using MaybeTaken = Result<std::optional<Taken>>;

    /// `name`: of the source, in messages; `kind`: what these call it, where it is no camera.
    explicit LiveReader(std::string name, std::string kind = "camera")
        : name_(std::move(name)), kind_(std::move(kind)) {}

    /// A frame that is there: before a run the oldest, in it the newest; nothing where none is. Never waits.
    /// Where no more will come, `gone`. An error ends this `next` alone.
    virtual MaybeTaken take() = 0;
    /// Waits until there may be a frame, at most for `stop_look`.
    virtual void wait() = 0;
    /// Before a run, once no frame has come since then: an error where that is too long.
    virtual std::optional<Error> nothing_came(Moment since) const = 0;
    /// A run begins: what has waited for it is of before, where its time does not tell.
    virtual void drain() { (void)take(); }

    bool has_begun() const { return zero_ns_.has_value(); }
    /// No more will come; `why` goes on from the source's name.
    MaybeTaken gone(const std::string& why);
    void remark(std::string words);
    void take_meaning(Meaning meaning);
    /// What `next` will give, before the run: for a source that looks at its first frames.
    Result<Taken> first_frame();

    const std::string name_;
    Scene scene_;
    std::vector<TrackInfo> tracks_;
    std::vector<std::string> notes_;
    /// Frames that remarks count.
    std::atomic<std::int64_t> damaged_{0}, repeated_{0};

private:
    struct Place {
        std::int64_t number = 0, time_ns = 0;
    };
    MaybeTaken wait_for_frame();
    std::optional<Place> place(const Taken& taken);

    const std::string kind_;
    UnstatedFilters unstated_filters_;
    bool is_gone_ = false;
    std::int64_t next_number_ = 0;
    std::optional<std::uint32_t> last_count_;  // of a frame of the run
    std::optional<std::int64_t> zero_ns_;
    std::int64_t last_time_ns_ = -1;
    struct Way {
        std::int64_t frame = -1, ns = 0;
    };
    mutable std::mutex mutex_;
    // Guarded by it.
    std::vector<std::string> remarks_;
    std::array<Way, 128> ways_;  // of the newest frames, from being taken to their time
};

/// When framesets of a sender were taken, and are shown so that most of them are there in time and none waits
/// longer than it must. The shortest way of the last seconds tells how the sender's clock stands to ours, and
/// is followed as they drift apart. How much longer others take is their jitter: all wait so long as nearly
/// all of the last ones took (97 of 100). That rises at once and falls slowly, up to a bound. A clock that
/// jumps, forward, back or by years, begins anew with the frameset that says so; of one that stands still
/// every frameset counts from its arrival. Reads no clock, as SegmentPace: both are functions of what they
/// are given.
class JitterBuffer {
public:
    /// The longest that a frameset waits for others' sake, and the longest way that is believed, ns.
    explicit JitterBuffer(std::int64_t latency_ns, std::int64_t longest_way_ns = most_way_ns)
        : latency_ns_(latency_ns), longest_way_ns_(longest_way_ns) {}

    struct Moments {
        std::int64_t taken_ns =
            0;  ///< as it would have come by the shortest way; at most the longest way ago
        std::int64_t shown_ns = 0;  ///< never before that of the frameset before
    };
    /// The moments of the next frameset, by our clock. `sent_ns`: by the sender's (0: not known);
    /// `arrived_ns`: by ours, ever later.
    Moments add(std::int64_t sent_ns, std::int64_t arrived_ns);
    /// The sender was connected to anew.
    void restart();
    /// The time that framesets wait for others' sake now.
    std::int64_t delay_ns() const { return delay_ns_; }

    static constexpr std::int64_t most_way_ns = 1'000'000'000;

private:
    static constexpr std::size_t buckets = 20, kept = 128;
    static constexpr std::int64_t bucket_ns = 500'000'000;
    struct Shortest {
        std::int64_t bucket = 0, way_ns = 0;
    };
    std::int64_t shortest_way(std::int64_t way_ns, std::int64_t arrived_ns);
    void adapt(std::int64_t jitter_ns, std::int64_t arrived_ns);

    const std::int64_t latency_ns_, longest_way_ns_;
    std::array<std::optional<Shortest>, buckets> shortest_{};
    std::array<std::int64_t, kept> jitters_{};  // a ring
    std::size_t jitter_count_ = 0;
    std::int64_t delay_ns_ = 0, last_sent_ns_ = 0, last_arrived_ns_ = 0, last_shown_ns_ = 0;
};

/// When framesets are shown that come many at a time, as in segments of HTTP Live Streaming: as far apart as
/// they were taken, the first one `margin_ns` after it came. Where one comes too late, all that follow are so
/// much later; where they run far ahead, or the sender's clock jumps, it begins anew.
class SegmentPace {
public:
    explicit SegmentPace(std::int64_t margin_ns) : margin_ns_(margin_ns) {}
    /// As JitterBuffer::add.
    JitterBuffer::Moments add(std::int64_t sent_ns, std::int64_t arrived_ns);

private:
    const std::int64_t margin_ns_;
    std::optional<std::int64_t> apart_ns_;  // our clock is so far ahead of the sender's
};

/// How a camera delivers what it takes. Moments are those of a run, ns.
struct CameraDelivery {
    static constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max();
    /// A frame, and when it is there.
    struct Frame {
        std::int64_t number = -1;
        std::int64_t at_ns = 0;  ///< of the run, or `never`
    };

    std::optional<FrameRate> rate{};  ///< nothing: the recording's own
    std::int64_t jitter_ns = 0;       ///< the longest time from exposure to delivery
    double drop = 0;                  ///< the share of frames that never come, 0 to below 1
    /// Nothing is delivered between; no end: never again.
    std::optional<std::int64_t> stall_ns{}, resume_ns{};

    /// What comes after `last`: the next frame that is not left out, not before its own time by the
    /// recording's rate. As random as the settings want it, and the same every time.
    Frame after(const Frame& last, const FrameRate& recorded) const;
};

/// A recording that behaves like a camera. Frame n is taken at time_ns = n / rate and comes when
/// CameraDelivery::after says. Frames keep the recording's numbers, so that those left out are gaps.
///
/// Until `begin` it is a clip: every frame is there at once. After it `next` waits for the next delivery, and
/// gives the newest frame where several were delivered before it was asked. A frame is decoded while it is
/// waited for. Frames are held and not interpolated, for none of the future exists.
std::unique_ptr<ClipReader> make_replay_camera(std::unique_ptr<ClipReader> recording,
                                               const CameraDelivery& delivery);

}  // namespace touchable
