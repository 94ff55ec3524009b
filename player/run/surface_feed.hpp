// SPDX-License-Identifier: Apache-2.0
#pragma once

// A clip's frames on their way to a SurfaceQueue (engine/run). A SurfaceFeed reads them in virtual time, on the thread
// of the run; FeedThreads runs it live. For an eye the feed also keeps stored planes and finds cuts.

#include <chrono>
#include <deque>
#include <functional>
#include <mutex>
#include <set>

#include "engine/base/result.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/clip.hpp"
#include "engine/scene/filter_codes.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "engine/run/touch_run.hpp"
#include "engine/surface/surface_builder.hpp"
#include "player/run/figures.hpp"

namespace touchable {

/// Hashes the stored samples of a frame's touch planes (depth, haptic, height), row by row: the part of a
/// clip on which forces depend.
void add_planes(const RawFrame& frame, ByteHash& hash);

/// Consecutive frames of a clip.
struct FrameRun {
    std::int64_t first = 0, count = 0;
    std::uint64_t epoch = 0;  ///< in which they were dropped
    bool operator==(const FrameRun&) const = default;
};

/// A frame's stored planes and their owner.
struct HeldPlanes {
    PlaneView colour;  ///< empty: no colour
    PlaneView depth;
    std::shared_ptr<const void> storage;
};

/// Figures of a running feed.
struct FeedFigures {
    std::string builder;
    std::int64_t frames = 0, dropped = 0;  ///< published, dropped
    double read_ms = 0, build_ms = 0;      ///< of the newest frame
};

/// Reads a clip's frames, and has them built and published. In virtual time it runs on the caller's thread:
/// `pair_at` returns once the frames around a moment are published.
class SurfaceFeed {
public:
    /// `scene`: the reader's, as applied in this run. `warm_up_frames`: frames that a temporal filter reads
    /// before an epoch's first. `eye`: whether the held frames are drawn; keeps stored planes for that.
    SurfaceFeed(std::unique_ptr<ClipReader> reader, std::unique_ptr<SurfaceBuilder> builder,
                const Scene& scene, int warm_up_frames = temporal_warm_up_frames,
                SurfaceTimeline::Eye eye = SurfaceTimeline::Eye::none);
    ~SurfaceFeed();

    /// Reads and builds until a frame later than the moment is published or the clip has ended. Moments must
    /// not decrease; a later epoch is read from its start on.
    Result<void> feed_to(const MediaMoment& moment);
    /// The same, and the pair around the moment (for an epoch already left, the current pair stays). An empty
    /// clip is an error.
    Result<FramePair> pair_at(const MediaMoment& moment);
    /// In epoch 0.
    Result<FramePair> pair_at(std::int64_t time_ns) { return pair_at(MediaMoment{0, time_ns, 0}); }

    /// From now on prefetches as many frames as the builder processes in parallel. For runs in virtual time,
    /// which get every frame by `pair_at` and `pair_of`.
    void work_ahead() { works_ahead_ = !reader_->is_live(); }

    /// The pair of these frames (equal or neighbours) at a blend: the pair of a recorded live tick, whatever
    /// its time.
    Result<FramePair> pair_of(std::int64_t prev, std::int64_t next, double blend, std::uint64_t epoch = 0,
                              std::int64_t start_ns = 0);

