// SPDX-License-Identifier: Apache-2.0
#include "engine/stream/srt.hpp"

#include <srt/access_control.h>
#include <srt/srt.h>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

constexpr int most_latency_ms = 60'000;

// --- libsrt's log

struct SrtLog {
    std::mutex mutex;
    // Guarded by mutex.
    std::string newest;
    std::int64_t lines = 0;  // since the last returned one
    std::optional<std::int64_t> returned_ns;
};

/// Never destroyed: libsrt's threads log until the process ends.
SrtLog& srt_log() {
    static SrtLog* const log = new SrtLog;
    return *log;
}

void take_log_line(void*, int, const char*, int, const char*, const char* message) {
    SrtLog& log = srt_log();
    const std::lock_guard lock(log.mutex);
    log.newest = message ? message : "";
    ++log.lines;
}

std::string last_error() {
    std::string text = srt_getlasterror_str();
    while (!text.empty() && (text.back() == '.' || text.back() == ' ')) text.pop_back();
    return text;
}

template <class Value>
bool set(int socket, SRT_SOCKOPT option, const Value& value) {
    return srt_setsockflag(socket, option, &value, sizeof value) != SRT_ERROR;
}

bool set(int socket, SRT_SOCKOPT option, const std::string& value) {
    return srt_setsockflag(socket, option, value.data(), static_cast<int>(value.size())) != SRT_ERROR;
}

/// Called on a thread of libsrt's before it answers a caller.
int ask_whether_a_caller_may_come(void* asked, SRTSOCKET caller, int, const sockaddr*, const char*) {
    const auto& may_come = *static_cast<const std::function<bool()>*>(asked);
    if (may_come()) return 0;
    (void)srt_setrejectreason(caller, SRT_REJX_OVERLOAD);
    return SRT_ERROR;
}

// --- Receiving

constexpr std::chrono::milliseconds look_for_caller_again{5};
constexpr std::uint32_t sequence_numbers = std::uint32_t{1} << 31U;

class SrtBytes final : public StreamBytes {
public:
    SrtBytes(std::shared_ptr<StreamWait> wait, SrtSocket socket)
        : StreamBytes(std::move(wait)), socket_(std::move(socket)) {}
    /// Waits until a sender calls.
    Result<void> wait_for_caller(const SrtSettings& settings, const SocketAddress& address) {
        TRY_ASSIGN(door_, SrtSocket::create(settings, SrtSocket::Direction::receives));
        TRY(door_.listen(address, may_come_));
        const auto is_there = [this] {
            if (auto caller = door_.accept()) {
                has_caller_ = true;
                socket_ = std::move(caller->first);
            }
            return has_caller_.load();
        };
        if (wait_unless_stopped(is_there, look_for_caller_again)) return {};
        return input_error("no connection: no caller came in time");
    }
    std::optional<StreamFigures::Link> link() const override {
        const std::lock_guard lock(mutex_);
        return figures_;
    }

private:
    std::int64_t some(std::uint8_t* to, std::size_t count) override {
        while (at_ == message_.size()) {
            if (stop_requested()) return AVERROR_EXIT;
            if (!take_next()) return 0;  // SRT has no other end
        }
        const std::size_t given = std::min(count, message_.size() - at_);
        std::memcpy(to, message_.data() + at_, given);
        at_ += given;
        return static_cast<std::int64_t>(given);
    }
    /// Takes the next message of the stream, if it comes soon; false: the connection is gone.
    bool take_next() {
        constexpr int longest_wait_ms = 20;
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
        const std::uint32_t sequence = static_cast<std::uint32_t>(got.sequence) % sequence_numbers;
        const std::uint32_t ahead = (sequence - *next_) % sequence_numbers;
        if (ahead == 0) {
            give(std::move(message));
            return true;
        }
        // The sender drops lost messages, against what was agreed, or is hostile.
        if (ahead >= most_early || early_.size() >= most_early) return false;
        early_.emplace(sequence, std::move(message));
        return true;
    }
    void give(std::vector<std::uint8_t> message) {
        message_ = std::move(message);
        at_ = 0;
        next_ = (*next_ + 1) % sequence_numbers;
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
    SrtSocket door_, socket_;                          // closed before may_come_ is gone
    static constexpr std::size_t most_early = 25'600;  // more than may be under way
    std::vector<std::uint8_t> message_;
    std::size_t at_ = 0;                                        // bytes of it that were returned
    std::optional<std::uint32_t> next_;                         // its sequence number
    std::map<std::uint32_t, std::vector<std::uint8_t>> early_;  // behind a lost message
    std::chrono::steady_clock::time_point next_note_{};
    mutable std::mutex mutex_;
    std::optional<StreamFigures::Link> figures_;  // guarded by mutex_
};

/// Calls until the sender answers; an error says why it does not.
Result<SrtSocket> call(const SrtSettings& settings, const SocketAddress& address) {
    // libsrt repeats a part of the handshake, but not all of it: a call of this length is begun anew.
    constexpr int longest_call_ms = 1500;
    Error why = input_error("it did not answer in time");
    while (!stop_requested()) {
        TRY_ASSIGN(auto socket, SrtSocket::create(settings, SrtSocket::Direction::receives));
        TRY(socket.call(address, longest_call_ms));
        const auto is_answered = [&socket] { return socket.state() != SrtSocket::State::calling; };
        if (!wait_unless_stopped(is_answered, look_for_caller_again)) break;
        if (socket.state() == SrtSocket::State::connected) return socket;
        const auto refusal = socket.refusal();
        why = input_error(refusal.why);
        if (refusal.is_final) break;
        std::this_thread::sleep_for(look_for_caller_again);
    }
    return why;
}

}  // namespace

