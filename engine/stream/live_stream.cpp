// SPDX-License-Identifier: Apache-2.0
// A stream as a live source: a thread receives framesets, and the reader returns each when it is due.

#include <deque>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/readers.hpp"
#include "engine/stream/listeners.hpp"
#include "engine/stream/receiver.hpp"
#include "engine/stream/stream_bytes.hpp"

namespace touchable {
namespace {

/// A sender without a whole frameset for this time is reported as silent.
constexpr std::int64_t is_silent_ns = 1'000'000'000;
constexpr std::size_t most_waiting = 256, most_waiting_bytes = std::size_t{512} << 20;

/// When a frameset was taken, by our clock; `sent_ns` is by the sender's, ns since 1970. If the clocks differ
/// too much, the moment at which the frameset would have come by the shortest way.
std::int64_t taken_ns(std::int64_t sent_ns, const JitterBuffer::Moments& moments, std::int64_t arrived_ns) {
    constexpr std::int64_t longest_way_ns = 60'000'000'000, most_apart_ns = 5'000'000;
    const auto since_1970 = std::chrono::system_clock::now().time_since_epoch();
    const std::int64_t way_ns = std::chrono::nanoseconds(since_1970).count() - sent_ns;
    if (way_ns < -most_apart_ns || way_ns > longest_way_ns) return moments.taken_ns;
    return arrived_ns - std::max<std::int64_t>(way_ns, 0);
}

/// Sums up the figures of successive connections.
std::optional<StreamFigures::Levels> sum_of(const std::optional<StreamFigures::Levels>& before,
                                            const std::optional<StreamFigures::Levels>& now) {
    if (!before || !now) return now ? now : before;
    return StreamFigures::Levels{before->full_s + now->full_s, before->low_s + now->low_s,
                                 before->changes + now->changes, now->is_low};
}

class LiveStream final : public LiveReader {
public:
    LiveStream(const StreamSource& source, const std::optional<SceneDescription>& described)
        : LiveReader(source.url.name(), "stream"),
          source_(source),
          described_(described),
          buffer_(std::chrono::nanoseconds(source.latency).count()),
          pace_(std::chrono::nanoseconds(source.latency).count()) {
        if (source_.connection && !source_.connection->is_unread()) source_.connection.reset();
        if (!source_.connection) return;
        wait_ = source_.connection->waits();
        wait_->each_alone();  // the connection may have been made long before
    }
    ~LiveStream() override {
        {
            const std::lock_guard lock(mutex_);
            ending_.request_stop();
            changed_.notify_all();
        }
        if (thread_.joinable()) thread_.join();
    }
    Result<void> open() {
        TRY_ASSIGN(receiver_, connect());
        source_.connection.reset();
        take_meaning({receiver_->scene(), receiver_->unstated().filters});
        tracks_ = receiver_->tracks();
        notes_ = receiver_->notes();
        newest_ns_ = steady_now_ns();
        return start_thread(thread_, "stream", "that receives the stream", [this] {
            try {
                receive();
            } catch (const std::exception& fault) {
                is_over(std::string("cannot be received: ") + fault.what());
            }
        });
    }

