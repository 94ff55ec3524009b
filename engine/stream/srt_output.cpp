// SPDX-License-Identifier: Apache-2.0
// Streams sent by SRT: listeners, each at the pace of its link, and the thread that takes callers, or calls.

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/stream/listeners.hpp"
#include "engine/stream/sending.hpp"
#include "engine/stream/srt.hpp"

namespace touchable {
namespace {

constexpr std::int64_t ns_per_ms = 1'000'000;
constexpr int longest_srt_call_ms = 3000;

/// One listener by SRT. It gets the stream at the pace of its link; if that is too slow, whole framesets are
/// left out for it alone. Never waits. Times are of a steady clock, ns.
class SrtListener : NonCopyable {
public:
    /// The socket is connected. The ring and the audience outlive it.
    SrtListener(SrtSocket socket, std::string name, const StreamRing& ring, StreamAudience& audience,
                std::int64_t now_ns)
        : socket_(std::move(socket)),
          name_(std::move(name)),
          ring_(ring),
          audience_(audience),
          begin_ns_(now_ns),
          cursor_(ring.join()),
          progress_ns_(now_ns) {
        audience_.came(name_);
    }

    ~SrtListener() { end("is cut off"); }

    /// Sends what there is and fits.
    void go_on(std::int64_t now_ns) {
        if (phase_ == Phase::over) return;
        if (socket_.state() == SrtSocket::State::gone) return end("has gone");
        look(now_ns);
        read();
        if (phase_ == Phase::listens) write(now_ns);
        if (phase_ == Phase::leaves) leave(now_ns);
        probe(now_ns);
        if (phase_ != Phase::over && now_ns - progress_ns_ > StreamListener::longest_piece_ns)
            end("took no whole frameset for 10 s");
    }

    /// Whether it can be removed.
    bool is_over() const { return phase_ == Phase::over; }
    /// Whether it was sent anything, and stayed for a second.
    bool has_stayed(std::int64_t now_ns) const {
        constexpr std::int64_t short_ns = 1'000'000'000;
        return sent_ > 0 && now_ns - begin_ns_ >= short_ns;
    }

private:
    enum class Phase { listens, leaves, over };
    /// Measures how quickly bytes arrive.
    void look(std::int64_t now_ns) {
        constexpr std::int64_t figures_every_ns = 50 * ns_per_ms;
        if (now_ns >= next_figures_ns_) {
            next_figures_ns_ = now_ns + figures_every_ns;
            link_ = socket_.figures().value_or(link_);
            // A burst overflows the short queue of a narrow link, so its datagrams are paced.
            const std::int64_t rate = rate_.bytes_per_second();
            const bool is_paced = now_ns < paced_until_ns_ && !rate_.is_growing();
            socket_.pace(is_paced ? std::max<std::int64_t>(2 * rate, 1 << 17) : 0);
        }
        const std::int64_t before =
            std::exchange(arrived_, handed_over_ - static_cast<std::int64_t>(socket_.unacknowledged_bytes()));
        if (arrived_ != before || arrived_ == handed_over_) {
            progress_ns_ = now_ns;
            probes_ = 0;
        }
        if (timed_byte_ > 0 && arrived_ >= timed_byte_) {
            rtt_ns_ = now_ns - timed_since_ns_;
            timed_byte_ = 0;
        }
        rate_.look({.now_ns = now_ns,
                    .arrived_bytes = arrived_,
                    .datagrams = link_.datagrams,
                    .lost = link_.lost,
                    .rtt_ns = std::exchange(rtt_ns_, 0),
                    .is_full = std::exchange(is_full_, false)});
    }

    /// Nothing is expected from a listener, and libsrt keeps little of it.
    void read() {
        std::array<std::uint8_t, SrtSocket::longest_message> bytes;
        const auto got = socket_.receive(bytes, 0).bytes;
        heard_bytes_ += got > 0 ? static_cast<std::size_t>(got) : 0;
        if (heard_bytes_ > StreamListener::most_heard_bytes) end("sends, but a listener has nothing to send");
    }

