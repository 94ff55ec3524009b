#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace touchable::test {

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
