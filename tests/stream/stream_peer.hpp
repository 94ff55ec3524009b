#pragma once

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

}  // namespace touchable::test