    /// A receiver notices a loss by what comes behind it. It would never know of lost datagrams with nothing
    /// behind them, as before the end of its handshake or at the stream's end, so padding follows.
    void probe(std::int64_t now_ns) {
        constexpr std::int64_t shortest_ns = 100 * ns_per_ms;
        if (phase_ == Phase::over || !rest_.empty() || arrived_ == handed_over_) return;
        const auto rtt_ns = static_cast<std::int64_t>(link_.rtt_ms * static_cast<double>(ns_per_ms));
        const std::int64_t wait_ns =
            back_off(std::chrono::nanoseconds(std::max(shortest_ns, 2 * rtt_ns)), probes_).count();
        if (probes_ == 0) next_probe_ns_ = progress_ns_ + wait_ns;
        if (now_ns < next_probe_ns_) return;
        const auto done = socket_.send(ring_.padding());
        handed_over_ += std::max<std::ptrdiff_t>(done, 0);
        ++probes_;
        next_probe_ns_ = now_ns + 2 * wait_ns;
    }

    void write(std::int64_t now_ns) {
        while (phase_ == Phase::listens && (!rest_.empty() || take_piece(now_ns))) {
            const auto done = socket_.send(rest_);
            if (done < 0) return end("has gone");
            if (timed_byte_ == 0 && done > 0) {
                timed_byte_ = handed_over_ + 1;
                timed_since_ns_ = now_ns;
            }
            rest_ = rest_.subspan(static_cast<std::size_t>(done));
            handed_over_ += done;
            if (!rest_.empty()) return;
        }
    }

    /// Takes the next piece; false: there is none, or it has to wait.
    bool take_piece(std::int64_t now_ns) {
        constexpr std::int64_t paced_ns = 2'000'000'000;
        if (!has_header_) {
            const auto header = ring_.header();
            if (!header) return false;
            has_header_ = true;
            piece_ = header;
            rest_ = *header;
            return true;
        }
        if (ring_.is_over(cursor_)) {
            phase_ = Phase::leaves;
            return false;
        }
        if (!ring_.has_next(cursor_)) {
            narrow_.has_caught_up();
            return false;
        }
        if (handed_over_ - arrived_ > rate_.window_bytes()) {
            is_full_ = true;
            const bool loses_colour = narrow_.is_behind(now_ns, rate_.is_growing());
            if (loses_colour && !std::exchange(is_said_, true)) audience_.goes_without_colour(name_);
            paced_until_ns_ = now_ns + paced_ns;
            return false;
        }
        if (narrow_.is_far_behind(now_ns) && ring_.go_to_newest_key(cursor_)) narrow_.has_caught_up();
        const auto block = ring_.next(cursor_);
        ++sent_;
        piece_ = block;
        rest_ = block->given(narrow_.gives_colour(block->is_key, now_ns));
        without_colour_ += rest_.size() < block->bytes.size() ? 1 : 0;
        return true;
    }

    /// Waits before closing: that loses bytes under way, and after all have arrived, the receiver holds them
    /// for its latency.
    void leave(std::int64_t now_ns) {
        constexpr std::int64_t more_ms = 200;
        if (arrived_ < handed_over_) return;
        if (!leaves_at_ns_)
            leaves_at_ns_ =
                now_ns + (socket_.peer_latency_ms() + 2 * static_cast<std::int64_t>(link_.rtt_ms) + more_ms) *
                             ns_per_ms;
        if (now_ns >= *leaves_at_ns_) end("");
    }

    void end(const std::string& why) {
        if (phase_ == Phase::over) return;
        link_ = socket_.figures().value_or(link_);
        audience_.went({name_, sent_, cursor_.dropped(), without_colour_, why, link_});
        phase_ = Phase::over;
        socket_.close();
    }

