#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "player/session/surface_feed.hpp"

namespace touchable {

/// A feed that runs by itself, for live touch: one thread decodes, one builds and publishes as fast as the
/// timeline has room. They meet at a short queue.
class FeedThreads {
public:
    /// Whether a frame that has just been published was needed before; asked by the thread that builds.
    using IsLate = std::function<bool(const RawFrame&)>;
    /// `feed` outlives this, and is left alone from `start` to `stop`.
    FeedThreads(SurfaceFeed& feed, IsLate is_late);
    ~FeedThreads();  ///< stops them
    FeedThreads(const FeedThreads&) = delete;
    FeedThreads& operator=(const FeedThreads&) = delete;

    /// Once. An error where the machine has no thread left; none runs then.
    Result<void> start();
    void stop();
    /// How many frames were, so far.
    std::int64_t late_frames() const { return late_frames_.load(std::memory_order_relaxed); }
    /// End of the clip's last frame once all are published.
    std::optional<std::int64_t> end_ns() const;
    /// Why they ended early, if they did.
    std::optional<Error> error() const;

private:
    void guarded(void (FeedThreads::*work)());
    void decode();
    void build();
    void fail(Error&& error);

    SurfaceFeed& feed_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<RawFrame> queue_;  // guarded by mutex_, as are the four below
    bool decoded_all_ = false, stopping_ = false;
    std::optional<std::int64_t> end_ns_;
    std::optional<Error> error_;
    Error out_of_memory_;  // made while there is memory to say it with
    const IsLate is_late_;
    std::atomic<std::int64_t> late_frames_{0};  // counted by the builder
    std::thread decoder_, builder_;
};

}  // namespace touchable
