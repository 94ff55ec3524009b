#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "player/session/playback_clock.hpp"
#include "player/session/surface_feed.hpp"

namespace touchable {

/// A feed that runs by itself, for live touch: one thread decodes, one builds and publishes as fast as the
/// timeline has room. They meet at a short queue.
class FeedThreads {
public:
    /// Whether a frame that has just been published was needed before; asked by the thread that builds.
    using IsLate = std::function<bool(const RawFrame&)>;
    /// Which moment the hand is at; asked by the thread that decodes.
    using Now = std::function<MediaMoment()>;
    /// `feed` outlives this, and is left alone from `start` to `stop`. `ahead`: the clip's clock at the
    /// moment that `feed` has come to, which tells of the epochs that are to come: each is read as soon as
    /// all that is wanted of the one before has been, or the hand is there already.
    FeedThreads(SurfaceFeed& feed, IsLate is_late, PlaybackClock ahead, Now now);
    /// Of a clip that is played once, from its beginning.
    FeedThreads(SurfaceFeed& feed, IsLate is_late)
        : FeedThreads(feed, std::move(is_late), PlaybackClock(FrameRate{}), [] { return MediaMoment{}; }) {}
    ~FeedThreads();  ///< stops them
    FeedThreads(const FeedThreads&) = delete;
    FeedThreads& operator=(const FeedThreads&) = delete;

    /// Once. An error where the machine has no thread left; none runs then.
    Result<void> start();
    void stop();
    /// How many frames they have published so far.
    std::int64_t published() const { return published_.load(std::memory_order_acquire); }
    /// How many frames were late, so far.
    std::int64_t late_frames() const { return late_frames_.load(std::memory_order_relaxed); }
    /// End of the clip's last frame in the last epoch once all are published.
    std::optional<MediaMoment> end() const;
    /// Why they ended early, if they did.
    std::optional<Error> error() const;

private:
    void guarded(void (FeedThreads::*work)());
    void decode();
    bool queue_up(FedFrame&& frame);
    Result<bool> go_on(bool all_is_read);
    void build();
    void fail(Error&& error);

    SurfaceFeed& feed_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<FedFrame> queue_;  // guarded by mutex_, as are the four below
    bool decoded_all_ = false, stopping_ = false;
    std::optional<MediaMoment> end_;
    std::optional<Error> error_;
    Error out_of_memory_;  // made while there is memory to say it with
    const IsLate is_late_;
    const Now now_;
    // Of the thread that decodes.
    PlaybackClock ahead_;
    std::optional<ComingEpoch> coming_;
    std::atomic<std::int64_t> published_{0}, late_frames_{0};  // counted by the builder
    std::thread decoder_, builder_;
};

}  // namespace touchable