// --- SrtSocket

Result<SrtSettings> read_srt_settings(const StreamUrl& url) {
    SrtSettings settings;
    const std::string mode = url.value("mode"), latency = url.value("latency"), key = url.value("pbkeylen");
    if (!mode.empty() && mode != "caller" && mode != "listener")
        return usage_error("mode is caller or listener");
    settings.says_mode = !mode.empty();
    settings.listens = mode == "listener";
    if (!latency.empty()) {
        settings.latency_ms = parsed_as<int>(latency);
        if (!settings.latency_ms || *settings.latency_ms < 0 || *settings.latency_ms > most_latency_ms)
            return usage_error("latency is milliseconds, from 0 to " + std::to_string(most_latency_ms));
    }
    if (!key.empty()) {
        settings.key_bytes = parsed_as<int>(key).value_or(-1);
        constexpr std::array key_sizes{0, 16, 24, 32};
        if (std::ranges::find(key_sizes, settings.key_bytes) == key_sizes.end())
            return usage_error("pbkeylen is 16, 24 or 32");
    }
    settings.passphrase = url.value("passphrase");
    settings.stream_id = url.value("streamid");
    constexpr std::size_t longest_stream_id = 512;
    if (settings.stream_id.size() > longest_stream_id)
        return usage_error("streamid has 512 characters at most");
    return settings;
}

void start_srt() {
    static std::once_flag once;
    std::call_once(once, [] {
        srt_setloghandler(nullptr, take_log_line);
        srt_setlogflags(SRT_LOGF_DISABLE_TIME | SRT_LOGF_DISABLE_THREADNAME | SRT_LOGF_DISABLE_SEVERITY |
                        SRT_LOGF_DISABLE_EOL);
        srt_setloglevel(LOG_ERR);
        (void)srt_startup();
    });
}

std::optional<std::string> srt_log_line(std::int64_t now_ns) {
    constexpr std::int64_t silence_ns = 10'000'000'000;
    SrtLog& log = srt_log();
    const std::lock_guard lock(log.mutex);
    if (log.lines == 0 || (log.returned_ns && now_ns - *log.returned_ns < silence_ns)) return std::nullopt;
    log.returned_ns = now_ns;
    const std::int64_t others = std::exchange(log.lines, 0) - 1;
    constexpr std::size_t longest = 200;
    return "libsrt: " + printable(log.newest, longest) +
           (others > 0 ? " (and " + std::to_string(others) + " lines before it)" : "");
}

SrtSocket& SrtSocket::operator=(SrtSocket&& other) noexcept {
    std::swap(socket_, other.socket_);
    std::swap(events_, other.events_);
    return *this;
}

void SrtSocket::close() {
    if (socket_ != none) (void)srt_close(std::exchange(socket_, none));
    if (events_ != none) (void)srt_epoll_release(std::exchange(events_, none));
}

