// SPDX-License-Identifier: Apache-2.0
#pragma once

// A run of touch: frames in, and for each tick the surface that it meets and the forces of a hand on it. No
// threads, files or wall clock: a program brings its own.
//
// A SurfaceQueue says which frame it wants next (`wanted`), builds frames and publishes them (`give`, or
// `begin` and `publish` for builders that work on several at once). A TouchRun has the clip's clock, solver
// and guard. In each tick it meets a pair of frames (`meet`); the hand looks at their surface (`field`) and
// says where it wants to be (`goals`); `solve` returns what it feels:
//
//     while (!surface.has(run.moment_at(tick))) surface.give(read(*surface.wanted(run.moment_at(tick))));
//     run.meet(tick);
//     hand(run.field(), run.goals());
//     const TouchTick felt = run.solve();
//
// Threads: one asks for frames, one builds and publishes, one meets and solves; they may be the same. None
// waits for another, and a tick allocates nothing. `surface_timeline.hpp` and `playback.hpp` have the parts.

#include <deque>

#include "engine/base/words.hpp"
#include "engine/run/playback.hpp"
#include "engine/run/surface_timeline.hpp"
#include "engine/surface/surface_builder.hpp"
#include "haptics_cpu/touch_step.hpp"

namespace touchable {

/// Position of reading in an epoch.
struct ReadPlace {
    std::uint64_t epoch = 0;
    std::int64_t start_ns = 0;  ///< start of the epoch
    std::int64_t first_shown = 0, next_number = 0;

    bool is_of(const MediaMoment& moment) const {
        return epoch == moment.epoch && start_ns == moment.start_ns;
    }
};

/// A frame as it was read.
struct FedFrame {
    RawFrame raw;
    bool shown = true;  ///< false: a warm-up frame before the epoch's first, for a temporal filter
};

/// The frames of a run on their way to the hand.
class SurfaceQueue : NonCopyable {
public:
    /// A frame that was begun, or built and, if it is to be shown, published.
    struct Published {
        FedFrame fed;
        bool unchanged = false;  ///< the frame before was published again
    };
    /// What is done with a frame that was built, before the hand can find it.
    using OnBuilt = std::function<void(const SurfaceFrame&)>;

    /// `scene` outlives this. `warm_up_frames`: frames that a temporal filter reads before an epoch's first.
    /// `slots`: of the timeline; 0: the fewest.
    SurfaceQueue(const Scene& scene, std::unique_ptr<SurfaceBuilder> builder,
                 int warm_up_frames = temporal_warm_up_frames,
                 SurfaceTimeline::Eye eye = SurfaceTimeline::Eye::none, int slots = 0);
    /// Instead of those, before the first frame.
    void build_with(const Scene& scene, std::unique_ptr<SurfaceBuilder> builder);
    const Scene& scene() const { return *scene_.load(std::memory_order_acquire); }
    SurfaceTimeline& timeline() { return timeline_; }
    const SurfaceTimeline& timeline() const { return timeline_; }

    // Which frame comes next: the thread that reads.
    const ReadPlace& place() const { return place_; }
    void go_to(const ReadPlace& place) { place_ = place; }
    /// Where reading an epoch begins: at the frame at its start, at most the last of `frames` (nothing or 0:
    /// unknown), or at a temporal filter's warm-up frames before.
    ReadPlace first_place(std::uint64_t epoch, std::int64_t start_ns,
                          std::optional<std::int64_t> frames) const;
    /// Reads that epoch from the frame on, with a temporal filter from the warm-up frames before the epoch's
    /// first.
    void return_to(const MediaMoment& moment, std::int64_t frame);
    /// Goes to the moment's epoch if that is later. True: reading begins anew there.
    bool follow(const MediaMoment& moment, std::optional<std::int64_t> frames);
    /// The next frame, if there is room for it; nothing after the last of `frames`, which ends the epoch.
    std::optional<std::int64_t> wanted(const MediaMoment& moment, std::int64_t frames);
    /// Frames up to this one were read or are left out. The frame as it is to be fed.
    FedFrame taken(RawFrame raw);

    // The thread that builds. Without a temporal filter, a frame whose touch planes are unchanged republishes
    // the one before.
    /// Whether the frames around a moment are published.
    bool has(const MediaMoment& moment) const;
    /// Begins a frame; up to the builder's `frames_in_flight` before `publish`.
    Result<void> begin(FedFrame frame);
    std::size_t begun() const { return begun_.size(); }
    /// Finishes and publishes the frame begun first. Nothing: the timeline has no room yet.
    Result<std::optional<Published>> publish(const OnBuilt& on_built = {});
    /// Both, unless there is no room; then it has not begun.
    Result<std::optional<Published>> give(FedFrame frame, const OnBuilt& on_built = {});
    /// Finishes what was begun, and publishes none of it.
    Result<void> forget();
    const SurfaceBuilder& builder() const { return *builder_; }
    /// The frame built last; it stays until the next one is built. Null: none.
    const SurfaceFrame* newest() const { return newest_built_; }

private:
    bool is_unchanged(const RawFrame& raw) const;

