#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace touchable {

/// What whoever connected asks of a server that has one stream and nothing else.
class HttpRequest {
public:
    static constexpr std::size_t most_bytes = 8192;

    /// `path`: where the stream is, "/clip.mkv".
    explicit HttpRequest(std::string path) : path_(std::move(path)) {}

    /// More of it. Once it is whole what comes further is of no meaning.
    void take(std::string_view bytes);
    /// 0: it is not whole yet; 200: the stream is asked for; 400, 404, 405: it is refused.
    int status() const { return status_; }
    /// Of 200: only what would be said of the stream.
    bool is_head() const { return is_head_; }

private:
    int judged(std::string_view head);

    std::string path_, head_;
    int status_ = 0;
    bool is_head_ = false;
};

/// The head of the answer, and of a refusal all of it. 503: there is no place.
std::string http_answer(int status);

}  // namespace touchable
