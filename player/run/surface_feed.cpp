// SPDX-License-Identifier: Apache-2.0
#include "player/run/surface_feed.hpp"

#include <cstdlib>
#include <iterator>
#include <limits>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "player/run/terminal.hpp"

namespace touchable {
namespace {

constexpr int columns = 32, rows = 24;
constexpr std::size_t most_cuts = 4096;
/// A pixel has changed if its code differs by more than `another` times the range of both frames' codes; a
/// frame is a cut if more than cut_share of its pixels have changed.
constexpr double another = 1.0 / 12, cut_share = 0.4;

/// Whether much of a picture has changed; -1: invalid.
bool is_cut(const std::vector<int>& before, const std::vector<int>& now) {
    int least = std::numeric_limits<int>::max(), greatest = 0;
    for (const auto* codes : {&before, &now})
        for (const int code : *codes)
            if (code >= 0) {
                least = std::min(least, code);
                greatest = std::max(greatest, code);
            }
    const double far_away = another * std::max(0, greatest - least);  // no valid code: 0
    int others = 0;
    for (std::size_t k = 0; k < now.size(); ++k) {
        const bool same_state = (now[k] < 0) == (before[k] < 0);
        others += !same_state || std::abs(now[k] - before[k]) > far_away;
    }
    return others > cut_share * columns * rows;
}

double milliseconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

bool has(const std::vector<FrameRun>& dropped, std::uint64_t epoch, std::int64_t number) {
    return std::ranges::any_of(dropped, [&](const FrameRun& frames) {
        return frames.epoch == epoch && number >= frames.first && number < frames.first + frames.count;
    });
}

// Decoded frames that wait for the builder: enough to absorb slow frames, few enough to keep memory small.
constexpr std::ptrdiff_t queue_length = 3;
// How long the builder waits for the hand to move past a frame before it looks again: at first, and at most,
// as while a clip is paused.
constexpr std::chrono::milliseconds slot_wait(1), longest_slot_wait(8);

/// Whether the command may keep the clip from moments it would have reached without it. True for all but
/// play, pause and rate, which only change when they are reached.
bool leads_elsewhere(PlaybackVerb verb) {
    return verb != PlaybackVerb::play && verb != PlaybackVerb::pause && verb != PlaybackVerb::rate;
}

}  // namespace

void add_planes(const RawFrame& frame, ByteHash& hash) {
    for (const PlaneView* plane : {&frame.depth, &frame.haptic, &frame.height})
        for (int y = 0; !plane->empty() && y < plane->height; ++y)
            hash.add(plane->row(y), plane->row_bytes());
}

/// What only an eye needs, passed from the builder thread: the timeline's frames as stored, and cuts.
class SurfaceFeed::Watched {
public:
    /// Before the frame is published, so that no frame is seen without its planes.
    void keep(const RawFrame& raw) {
        if (!raw.storage) return;
        const std::lock_guard lock(mutex_);
        if (!frames_.empty() && frames_.back().epoch == raw.epoch && frames_.back().number == raw.number)
            return;
        frames_.push_back({raw.epoch, raw.number, {raw.colour, raw.depth, raw.storage}});
        // `storage` keeps the samples unchanged.
        frames_.back().planes.colour.content = new_content_number();
        if (frames_.size() > most) frames_.pop_front();
    }
    std::optional<HeldPlanes> find(std::uint64_t epoch, std::int64_t number) {
        const std::lock_guard lock(mutex_);
        const auto found = std::ranges::find_if(
            frames_, [&](const Frame& frame) { return frame.epoch == epoch && frame.number == number; });
        if (found == frames_.end()) return std::nullopt;
        frames_.erase(frames_.begin(), found);
        return frames_.front().planes;
    }
    /// Samples some 800 pixels and compares with the last frame looked at, if that is one or two frames
    /// earlier in the same epoch.
    void look(const RawFrame& frame, const DepthCoding& coding) {
        std::vector<int> codes;
        for (int row = 0; row < rows; ++row)
            for (int column = 0; column < columns; ++column) {
                const std::uint16_t code =
                    stored_code(frame.depth, coding, (2 * column + 1) * frame.depth.width / (2 * columns),
                                (2 * row + 1) * frame.depth.height / (2 * rows));
                codes.push_back(coding.is_valid(code) ? int{code} : -1);
            }
        const bool follows = frame.epoch == epoch_ && frame.number > number_ && frame.number <= number_ + 2;
        epoch_ = frame.epoch;
        number_ = frame.number;
        std::swap(codes, codes_);
        if (!follows || codes.empty() || !is_cut(codes, codes_)) return;
        const std::lock_guard lock(mutex_);
        if (cuts_.size() < most_cuts) cuts_.insert(frame.number);
    }
    std::set<std::int64_t> cuts() const {
        const std::lock_guard lock(mutex_);
        return cuts_;
    }

private:
    static constexpr std::size_t most = 32;  // more than the entries of a timeline with an eye
    struct Frame {
        std::uint64_t epoch;
        std::int64_t number;
        HeldPlanes planes;
    };
    mutable std::mutex mutex_;
    std::deque<Frame> frames_;  // guarded by mutex_, like cuts_
    std::set<std::int64_t> cuts_;
    // Builder thread: the last frame looked at.
    std::uint64_t epoch_ = 0;
    std::int64_t number_ = -1;
    std::vector<int> codes_;
};

SurfaceFeed::SurfaceFeed(std::unique_ptr<ClipReader> reader, std::unique_ptr<SurfaceBuilder> builder,
                         const Scene& scene, int warm_up_frames, SurfaceTimeline::Eye eye)
    : reader_(std::move(reader)),
      rate_(scene.rate),
      stored_(scene.depth),
      queue_(scene, std::move(builder), warm_up_frames, eye),
      watched_(eye == SurfaceTimeline::Eye::none ? nullptr : std::make_unique<Watched>()) {
    figures_.builder = builder_name();
}

SurfaceFeed::~SurfaceFeed() = default;

Result<void> SurfaceFeed::read_from(std::uint64_t epoch, std::int64_t start_ns) {
    return go_back(queue_.first_place(epoch, start_ns, reader_->frame_count()));
}

Result<void> SurfaceFeed::go_back(const ReadPlace& place) {
    queue_.go_to(place);
    const auto never_was = [&place](const FrameRun& frames) {
        return frames.epoch > place.epoch ||
               (frames.epoch == place.epoch && frames.first >= place.next_number);
    };
    std::erase_if(dropped_, never_was);
    {
        const std::lock_guard lock(figures_mutex_);
        figures_.dropped = dropped_frames();
    }
    return reader_->seek(place.next_number);
}

Result<void> SurfaceFeed::catch_up(const MediaMoment& now) {
    constexpr std::int64_t oldest = 2;  // frames behind the moment
    const ReadPlace place = queue_.place();
    if (!place.is_of(now) || reader_->is_live()) return {};
    std::int64_t due = rate_.frame_at(now.time_ns);
    if (const auto count = reader_->frame_count(); count && *count > 0) due = std::min(due, *count - 1);
    if (place.next_number < place.first_shown || place.next_number + oldest > due) return {};
    const std::int64_t there = reader_->access_point(due);
    return there > place.next_number ? reader_->seek(there) : Result<void>{};
}

std::int64_t SurfaceFeed::dropped_frames() const {
    std::int64_t all = dropped_long_ago_;
    for (const FrameRun& frames : dropped_) all += frames.count;
    return all;
}

Result<std::optional<FedFrame>> SurfaceFeed::read_next() {
    const auto start = std::chrono::steady_clock::now();
    auto raw = reader_->next();
    while (raw && *raw && has(left_out_, place().epoch, (*raw)->number)) raw = reader_->next();
    if (!raw) return raw.error();
    if (!*raw) return std::optional<FedFrame>();
    const double took_ms = milliseconds_since(start);
    read_ms_.add(took_ms);
    const std::int64_t dropped = std::max<std::int64_t>((*raw)->number - place().next_number, 0);
    if (dropped > 0) note_dropped(dropped);
    FedFrame frame = queue_.taken(std::move(**raw));
    const std::lock_guard lock(figures_mutex_);
    figures_.read_ms = took_ms;
    figures_.dropped += dropped;
    return std::optional(std::move(frame));
}

/// When the run is not recorded, only a count is kept, except for the epochs that reading may go back to.
void SurfaceFeed::note_dropped(std::int64_t frames) {
    constexpr std::uint64_t epochs_ahead = 16;  // more than can be read before the hand reaches the first
    dropped_.push_back({place().next_number, frames, place().epoch});
    if (hashed_) return;
    std::erase_if(dropped_, [this](const FrameRun& old) {
        if (old.epoch + epochs_ahead >= place().epoch) return false;
        dropped_long_ago_ += old.count;
        return true;
    });
}

void SurfaceFeed::note_built(const RawFrame& raw) {
    if (!hashed_) return;
    add_planes(raw, hash_);
    if (built_.empty() || built_.back().first + built_.back().count != raw.number)
        built_.push_back({raw.number, 0});
    ++built_.back().count;
}

Result<bool> SurfaceFeed::publish(const FedFrame& frame) {
    const auto start = std::chrono::steady_clock::now();
    if (frame.shown && watched_) watched_->keep(frame.raw);
    TRY_ASSIGN(const auto published, queue_.give(frame));
    if (published) note_published(*published, milliseconds_since(start));
    return published.has_value();
}

void SurfaceFeed::note_published(const SurfaceQueue::Published& published, double took_ms) {
    const RawFrame& raw = published.fed.raw;
    build_ms_.add(took_ms);
    note_built(raw);
    if (!published.fed.shown) return;
    any_valid_ = any_valid_ || has_valid_pixel(raw.depth, stored_);
    newest_number_ = raw.number;
    ++frames_;
    skipped_frames_ += published.unchanged ? 1 : 1 - queue_.builder().built_share();
    if (watched_) watched_->look(raw, stored_);
    const std::lock_guard lock(figures_mutex_);
    figures_.builder = queue_.builder().name();
    figures_.frames = frames_;
    figures_.build_ms = took_ms;
}

std::set<std::int64_t> SurfaceFeed::cuts() const {
    return watched_ ? watched_->cuts() : std::set<std::int64_t>();
}

std::optional<HeldPlanes> SurfaceFeed::stored_planes(std::uint64_t epoch, std::int64_t number) {
    return watched_ ? watched_->find(epoch, number) : std::nullopt;
}

FeedFigures SurfaceFeed::figures() const {
    const std::lock_guard lock(figures_mutex_);
    return figures_;
}

/// Reads and begins as many frames as the builder processes in parallel. A frame whose planes are valid only
/// until the next read must be finished first.
void SurfaceFeed::begin_ahead() {
    const std::size_t most =
        works_ahead_ ? static_cast<std::size_t>(queue_.builder().frames_in_flight()) : 1;
    while (!all_read_ && queue_.begun() < most && (queue_.begun() == 0 || may_begin_another_)) {
        auto frame = read_next();
        all_read_ = !frame || !*frame;
        if (!frame) unread_ = frame.error();
        if (all_read_) return;
        const auto start = std::chrono::steady_clock::now();
        may_begin_another_ = (*frame)->raw.storage != nullptr;
        if ((*frame)->shown && watched_) watched_->keep((*frame)->raw);
        if (auto begun = queue_.begin(std::move(**frame)); !begun) {
            unread_ = begun.error();
            all_read_ = true;
            return;
        }
        begin_ms_ += milliseconds_since(start);
    }
}

Result<void> SurfaceFeed::feed_next() {
    begin_ahead();
    if (queue_.begun() == 0) {
        if (unread_) return *unread_;
        ended_ = true;
        timeline().end_epoch();
        return {};
    }
    const auto start = std::chrono::steady_clock::now();
    TRY_ASSIGN(const auto published, queue_.publish());
    assert(published && "the reader of virtual time never holds more than two pairs");
    note_published(*published, std::exchange(begin_ms_, 0) + milliseconds_since(start));
    return {};
}

Result<void> SurfaceFeed::feed_to(const MediaMoment& moment) {
    if (moment.epoch > place().epoch) {
        TRY(queue_.forget());
        TRY(read_from(moment.epoch, moment.start_ns));
        ended_ = all_read_ = false;
        unread_.reset();
    }
    // Each pair_at lets the timeline release frames before the build, so a slot is free however far time
    // jumps.
    FramePair pair;
    while (!ended_ && !queue_.has(moment)) {
        if (stop_requested()) return interrupted_error();
        timeline().pair_at(moment, pair);
        TRY(feed_next());
    }
    return {};
}

Result<FramePair> SurfaceFeed::pair_at(const MediaMoment& moment) {
    TRY(feed_to(moment));
    FramePair pair;
    if (!timeline().pair_at(moment, pair))
        return input_error("the clip has no frames; there is nothing to touch");
    return pair;
}

Result<FramePair> SurfaceFeed::pair_of(std::int64_t prev, std::int64_t next, double blend,
                                       std::uint64_t epoch, std::int64_t start_ns) {
    const std::int64_t time_ns = reader_->taken_at(prev).value_or(rate_.time_ns(prev));
    auto pair = pair_at(MediaMoment{epoch, time_ns, start_ns});
    if (!pair) return pair;
    if (next == prev) pair->next = pair->prev;
    if (pair->prev.number != prev || pair->next.number != next)
        return input_error("the clip has no frames " + std::to_string(prev) + " and " + std::to_string(next) +
                           " side by side");
    pair->blend = next == prev ? 0.0 : blend;
    return pair;
}

FeedThreads::FeedThreads(SurfaceFeed& feed, IsLate is_late, PlaybackClock ahead, Now now)
    : feed_(feed),
      out_of_memory_(no_memory_for(
          "frames of " + size_text(feed.reader().scene().width, feed.reader().scene().height) + " pixels")),
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
