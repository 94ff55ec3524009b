// SPDX-License-Identifier: Apache-2.0
#pragma once

// Building blocks of clip readers: wrapping readers, and the parts of a live reader.
//
// A wrapping reader owns another reader and is itself a clip: a part of it, with still planes in every frame,
// with a far plane found in its frames, with depth of one scale, or delivered as by a camera. part_of_clip,
// with_far_plane and with_aligned_depth return the clip unchanged if there is nothing to do; classes of other
// modules derive from ReaderAround, or from ChangedClip, and override what they change. Prefetch keeps the
// first frames that it read (up to 512 MiB), so that they are not decoded twice.
//
// LiveReader is the base of every source whose frames come as they are taken: a camera, a program that sends
// framesets, a stream. Derived classes turn bytes into frames; LiveReader has the numbers, times, waits,
// stops and remarks.
//
// Threads: one at a time uses a reader; functions that any may call say so.

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

/// Wraps another reader; a derived class overrides what it changes.
class ReaderAround : public ClipReader {
public:
    const Scene& scene() const override { return reader_->scene(); }
    UnstatedFilters unstated_filters() const override { return reader_->unstated_filters(); }
    const std::vector<TrackInfo>& tracks() const override { return reader_->tracks(); }
    std::optional<std::int64_t> frame_count() const override { return reader_->frame_count(); }
    const std::vector<ClipNote>& notes() const override { return reader_->notes(); }
    std::span<const Camera> frame_cameras() const override { return reader_->frame_cameras(); }
    Result<std::optional<RawFrame>> next() override {
        auto frame = reader_->next();
        const auto changed = frame && *frame ? change(**frame) : Result<void>();
        return changed ? std::move(frame) : changed.error();
    }
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
    /// Changes a frame that `next` returns.
    virtual Result<void> change(RawFrame& /*frame*/) { return {}; }

private:
    std::shared_ptr<ClipReader> reader_;
};

/// A wrapping reader with its own scene, tracks and notes, at first copies of the inner reader's.
class ChangedClip : public ReaderAround {
public:
    const Scene& scene() const override { return scene_; }
    const std::vector<TrackInfo>& tracks() const override { return tracks_; }
    const std::vector<ClipNote>& notes() const override { return notes_; }

    /// With another scene, and a note on that; empty: none.
    ChangedClip(std::unique_ptr<ClipReader> clip, Scene scene, std::string note = {})
        : ChangedClip(std::move(clip)) {
        scene_ = std::move(scene);
        if (!note.empty()) notes_.push_back(std::move(note));
    }

protected:
    explicit ChangedClip(std::unique_ptr<ClipReader> clip)
        : ReaderAround(std::move(clip)),
          scene_(inner().scene()),
          tracks_(inner().tracks()),
          notes_(inner().notes()) {}
    /// Inserts a track in the order of roles, replacing that of its role and the notes on it. Returns whether
    /// there was one.
    bool replace_track(PlaneRole role, TrackInfo track);

    Scene scene_;
    std::vector<TrackInfo> tracks_;
    std::vector<ClipNote> notes_;
};

/// Which frames and pixels of a clip.
struct ClipPart {
    /// Columns x to x + width - 1, rows y to y + height - 1.
    struct Crop {
        int x = 0, y = 0, width = 0, height = 0;
    };

    std::int64_t first = 0;
    std::optional<std::int64_t> last{};  ///< inclusive; nothing: the clip's last
    std::int64_t every = 1;              ///< takes the first, then every so many frames
    std::optional<Crop> crop{};

    bool is_whole() const { return first == 0 && !last && every == 1 && !crop; }
};

/// Returns part of a clip as a clip: frames are numbered from 0, and the rate falls with `every`. Cropping
/// moves the camera's principal point, so that every pixel that is left keeps its place in the world. Refused
/// (ErrorKind::usage) if the clip has no such frame or pixel.
Result<std::unique_ptr<ClipReader>> part_of_clip(std::unique_ptr<ClipReader> clip, const ClipPart& part);