    // The steps, each for its own thread (FeedThreads).
    /// Reads this epoch from now on: from the frame at its start (at most the clip's last), with a temporal
    /// filter from its warm-up frames before. Reading thread.
    Result<void> read_from(std::uint64_t epoch, std::int64_t start_ns);
    ReadPlace place() const { return queue_.place(); }
    /// Returns to this place and forgets what was read since, of epochs that were never played or built.
    /// Reading thread.
    Result<void> go_back(const ReadPlace& place);
    /// Drops frames whose time has passed at `now`, because they would not be felt any more, up to a frame at
    /// which decoding can begin. (A live source does so itself.) Reading thread.
    Result<void> catch_up(const MediaMoment& now);
    /// For a replay: frames to leave out, as its recording did.
    void leave_out(std::vector<FrameRun> frames) { left_out_ = std::move(frames); }
    /// Decodes the next frame; nothing after the last.
    Result<std::optional<FedFrame>> read_next();
    /// Builds and publishes the frame. Without a temporal filter, a frame whose touch planes are unchanged
    /// republishes the previous one. False while the timeline has no room.
    Result<bool> publish(const FedFrame& frame);
    /// Builder thread: all frames of this epoch have been passed to it.
    void end_epoch(std::uint64_t epoch) {
        if (epoch == queue_.timeline().epoch()) queue_.timeline().end_epoch();
    }
    SurfaceQueue& queue() { return queue_; }
    SurfaceTimeline& timeline() { return queue_.timeline(); }
    /// The eye's thread: a published frame's stored planes, if kept. Frees earlier frames' planes, which are
    /// no longer needed.
    std::optional<HeldPlanes> stored_planes(std::uint64_t epoch, std::int64_t number);
    /// Any thread, at any time.
    FeedFigures figures() const;
    /// Any thread: the first frames after a cut, a frame whose depth differs from the previous frame's in
    /// much of the picture; at most 4096. For display only: touch has its own measure of sudden changes.
    /// Empty without an eye.
    std::set<std::int64_t> cuts() const;
    /// For a live source: sets time 0 of the run, before the reading thread starts.
    Result<void> begin(std::chrono::steady_clock::time_point zero) { return reader_->begin(zero); }

    const ClipReader& reader() const { return *reader_; }
    std::string_view builder_name() const { return queue_.builder().name(); }
    std::int64_t frames() const { return frames_; }  ///< published so far
    /// Share of all published tiles that was not built, 0 to 1: unchanged since an earlier frame, or not
    /// touched (lazy).
    double skipped_share() const { return frames_ > 0 ? skipped_frames_ / static_cast<double>(frames_) : 1; }
    /// Whether any stored pixel of the frames published so far was valid.
    bool any_valid() const { return any_valid_; }
    bool ended() const { return ended_; }
    /// The newest epoch built, and the end of its newest frame.
    MediaMoment end() const { return {queue_.timeline().epoch(), end_ns(), 0}; }
    std::int64_t end_ns() const { return rate_.time_ns(newest_number_ + 1); }
    /// The frames built, in order, which `planes_hash` covers; empty without a hash.
    const std::vector<FrameRun>& built() const { return built_; }
    /// The frames dropped, in order; without a hash only the newer ones.
    const std::vector<FrameRun>& dropped() const { return dropped_; }
    std::int64_t dropped_frames() const;
    /// Milliseconds per frame read or built since `forget_times`. If frames are built in parallel, the time
    /// the run's thread spends on a frame, waits included.
    const TimeSpread& read_ms() const { return read_ms_; }
    const TimeSpread& build_ms() const { return build_ms_; }
    void forget_times() { read_ms_ = build_ms_ = {}; }
    std::string planes_hash() const { return hash_.hex(); }
    /// Hashes no frame; call before the first one.
    void leave_out_hash() { hashed_ = false; }

private:
    class Watched;
    Result<void> feed_next();
    void begin_ahead();
    void note_built(const RawFrame& raw);
    void note_dropped(std::int64_t frames);
    void note_published(const SurfaceQueue::Published& published, double took_ms);