Result<SrtSocket> SrtSocket::create(const SrtSettings& settings, Direction direction) {
    start_srt();
    SrtSocket made(srt_create_socket());
    const int socket = made.socket_;
    if (socket == none) return input_error("no SRT socket can be had: " + last_error());
    const bool sends = direction == Direction::sends;
    // Neither end drops late messages, as a frameset with a missing part is of no use: the sender leaves out
    // whole framesets before they are sent. Our receiver takes messages as they come, since its jitter buffer
    // knows when framesets are due. libsrt's own thread for that (TSBPD) holds the socket's lock while it
    // waits for a lost datagram that is late, so that no call returns.
    constexpr int never = -1;
    bool is_set = set(socket, SRTO_TRANSTYPE, SRTT_LIVE) && set(socket, SRTO_RCVSYN, false) &&
                  set(socket, SRTO_SNDSYN, false) && set(socket, SRTO_TSBPDMODE, sends) &&
                  set(socket, SRTO_SNDDROPDELAY, never) &&
                  set(socket, SRTO_PAYLOADSIZE, static_cast<int>(message_bytes));
    // A listener has nothing to send: what it sends nevertheless gets little room.
    constexpr int little_room = 64 * 1500;
    if (sends) is_set = is_set && set(socket, SRTO_RCVBUF, little_room);
    if (settings.latency_ms) is_set = is_set && set(socket, SRTO_LATENCY, *settings.latency_ms);
    if (settings.key_bytes > 0) is_set = is_set && set(socket, SRTO_PBKEYLEN, settings.key_bytes);
    if (!settings.passphrase.empty()) is_set = is_set && set(socket, SRTO_PASSPHRASE, settings.passphrase);
    if (!settings.stream_id.empty()) is_set = is_set && set(socket, SRTO_STREAMID, settings.stream_id);
    if (!is_set) return input_error("libsrt refuses a setting: " + last_error());
    return made;
}

Result<void> SrtSocket::listen(const SocketAddress& address, std::function<bool()>& may_come) {
    constexpr int most_waiting = 16, no = 0;
    if (address.is_ipv6()) (void)set(socket_, SRTO_IPV6ONLY, no);
    // The socket is watched before it listens: libsrt 1.5.1 reports no caller that came before.
    if (srt_listen_callback(socket_, ask_whether_a_caller_may_come, &may_come) == SRT_ERROR ||
        srt_bind(socket_, address.get(), static_cast<int>(address.length)) == SRT_ERROR || !watch() ||
        srt_listen(socket_, most_waiting) == SRT_ERROR)
        return input_error("cannot listen there: " + last_error());
    return {};
}

bool SrtSocket::watch() {
    const int wanted = SRT_EPOLL_IN | SRT_EPOLL_ERR;
    events_ = srt_epoll_create();
    return events_ != SRT_ERROR && srt_epoll_add_usock(events_, socket_, &wanted) != SRT_ERROR;
}

/// Waits for something to receive, or a caller.
bool SrtSocket::has_something(int longest_ms) {
    if (events_ == none && !watch()) return true;
    SRT_EPOLL_EVENT event;
    return srt_epoll_uwait(events_, &event, 1, longest_ms) > 0;
}

std::optional<std::pair<SrtSocket, SocketAddress>> SrtSocket::accept() {
    if (!has_something(0)) return std::nullopt;  // srt_accept would log an error
    SocketAddress address;
    int length = sizeof address.storage;
    SrtSocket caller(srt_accept(socket_, reinterpret_cast<sockaddr*>(&address.storage), &length));
    if (caller.socket_ == none) return std::nullopt;
    address.length = static_cast<socklen_t>(length);
    return std::pair(std::move(caller), address);
}

Result<void> SrtSocket::call(const SocketAddress& address, int longest_ms) {
    if (!set(socket_, SRTO_CONNTIMEO, longest_ms) ||
        srt_connect(socket_, address.get(), static_cast<int>(address.length)) == SRT_ERROR)
        return input_error(last_error());
    return {};
}

SrtSocket::State SrtSocket::state() const {
    const SRT_SOCKSTATUS status = srt_getsockstate(socket_);  // they are in the order of a connection's life
    if (status == SRTS_CONNECTED) return State::connected;
    return status < SRTS_CONNECTED ? State::calling : State::gone;
}