/// A picture that serves all frames of a clip.
struct StillPlane {
    PlaneRole role = PlaneRole::haptic;
    Plane plane;                                 ///< of any size: as stored, or resampled already
    TrackInfo info;                              ///< how it is stored
    std::vector<std::filesystem::path> files{};  ///< read for it; first the one that the user named
    std::vector<ClipNote> notes{};
    /// If it changes: returns the plane of a frame, which fits the scene, by its number and time.
    std::function<Result<Plane>(std::int64_t frame, std::int64_t time_ns)> at{};
};

/// The clip with these planes in every frame, replacing its own of their roles. `scene` is the clip's, except
/// for the planes' meaning: haptic ranges, height coding and room for heights. Refused if the scene is
/// invalid, or a plane does not fit it.
Result<std::unique_ptr<ClipReader>> with_still_planes(std::unique_ptr<ClipReader> clip,
                                                      std::vector<StillPlane> planes, const Scene& scene);

/// A clip whose first frames were read already: `next` returns them before it reads on.
std::unique_ptr<ClipReader> with_prefetched_frames(std::unique_ptr<ClipReader> clip,
                                                   std::vector<RawFrame> frames);

/// Reads ahead in a clip that is at its beginning, and keeps its first frames for playback.
class Prefetch {
public:
    explicit Prefetch(std::unique_ptr<ClipReader> clip) : clip_(std::move(clip)) {}

    /// The next frame, which is kept.
    Result<std::optional<RawFrame>> next();
    /// A later frame, which is not kept. No `next` may follow it.
    Result<std::optional<RawFrame>> at(std::int64_t frame);
    const ClipReader& clip() const { return *clip_; }
    /// Returns the clip, at its beginning again. Once.
    Result<std::unique_ptr<ClipReader>> finish();

private:
    static constexpr std::size_t most_bytes = std::size_t{512} << 20;  // 25 frames of 1920x1080, all planes

    std::unique_ptr<ClipReader> clip_;
    std::vector<RawFrame> frames_;  // empty if they took too much memory
    std::size_t bytes_ = 0;
    std::int64_t number_ = 0;  // of the frame that `next` gives
    bool has_moved_ = false, is_damaged_ = false;
};

/// The frames from which properties of a clip are estimated: the first ones, and as many spread over the
/// rest. The time this takes does not grow with the clip's length.
inline constexpr std::int64_t first_frames = 16, spread_frames = 16;
/// Their numbers, ascending, in a clip of `count` frames that can each be read on its own.
std::vector<std::int64_t> telling_frames(std::int64_t count);

/// Settles a far plane that the description leaves open (SceneDescription::Unstated::far), until then the
/// deepest code's, and adds a note on it; otherwise returns the clip unchanged. The far plane is 5 % beyond
/// the depth that at most one valid pixel in 10 000 exceeds, in telling_frames, or in the first frames of a
/// clip that cannot seek. Depth beyond it is invalid. A later frame that is damaged is skipped: playback
/// reports it. An error if no depth is valid. Errors name `file`. The clip is at its beginning, before and
/// after.
Result<std::unique_ptr<ClipReader>> with_far_plane(std::unique_ptr<ClipReader> clip, bool far_is_open,
                                                   const std::filesystem::path& file);

/// Whether depth without a scale gets one for all frames. Automatic: if it pumps in sampled frames.
enum class DepthAlignment { automatic, on, off };

/// Returns the clip with 16-bit codes of one scale for all frames: near and far are those of the whole clip.
/// Reads all frames once beforehand, so that a frame does not depend on which frames were read before it. If
/// depth does not pump (automatic), or the clip has one frame, returns it unchanged. A note says how far what
/// stands still moved, before and after. Refused (`on`) if codes are not evenly spaced in depth or in 1 /
/// depth. The clip, with its colour, is at its beginning before and after.
Result<std::unique_ptr<ClipReader>> with_aligned_depth(std::unique_ptr<ClipReader> clip,
                                                       DepthAlignment wanted);

