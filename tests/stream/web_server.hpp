#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

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
    explicit WebServer(Answer answer);
    ~WebServer();
    WebServer(const WebServer&) = delete;
    WebServer& operator=(const WebServer&) = delete;

    std::string url(const std::string& path) const;
    std::vector<std::string> requests() const;

private:
    void run();
    void serve(int connection);

    const Answer answer_;
    int listener_ = -1, port_ = 0;
    std::atomic<bool> ends_{false};
    std::vector<int> silent_;
    mutable std::mutex mutex_;
    std::vector<std::string> requests_;  // guarded by mutex_
    std::thread thread_;
};

/// A file of a folder, or 404.
WebReply reply_with_file(const std::filesystem::path& folder, const std::string& path);

}  // namespace touchable::test
