// SPDX-License-Identifier: Apache-2.0
#include "tests/stream/servers.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>

#include <utility>

#include "tests/clip/clip_fixture.hpp"
#include "tests/unused_port.hpp"

namespace touchable::test {

namespace {

constexpr int step_ms = 10;

bool is_ready(int descriptor, short what) {
    pollfd waited{descriptor, what, 0};
    return ::poll(&waited, 1, step_ms) > 0;
}

}  // namespace

bool LoopbackSender::Listener::send(std::string_view bytes) const {
    while (!bytes.empty()) {
        if (stopping_) return false;
        if (!is_ready(socket_, POLLOUT)) continue;
        const auto sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
        if (sent < 0) return false;
        bytes.remove_prefix(static_cast<std::size_t>(sent));
    }
    return true;
}

std::string LoopbackSender::Listener::request() const {
    std::string asked;
    while (!stopping_ && asked.find("\r\n\r\n") == std::string::npos) {
        if (!is_ready(socket_, POLLIN)) continue;
        char bytes[4096];
        const auto got = ::recv(socket_, bytes, sizeof bytes, 0);
        if (got <= 0) break;
        asked.append(bytes, static_cast<std::size_t>(got));
    }
    return asked;
}

bool LoopbackSender::Listener::is_gone() const {
    char byte = 0;
    return ::recv(socket_, &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0;
}

bool LoopbackSender::Listener::wait(std::chrono::milliseconds time) const {
    const auto until = std::chrono::steady_clock::now() + time;
    while (!stopping_ && std::chrono::steady_clock::now() < until)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return !stopping_;
}

LoopbackSender::LoopbackSender(Say say, int port) : say_(std::move(say)) {
    listening_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const int on = 1;
    ::setsockopt(listening_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    ::sockaddr_in address = loopback(port);
    ::socklen_t length = sizeof address;
    auto* const bytes = reinterpret_cast<::sockaddr*>(&address);
    if (::bind(listening_, bytes, length) != 0 || ::listen(listening_, 64) != 0 ||
        ::getsockname(listening_, bytes, &length) != 0)
        ADD_FAILURE() << "no port to listen at";
    port_ = ::ntohs(address.sin_port);
    thread_ = std::thread([this] { run(); });
}

LoopbackSender::~LoopbackSender() {
    stopping_ = true;
    thread_.join();
    ::close(listening_);
    for (const int socket : staying_) ::close(socket);
}

void LoopbackSender::run() {
    while (!stopping_) {
        if (!is_ready(listening_, POLLIN)) continue;
        const int socket = ::accept4(listening_, nullptr, nullptr, SOCK_CLOEXEC);
        if (socket < 0) continue;
        const Listener listener(socket, stopping_);
        say_(listener, connections_++);
        if (listener.stays_)
            staying_.push_back(socket);
        else
            ::close(socket);
    }
}

std::vector<std::string> WebServer::requests() const {
    const std::lock_guard lock(mutex_);
    return requests_;
}

void WebServer::serve(const LoopbackSender::Listener& client) {
    const std::string head = client.request();
    const std::size_t begin = head.find(' ') + 1;
    const std::string path = head.substr(begin, head.find(' ', begin) - begin);
    {
        const std::lock_guard lock(mutex_);
        requests_.push_back(path);
    }
    const WebReply reply = answer_(path);
    if (reply.is_silent) return client.stay();
    (void)client.send("HTTP/1.1 " + std::to_string(reply.status) + " said\r\nContent-Length: " +
                      std::to_string(reply.body.size()) + "\r\nConnection: close\r\n" + reply.headers +
                      "\r\n" + reply.body.substr(0, reply.sent.value_or(reply.body.size())));
}

WebReply reply_with_file(const std::filesystem::path& folder, const std::string& path) {
    const auto file = folder / path.substr(1, path.find('?') - 1);
    if (!std::filesystem::is_regular_file(file)) return {404};
    return {200, read_bytes(file)};
}

}  // namespace touchable::test
