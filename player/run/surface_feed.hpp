#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "engine/clip/clip_reader.hpp"
#include "engine/scene/surface_timeline.hpp"
#include "engine/scene/temporal.hpp"
#include "engine/surface/surface_builder.hpp"
#include "player/run/planes_hash.hpp"
#include "player/run/scene_cuts.hpp"
#include "player/run/time_spread.hpp"
#include "player/run/watched_planes.hpp"

namespace touchable {

/// Frames of an epoch that were left out.
struct DroppedFrames {
    std::uint64_t epoch = 0;
    std::int64_t first = 0, count = 0;
    bool operator==(const DroppedFrames&) const = default;
};

/// A frame as it was read.
struct FedFrame {
    RawFrame raw;
    bool shown = true;  ///< false: before the epoch's first, for the memory of a filter alone
};

/// Where reading has come to in an epoch.
struct ReadPlace {
    std::uint64_t epoch = 0;
    std::int64_t start_ns = 0;  ///< the epoch's
    std::int64_t first_shown = 0, next_number = 0;

    bool is_of(const MediaMoment& moment) const {
        return epoch == moment.epoch && start_ns == moment.start_ns;
    }
};

/// How a feed is doing.
struct FeedFigures {
    std::string builder;
    std::int64_t frames = 0, dropped = 0;  ///< published, left out
    double read_ms = 0, build_ms = 0;      ///< of the newest frame
};

/// A clip's frames on their way into the timeline, and in virtual time on the caller's thread: whoever asks
/// for a moment finds the frames around it published.
class SurfaceFeed {
public:
    /// `scene`: the reader's, as this run applies it. `warm_up_frames`: that a filter with a memory sees
    /// before an epoch's first frame. `eye`: whether somebody looks at what the hand holds; stored
    /// planes are kept for them.
    SurfaceFeed(std::unique_ptr<ClipReader> reader, std::unique_ptr<SurfaceBuilder> builder,
                const Scene& scene, int warm_up_frames = temporal_warm_up_frames,
                SurfaceTimeline::Eye eye = SurfaceTimeline::Eye::none);

    /// Reads and builds until a frame later than the moment is published or the clip has ended, then gives
    /// the pair around it. Moments must not go backward (of an epoch that is left, the pair in hand stays
    /// the one that it is); a later epoch is read from its start on. An empty clip is an error.
    Result<FramePair> pair_at(const MediaMoment& moment);
    /// Of epoch 0.
    Result<FramePair> pair_at(std::int64_t time_ns) { return pair_at(MediaMoment{0, time_ns, 0}); }

    /// The pair of these frames (the same, or neighbours) at a blend: what a live tick found in an epoch,
    /// whatever its time.
    Result<FramePair> pair_of(std::uint64_t epoch, std::int64_t start_ns, std::int64_t prev,
                              std::int64_t next, double blend);
    /// Likewise, of epoch 0.
    Result<FramePair> pair_of(std::int64_t prev, std::int64_t next, double blend) {
        return pair_of(0, 0, prev, next, blend);
    }

    /// Once it is requested, `pair_at` waits for no frame any more: an error of kind interrupted.
    void stop_at(std::stop_token given_up) { given_up_ = std::move(given_up); }

    // The parts, for a thread each (FeedThreads).
    /// What is read from now on is of this epoch: from the frame at its start on (the clip's last where that
    /// is beyond), and where a filter remembers from the warm-up before. By the thread that
    /// reads.
    Result<void> read_from(std::uint64_t epoch, std::int64_t start_ns);
    ReadPlace place() const { return place_; }
    /// Forgets what was read since this place, of epochs that were never played: reading goes on from there.
    /// Nothing of it was built. By the thread that reads.
    Result<void> go_back(const ReadPlace& place);
    /// Leaves out frames whose time has passed at `now`, because nobody would feel them any more, up to one
    /// from which decoding can begin again. (A live source does so itself.) By the thread that reads.
    Result<void> catch_up(const MediaMoment& now);
    /// A replay leaves out what its recording did.
    void leave_out(std::vector<DroppedFrames> frames) { left_out_ = std::move(frames); }
    /// Decodes a frame; nothing after the last.
    Result<std::optional<FedFrame>> read_next();
    /// Builds and publishes it, or, where no filter remembers, the frame before once more where nothing that
    /// can be touched has changed; false while the timeline has no room.
    Result<bool> publish(const FedFrame& frame);
    /// By the thread that builds: of this epoch all has been given to it.
    void end_epoch(std::uint64_t epoch);
    SurfaceTimeline& timeline() { return timeline_; }
    /// Where there is an eye.
    WatchedPlanes& stored_planes() { return stored_planes_; }
    /// Any thread, at any time.
    FeedFigures figures() const;
    /// Any thread: the frames that are cuts (SceneCuts), where there is an eye.
    std::set<std::int64_t> cuts() const;
    /// Of a live source: time 0 of the run, before the thread that reads begins.
    Result<void> begin(std::chrono::steady_clock::time_point zero) { return reader_->begin(zero); }
    /// From any thread: `read_next` waits for no live source any more.
    void interrupt() { reader_->interrupt(); }

