#pragma once

#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>

#include "player/surface_feed.hpp"

namespace touchable {

/// A feed that runs by itself, for live touch: one thread decodes, one builds and publishes as fast as the
/// timeline has room. They meet at a short queue.
class FeedThreads {
public:
    /// `feed` outlives this and is left alone until `stop`.
    explicit FeedThreads(SurfaceFeed& feed);
    ~FeedThreads();  ///< stops them
    FeedThreads(const FeedThreads&) = delete;
    FeedThreads& operator=(const FeedThreads&) = delete;

    void stop();
    /// End of the clip's last frame once all are published.
    std::optional<std::int64_t> end_ns() const;
    /// Why they ended early, if they did.
    std::optional<Error> error() const;

private:
    void guarded(void (FeedThreads::*work)());
    void decode();
    void build();
    void fail(const Error& error);

    SurfaceFeed& feed_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<RawFrame> queue_;  // guarded by mutex_, as are the four below
    bool decoded_all_ = false, stopping_ = false;
    std::optional<std::int64_t> end_ns_;
    std::optional<Error> error_;
    std::thread decoder_, builder_;
};

}  // namespace touchable
