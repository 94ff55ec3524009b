// SPDX-License-Identifier: Apache-2.0
#pragma once

// SRT by libsrt: the settings of a URL, the socket, libsrt's log, and the bytes of a received stream.
// srt_output.cpp sends streams.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/stream/listeners.hpp"
#include "engine/stream/stream_bytes.hpp"

namespace touchable {

/// The settings of an srt:// URL.
struct SrtSettings {
    bool listens = false;             ///< mode=listener
    bool says_mode = false;           ///< the URL names a mode; otherwise the program chooses
    std::optional<int> latency_ms{};  ///< 0 to 60000; nothing: libsrt's 120
    std::string passphrase{};         ///< empty: not encrypted
    int key_bytes = 0;                ///< 16, 24 or 32; 0: libsrt's choice
    std::string stream_id{};
};

/// Refuses (ErrorKind::usage) a value out of range; the message says what would be right.
Result<SrtSettings> read_srt_settings(const StreamUrl& url);

/// Starts libsrt once per process and takes over its log. libsrt ends itself when the process exits.
void start_srt();

/// An error that libsrt logged, with the number of lines that were left out before it. Nothing: there was
/// none, or the last returned one is less than 10 s old. A flood of hostile datagrams makes libsrt log
/// thousands of lines a second. Any thread; `now_ns` is of a steady clock.
std::optional<std::string> srt_log_line(std::int64_t now_ns);

/// A socket of libsrt, closed by its destructor. No call waits inside libsrt; `receive` waits for an event,
/// at most for the given time. Used by one thread.
class SrtSocket {
public:
    enum class Direction { sends, receives };
    enum class State { calling, connected, gone };

    /// Bytes of a message that is sent: seven packets of MPEG-TS.
    static constexpr std::size_t message_bytes = 1316;
    /// The longest message that a peer may send.
    static constexpr std::size_t longest_message = 1456;

    SrtSocket() = default;
    ~SrtSocket() { close(); }
    SrtSocket(SrtSocket&& other) noexcept
        : socket_(std::exchange(other.socket_, none)), events_(std::exchange(other.events_, none)) {}
    SrtSocket& operator=(SrtSocket&& other) noexcept;

    static Result<SrtSocket> create(const SrtSettings& settings, Direction direction);

    /// Accepts callers at this address until it is closed. A thread of libsrt's calls `may_come`, which
    /// outlives the socket, before a caller is accepted.
    Result<void> listen(const SocketAddress& address, std::function<bool()>& may_come);
    /// The next caller, if there is one. The listening socket has to stay open: it repeats answers to
    /// handshakes that were lost.
    std::optional<std::pair<SrtSocket, SocketAddress>> accept();

    /// Begins to call; `state` shows the result. libsrt repeats lost parts of the handshake.
    Result<void> call(const SocketAddress& address, int longest_ms);
    State state() const;
    /// Why the call failed; `is_final`: the same call will not succeed later.
    struct Refusal {
        std::string why;
        bool is_final = false;
    };
    Refusal refusal() const;

    /// Sends as much as there is room for, and returns how much that was; negative: the connection is gone.
    std::ptrdiff_t send(std::span<const std::uint8_t> bytes);
    /// Bytes that were passed to `send` and are not acknowledged yet.
    std::size_t unacknowledged_bytes() const;
    /// Limits the rate at which datagrams are sent, bytes a second; 0: no limit.
    void pace(std::int64_t bytes_per_second);
    /// How long the receiver holds datagrams back, as agreed by both ends.
    int peer_latency_ms() const;

    struct Message {
        std::ptrdiff_t bytes = 0;   ///< 0: none came; negative: the connection is gone
        std::int32_t sequence = 0;  ///< of 31 bits; one more than that of the message before
    };
    /// Receives a message; waits `longest_ms` at most. Messages behind a lost one come before it. `to` has
    /// room for `longest_message`.
    Message receive(std::span<std::uint8_t> to, int longest_ms);
    /// The sequence number of the first message.
    std::int32_t first_sequence() const;

    /// Figures that libsrt has counted so far; nothing if the connection is gone.
    std::optional<StreamFigures::Link> figures() const;

    bool is_open() const { return socket_ != none; }
    void close();

private:
    static constexpr int none = -1;
    explicit SrtSocket(int socket) : socket_(socket) {}
    /// Makes libsrt report the events for `has_something`; false: it refuses.
    bool watch();
    bool has_something(int longest_ms);

    int socket_ = none;
    int events_ = none;  // libsrt's epoll: something to receive, or a caller
};

/// StreamBytes::connect by SRT: calls repeatedly until the sender answers, or (mode=listener) waits for a
/// caller.
Result<std::shared_ptr<StreamBytes>> connect_by_srt(const StreamUrl& url, std::shared_ptr<StreamWait> wait);

}  // namespace touchable