/// A frame as some thousand cells, in which noise is averaged out: 640x480 pixels are 80x60.
struct CellPicture {
    static constexpr std::int32_t per_code = 16, per_level = 16;
    static constexpr std::int32_t none = -1;
    /// A square of pixels.
    struct Cell {
        /// Mean code, sixteenths; none: it has two surfaces, or a pixel without depth.
        std::int32_t depth = none;
        std::int32_t luma = none;  ///< mean brightness, sixteenths of 255 levels; none: without colour
        bool is_textured = false;  ///< its brightness varies enough to show motion
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

/// Distance of frames before a run, ns.
inline constexpr std::int64_t ns_before_a_run = 1000;

/// Appends "3 of the stream's framesets came late"; nothing if `count` is 0.
void add_count(std::vector<std::string>& remarks, std::int64_t count, const std::string& of_what);

/// A live source as a clip without an end. A derived class turns the source's bytes into frames: `poll`
/// never waits, `wait` waits for more. The rest is the same for every source:
///
/// - Before a run `next` returns every frame, in order, and one must come before the source's timeout
///   (`nothing_came`). In a run it returns the newest frame, and waits for it without a timeout.
/// - Numbers: consecutive before a run. In a run the source's counter tells how many were lost; if it stands
///   still, begins anew or leaps by more than a million, the next number follows.
/// - Times: `ns_before_a_run` apart before a run. In a run they count from its time 0 and never go back;
///   frames taken before it are dropped until the run's first frame has come.
/// - The end: a source that is `gone` gives no more frames, its last one stands still, and a remark says why;
///   before a run that is an error. A stop of the thread that reads (stop_requested) ends its waits within
///   20 ms. After a run another may begin.
///
/// Used by one thread, except where ClipReader says that any may call.
class LiveReader : public ClipReader {
public:
    /// The frames' meaning, and the files it was read from.
    struct Meaning {
        Scene scene;
        UnstatedFilters unstated_filters{};
        std::vector<std::filesystem::path> inputs{};
    };

    const Scene& scene() const final { return scene_; }
    UnstatedFilters unstated_filters() const final { return unstated_filters_; }
    const std::vector<TrackInfo>& tracks() const final { return tracks_; }
    std::optional<std::int64_t> frame_count() const final { return std::nullopt; }
    const std::vector<ClipNote>& notes() const final { return notes_; }
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
        std::uint32_t count = 0;  ///< the source's counter, 32 bits
        std::int64_t at_ns = 0;   ///< its time, of std::chrono::steady_clock
        std::int64_t way_ns = 0;  ///< from being taken to that time (taken_before)
        RawFrame frame{};         ///< planes only
    };
    using MaybeTaken = Result<std::optional<Taken>>;

    /// `name`: of the source, in messages; `kind`: what messages call it, if it is no camera.
    explicit LiveReader(std::string name, std::string kind = "camera")
        : name_(std::move(name)), kind_(std::move(kind)) {}

    /// Returns an available frame: before a run the oldest, in it the newest; nullopt if there is none. Never
    /// waits. Returns `gone` if no more will come. An error ends only this `next`.
    virtual MaybeTaken poll() = 0;
    /// Waits until there may be a frame, at most for `stop_look`.
    virtual void wait() = 0;
    /// Called before a run while no frame has come since `since`: an error after the source's timeout.
    virtual std::optional<Error> nothing_came(Moment since) const = 0;
    /// A run begins: drops frames that waited for it, for sources whose times do not tell.
    virtual void drain() { (void)poll(); }

    bool has_begun() const { return zero_ns_.has_value(); }
    /// Ends the source: no more frames. `why` goes on from the source's name.
    MaybeTaken gone(const std::string& why);
    void remark(std::string words);
    void take_meaning(Meaning meaning);
    /// Waits for the next frame before the run, for a source that looks at its first frames.
    Result<Taken> first_frame();

