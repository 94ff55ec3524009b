#include "player/run/feed_threads.hpp"

#include "engine/base/try.hpp"

namespace touchable {
namespace {

// Decoded frames that wait for the builder: enough to absorb slow frames, few enough to keep memory small.
constexpr std::ptrdiff_t queue_length = 3;
// How long the builder waits for the hand to move past a frame before it looks again: at first, and at most, as
// while a clip is paused.
constexpr std::chrono::milliseconds slot_wait(1), longest_slot_wait(8);

/// Whether the command may keep the clip from moments it would have reached without it. True for all but
/// play, pause and rate, which only change when they are reached.
bool leads_elsewhere(PlaybackVerb verb) {
    return verb != PlaybackVerb::play && verb != PlaybackVerb::pause && verb != PlaybackVerb::rate;
}

}  // namespace

FeedThreads::FeedThreads(SurfaceFeed& feed, IsLate is_late, PlaybackClock ahead, Now now)
    : feed_(feed),
      out_of_memory_(too_large(frames_in_words(feed.reader().scene()))),
      is_late_(std::move(is_late)),
      now_(std::move(now)),
      commands_may_come_(ahead.log().is_open()),
      known_(std::move(ahead)),
      ahead_(known_),
      coming_(ahead_.next_epoch()) {}

Result<void> FeedThreads::start() {
    auto begun =
        start_thread(decoder_, "feed-decoder", "that decodes", [this] { guarded(&FeedThreads::decode); });
    if (begun)
        begun =
            start_thread(builder_, "feed-builder", "that builds", [this] { guarded(&FeedThreads::build); });
    if (!begun) stop();
    return begun;
}

FeedThreads::~FeedThreads() {
    stop();
}

void FeedThreads::stop() {
    {
        const std::lock_guard lock(mutex_);
        stopping_.request_stop();
    }
    changed_.notify_all();
    if (decoder_.joinable()) decoder_.join();
    if (builder_.joinable()) builder_.join();
}

/// Catches every exception of a thread; the session then ends with this error and zero force. A stop of the
/// program also ends the work, because it ends the session's loop: with zero force the hand needs no frame.
void FeedThreads::guarded(void (FeedThreads::*work)()) {
    const StopScope until(stopping_.get_token());
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

/// Allocates nothing. Keeps the first error.
void FeedThreads::fail(Error&& error) {
    const std::lock_guard lock(mutex_);
    if (!error_) error_ = std::move(error);
    stopping_.request_stop();
    changed_.notify_all();
}

void FeedThreads::look_at_commands() {
    {
        const std::lock_guard lock(mutex_);  // no thread is between testing its condition and waiting
    }
    changed_.notify_all();
}

void FeedThreads::decode() {
    do {
        auto read = read_on();
        if (!read && stop_requested()) return;
        if (!read) return fail(Error(read.error()));
    } while (hand_over());
}

/// Reads the next frame, unless none is wanted or the last one read is not in the queue yet.
Result<void> FeedThreads::read_on() {
    const MediaMoment now = now_();  // before follow_commands, so that the commands up to `now` are known
    TRY(follow_commands());
    if (next_) return {};
    TRY(go_on(now.epoch));
    if (all_is_read_) return {};
    TRY(feed_.catch_up(now));
    TRY_ASSIGN(auto frame, feed_.read_next());
    all_is_read_ = !frame || (coming_ && frame->raw.time_ns >= coming_->left_ns);
    next_ = Queued{feed_.place(), std::move(frame), all_is_read_};
    return {};
}

/// Applies new commands: predicted epochs may be void, and more frames of the hand's epoch may be wanted.
Result<void> FeedThreads::follow_commands() {
    if (!known_.has_news()) return {};
    const std::size_t before = known_.known();
    const MediaMoment hand = known_.at_newest_command();
    bool elsewhere = false;
    for (std::size_t k = before; k < known_.known(); ++k)
        elsewhere = elsewhere || leads_elsewhere(known_.log()[k].verb);
    const ReadPlace reading = feed_.place();
    if (!reading.is_of(hand) && (reading.epoch <= hand.epoch || elsewhere)) TRY(go_to(hand));
    all_is_read_ = false;
    ahead_ = known_;
    do coming_ = ahead_.next_epoch();
    while (coming_ && coming_->number <= feed_.place().epoch);
    return {};
}

/// Returns to the hand's epoch from one that the hand has left or will never reach.
Result<void> FeedThreads::go_to(const MediaMoment& hand) {
    next_.reset();
    {
        const std::lock_guard lock(mutex_);
        std::erase_if(queue_, [&hand](const Queued& queued) { return queued.place.epoch > hand.epoch; });
    }
    const auto left =
        std::ranges::find_if(left_, [&hand](const ReadPlace& place) { return place.is_of(hand); });
    auto there = left == left_.end() ? feed_.read_from(hand.epoch, hand.start_ns) : feed_.go_back(*left);
    left_.clear();
    return there;
}

/// Goes to the coming epoch when it is due; skips epochs that the hand has left by then.
Result<void> FeedThreads::go_on(std::uint64_t wanted) {
    if (!coming_ || !(all_is_read_ || coming_->number <= wanted)) return {};
    ComingEpoch next = *coming_;
    for (coming_ = ahead_.next_epoch(); coming_ && coming_->number <= wanted; coming_ = ahead_.next_epoch())
        next = *coming_;
    std::erase_if(left_, [wanted](const ReadPlace& place) { return place.epoch < wanted; });
    if (commands_may_come_) left_.push_back(feed_.place());
    all_is_read_ = false;
    return feed_.read_from(next.number, next.start_ns);
}

/// Warm-up frames before an epoch's first do not count; otherwise a loop's way back would wait for them.
std::ptrdiff_t FeedThreads::frames_waiting() const {
    return std::ranges::count_if(queue_,
                                 [](const Queued& queued) { return queued.frame && queued.frame->shown; });
}

/// Queues the frame read for the builder once there is room, or waits for commands. False: no more to do.
bool FeedThreads::hand_over() {
    std::unique_lock lock(mutex_);
    // A camera's frames would only grow old in the queue.
    const std::ptrdiff_t room = feed_.reader().is_live() ? 1 : queue_length;
    const auto has_room = [&] { return next_ && frames_waiting() < room; };
    decoded_all_ = !next_;
    if (decoded_all_) changed_.notify_all();
    if (decoded_all_ && !commands_may_come_) return false;
    changed_.wait(lock, [&] { return stopping_.stop_requested() || known_.has_news() || has_room(); });
    if (known_.has_news()) {
        decoded_all_ = false;
        end_.reset();
    }
    if (!stopping_.stop_requested() && has_room()) {
        queue_.push_back(std::move(*next_));
        next_.reset();
        changed_.notify_all();
    }
    return !stopping_.stop_requested();
}

void FeedThreads::build() {
    while (const auto next = wait_for_next()) {
        if (next->frame && !publish(*next)) return;
        if (next->ends_epoch) feed_.end_epoch(next->place.epoch);
    }
}

/// Nothing once the threads must stop or everything is built.
std::optional<FeedThreads::Queued> FeedThreads::wait_for_next() {
    std::unique_lock lock(mutex_);
    while (true) {
        changed_.wait(lock, [this] {
            return stopping_.stop_requested() || !queue_.empty() || (decoded_all_ && !end_.has_value());
        });
        if (stopping_.stop_requested()) return std::nullopt;
        if (queue_.empty()) {
            end_ = feed_.end();
            if (!commands_may_come_) return std::nullopt;
            continue;
        }
        const Turn turn = turn_of(queue_.front());
        if (turn == Turn::early) {
            changed_.wait_for(lock, slot_wait);
            continue;
        }
        Queued next = std::move(queue_.front());
        queue_.pop_front();
        changed_.notify_all();
        if (turn == Turn::due) return next;
    }
}

/// past: of an epoch that the hand has left; early: of an epoch that it may never reach.
FeedThreads::Turn FeedThreads::turn_of(const Queued& queued) const {
    const MediaMoment now = now_();
    if (queued.place.epoch > now.epoch) return commands_may_come_ ? Turn::early : Turn::due;
    return queued.place.is_of(now) ? Turn::due : Turn::past;
}

/// False once the threads must stop.
bool FeedThreads::publish(const Queued& queued) {
    for (auto wait = slot_wait;; wait = std::min(2 * wait, longest_slot_wait)) {
        const auto published = feed_.publish(*queued.frame);
        if (!published) {
            if (!stop_requested()) fail(Error(published.error()));
            return false;
        }
        if (*published) {
            late_frames_ += queued.frame->shown && is_late_(queued.frame->raw);
            published_.fetch_add(queued.frame->shown, std::memory_order_release);
            return true;
        }
        std::unique_lock lock(mutex_);
        if (changed_.wait_for(lock, wait, [this] { return stopping_.stop_requested(); })) return false;
        if (turn_of(queued) == Turn::past) return true;
    }
}

bool FeedThreads::waits_for_the_hand() const {
    const std::lock_guard lock(mutex_);
    return !queue_.empty() && turn_of(queue_.front()) == Turn::early;
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
