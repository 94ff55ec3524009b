#pragma once

#include <deque>
#include <functional>

#include "engine/base/threads.hpp"
#include "player/run/playback.hpp"
#include "player/run/surface_feed.hpp"

namespace touchable {

/// A feed that runs by itself, for live touch: one thread decodes, one builds and publishes as fast as the
/// timeline has room. They meet at a short queue.
///
/// Where commands may come while it runs (PlaybackLog), what lies ahead is a guess. Frames of an epoch that
/// the hand is not in yet wait undecided in the queue; when a command leads elsewhere, the thread that
/// decodes takes them back and goes at once to where the hand is. Frames of an epoch that the hand has left
/// are not built. So a published frame always belongs to an epoch that was played, and no epoch's number is
/// used twice.
class FeedThreads : NonCopyable {
public:
    /// Whether a frame that has just been published was needed before; asked by the thread that builds.
    using IsLate = std::function<bool(const RawFrame&)>;
    /// Which moment the hand is at; asked by both threads. The commands that led there are in the clock's
    /// log.
    using Now = std::function<MediaMoment()>;
    /// `feed` outlives this, and is left alone from `start` to `stop`. `ahead`: the clip's clock at the
    /// moment that `feed` has come to, which tells of the epochs that are to come: each is read as soon as
    /// all that is wanted of the one before has been, or the hand is there already.
    FeedThreads(SurfaceFeed& feed, IsLate is_late, PlaybackClock ahead, Now now);
    /// Of a clip that is played once, from its beginning.
    FeedThreads(SurfaceFeed& feed, IsLate is_late)
        : FeedThreads(feed, std::move(is_late), PlaybackClock(FrameRate{}), [] { return MediaMoment{}; }) {}
    ~FeedThreads();  ///< stops them

    /// Once. An error where the machine has no thread left; none runs then.
    Result<void> start();
    void stop();
    /// Commands have come; does nothing where none have.
    void look_at_commands();
    /// How many frames they have published so far.
    std::int64_t published() const { return published_.load(std::memory_order_acquire); }
    /// How many frames were late, so far.
    std::int64_t late_frames() const { return late_frames_.load(std::memory_order_relaxed); }
    /// Whether the next frame is of an epoch that the hand has not come to, as after the last frames before a
    /// loop's way back.
    bool waits_for_the_hand() const;
    /// End of the clip's last frame in the last epoch once all are published; until a command leads away.
    std::optional<MediaMoment> end() const;
    /// Why they ended early, if they did.
    std::optional<Error> error() const;

private:
    /// For the builder: a frame of an epoch, or only that there are no more.
    struct Queued {
        ReadPlace place;  // after it
        std::optional<FedFrame> frame;
        bool ends_epoch = false;
    };
    enum class Turn { early, due, past };

    void guarded(void (FeedThreads::*work)());
    void fail(Error&& error);
    // Of the thread that decodes.
    void decode();
    Result<void> read_on();
    Result<void> follow_commands();
    Result<void> go_to(const MediaMoment& hand);
    Result<void> go_on(std::uint64_t wanted);
    std::ptrdiff_t frames_waiting() const;
    bool hand_over();
    // Of the thread that builds.
    void build();
    std::optional<Queued> wait_for_next();
    Turn turn_of(const Queued& queued) const;
    bool publish(const Queued& queued);

    SurfaceFeed& feed_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::stop_source stopping_;  // asked to stop under mutex_, which guards what follows, too
    std::deque<Queued> queue_;
    bool decoded_all_ = false;
    std::optional<MediaMoment> end_;
    std::optional<Error> error_;
    Error out_of_memory_;  // made at the start, while there is memory for it
    const IsLate is_late_;
    const Now now_;
    const bool commands_may_come_;
    // Of the thread that decodes.
    PlaybackClock known_;  // at the newest command that it knows
    PlaybackClock ahead_;  // at the coming epoch
    std::optional<ComingEpoch> coming_;
    std::optional<Queued> next_;                               // read, and not in the queue yet
    bool all_is_read_ = false;                                 // that is wanted of the epoch
    std::vector<ReadPlace> left_;                              // epochs that may have to be gone on with
    std::atomic<std::int64_t> published_{0}, late_frames_{0};  // counted by the builder
    std::thread decoder_, builder_;
};

}  // namespace touchable
