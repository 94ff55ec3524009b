#include "tests/stream/web_server.hpp"

#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {

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
