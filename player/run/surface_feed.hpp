#pragma once

#include <chrono>
#include <deque>
#include <mutex>
#include <new>
#include <nlohmann/json.hpp>
#include <set>

#include "engine/base/result.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/clip/clip.hpp"
#include "engine/scene/filter_codes.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable {

/// "frames of 720x480 pixels": what most of the memory is for.
inline std::string frames_in_words(const Scene& scene) {
    return "frames of " + std::to_string(scene.width) + "x" + std::to_string(scene.height) + " pixels";
}

inline Error too_large(const std::string& what) {
    return input_error("memory does not suffice for " + what);
}

/// Does the work; where memory does not suffice, says what is too large. `what` is looked at only then, so
/// that the work may make it more precise as it learns of sizes.
template <class Work>
Result<void> within_memory(const std::string& what, Work&& work) {
    try {
        return work();
    } catch (const std::bad_alloc&) {
        return too_large(what);
    }
}

/// XXH64 over the samples of frames' touch planes (depth, haptic, height) as stored, row by row: what forces
/// depend on, of a clip.
class PlanesHash {
public:
    void add(const RawFrame& frame);
    std::string hex() const { return hash_.hex(); }  ///< 16 digits

private:
    ByteHash hash_;
};

/// Frames of a clip that were read one after another.
struct FrameRun {
    std::int64_t first = 0, count = 0;
    bool operator==(const FrameRun&) const = default;
};

/// Of these frames of a clip, in this order; an error where it has not all of them.
Result<std::string> planes_hash_of(ClipReader& clip, const std::vector<FrameRun>& runs);

/// Finds a clip's cuts by its depth, as frames come by: a cut is a frame in which most of the picture has
/// another depth than in the frame before. For the eye alone; touch has its own measure of sudden changes.
class SceneCuts {
public:
    /// Some 800 pixels of a frame are looked at; the frame before is the last one that was, where it is one
    /// or two earlier and of the same epoch.
    void look(const RawFrame& frame, const DepthCoding& coding);
    /// Their numbers, of a clip of any length no more than 4096.
    const std::set<std::int64_t>& found() const { return found_; }

private:
    std::uint64_t epoch_ = 0;
    std::int64_t number_ = -1;
    std::vector<int> codes_, before_;  // -1: invalid
    std::set<std::int64_t> found_;
};

/// Spread of a measured quantity.
struct Spread {
    double mean = 0, p50 = 0, p99 = 0, p999 = 0, max = 0;
};
/// The value at rank floor(share n) of n, for each share; all 0 of none.
Spread spread_of(std::vector<double> values);
nlohmann::ordered_json to_json(const Spread& spread);

/// The spread of times of which there may be more than memory has room for: a histogram whose bins grow with
/// the time, 128 from one power of 2 to the next. Mean and max are exact, the rest is within half a percent
/// (below 1/1024 of the unit that times are given in: within that). Its memory is the same however many there
/// are.
class TimeSpread {
public:
    TimeSpread();
    /// In any unit, 0 or more.
    void add(double time);
    /// In the same; all 0 of none.
    Spread spread() const;

private:
    double quantile(double share) const;

    std::vector<std::int64_t> times_;  // how many, of each bin
    std::int64_t count_ = 0;
    double sum_ = 0, least_ = 0, most_ = 0;
};

/// Of a frame, as stored, and what keeps it alive.
struct HeldPlanes {
    PlaneView colour;  ///< empty: it has none
    PlaneView depth;
    std::shared_ptr<const void> storage;
};

/// Stored planes of the frames in the timeline, for drawing: between the thread that builds and the eye's.
/// Touch knows nothing of it.
class WatchedPlanes {
public:
    /// By the thread that builds: before its frame is published, so that none is seen without.
    void put(const RawFrame& raw) {
        if (!raw.storage) return;
        const std::lock_guard lock(mutex_);
        if (!frames_.empty() && frames_.back().epoch == raw.epoch && frames_.back().number == raw.number)
            return;
        frames_.push_back({raw.epoch, raw.number, {raw.colour, raw.depth, raw.storage}});
        // `storage` keeps the samples as they are.
        frames_.back().planes.colour.content = new_content_number();
        if (frames_.size() > most) frames_.pop_front();
    }
    /// By the eye: the planes of this frame, if they are kept. Those of earlier frames are freed, since they
    /// are not asked for any more.
    std::optional<HeldPlanes> find(std::uint64_t epoch, std::int64_t number) {
        const std::lock_guard lock(mutex_);
        for (std::size_t k = 0; k < frames_.size(); ++k) {
            if (frames_[k].epoch != epoch || frames_[k].number != number) continue;
            frames_.erase(frames_.begin(), frames_.begin() + static_cast<std::ptrdiff_t>(k));
            return frames_.front().planes;
        }
        return std::nullopt;
    }

private:
    static constexpr std::size_t most = 32;  // more than a timeline with an eye has entries
    struct Frame {
        std::uint64_t epoch;
        std::int64_t number;
        HeldPlanes planes;
    };
    std::mutex mutex_;
    std::deque<Frame> frames_;
};

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

