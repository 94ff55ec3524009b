#pragma once

#include <deque>
#include <functional>

#include "engine/base/threads.hpp"
#include "player/run/playback.hpp"
#include "player/run/surface_feed.hpp"

namespace touchable {

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
    ~FeedThreads();  ///< calls stop

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
