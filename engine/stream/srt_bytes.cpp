#include "engine/stream/srt_bytes.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstring>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "engine/base/try.hpp"
#include "engine/base/unless_stopped.hpp"
#include "engine/stream/srt_socket.hpp"

namespace touchable {
namespace {

constexpr std::chrono::milliseconds look_again{5};

class SrtBytes final : public StreamBytes {
public:
    SrtBytes(std::shared_ptr<StreamWait> wait, SrtSocket socket)
        : StreamBytes(std::move(wait)), socket_(std::move(socket)) {}
    /// Waits until somebody calls.
    Result<void> wait_for_caller(const SrtSettings& settings, const SocketAddress& address) {
        TRY_ASSIGN(auto door, SrtSocket::create(settings, SrtSocket::Direction::receives));
        door_ = std::move(door);
        if (auto listens = door_.listen(address, may_come_); !listens) return listens;
        while (!waits()->is_over()) {
            if (auto caller = door_.accept()) {
                has_caller_ = true;
                socket_ = std::move(caller->first);
                return {};
            }
            std::this_thread::sleep_for(look_again);
        }
        return input_error("no connection: nobody called in time");
    }
    std::optional<LinkFigures> link() const override {
        const std::lock_guard lock(mutex_);
        return figures_;
    }

private:
    std::int64_t some(std::uint8_t* to, std::size_t count) override {
        while (at_ == message_.size()) {
            if (waits()->is_over()) return AVERROR_EXIT;
            if (!take_next()) return 0;  // SRT has no other end
        }
        const std::size_t given = std::min(count, message_.size() - at_);
        std::memcpy(to, message_.data() + at_, given);
        at_ += given;
        return static_cast<std::int64_t>(given);
    }
    /// The next message of the stream, if it is there soon; false: the connection is gone.
    bool take_next() {
        constexpr int longest_wait_ms = 20;
        constexpr std::uint32_t numbers = std::uint32_t{1} << 31U;
        if (!next_) next_ = static_cast<std::uint32_t>(socket_.first_sequence());
        if (const auto found = early_.find(*next_); found != early_.end()) {
            give(std::move(found->second));
            early_.erase(found);
            return true;
        }
        std::array<std::uint8_t, SrtSocket::longest_message> bytes;
        const auto got = socket_.receive(bytes, longest_wait_ms);
        note();
        if (got.bytes < 0) return false;
        if (got.bytes == 0) return true;
        std::vector<std::uint8_t> message(bytes.begin(), bytes.begin() + got.bytes);
        const std::uint32_t sequence = static_cast<std::uint32_t>(got.sequence) % numbers;
        const std::uint32_t ahead = (sequence - *next_) % numbers;
        if (ahead == 0) {
            give(std::move(message));
            return true;
        }
        // A sender that gives up what is lost, against what was agreed, or a hostile one.
        if (ahead >= most_early || early_.size() >= most_early) return false;
        early_.emplace(sequence, std::move(message));
        return true;
    }
    void give(std::vector<std::uint8_t> message) {
        constexpr std::uint32_t numbers = std::uint32_t{1} << 31U;
        message_ = std::move(message);
        at_ = 0;
        next_ = (*next_ + 1) % numbers;
    }
    void note() {
        constexpr std::chrono::milliseconds now_and_then{100};
        const auto now = std::chrono::steady_clock::now();
        if (now < next_note_) return;
        next_note_ = now + now_and_then;
        if (const auto figures = socket_.figures()) {
            const std::lock_guard lock(mutex_);
            figures_ = figures;
        }
    }

    std::atomic<bool> has_caller_{false};
    std::function<bool()> may_come_ = [this] { return !has_caller_; };
    SrtSocket door_, socket_;                          // closed before what they ask is gone
    static constexpr std::size_t most_early = 25'600;  // more than may be on their way
    std::vector<std::uint8_t> message_;
    std::size_t at_ = 0;                                        // of it, what was given
    std::optional<std::uint32_t> next_;                         // its sequence number
    std::map<std::uint32_t, std::vector<std::uint8_t>> early_;  // behind one that was lost
    std::chrono::steady_clock::time_point next_note_{};
    mutable std::mutex mutex_;
    std::optional<LinkFigures> figures_;  // guarded by it
};

/// Where one answers; an error otherwise.
Result<SrtSocket> call(const SrtSettings& settings, const SocketAddress& address, StreamWait& wait) {
    // libsrt repeats a part of the handshake, but not all of it: a call that takes so long is begun anew.
    constexpr int longest_call_ms = 1500;
    Error why = input_error("it did not answer in time");
    while (!wait.is_over()) {
        TRY_ASSIGN(auto socket, SrtSocket::create(settings, SrtSocket::Direction::receives));
        TRY(socket.call(address, longest_call_ms));
        while (!wait.is_over() && socket.state() == SrtSocket::State::calling)
            std::this_thread::sleep_for(look_again);
        if (socket.state() == SrtSocket::State::connected) return socket;
        if (wait.is_over()) break;
        const auto refusal = socket.refusal();
        why = input_error(refusal.why);
        if (refusal.is_final) break;
        std::this_thread::sleep_for(look_again);
    }
    return why;
}

}  // namespace

Result<std::shared_ptr<StreamBytes>> connect_by_srt(const StreamUrl& url, std::shared_ptr<StreamWait> wait) {
    TRY_ASSIGN(const auto settings, read_srt_settings(url));
    const auto find = [url, listens = settings.listens] { return listens ? own_address(url) : look_up(url); };
    const auto found = unless_stopped(find, [wait] { return wait->is_over(); });
    if (wait->is_interrupted()) return interrupted_error();
    if (!found || !*found) return input_error("no connection: there is no such host");
    if (settings.listens) {
        auto bytes = std::make_shared<SrtBytes>(wait, SrtSocket());
        auto called = bytes->wait_for_caller(settings, **found);
        if (wait->is_interrupted()) return interrupted_error();
        if (!called) return called.error();
        return std::shared_ptr<StreamBytes>(std::move(bytes));
    }
    auto socket = call(settings, **found, *wait);
    if (wait->is_interrupted()) return interrupted_error();
    if (!socket)
        return input_error("no connection: " + socket.error().message + "; does the sender listen there?");
    return std::shared_ptr<StreamBytes>(std::make_shared<SrtBytes>(std::move(wait), std::move(*socket)));
}

}  // namespace touchable