    const std::string name_;
    Scene scene_;
    std::vector<TrackInfo> tracks_;
    std::vector<ClipNote> notes_;
    /// Counts of frames, for remarks.
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
    std::optional<std::uint32_t> last_count_;  // of the run's last frame
    std::optional<std::int64_t> zero_ns_;
    std::int64_t last_time_ns_ = -1;
    struct Way {
        std::int64_t frame = -1, ns = 0;
    };
    mutable std::mutex mutex_;
    // Guarded by mutex_.
    std::vector<std::string> remarks_;
    std::array<Way, 128> ways_;  // newest frames: ns from being taken to their time
};

/// Computes when a sender's framesets were taken, and when to show them so that most arrive in time and none
/// waits longer than needed. The shortest transit time of the last seconds gives the offset of the sender's
/// clock from ours, and follows their drift. Jitter is how much longer a frameset took; all are delayed by
/// the jitter that 97 of 100 recent ones kept to, which rises at once and falls slowly, up to a bound. If the
/// sender's clock jumps, forward, back or by years, the estimate begins anew with that frameset; if it stands
/// still, framesets count from their arrival. Reads no clock, like SegmentPace: both are functions of their
/// arguments.
class JitterBuffer {
public:
    /// ns; the longest delay of a frameset, and the longest transit time that is believed.
    explicit JitterBuffer(std::int64_t latency_ns, std::int64_t longest_way_ns = most_way_ns)
        : latency_ns_(latency_ns), longest_way_ns_(longest_way_ns) {}

    struct Moments {
        std::int64_t taken_ns = 0;  ///< arrival, less jitter; at most the longest transit time before arrival
        std::int64_t shown_ns = 0;  ///< never before the previous frameset's
    };
    /// Returns the moments of the next frameset, by our clock. `sent_ns`: by the sender's clock (0: unknown);
    /// `arrived_ns`: by ours, never decreasing.
    Moments add(std::int64_t sent_ns, std::int64_t arrived_ns);
    /// The sender has reconnected: forgets its clock.
    void restart();
    /// The current delay of framesets, ns.
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

/// Computes when to show framesets that arrive many at a time, as in segments of HTTP Live Streaming: as far
/// apart as they were taken, the first one `margin_ns` after it came. A late frameset delays all that follow;
/// if they run more than a minute ahead, or the sender's clock jumps, the pace begins anew.
class SegmentPace {
public:
    explicit SegmentPace(std::int64_t margin_ns) : margin_ns_(margin_ns) {}
    /// Like JitterBuffer::add.
    JitterBuffer::Moments add(std::int64_t sent_ns, std::int64_t arrived_ns);

private:
    const std::int64_t margin_ns_;
    std::optional<std::int64_t> apart_ns_;  // ns from the sender's clock to when it is shown
};

/// How a camera delivers its frames. Times are ns of the run.
struct CameraDelivery {
    static constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max();
    /// A frame and its delivery time.
    struct Frame {
        std::int64_t number = -1;
        std::int64_t at_ns = 0;  ///< of the run, or `never`
    };

    std::optional<FrameRate> rate{};  ///< nothing: the recording's own
    std::int64_t jitter_ns = 0;       ///< the longest time from exposure to delivery
    double drop = 0;                  ///< the share of frames that never come, 0 to below 1
    /// Nothing is delivered from stall_ns to resume_ns; no resume_ns: never again.
    std::optional<std::int64_t> stall_ns{}, resume_ns{};

    /// The delivery after `last`: the next frame that is not dropped, not before its own time by the
    /// recording's rate. Random within the settings, and the same every time.
    Frame after(const Frame& last, const FrameRate& recorded) const;
};

/// A recording that behaves like a camera. Frame n is taken at time_ns = n / rate and comes when
/// CameraDelivery::after says. Frames keep the recording's numbers, so that those left out are gaps.
///
/// Until `begin` it is a clip: every frame is available at once. After it `next` waits for the next delivery,
/// and returns the newest frame if several were delivered before the call. A frame is decoded during the
/// wait. Frames are held and not interpolated: no future frame exists.
std::unique_ptr<ClipReader> make_replay_camera(std::unique_ptr<ClipReader> recording,
                                               const CameraDelivery& delivery);

}  // namespace touchable