    const ClipReader& reader() const { return *reader_; }
    std::string_view builder_name() const { return builder_->name(); }
    std::int64_t frames() const { return frames_; }  ///< published so far
    /// Of them, those that were the frame before once more.
    std::int64_t unchanged_frames() const { return unchanged_frames_; }
    /// Of all their tiles the share that was not built, 0 to 1: because nothing there has changed since a
    /// frame before, or because nobody touched it (lazy).
    double skipped_share() const { return frames_ > 0 ? skipped_frames_ / static_cast<double>(frames_) : 1; }
    /// Whether any stored pixel of the frames published so far was valid.
    bool any_valid() const { return any_valid_; }
    bool ended() const { return ended_; }
    /// The newest epoch that was built, and the end of its newest frame's time on screen.
    MediaMoment end() const { return {built_epoch_, end_ns(), 0}; }
    std::int64_t end_ns() const { return rate_.time_ns(newest_number_ + 1); }
    /// Which frames were built, in order; what `planes_hash` is of, and empty where there is none.
    const std::vector<FrameRun>& built() const { return built_; }
    /// Which frames were left out, in order. Of a feed without a hash the newer ones.
    const std::vector<DroppedFrames>& dropped() const { return dropped_; }
    bool has_dropped(std::uint64_t epoch, std::int64_t number) const;
    std::int64_t dropped_frames() const;
    /// Of a frame, milliseconds: of all that were read or built since `forget_times`.
    const TimeSpread& read_ms() const { return read_ms_; }
    const TimeSpread& build_ms() const { return build_ms_; }
    void forget_times() { read_ms_ = build_ms_ = {}; }
    std::string planes_hash() const { return hash_.hex(); }
    /// From the first frame on: no frame is hashed.
    void leave_out_hash() { hashed_ = false; }

private:
    Result<void> feed_next();
    void note_built(const RawFrame& raw);
    void note_dropped(std::int64_t frames);
    Result<bool> build(const FedFrame& frame);

    std::stop_token given_up_;
    std::unique_ptr<ClipReader> reader_;
    std::unique_ptr<SurfaceBuilder> builder_;
    FrameRate rate_;
    DepthCoding stored_;
    int warm_up_frames_;
    bool settles_;  // a filter that remembers makes another surface of the same frame once more
    SurfaceTimeline::Eye eye_;
    SurfaceTimeline timeline_;
    WatchedPlanes stored_planes_;
    mutable std::mutex figures_mutex_;
    FeedFigures figures_;  // guarded by it
    SceneCuts cuts_;       // likewise
    // Of the thread that reads.
    ReadPlace place_;
    std::vector<DroppedFrames> dropped_, left_out_;
    std::int64_t dropped_long_ago_ = 0;  // frames that are in `dropped_` no more
    // Of the thread that builds.
    std::uint64_t built_epoch_ = 0;
    PlanesHash hash_;
    bool hashed_ = true;
    std::vector<FrameRun> built_;
    std::optional<RawFrame> newest_;   // of those that were built
    std::int64_t newest_number_ = -1;  // of those that were published
    std::int64_t frames_ = 0, unchanged_frames_ = 0;
    double skipped_frames_ = 0;  // and parts of frames
    bool any_valid_ = false, ended_ = false;
    TimeSpread read_ms_, build_ms_;
};

}  // namespace touchable
