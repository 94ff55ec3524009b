#include "tests/stream/stream_peer.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>

#include <cerrno>

#include "engine/stream/stream_url.hpp"
#include "tests/unused_port.hpp"

namespace touchable::test {

StreamPeer::StreamPeer(const std::string& address, int receive_bytes)
    : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    const auto url = read_stream_url(address);
    EXPECT_TRUE(url);
    if (receive_bytes > 0) ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &receive_bytes, sizeof receive_bytes);
    const sockaddr_in to = loopback(url->port);
    EXPECT_EQ(::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
}

StreamPeer::~StreamPeer() {
    ::close(socket_);
}

void StreamPeer::say(const std::string& bytes) const {
    EXPECT_EQ(::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL), static_cast<ssize_t>(bytes.size()));
}

void StreamPeer::hang_up_saying() const {
    ::shutdown(socket_, SHUT_WR);
}

std::optional<std::string> StreamPeer::hear(std::size_t most) const {
    std::string bytes(most, '\0');
    const auto got = ::recv(socket_, bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (got < 0 && (errno == EAGAIN || errno == EINTR)) return "";
    if (got <= 0) return std::nullopt;
    bytes.resize(static_cast<std::size_t>(got));
    return bytes;
}

std::string StreamPeer::hear_all(std::size_t enough) const {
    std::string all, some(std::size_t{1} << 16U, '\0');
    while (all.size() < enough) {
        const auto got = ::recv(socket_, some.data(), some.size(), 0);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) break;
        all.append(some, 0, static_cast<std::size_t>(got));
    }
    return all;
}

}  // namespace touchable::test