    SrtSocket socket_;
    const std::string name_;
    const StreamRing& ring_;
    StreamAudience& audience_;
    const std::int64_t begin_ns_;
    Phase phase_ = Phase::listens;
    StreamRing::Cursor cursor_;
    LinkRate rate_;
    StreamFigures::Link link_{};
    std::int64_t next_figures_ns_ = 0;
    std::int64_t handed_over_ = 0, arrived_ = 0;  // bytes
    // Round trip, timed by one byte after the other: libsrt reports 100 ms at first, and for long.
    std::int64_t timed_byte_ = 0, timed_since_ns_ = 0, rtt_ns_ = 0;
    std::size_t heard_bytes_ = 0;  // received, though a listener has nothing to send
    std::int64_t progress_ns_;     // when bytes last arrived, or none were under way
    bool is_full_ = false;         // more would be sent if more might be under way
    std::int64_t next_probe_ns_ = 0;
    int probes_ = 0;  // since bytes last arrived
    NarrowLink narrow_;
    bool is_said_ = false;  // the loss of its colour was reported
    std::int64_t paced_until_ns_ = 0;
    std::int64_t sent_ = 0, without_colour_ = 0;  // framesets
    std::optional<std::int64_t> leaves_at_ns_;
    // The piece that is being sent.
    bool has_header_ = false;
    std::shared_ptr<const void> piece_;
    std::span<const std::uint8_t> rest_;
};

class SrtSender final : public SrtOutput {
public:
    SrtSender(const StreamUrl& url, SrtSettings settings, const StreamRing& ring, StreamAudience& audience)
        : SrtOutput(url), settings_(std::move(settings)), ring_(ring), audience_(audience) {}
    ~SrtSender() override {
        SrtSender::end();
        if (thread_.joinable()) thread_.join();
        door_.close();  // before may_come_ is gone
    }
    Result<void> open_door() {
        const auto address = own_address(url_);
        if (!address) return usage_error("must be an address of this machine in numbers");
        TRY_ASSIGN(door_, SrtSocket::create(settings_, SrtSocket::Direction::sends));
        return door_.listen(*address, may_come_);
    }
    Result<void> start() override {
        return start_thread(thread_, "stream-output", "that sends a stream", [this] { serve(); });
    }
    void end() override { stop_.request_stop(); }
    bool is_over() const override { return is_over_; }
    bool calls() const override { return !settings_.listens; }

private:
    void serve() {
        constexpr std::chrono::milliseconds turn_of_listeners{5}, turn_of_none{20};
        const StopScope goes_on = StopScope::after_stop();  // only `end` ends it
        const StopScope until(stop_.get_token());
        auto newest = ring_.join();
        while (!stop_requested()) {
            turn(steady_now_ns());
            const bool is_ended = ring_.is_ended();
            if (is_ended && listeners_.empty()) break;
            if (is_ended)
                (void)wait_unless_stopped(std::chrono::steady_clock::now() + turn_of_listeners);
            else  // the next frameset ends the wait
                (void)ring_.wait_next(newest, listeners_.empty() ? turn_of_none : turn_of_listeners);
        }
        listeners_.clear();
        is_over_ = true;
    }
    void turn(std::int64_t now_ns) {
        if (settings_.listens)
            take_callers(now_ns);
        else
            go_on_calling(now_ns);
        for (const auto& listener : listeners_) listener->go_on(now_ns);
        if (!settings_.listens && !listeners_.empty() && listeners_.front()->is_over()) {
            const bool stayed = listeners_.front()->has_stayed(now_ns);
            if (stayed) {
                calls_in_vain_ = 0;
                is_said_ = is_short_said_ = false;
            } else if (!stop_requested() && !ring_.is_ended() && !std::exchange(is_short_said_, true)) {
                audience_.remark(url_.name() + ": goes again within a second; called less and less often");
            }
            if (!stayed) call_later(steady_now_ns());  // closing takes a while
        }
        std::erase_if(listeners_, [](const auto& listener) { return listener->is_over(); });
        if (const auto line = srt_log_line(now_ns)) audience_.remark(*line);
    }
    void take_callers(std::int64_t now_ns) {
        while (auto caller = door_.accept()) {
            if (!audience_.has_room()) {
                ++refused_;
                continue;
            }
            listeners_.push_back(std::make_unique<SrtListener>(
                std::move(caller->first), "srt://" + caller->second.text(), ring_, audience_, now_ns));
        }
        say_refusals(now_ns);
    }
    void go_on_calling(std::int64_t now_ns) {
        if (!listeners_.empty() || ring_.is_ended()) return;
        if (!calling_.is_open()) {
            if (now_ns >= next_call_ns_) begin_call(now_ns);
            return;
        }
        switch (calling_.state()) {
            case SrtSocket::State::calling:
                return;
            case SrtSocket::State::connected:
                listeners_.push_back(std::make_unique<SrtListener>(std::exchange(calling_, SrtSocket()),
                                                                   url_.name(), ring_, audience_, now_ns));
                return;
            case SrtSocket::State::gone:
                return call_failed(calling_.refusal().why, now_ns);
        }
    }
    void begin_call(std::int64_t now_ns) {
        // Looking up the host may take long.
        const auto address = unless_stopped([url = url_] { return look_up(url); });
        if (stop_requested()) return;
        if (!address || !*address) return call_failed("no host of that name", now_ns);
        auto socket = SrtSocket::create(settings_, SrtSocket::Direction::sends);
        if (!socket) return call_failed(socket.error().message, now_ns);
        calling_ = std::move(*socket);
        if (auto called = calling_.call(**address, longest_srt_call_ms); !called)
            call_failed(called.error().message, now_ns);
    }
    /// Reports failed calls once, until the other end answers.
    void call_failed(const std::string& why, std::int64_t now_ns) {
        calling_.close();
        call_later(now_ns);
        if (stop_requested() || ring_.is_ended() || std::exchange(is_said_, true)) return;
        audience_.remark(url_.name() + ": no answer (" + why + "); tried again until there is one");
    }
    void call_later(std::int64_t now_ns) {
        constexpr std::chrono::milliseconds at_first{500};
        next_call_ns_ = now_ns + back_off(at_first, calls_in_vain_++).count();
    }
    /// At most one line every 10 s, however many call.
    void say_refusals(std::int64_t now_ns) {
        constexpr std::int64_t silence_ns = 10'000'000'000;
        if (refused_ == 0 || now_ns < next_refusal_said_ns_) return;
        next_refusal_said_ns_ = now_ns + silence_ns;
        const std::int64_t refused = refused_.exchange(0);
        audience_.remark(url_.name() + ": " + counted(refused, "caller is", "callers are") +
                         " refused: there are " + std::to_string(StreamAudience::most_listeners) +
                         " listeners, which is as many as there may be");
    }

