#pragma once

#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/stream/loopback_sender.hpp"

namespace touchable::test {

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
