#include "player/session/feed_threads.hpp"

#include <algorithm>
#include <chrono>
#include <exception>
#include <new>
#include <string>
#include <utility>

#include "engine/start_thread.hpp"
#include "player/session/memory.hpp"

namespace touchable {

namespace {

// Decoded frames that wait for the builder: enough to even out slow ones, few enough to keep memory small.
constexpr std::size_t queue_length = 3;
// How long the builder waits for the hand to move past a frame before it looks again.
constexpr std::chrono::milliseconds slot_wait(1);

}  // namespace

FeedThreads::FeedThreads(SurfaceFeed& feed, IsLate is_late, PlaybackClock ahead, Now now)
    : feed_(feed),
      out_of_memory_(too_large(frames_in_words(feed.reader().scene()))),
      is_late_(std::move(is_late)),
      now_(std::move(now)),
      ahead_(std::move(ahead)),
      coming_(ahead_.next_epoch()) {}

Result<void> FeedThreads::start() {
    auto begun = start_thread(decoder_, "that decodes", [this] { guarded(&FeedThreads::decode); });
    if (begun.ok()) begun = start_thread(builder_, "that builds", [this] { guarded(&FeedThreads::build); });
    if (!begun.ok()) stop();
    return begun;
}

FeedThreads::~FeedThreads() {
    stop();
}

void FeedThreads::stop() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    changed_.notify_all();
    feed_.interrupt();
    if (decoder_.joinable()) decoder_.join();
    if (builder_.joinable()) builder_.join();
}

/// Nothing thrown leaves a thread: the session ends with its reason, and the hand with zero force.
void FeedThreads::guarded(void (FeedThreads::*work)()) {
    try {
        try {
            (this->*work)();
        } catch (const std::bad_alloc&) {
            throw;
        } catch (const std::exception& fault) {
            fail({ErrorKind::internal, std::string("while frames were read: ") + fault.what()});
        }
    } catch (const std::bad_alloc&) {
        fail(std::move(out_of_memory_));
    }
}

/// Allocates nothing. The first reason counts.
void FeedThreads::fail(Error&& error) {
    const std::lock_guard lock(mutex_);
    if (!error_) error_ = std::move(error);
    stopping_ = true;
    changed_.notify_all();
}

/// To the epoch that is to come, if it is time; one that the hand has left behind by then is left out.
Result<bool> FeedThreads::go_on(bool all_is_read) {
    const std::uint64_t wanted = now_().epoch;
    if (!coming_ || !(all_is_read || coming_->number <= wanted)) return false;
    ComingEpoch next = *coming_;
    for (coming_ = ahead_.next_epoch(); coming_ && coming_->number <= wanted; coming_ = ahead_.next_epoch())
        next = *coming_;
    if (auto there = feed_.read_from(next.number, next.start_ns); !there.ok()) return there.error();
    return true;
}

/// False once the threads are to stop.
bool FeedThreads::queue_up(FedFrame&& frame) {
    std::unique_lock lock(mutex_);
    // What waits here of a camera would only grow old.
    const std::size_t room = feed_.reader().is_live() ? 1 : queue_length;
    changed_.wait(lock, [&] { return stopping_ || queue_.size() < room; });
    if (stopping_) return false;
    queue_.push_back(std::move(frame));
    changed_.notify_all();
    return true;
}

void FeedThreads::decode() {
    bool all_is_read = false;
    while (true) {
        const auto gone_on = go_on(all_is_read);
        if (!gone_on.ok()) return fail(Error(gone_on.error()));
        if (all_is_read && !*gone_on) break;
        MediaMoment now = now_();  // whose time may be of the next epoch already
        if (coming_) now.time_ns = std::min(now.time_ns, coming_->left_ns);
        if (auto caught_up = feed_.catch_up(now); !caught_up.ok()) return fail(Error(caught_up.error()));
        auto frame = feed_.read_next();
        if (!frame.ok() && frame.error().kind == ErrorKind::interrupted) return;
        if (!frame.ok()) return fail(Error(frame.error()));
        all_is_read = !*frame || (coming_ && (*frame)->raw.time_ns >= coming_->left_ns);
        if (*frame && !queue_up(std::move(**frame))) return;
    }
    const std::lock_guard lock(mutex_);
    decoded_all_ = true;
    changed_.notify_all();
}

void FeedThreads::build() {
    while (true) {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [this] { return stopping_ || decoded_all_ || !queue_.empty(); });
        if (stopping_) return;
        if (queue_.empty()) {
            feed_.timeline().end_epoch();
            end_ = feed_.end();
            return;
        }
        const FedFrame frame = std::move(queue_.front());
        queue_.pop_front();
        changed_.notify_all();
        lock.unlock();
        while (true) {
            const auto published = feed_.publish(frame);
            if (!published.ok()) return fail(Error(published.error()));
            if (*published) {
                late_frames_ += frame.shown && is_late_(frame.raw);
                published_.fetch_add(frame.shown, std::memory_order_release);
                break;
            }
            lock.lock();
            if (changed_.wait_for(lock, slot_wait, [this] { return stopping_; })) return;
            lock.unlock();
        }
    }
}

std::optional<MediaMoment> FeedThreads::end() const {
    const std::lock_guard lock(mutex_);
    return end_;
}

std::optional<Error> FeedThreads::error() const {
    const std::lock_guard lock(mutex_);
    return error_;
}

}  // namespace touchable
