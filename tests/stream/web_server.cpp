#include "tests/stream/web_server.hpp"

#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <stdexcept>
#include <utility>

#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

void send_all(int connection, const std::string& bytes) {
    std::size_t sent = 0;
    while (sent < bytes.size()) {
        const auto taken = ::send(connection, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
        if (taken <= 0) return;
        sent += static_cast<std::size_t>(taken);
    }
}

/// The head of a request; shorter where the client ends it or waits.
std::string request_head(int connection) {
    std::string head;
    char some[4096];
    while (head.find("\r\n\r\n") == std::string::npos) {
        pollfd waited{connection, POLLIN, 0};
        constexpr int patience_ms = 5000;
        if (::poll(&waited, 1, patience_ms) <= 0) break;
        const auto got = ::recv(connection, some, sizeof some, 0);
        if (got <= 0) break;
        head.append(some, static_cast<std::size_t>(got));
    }
    return head;
}

}  // namespace

WebServer::WebServer(Answer answer) : answer_(std::move(answer)) {
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* const named = reinterpret_cast<sockaddr*>(&address);
    if (::bind(listener_, named, size) != 0 || ::listen(listener_, 64) != 0 ||
        ::getsockname(listener_, named, &size) != 0)
        throw std::runtime_error("no port to listen at");
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { run(); });
}

WebServer::~WebServer() {
    ends_ = true;
    ::shutdown(listener_, SHUT_RDWR);
    thread_.join();
    ::close(listener_);
    for (const int connection : silent_) ::close(connection);
}

std::string WebServer::url(const std::string& path) const {
    return "http://127.0.0.1:" + std::to_string(port_) + path;
}

std::vector<std::string> WebServer::requests() const {
    const std::lock_guard lock(mutex_);
    return requests_;
}

void WebServer::run() {
    while (!ends_) {
        const int connection = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
        if (connection >= 0) serve(connection);
    }
}

void WebServer::serve(int connection) {
    const std::string head = request_head(connection);
    const std::size_t begin = head.find(' ') + 1;
    const std::string path = head.substr(begin, head.find(' ', begin) - begin);
    {
        const std::lock_guard lock(mutex_);
        requests_.push_back(path);
    }
    const WebReply reply = answer_(path);
    if (reply.is_silent) {
        silent_.push_back(connection);
        return;
    }
    send_all(connection, "HTTP/1.1 " + std::to_string(reply.status) + " said\r\nContent-Length: " +
                             std::to_string(reply.body.size()) + "\r\nConnection: close\r\n" + reply.headers +
                             "\r\n" + reply.body.substr(0, reply.sent.value_or(reply.body.size())));
    ::close(connection);
}

WebReply reply_with_file(const std::filesystem::path& folder, const std::string& path) {
    const auto file = folder / path.substr(1, path.find('?') - 1);
    if (!std::filesystem::is_regular_file(file)) return {404};
    return {200, read_bytes(file)};
}

}  // namespace touchable::test
