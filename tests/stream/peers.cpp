// SPDX-License-Identifier: Apache-2.0
#include "tests/stream/peers.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <srt/srt.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <thread>

#include "engine/stream/srt.hpp"
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

namespace {

constexpr std::size_t most_in_a_message = 1316;

int make_socket(const std::string& passphrase) {
    start_srt();  // the library is started once per process
    const int socket = srt_create_socket();
    // Nothing is dropped because it is late: a test reads when it wants to. With SRTO_TLPKTDROP alone off,
    // libsrt 1.5.1 may never return from srt_recv.
    const bool no = false;
    const int ten_seconds = 10'000;
    EXPECT_EQ(srt_setsockflag(socket, SRTO_TSBPDMODE, &no, sizeof no), 0);
    EXPECT_EQ(srt_setsockflag(socket, SRTO_CONNTIMEO, &ten_seconds, sizeof ten_seconds), 0);
    // If the other end closes while a call waits for room, libsrt 1.5.1 may never return from srt_send.
    EXPECT_EQ(srt_setsockflag(socket, SRTO_SNDTIMEO, &ten_seconds, sizeof ten_seconds), 0);
    if (!passphrase.empty()) {
        EXPECT_EQ(
            srt_setsockflag(socket, SRTO_PASSPHRASE, passphrase.data(), static_cast<int>(passphrase.size())),
            0);
    }
    return socket;
}

}  // namespace

SrtPeer::SrtPeer(Kind kind, int port, const std::string& passphrase) {
    const sockaddr_in at = loopback(port);
    const auto* const address = reinterpret_cast<const sockaddr*>(&at);
    const int made = make_socket(passphrase);
    if (kind == Kind::listens) {
        door_ = made;
        EXPECT_EQ(srt_bind(door_, address, sizeof at), 0);
        EXPECT_EQ(srt_listen(door_, 1), 0);
        socket_ = srt_accept(door_, nullptr, nullptr);
        return;
    }
    if (srt_connect(made, address, sizeof at) != SRT_ERROR) {
        socket_ = made;
        return;
    }
    refusal_ = srt_getrejectreason(made);
    (void)srt_close(made);
}

SrtPeer::~SrtPeer() {
    if (socket_ >= 0) (void)srt_close(socket_);
    if (door_ >= 0) (void)srt_close(door_);
}

bool SrtPeer::say(const std::string& bytes) const {
    for (std::size_t at = 0; at < bytes.size(); at += most_in_a_message) {
        const auto some = static_cast<int>(std::min(most_in_a_message, bytes.size() - at));
        if (srt_send(socket_, bytes.data() + at, some) == SRT_ERROR) return false;
    }
    return true;
}

void SrtPeer::wait_until_arrived() const {
    constexpr std::chrono::milliseconds look_again{1}, latency{400};
    std::size_t messages = 0;
    while (srt_getsndbuffer(socket_, &messages, nullptr) != SRT_ERROR && messages > 0)
        std::this_thread::sleep_for(look_again);
    std::this_thread::sleep_for(latency);
}

std::optional<std::string> SrtPeer::hear() const {
    std::string message(most_in_a_message, '\0');
    const int got = srt_recv(socket_, message.data(), static_cast<int>(message.size()));
    if (got <= 0) return std::nullopt;
    message.resize(static_cast<std::size_t>(got));
    return message;
}

std::string SrtPeer::hear_all(std::size_t enough) const {
    std::string all;
    while (all.size() < enough) {
        const auto message = hear();
        if (!message) break;
        all += *message;
    }
    return all;
}

}  // namespace touchable::test