/// A clip's frames on their way into the timeline, and in virtual time on the caller's thread: a
/// caller that asks for a moment finds the frames around it published.
class SurfaceFeed {
public:
    /// `scene`: the reader's, as this run applies it. `warm_up_frames`: that a filter with a memory sees
    /// before an epoch's first frame. `eye`: whether what the hand holds is looked at; stored
    /// planes are kept for that.
    SurfaceFeed(std::unique_ptr<ClipReader> reader, std::unique_ptr<SurfaceBuilder> builder,
                const Scene& scene, int warm_up_frames = temporal_warm_up_frames,
                SurfaceTimeline::Eye eye = SurfaceTimeline::Eye::none);

    /// Reads and builds until a frame later than the moment is published or the clip has ended, then gives
    /// the pair around it. Moments must not go backward (of an epoch that is left, the pair in hand stays
    /// the one that it is); a later epoch is read from its start on. An empty clip is an error.
    Result<FramePair> pair_at(const MediaMoment& moment);
    /// Of epoch 0.
    Result<FramePair> pair_at(std::int64_t time_ns) { return pair_at(MediaMoment{0, time_ns, 0}); }

    /// From now on frames are begun before they are asked for, as many as the builder works at side by side:
    /// of a run in virtual time, which asks for all of them by `pair_at` and `pair_of`.
    void work_ahead() { works_ahead_ = !reader_->is_live(); }

    /// The pair of these frames (the same, or neighbours) at a blend: what a live tick found in an epoch,
    /// whatever its time.
    Result<FramePair> pair_of(std::uint64_t epoch, std::int64_t start_ns, std::int64_t prev,
                              std::int64_t next, double blend);
    /// The same of epoch 0.
    Result<FramePair> pair_of(std::int64_t prev, std::int64_t next, double blend) {
        return pair_of(0, 0, prev, next, blend);
    }

    // The parts, for a thread each (FeedThreads).
    /// What is read from now on is of this epoch: from the frame at its start on (the clip's last where that
    /// is beyond), and where a filter remembers from the warm-up before. By the thread that
    /// reads.
    Result<void> read_from(std::uint64_t epoch, std::int64_t start_ns);
    ReadPlace place() const { return place_; }
    /// Forgets what was read since this place, of epochs that were never played: reading goes on from there.
    /// Nothing of it was built. By the thread that reads.
    Result<void> go_back(const ReadPlace& place);
    /// Leaves out frames whose time has passed at `now`, because they would not be felt any more, up to one
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
    void end_epoch(std::uint64_t epoch) {
        if (epoch == built_epoch_) timeline_.end_epoch();
    }
    SurfaceTimeline& timeline() { return timeline_; }
    /// Where there is an eye.
    WatchedPlanes& stored_planes() { return stored_planes_; }
    /// Any thread, at any time.
    FeedFigures figures() const;
    /// Any thread: the frames that are cuts (SceneCuts), where there is an eye.
    std::set<std::int64_t> cuts() const;
    /// Of a live source: time 0 of the run, before the thread that reads begins.
    Result<void> begin(std::chrono::steady_clock::time_point zero) { return reader_->begin(zero); }

    const ClipReader& reader() const { return *reader_; }
    std::string_view builder_name() const { return builder_->name(); }
    std::int64_t frames() const { return frames_; }  ///< published so far
    /// Of them, those that were the frame before once more.
    std::int64_t unchanged_frames() const { return unchanged_frames_; }
    /// Of all their tiles the share that was not built, 0 to 1: because nothing there has changed since a
    /// frame before, or because it was not touched (lazy).
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
    /// Of a frame, milliseconds: of all that were read or built since `forget_times`. Where frames are built
    /// side by side that is what the thread of the run spends on one, its waits included.
    const TimeSpread& read_ms() const { return read_ms_; }
    const TimeSpread& build_ms() const { return build_ms_; }
    void forget_times() { read_ms_ = build_ms_ = {}; }
    std::string planes_hash() const { return hash_.hex(); }
    /// From the first frame on: no frame is hashed.
    void leave_out_hash() { hashed_ = false; }

private:
    /// A frame that the builder has begun, or that is the one before once more.
    struct FrameAhead {
        FedFrame fed;
        bool unchanged = false;
        double began_ms = 0;  ///< what it took to begin it
    };
    Result<void> feed_next();
    void begin_ahead();
    Result<void> forget_ahead();
    bool is_unchanged(const std::optional<RawFrame>& before, const RawFrame& raw) const;
    void note_newest(std::optional<RawFrame>& newest, const RawFrame& raw) const;
    void note_built(const RawFrame& raw);
    void note_dropped(std::int64_t frames);
    /// `began_ms`: nothing: the builder has not begun it.
    Result<bool> publish(const FedFrame& frame, bool unchanged, std::optional<double> began_ms);
    Result<bool> build(const FedFrame& frame, bool begun);

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
    SceneCuts cuts_;       // guarded by it
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
    // In virtual time, of what is read before its turn.
    std::deque<FrameAhead> ahead_;
    std::optional<RawFrame> newest_ahead_;
    bool works_ahead_ = false, all_read_ = false;
    std::optional<Error> unread_;  // why there is no more, where the clip has not ended
    TimeSpread read_ms_, build_ms_;
};

}  // namespace touchable