    std::unique_ptr<ClipReader> reader_;
    FrameRate rate_;
    DepthCoding stored_;
    SurfaceQueue queue_;
    std::unique_ptr<Watched> watched_;  // for an eye; null: none
    mutable std::mutex figures_mutex_;
    FeedFigures figures_;  // guarded by figures_mutex_
    // Reading thread.
    std::vector<FrameRun> dropped_, left_out_;
    std::int64_t dropped_long_ago_ = 0;  // frames no longer in `dropped_`
    // Builder thread.
    ByteHash hash_;
    bool hashed_ = true;
    std::vector<FrameRun> built_;
    std::int64_t newest_number_ = -1;  // newest frame published
    std::int64_t frames_ = 0;
    double skipped_frames_ = 0;  // with fractions of frames
    bool any_valid_ = false, ended_ = false;
    // In virtual time.
    bool works_ahead_ = false, all_read_ = false;
    bool may_begin_another_ = true;  // the frame begun last keeps its planes
    double begin_ms_ = 0;            // since a frame was published
    std::optional<Error> unread_;  // why reading or building stopped before the clip's end
    TimeSpread read_ms_, build_ms_;
};

/// Runs a feed for live touch: one thread decodes, one builds and publishes as fast as the timeline has room.
/// A short queue connects them.
///
/// If commands may come during the run (PlaybackLog), later epochs are predictions. Frames of an epoch that
/// the hand has not reached wait in the queue; if a command leads elsewhere, the decoder removes them and
/// goes at once to the hand's moment. Frames of an epoch that the hand has left are not built. So a published
/// frame always belongs to an epoch that was played, and no epoch's number is used twice.
class FeedThreads : NonCopyable {
public:
    /// Whether a frame just published was needed earlier; called by the builder thread.
    using IsLate = std::function<bool(const RawFrame&)>;
    /// The hand's current moment; called by both threads. The commands that led to it are in the clock's log.
    using Now = std::function<MediaMoment()>;
    /// `feed` must outlive this and must not be used between `start` and `stop`. `ahead`: the clip's clock at
    /// `feed`'s moment; it predicts the coming epochs. Each is read once all wanted frames of the previous
    /// epoch are read, or once the hand is in it.
    FeedThreads(SurfaceFeed& feed, IsLate is_late, PlaybackClock ahead, Now now);
    ~FeedThreads() { stop(); }

    /// Call once. Error: the machine has no thread left; none is running then.
    Result<void> start();
    void stop();
    /// Wakes the threads to apply new commands, if any.
    void look_at_commands();
    /// Frames published so far.
    std::int64_t published() const { return published_.load(std::memory_order_acquire); }
    /// Late frames so far.
    std::int64_t late_frames() const { return late_frames_.load(std::memory_order_relaxed); }
    /// Whether the next frame is of an epoch that the hand has not reached, for example after a loop's last
    /// frames.
    bool waits_for_the_hand() const;
    /// End of the last epoch's last frame once all frames are published; nothing again after a command leads
    /// away.
    std::optional<MediaMoment> end() const;
    /// Why the threads ended early; nothing: they did not.
    std::optional<Error> error() const;

private:
    /// A frame of an epoch for the builder, or only the mark that there are no more.
    struct Queued {
        ReadPlace place;  // after `frame`
        std::optional<FedFrame> frame;
        bool ends_epoch = false;
    };
    enum class Turn { early, due, past };

    void guarded(void (FeedThreads::*work)());
    void fail(Error&& error);
    // Decoder thread.
    void decode();
    Result<void> read_on();
    Result<void> follow_commands();
    Result<void> go_to(const MediaMoment& hand);
    Result<void> go_on(std::uint64_t wanted);
    std::ptrdiff_t frames_waiting() const;
    bool hand_over();
    // Builder thread.
    void build();
    std::optional<Queued> wait_for_next();
    Turn turn_of(const Queued& queued) const;
    bool publish(const Queued& queued);

    SurfaceFeed& feed_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::stop_source stopping_;  // requested under mutex_, which also guards the members down to error_
    std::deque<Queued> queue_;
    bool decoded_all_ = false;
    std::optional<MediaMoment> end_;
    std::optional<Error> error_;
    Error out_of_memory_;  // made at the start, while there is memory for it
    const IsLate is_late_;
    const Now now_;
    const bool commands_may_come_;
    // Decoder thread.
    PlaybackClock known_;  // at its newest known command
    PlaybackClock ahead_;  // at the coming epoch
    std::optional<ComingEpoch> coming_;
    std::optional<Queued> next_;                               // read, not in the queue yet
    bool all_is_read_ = false;                                 // all wanted frames of the epoch are read
    std::vector<ReadPlace> left_;                              // places in epochs that reading may have to
                                                               // continue
    std::atomic<std::int64_t> published_{0}, late_frames_{0};  // counted by the builder
    std::thread decoder_, builder_;
};

}  // namespace touchable
