#include "engine/stream/http_request.hpp"

#include <algorithm>
#include <utility>

namespace touchable {
namespace {

/// The next word of a line, which is cut off it.
std::string_view next_word(std::string_view& line) {
    const std::size_t end = std::min(line.find(' '), line.size());
    const std::string_view word = line.substr(0, end);
    line.remove_prefix(std::min(end + 1, line.size()));
    return word;
}

std::string_view reason_of(int status) {
    switch (status) {
        case 200:
            return "OK";
        case 404:
            return "Not Found";
        case 405:
            return "Method Not Allowed";
        case 503:
            return "Service Unavailable";
        default:
            return "Bad Request";
    }
}

std::string_view words_of(int status) {
    switch (status) {
        case 404:
            return "there is no stream of this name\n";
        case 405:
            return "the stream is only read: GET or HEAD\n";
        case 503:
            return "as many listen as there is room for; try again later\n";
        default:
            return "this is no request of HTTP/1.0 or HTTP/1.1\n";
    }
}

}  // namespace

void HttpRequest::take(std::string_view bytes) {
    if (status_ != 0) return;
    const std::size_t before = head_.size();
    head_.append(bytes.substr(0, most_bytes + 1 - before));
    // A line may end without its CR (RFC 9112, 2.2).
    const std::size_t from = before < 3 ? 0 : before - 3;
    const std::size_t end = std::min(head_.find("\r\n\r\n", from), head_.find("\n\n", from));
    if (end != std::string::npos && end < most_bytes)
        status_ = judged(std::string_view(head_).substr(0, end));
    else if (head_.size() > most_bytes)
        status_ = 400;
    if (status_ != 0) head_ = {};
}

int HttpRequest::judged(std::string_view head) {
    std::string_view line = head.substr(0, std::min(head.find_first_of("\r\n"), head.size()));
    const std::string_view method = next_word(line), target = next_word(line), version = next_word(line);
    if (!line.empty() || !target.starts_with('/') || (version != "HTTP/1.0" && version != "HTTP/1.1"))
        return 400;
    is_head_ = method == "HEAD";
    if (method != "GET" && !is_head_) return 405;
    return target.substr(0, target.find('?')) == path_ ? 200 : 404;
}

std::string http_answer(int status) {
    std::string head = "HTTP/1.1 " + std::to_string(status) + " " + std::string(reason_of(status)) +
                       "\r\nConnection: close\r\nCache-Control: no-store\r\n";
    if (status == 200) return head + "Content-Type: video/x-matroska\r\nAccept-Ranges: none\r\n\r\n";
    if (status == 405) head += "Allow: GET, HEAD\r\n";
    const std::string_view words = words_of(status);
    return head.append("Content-Type: text/plain; charset=utf-8\r\nContent-Length: ")
        .append(std::to_string(words.size()))
        .append("\r\n\r\n")
        .append(words);
}

}  // namespace touchable
