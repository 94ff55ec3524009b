#include "engine/stream/hls_fetch.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <memory>
#include <string_view>

#include "engine/base/given_file.hpp"
#include "engine/base/unless_stopped.hpp"
#include "engine/picture/ffmpeg.hpp"

namespace touchable {
namespace {

constexpr std::chrono::seconds longest_fetch{10};

/// Until when FFmpeg goes on. The thread that fetches may outlive who waits for it.
struct FetchWait {
    const std::chrono::steady_clock::time_point until = std::chrono::steady_clock::now() + longest_fetch;
    std::atomic<bool> is_given_up{false};
    bool is_late() const { return std::chrono::steady_clock::now() > until; }
    static int is_over(void* own) {
        const auto& wait = *static_cast<const FetchWait*>(own);
        return wait.is_given_up || wait.is_late() ? 1 : 0;
    }
};

struct FetchedIoCloser {
    void operator()(AVIOContext* io) const { avio_closep(&io); }
};

/// No other protocols than its own, and no host that it did not name.
AVDictionary* fetch_options(const std::string& place, const ByteRange& range) {
    AVDictionary* options = nullptr;
    const bool is_tls = place.starts_with("https:");
    av_dict_set(&options, "protocol_whitelist", is_tls ? "https,tls,tcp" : "http,tcp", 0);
    av_dict_set(&options, "max_redirects", "0", 0);
    av_dict_set(&options, "icy", "0", 0);
    av_dict_set(&options, "user_agent", "touchable", 0);
    if (is_tls) av_dict_set(&options, "tls_verify", "1", 0);
    if (range.begin > 0) av_dict_set_int(&options, "offset", range.begin, 0);
    if (range.end) av_dict_set_int(&options, "end_offset", *range.end, 0);
    return options;
}

Error fetch_failure(const FetchWait& wait, int status) {
    if (wait.is_late()) return input_error("cannot be fetched: it took longer than 10 s");
    return input_error("cannot be fetched: " + ffmpeg_text(status));
}

Result<std::string> fetch_from_web(const std::string& place, std::size_t most, const ByteRange& range,
                                   FetchWait& wait) {
    AVDictionary* options = fetch_options(place, range);
    const AVIOInterruptCB callback{FetchWait::is_over, &wait};
    AVIOContext* opened = nullptr;
    int status = avio_open2(&opened, place.c_str(), AVIO_FLAG_READ, &callback, &options);
    av_dict_free(&options);
    if (status < 0) return fetch_failure(wait, status);
    const std::unique_ptr<AVIOContext, FetchedIoCloser> io(opened);
    std::string bytes;
    std::array<unsigned char, 1 << 16> some;
    while (true) {
        status = avio_read_partial(io.get(), some.data(), static_cast<int>(some.size()));
        if (status == AVERROR_EOF || status == 0) return bytes;
        if (status < 0) return fetch_failure(wait, status);
        bytes.append(reinterpret_cast<const char*>(some.data()), static_cast<std::size_t>(status));
        if (bytes.size() > most)
            return input_error("is larger than " + in_bytes(most) + ", which nothing of a stream is");
    }
}

}  // namespace

Result<std::string> fetch_place(const std::string& place, std::size_t most, const WaitIsOver& is_over,
                                const ByteRange& range) {
    constexpr std::string_view file = "file:";
    if (place.starts_with(file))
        return read_given_file(place.substr(file.size()), "", "a file of a stream", most);
    silence_ffmpeg();
    const auto wait = std::make_shared<FetchWait>();
    auto fetched =
        unless_stopped([place, most, range, wait] { return fetch_from_web(place, most, range, *wait); },
                       [&] { return is_over() || wait->is_late(); });
    wait->is_given_up = true;
    if (is_over()) return Error{ErrorKind::interrupted, "did not come in time"};
    if (!fetched) return fetch_failure(*wait, AVERROR_EXIT);
    return std::move(*fetched);
}

}  // namespace touchable
