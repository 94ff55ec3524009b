// SPDX-License-Identifier: Apache-2.0
#pragma once

// The other ends of connections on this machine, by plain calls: of a server of ours, and of SRT.

#include <cstddef>
#include <optional>
#include <string>

namespace touchable::test {

/// A client of a server on this machine.
class StreamPeer {
public:
    /// `address`: "tcp://127.0.0.1:7000", "http://127.0.0.1:7000/live.mkv".
    /// `receive_bytes`: of the kernel's buffer; 0: as it is.
    explicit StreamPeer(const std::string& address, int receive_bytes = 0);
    ~StreamPeer();
    StreamPeer(const StreamPeer&) = delete;
    StreamPeer& operator=(const StreamPeer&) = delete;

    void say(const std::string& bytes) const;
    void hang_up_saying() const;  ///< has nothing more to say, and listens on
    /// What is there, at most so much; empty: nothing is. Nothing: the server has closed, or broken off.
    std::optional<std::string> hear(std::size_t most = std::size_t{1} << 20U) const;
    /// All until the server closes, or `enough` bytes; waits for it.
    std::string hear_all(std::size_t enough = std::size_t{1} << 40U) const;

private:
    int socket_ = -1;
};

/// The other end of a connection by SRT, of libsrt's plain calls.
class SrtPeer {
public:
    enum class Kind { calls, listens };
    /// Connects on this machine, and waits for that.
    SrtPeer(Kind kind, int port, const std::string& passphrase = "");
    ~SrtPeer();
    SrtPeer(const SrtPeer&) = delete;
    SrtPeer& operator=(const SrtPeer&) = delete;

    bool is_connected() const { return socket_ >= 0; }
    /// What came of the call, a number of libsrt's SRT_REJECT_REASON; 0: it was answered.
    int refusal() const { return refusal_; }
    /// False: the other end has gone.
    bool say(const std::string& bytes) const;
    /// All that was said, and its latency has passed.
    void wait_until_arrived() const;
    /// The next message; nothing: the other end has gone.
    std::optional<std::string> hear() const;
    /// All until the other end goes, or `enough` bytes.
    std::string hear_all(std::size_t enough = std::size_t{1} << 40U) const;

private:
    int door_ = -1, socket_ = -1, refusal_ = 0;
};

}  // namespace touchable::test