    const SrtSettings settings_;
    const StreamRing& ring_;
    StreamAudience& audience_;
    std::stop_source stop_;
    std::atomic<bool> is_over_{false};
    std::atomic<std::int64_t> refused_{0};
    std::function<bool()> may_come_ = [this] {
        const bool may = audience_.has_room();
        if (!may) ++refused_;
        return may;
    };
    SrtSocket door_;     // listens for callers
    SrtSocket calling_;  // calls, until the other end answers
    std::vector<std::unique_ptr<SrtListener>> listeners_;
    int calls_in_vain_ = 0;
    std::int64_t next_call_ns_ = 0, next_refusal_said_ns_ = 0;
    bool is_said_ = false, is_short_said_ = false;
    std::thread thread_;
};

}  // namespace

Result<std::unique_ptr<SrtOutput>> SrtOutput::create(const StreamUrl& url, const StreamRing& ring,
                                                     StreamAudience& audience) {
    const auto refused = [&](const std::string& right) {
        return usage_error(in_quotes(url.name()) + " cannot be sent to: " + right);
    };
    const auto failed = [&](const Error& error) {
        return error.kind == ErrorKind::usage ? refused(error.message)
                                              : input_error(url.name() + ": " + error.message);
    };
    if (url.transport != StreamTransport::srt) return refused("must be srt://");
    if (url.port == 0) return refused("it needs a port from 1 to 65535");
    auto settings = read_srt_settings(url);
    if (!settings) return failed(settings.error());
    settings->listens = !settings->says_mode || settings->listens;
    if (!settings->listens && url.host.empty()) return refused("it names no host to call");
    auto output = std::make_unique<SrtSender>(url, std::move(*settings), ring, audience);
    if (!output->calls())
        if (auto opened = output->open_door(); !opened) return failed(opened.error());
    return std::unique_ptr<SrtOutput>(std::move(output));
}

}  // namespace touchable
