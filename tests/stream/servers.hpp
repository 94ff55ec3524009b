// SPDX-License-Identifier: Apache-2.0
#pragma once

// Servers on this machine, for as long as they live: of bytes that a test says, and of a web server's
// answers.

#include <atomic>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

namespace touchable::test {

/// A server on this machine, at a free port, for as long as it lives. It serves its clients one after the
/// other by a function that the test gives.
class LoopbackSender {
public:
    /// A client that connected.
    class Listener {
    public:
        Listener(int socket, const std::atomic<bool>& stopping) : socket_(socket), stopping_(stopping) {}
        /// False where it is gone, or the sender ends.
        bool send(std::string_view bytes) const;
        /// Its request, up to an empty line, as in HTTP.
        std::string request() const;
        /// Waits, but not beyond the sender's end; false there.
        bool wait(std::chrono::milliseconds time) const;
        /// It has closed the connection.
        bool is_gone() const;
        /// The connection stays open until the sender ends.
        void stay() const { stays_ = true; }

    private:
        friend class LoopbackSender;
        const int socket_;
        const std::atomic<bool>& stopping_;
        mutable bool stays_ = false;
    };
    /// `number`: of the connection, from 0. When it returns the connection is closed.
    using Say = std::function<void(const Listener&, int number)>;
    explicit LoopbackSender(Say say, int port = 0);
    /// These bytes to every client.
    explicit LoopbackSender(std::string bytes)
        : LoopbackSender([bytes = std::move(bytes)](const Listener& to, int) { (void)to.send(bytes); }) {}
    ~LoopbackSender();
    LoopbackSender(const LoopbackSender&) = delete;
    LoopbackSender& operator=(const LoopbackSender&) = delete;

    int port() const { return port_; }
    std::string url(const std::string& scheme = "tcp", const std::string& path = "") const {
        return scheme + "://127.0.0.1:" + std::to_string(port_) + path;
    }
    int connections() const { return connections_; }

private:
    void run();

    const Say say_;
    int listening_ = -1, port_ = 0;
    std::atomic<bool> stopping_{false};
    std::atomic<int> connections_{0};
    std::vector<int> staying_;  // sockets, of the thread
    std::thread thread_;
};

/// What a web server answers.
struct WebReply {
    int status = 200;
    std::string body{};
    std::string headers{};              ///< more lines, each with its end
    std::optional<std::size_t> sent{};  ///< so many bytes of the body alone, of a length that says all
    bool is_silent = false;             ///< nothing, and the connection stays open
};

/// A web server on this machine, at a free port, for as long as it lives. It takes one request after the
/// other, each by a connection of its own.
class WebServer {
public:
    /// What a path is answered with; on the server's thread.
    using Answer = std::function<WebReply(const std::string& path)>;
    explicit WebServer(Answer answer) : answer_(std::move(answer)) {}

    std::string url(const std::string& path) const { return sender_.url("http", path); }
    std::vector<std::string> requests() const;

private:
    void serve(const LoopbackSender::Listener& client);

    const Answer answer_;
    mutable std::mutex mutex_;
    std::vector<std::string> requests_;  // guarded by mutex_
    const LoopbackSender sender_{[this](const LoopbackSender::Listener& client, int) { serve(client); }};
};

/// A file of a folder, or 404.
WebReply reply_with_file(const std::filesystem::path& folder, const std::string& path);

}  // namespace touchable::test