    void leave_out_colour() override { leaves_out_colour_ = true; }
    std::vector<std::string> remarks() const override {
        std::vector<std::string> all = LiveReader::remarks();
        const std::lock_guard lock(mutex_);
        if (!figures_.reconnects.empty())
            all.push_back(figures_.reconnects);
        else if (const std::int64_t silent = steady_now_ns() - newest_ns_;
                 over_.empty() && silent > is_silent_ns)
            all.push_back(formatted("the sender has sent no whole frameset for %.0f s; it is waited for",
                                    1e-9 * static_cast<double>(silent)));
        if (figures_.connections > 1)
            all.push_back("the sender was connected to again, " + counted(figures_.connections - 1, "time"));
        if (const auto& levels = figures_.levels; levels && levels->is_low)
            all.push_back(
                "the link is too slow for the full level: the low one is read, every second frameset "
                "and coarser colour");
        else if (levels && levels->changes > 0)
            all.push_back(
                formatted("the link was too slow for the full level: for %.0f s the low one was read, "
                          "every second frameset and coarser colour",
                          levels->low_s));
        add_count(all, figures_.lost + given_up_ + overdue(steady_now_ns()),
                  "the stream's framesets were lost on the way, or left out by the sender");
        add_count(all, figures_.late, "the stream's framesets came late");
        add_count(all, without_colour_,
                  "the stream's framesets came without their colour, which a narrow link leaves out first");
        add_count(all, figures_.torn, "the stream's framesets were damaged on the way, and left out");
        return all;
    }
    std::optional<StreamFigures> stream_figures() const override {
        const std::lock_guard lock(mutex_);
        StreamFigures figures = figures_;
        const std::int64_t now = steady_now_ns();
        figures.lost += given_up_ + overdue(now);
        figures.held = figures.late + figures.lost + figures.torn;
        if (over_.empty())
            figures.longest_gap_ms =
                std::max(figures.longest_gap_ms, static_cast<double>(now - newest_ns_) * 1e-6);
        return figures;
    }

private:
    struct Waiting {
        Received received;
        JitterBuffer::Moments moments;
    };
    /// In a run: the newest frameset that is due.
    MaybeTaken poll() override {
        const std::lock_guard lock(mutex_);
        const std::int64_t now = steady_now_ns();
        if (waiting_.empty()) return over_.empty() ? MaybeTaken(std::nullopt) : gone(over_);
        if (has_begun()) {
            while (waiting_.size() > 1 && waiting_[1].moments.shown_ns <= now) (void)take_front();
            if (waiting_.front().moments.shown_ns > now) return std::optional<Taken>();
        }
        auto [received, moments] = take_front();
        return std::optional(Taken{static_cast<std::uint32_t>(received.number), moments.shown_ns,
                                   moments.shown_ns - moments.taken_ns, std::move(received.frame)});
    }
    /// Waits for any frameset, or until the first waiting one is due.
    void wait() override {
        std::unique_lock lock(mutex_);
        std::chrono::nanoseconds longest = stop_look;
        if (!waiting_.empty())
            longest = std::min(longest,
                               std::chrono::nanoseconds(waiting_.front().moments.shown_ns - steady_now_ns()));
        changed_.wait_for(lock, longest, [this, none = waiting_.empty()] {
            return none && !(waiting_.empty() && over_.empty());
        });
    }
    std::optional<Error> nothing_came(Moment since) const override {
        if (std::chrono::steady_clock::now() - since <= source_.patience.frameset) return std::nullopt;
        return input_error(name_ + ": sent no whole frameset in time");
    }
    void drain() override {}  // framesets are chosen by their due times
    Result<std::unique_ptr<StreamReceiver>> connect() const {
        return StreamReceiver::open(source_, wait_, described_, steady_now_ns);
    }
    void receive() {
        const StopScope goes_on = StopScope::after_stop();  // a stop of the program does not end it
        const StopScope until(ending_.get_token());
        while (true) {
            if (leaves_out_colour_) receiver_->leave_out_colour();
            auto received = receiver_->next(source_.patience.silence);
            note(*receiver_);
            if (received && *received) {
                put(std::move(**received));
                continue;
            }
            if (stop_requested()) return;
            if (!received && received.error().kind == ErrorKind::internal)
                return is_over(received.error().message);
            const std::string why =
                received ? receiver_->how_it_ended() : "is given up: " + in_short(received.error());
            const bool has_ended = received && source_.url.is_playlist();
            if (has_ended || source_.url.transport == StreamTransport::pipe) return is_over(why);
            if (!connect_again(why)) return;
        }
    }
    /// False if the stream is closed, or the sender now sends something else.
    bool connect_again(std::string why) {
        before_ += receiver_->counts();
        levels_before_ = sum_of(levels_before_, receiver_->levels());
        receiver_->hang_up();
        {
            const std::lock_guard lock(mutex_);
            given_up_ += overdue(steady_now_ns());
        }
        for (int attempt = 0;; ++attempt) {
            {
                std::unique_lock lock(mutex_);
                figures_.reconnects = "the sender " + why + "; connecting again";
                const auto pause = back_off(source_.patience.back_off, attempt);
                if (changed_.wait_for(lock, pause, stop_requested)) return false;
            }
            auto receiver = connect();
            if (stop_requested()) return false;
            if (!receiver) {
                why = "cannot be had: " + in_short(receiver.error());
                continue;
            }
            if (!(*receiver)->is_like(*receiver_)) {
                is_over("sends another scene or other planes than before: begin again to touch them");
                return false;
            }
            receiver_ = std::move(*receiver);
            buffer_.restart();
            const std::lock_guard lock(mutex_);
            ++figures_.connections;
            figures_.reconnects.clear();
            return true;
        }
    }
    /// The message without the stream's name at its beginning.
    std::string in_short(const Error& error) const {
        const std::string name = name_ + ": ";
        return error.message.starts_with(name) ? error.message.substr(name.size()) : error.message;
    }
    /// If framesets are not taken, the oldest are dropped; segments, which wait at their server, are not
    /// fetched.
    void put(Received received) {
        const std::int64_t now = steady_now_ns();
        const bool in_segments = source_.url.is_playlist();
        auto moments = in_segments ? pace_.add(received.sent_ns, now) : buffer_.add(received.sent_ns, now);
        moments.taken_ns = taken_ns(received.sent_ns, moments, now);
        std::unique_lock lock(mutex_);
        const auto has_room = [this] {
            return stop_requested() ||
                   (waiting_.size() < most_waiting / 2 && waiting_bytes_ < most_waiting_bytes / 2);
        };
        if (in_segments) changed_.wait(lock, has_room);
        figures_.longest_gap_ms =
            std::max(figures_.longest_gap_ms, static_cast<double>(now - newest_ns_) * 1e-6);
        newest_ns_ = now;
        waiting_bytes_ += bytes_of_planes(received.frame);
        waiting_.push_back({std::move(received), moments});
        while (waiting_.size() > 1 && (waiting_.size() > most_waiting || waiting_bytes_ > most_waiting_bytes))
            (void)take_front();
        changed_.notify_all();
    }
    void note(const StreamReceiver& receiver) {
        FramesetCounts counts = before_;
        counts += receiver.counts();
        const auto link = receiver.link();
        const std::lock_guard lock(mutex_);
        if (link) figures_.link = link;
        figures_.levels = sum_of(levels_before_, receiver.levels());
        figures_.whole = counts.whole;
        figures_.late = counts.late;
        figures_.lost = counts.lost;
        figures_.torn = counts.torn;
        figures_.repeated = counts.repeated;
        without_colour_ = counts.without_colour;
        figures_.delay_ms = static_cast<double>(buffer_.delay_ns()) * 1e-6;
    }
    void is_over(const std::string& why) {
        const std::lock_guard lock(mutex_);
        over_ = why;
        figures_.reconnects.clear();
        changed_.notify_all();
    }
    /// Framesets that the clip's rate says were sent while no whole one came; the next whole one shows how
    /// many were lost. Guarded by mutex_.
    std::int64_t overdue(std::int64_t now_ns) const {
        const std::int64_t period_ns = scene_.rate.time_ns(1), silent_ns = now_ns - newest_ns_;
        if (!over_.empty() || !figures_.reconnects.empty() || period_ns <= 0 || silent_ns < is_silent_ns)
            return 0;
        return silent_ns / period_ns - 1;
    }
    Waiting take_front() {
        Waiting front = std::move(waiting_.front());
        waiting_.pop_front();
        waiting_bytes_ -= bytes_of_planes(front.received.frame);
        changed_.notify_all();
        return front;
    }

