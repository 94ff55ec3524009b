#include "tests/stream/loopback_sender.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>

#include <utility>

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

}  // namespace touchable::test