SrtSocket::Refusal SrtSocket::refusal() const {
    switch (const int reason = srt_getrejectreason(socket_)) {
        case SRT_REJ_BADSECRET:
        case SRT_REJ_UNSECURE:
            return {"the passphrase is not the sender's and the receiver's alike", true};
        case SRT_REJX_OVERLOAD:
            return {"it has as many listeners as there may be", true};
        case SRT_REJ_UNKNOWN:
        case SRT_REJ_TIMEOUT:
            return {"it did not answer in time", false};
        case SRT_REJ_VERSION:
        case SRT_REJ_MESSAGEAPI:
        case SRT_REJ_CONGESTION:
            return {std::string("it refuses: ") + srt_rejectreason_str(reason), true};
        default:
            return {std::string("it refuses: ") + srt_rejectreason_str(reason), false};
    }
}

std::ptrdiff_t SrtSocket::send(std::span<const std::uint8_t> bytes) {
    std::size_t done = 0;
    while (done < bytes.size()) {
        const auto some = bytes.subspan(done, std::min(message_bytes, bytes.size() - done));
        SRT_MSGCTRL facts = srt_msgctrl_default;
        facts.inorder = 1;
        const int sent = srt_sendmsg2(socket_, reinterpret_cast<const char*>(some.data()),
                                      static_cast<int>(some.size()), &facts);
        if (sent == SRT_ERROR) {
            if (srt_getlasterror(nullptr) == SRT_EASYNCSND) break;
            return -1;
        }
        done += static_cast<std::size_t>(sent);
    }
    return static_cast<std::ptrdiff_t>(done);
}

std::size_t SrtSocket::unacknowledged_bytes() const {
    std::size_t messages = 0, bytes = 0;
    return srt_getsndbuffer(socket_, &messages, &bytes) == SRT_ERROR ? 0 : bytes;
}

void SrtSocket::pace(std::int64_t bytes_per_second) {
    (void)set(socket_, SRTO_MAXBW, bytes_per_second > 0 ? bytes_per_second : std::int64_t{-1});
}

int SrtSocket::peer_latency_ms() const {
    int latency = 0, size = sizeof latency;
    return srt_getsockflag(socket_, SRTO_PEERLATENCY, &latency, &size) == SRT_ERROR ? 0 : latency;
}

SrtSocket::Message SrtSocket::receive(std::span<std::uint8_t> to, int longest_ms) {
    for (const bool has_waited : {false, true}) {
        SRT_MSGCTRL facts = srt_msgctrl_default;
        const int got =
            srt_recvmsg2(socket_, reinterpret_cast<char*>(to.data()), static_cast<int>(to.size()), &facts);
        if (got != SRT_ERROR) return {got > 0 ? got : -1, facts.pktseq};
        if (srt_getlasterror(nullptr) != SRT_EASYNCRCV) return {-1};
        if (has_waited || longest_ms == 0) break;
        (void)has_something(longest_ms);
    }
    return {};
}

std::int32_t SrtSocket::first_sequence() const {
    std::int32_t first = 0;
    int size = sizeof first;
    (void)srt_getsockflag(socket_, SRTO_ISN, &first, &size);
    return first;
}

std::optional<StreamFigures::Link> SrtSocket::figures() const {
    SRT_TRACEBSTATS all{};
    constexpr int keep = 0, at_this_moment = 1;
    if (srt_bistats(socket_, &all, keep, at_this_moment) == SRT_ERROR) return std::nullopt;
    const bool sends = all.pktSentTotal > all.pktRecvTotal;
    return StreamFigures::Link{.rtt_ms = all.msRTT,
                               .datagrams = sends ? all.pktSentTotal : all.pktRecvTotal,
                               .lost = sends ? all.pktSndLossTotal : all.pktRcvLossTotal,
                               .sent_again = sends ? all.pktRetransTotal : all.pktRcvRetrans};
}

Result<std::shared_ptr<StreamBytes>> connect_by_srt(const StreamUrl& url, std::shared_ptr<StreamWait> wait) {
    TRY_ASSIGN(const auto settings, read_srt_settings(url));
    const auto find = [url, listens = settings.listens] { return listens ? own_address(url) : look_up(url); };
    const auto found = unless_stopped(find);
    if (!found || !*found) return input_error("no connection: no host of that name");
    if (settings.listens) {
        auto bytes = std::make_shared<SrtBytes>(wait, SrtSocket());
        TRY(bytes->wait_for_caller(settings, **found));
        return std::shared_ptr<StreamBytes>(std::move(bytes));
    }
    auto socket = call(settings, **found);
    if (!socket)
        return input_error("no connection: " + socket.error().message + "; does the sender listen there?");
    return std::shared_ptr<StreamBytes>(std::make_shared<SrtBytes>(std::move(wait), std::move(*socket)));
}

}  // namespace touchable