    StreamSource source_;
    const std::optional<SceneDescription> described_;
    std::shared_ptr<StreamWait> wait_ = std::make_shared<StreamWait>();
    std::stop_source ending_;
    std::atomic<bool> leaves_out_colour_{false};
    // Receiving thread only.
    std::unique_ptr<StreamReceiver> receiver_;
    JitterBuffer buffer_;
    SegmentPace pace_;
    FramesetCounts before_;                               // of earlier connections
    std::optional<StreamFigures::Levels> levels_before_;  // the same

    mutable std::mutex mutex_;
    std::condition_variable changed_;
    // Guarded by mutex_.
    std::deque<Waiting> waiting_;
    std::size_t waiting_bytes_ = 0;
    StreamFigures figures_{.connections = 1};
    std::int64_t without_colour_ = 0;  // otherwise whole framesets
    std::int64_t newest_ns_ = 0;       // time of the last frameset
    std::int64_t given_up_ = 0;        // framesets overdue when a connection was given up
    std::string over_;                 // why no more will come; empty: more may
    std::thread thread_;
};

}  // namespace

Result<std::unique_ptr<ClipReader>> open_live_stream(const StreamSource& source,
                                                     const std::optional<SceneDescription>& described) {
    return opened_as<ClipReader>(std::make_unique<LiveStream>(source, described));
}

}  // namespace touchable
