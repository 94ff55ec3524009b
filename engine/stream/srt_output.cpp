#include "engine/stream/srt_output.hpp"

#include <algorithm>
#include <atomic>
#include <functional>
#include <thread>
#include <utility>
#include <vector>

#include "engine/base/printable.hpp"
#include "engine/base/start_thread.hpp"
#include "engine/base/try.hpp"
#include "engine/base/unless_stopped.hpp"
#include "engine/stream/sender_time.hpp"
#include "engine/stream/srt_listener.hpp"

namespace touchable {
namespace {

constexpr std::int64_t longest_call_ns = 3'000'000'000, ns_per_millisecond = 1'000'000;

class SrtSender final : public SrtOutput {
public:
    SrtSender(const StreamUrl& url, SrtSettings settings, const StreamRing& ring, StreamAudience& audience)
        : SrtOutput(url), settings_(std::move(settings)), ring_(ring), audience_(audience) {}
    ~SrtSender() override {
        SrtSender::end();
        if (thread_.joinable()) thread_.join();
        door_.close();  // before what it asks is gone
    }
    Result<void> open_door();
    Result<void> start() override {
        return start_thread(thread_, "stream-output", "that sends a stream", [this] { serve(); });
    }
    void end() override {
        stop_ = true;
        time_.end();
    }
    bool is_over() const override { return is_over_; }
    bool calls() const override { return !settings_.listens; }

private:
    void serve();
    void turn(std::int64_t now_ns);
    void take_callers(std::int64_t now_ns);
    void go_on_calling(std::int64_t now_ns);
    void begin_call(std::int64_t now_ns);
    void call_failed(const std::string& why, std::int64_t now_ns);
    void call_later(std::int64_t now_ns);
    void say_refusals(std::int64_t now_ns);

    const SrtSettings settings_;
    const StreamRing& ring_;
    StreamAudience& audience_;
    SteadySenderTime time_;
    std::atomic<bool> stop_{false}, is_over_{false};
    std::atomic<std::int64_t> refused_{0};
    std::function<bool()> may_come_ = [this] {
        const bool may = audience_.has_room();
        if (!may) ++refused_;
        return may;
    };
    SrtSocket door_;     // where this end listens
    SrtSocket calling_;  // where it calls, until somebody answers
    std::vector<std::unique_ptr<SrtListener>> listeners_;
    int calls_in_vain_ = 0;
    std::int64_t next_call_ns_ = 0, next_refusal_said_ns_ = 0;
    bool is_said_ = false, is_short_said_ = false;
    std::thread thread_;
};

Result<void> SrtSender::open_door() {
    const auto address = own_address(url_);
    if (!address) return usage_error("right would be an address of this machine in numbers");
    TRY_ASSIGN(auto door, SrtSocket::create(settings_, SrtSocket::Direction::sends));
    door_ = std::move(door);
    return door_.listen(*address, may_come_);
}

void SrtSender::serve() {
    constexpr std::chrono::milliseconds turn_of_listeners{5}, turn_of_none{20};
    auto newest = ring_.join();
    while (!stop_) {
        turn(time_.now_ns());
        const bool is_ended = ring_.is_ended();
        if (is_ended && listeners_.empty()) break;
        if (is_ended)
            (void)time_.wait_until(time_.now_ns() + turn_of_listeners.count() * ns_per_millisecond);
        else  // what comes next ends the wait
            (void)ring_.wait_next(newest, listeners_.empty() ? turn_of_none : turn_of_listeners);
    }
    listeners_.clear();
    is_over_ = true;
}

void SrtSender::turn(std::int64_t now_ns) {
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
        } else if (!stop_ && !ring_.is_ended() && !std::exchange(is_short_said_, true)) {
            audience_.remark(url_.name() + ": goes again within a second; called less and less often");
        }
        if (!stayed) call_later(time_.now_ns());  // closing takes a while
    }
    std::erase_if(listeners_, [](const auto& listener) { return listener->is_over(); });
    if (const auto line = srt_log_line(now_ns)) audience_.remark(*line);
}

void SrtSender::take_callers(std::int64_t now_ns) {
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

/// One line every 10 s at most, however many call.
void SrtSender::say_refusals(std::int64_t now_ns) {
    constexpr std::int64_t silence_ns = 10'000'000'000;
    if (refused_ == 0 || now_ns < next_refusal_said_ns_) return;
    next_refusal_said_ns_ = now_ns + silence_ns;
    const std::int64_t refused = refused_.exchange(0);
    audience_.remark(url_.name() + ": " + std::to_string(refused) +
                     (refused == 1 ? " caller is" : " callers are") + " refused: there are " +
                     std::to_string(StreamAudience::most_listeners) +
                     " listeners, which is as many as there may be");
}

void SrtSender::go_on_calling(std::int64_t now_ns) {
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

void SrtSender::begin_call(std::int64_t now_ns) {
    // A name server may take its time.
    const auto address =
        unless_stopped([url = url_] { return look_up(url); }, [this] { return stop_.load(); });
    if (stop_) return;
    if (!address || !*address) return call_failed("there is no such host", now_ns);
    auto socket = SrtSocket::create(settings_, SrtSocket::Direction::sends);
    if (!socket) return call_failed(socket.error().message, now_ns);
    calling_ = std::move(*socket);
    constexpr int longest_call_ms = longest_call_ns / ns_per_millisecond;
    if (auto called = calling_.call(**address, longest_call_ms); !called)
        call_failed(called.error().message, now_ns);
}

/// That nobody answers is said once, until somebody does.
void SrtSender::call_failed(const std::string& why, std::int64_t now_ns) {
    calling_.close();
    call_later(now_ns);
    if (stop_ || ring_.is_ended() || std::exchange(is_said_, true)) return;
    audience_.remark(url_.name() + ": nobody answers (" + why + "); tried again until somebody does");
}

void SrtSender::call_later(std::int64_t now_ns) {
    next_call_ns_ = now_ns + wait_before_call_ns(++calls_in_vain_);
}

}  // namespace

std::int64_t wait_before_call_ns(int calls_in_vain) {
    constexpr std::int64_t shortest_ns = 500'000'000;
    constexpr int most_doublings = 4;
    return shortest_ns << std::clamp(calls_in_vain - 1, 0, most_doublings);
}

Result<std::unique_ptr<SrtOutput>> SrtOutput::create(const StreamUrl& url, const StreamRing& ring,
                                                     StreamAudience& audience) {
    const auto refused = [&](const std::string& right) {
        return usage_error(in_quotes(url.name()) + " cannot be sent to: " + right);
    };
    const auto failed = [&](const Error& error) {
        return error.kind == ErrorKind::usage ? refused(error.message)
                                              : input_error(url.name() + ": " + error.message);
    };
    if (url.transport != StreamTransport::srt) return refused("right would be srt://");
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