    std::atomic<const Scene*> scene_ = nullptr;
    std::unique_ptr<SurfaceBuilder> builder_;
    int warm_up_frames_;      // 0 without such a filter
    bool remembers_ = false;  // a temporal filter makes another surface even of the same frame
    SurfaceTimeline timeline_;
    ReadPlace place_;
    std::deque<Published> begun_;  // and not finished
    std::optional<RawFrame> newest_;  // begun last, of those that are shown
    const SurfaceFrame* newest_built_ = nullptr;
};

/// The ticks of a hand over a surface.
class TouchRun {
public:
    /// `surface` outlives this. `log`: may be open, for commands that come during the run; null: none come.
    explicit TouchRun(SurfaceQueue& surface, std::shared_ptr<PlaybackLog> log = nullptr);
    TouchRun(SurfaceQueue& surface, std::shared_ptr<PlaybackLog> log, const TouchSolver& solver,
             const GuardSettings& guard, int fingers);
    /// Before the first goals; the solver's scale may be that of the first frames met.
    void touch(const TouchSolver& solver, const GuardSettings& guard, int fingers);

    int fingers() const { return step_->fingers(); }
    /// Memory for the goals of the next `solve`, and for what the hand says of them (TouchStep::hops).
    std::span<glm::dvec3> goals() { return step_->goals(); }
    std::span<std::uint8_t> hops() { return step_->hops(); }
    PlaybackLog& log() const { return *log_; }

    /// The clip's moment at a tick, which takes the commands that have come. Ticks must not decrease.
    MediaMoment moment_at(std::int64_t tick);
    /// The clip's clock at the tick met last. Any thread.
    PlaybackState playback() const { return board_.read(); }
    /// A copy for a reader that looks ahead.
    const PlaybackClock& clock() const { return clock_; }

    /// Takes the frames around the tick's moment, by the clip's clock or as given: those that are there.
    /// False: none was published yet. `after_gap`, or `come_back` before: the hand was left alone
    /// (TouchStep), as the caller's clock says.
    bool meet(std::int64_t tick, bool after_gap = false);
    bool meet(std::int64_t tick, const MediaMoment& moment);
    void come_back() { step_->come_back(); }
    /// The same with given frames, at a given time.
    void meet(std::int64_t tick, std::int64_t time_ns, const FramePair& pair, bool after_gap = false);
    std::int64_t tick() const { return tick_; }  ///< met last
    const FramePair& pair() const { return pair_; }
    /// The surface that was met; there are frames.
    HeightField field() const { return {surface_.scene(), pair_}; }
    /// The tick that was met, with the goals. Spans are valid until the next call.
    TouchTick solve();
    /// Of all ticks so far.
    const ForceHash& hash() const { return hash_; }
    /// For a loop in real time.
    HapticTicks ticks();

    // A moment of a run, for another process or another try: fingers, guards, clock with its commands, and
    // hash; no frames. Not for a live source, whose frames do not come again; the hand is the caller's.
    /// After a tick: some hundred bytes a finger, which the same run on any machine and builder has too.
    std::vector<std::uint8_t> save();
    /// Into a run that has the settings and scene of the one that was saved, with a queue that has met no
    /// frame of another epoch: the next tick is the one after. The queue wants the frames around `moment`
    /// first; `resume` takes them, or refuses others. Error (input): damaged, of another version, other
    /// rules, scene or settings; nothing was changed.
    Result<void> load(std::span<const std::uint8_t> saved);
    const MediaMoment& moment() const { return moment_; }  ///< of the tick met last
    Result<void> resume();

private:
    SurfaceQueue& surface_;
    std::shared_ptr<PlaybackLog> log_;
    PlaybackClock clock_;
    PlaybackBoard board_;
    std::optional<TouchSolver> solver_;
    std::optional<TouchStep> step_;
    /// What a saved moment says of its frames.
    struct SavedPair {
        std::int64_t prev = -1, next = -1;
        double blend = 0;
        std::uint64_t epoch = 0;
        std::uint64_t content = 0;  ///< of both frames: depth, properties and heights
        bool operator==(const SavedPair&) const = default;
    };
    struct Saved;
    SavedPair pair_now() const;

    GuardSettings guard_;
    ForceHash hash_;
    std::int64_t tick_ = 0, time_ns_ = 0;
    MediaMoment moment_;
    FramePair pair_;
    SavedPair expected_;  // by `resume`
};

}  // namespace touchable
