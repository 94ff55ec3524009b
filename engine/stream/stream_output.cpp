#include "engine/stream/stream_output.hpp"

#include <algorithm>
#include <charconv>
#include <utility>

#include "engine/ffmpeg/ffmpeg.hpp"
#include "engine/printable.hpp"
#include "engine/start_thread.hpp"

namespace touchable {
namespace {

/// Of SRT and of MPEG-TS: what goes into a datagram.
constexpr const char* datagram_bytes = "1316";
constexpr std::int64_t most_latency_ms = 60'000;

std::optional<std::int64_t> milliseconds_of(const std::string& words) {
    std::int64_t value = 0;
    const auto [end, failure] = std::from_chars(words.data(), words.data() + words.size(), value);
    if (failure != std::errc() || end != words.data() + words.size() || value < 0 || value > most_latency_ms)
        return std::nullopt;
    return value;
}

}  // namespace

std::int64_t wait_before_call_ns(int calls_in_vain) {
    constexpr std::int64_t shortest_ns = 500'000'000;
    constexpr int most_doublings = 4;
    return shortest_ns << std::clamp(calls_in_vain - 1, 0, most_doublings);
}

void StreamOutput::Closer::operator()(AVIOContext* io) const {
    avio_closep(&io);
}

StreamOutput::StreamOutput(const StreamUrl& url, const StreamRing& ring, StreamAudience& audience)
    : url_(url),
      ring_(ring),
      audience_(audience),
      calls_(url.transport == StreamTransport::udp || url.value("mode") == "caller") {}

Result<std::unique_ptr<StreamOutput>> StreamOutput::create(const StreamUrl& url, const StreamRing& ring,
                                                           StreamAudience& audience) {
    const auto refused = [&](const std::string& right) {
        return usage_error(in_quotes(url.name()) + " cannot be sent to: " + right);
    };
    const bool is_srt = url.transport == StreamTransport::srt;
    if (!is_srt && url.transport != StreamTransport::udp) return refused("right would be srt:// or udp://");
    if (url.port == 0) return refused("it needs a port from 1 to 65535");
    const std::string mode = url.value("mode"), latency = url.value("latency");
    if (is_srt && !mode.empty() && mode != "caller" && mode != "listener")
        return refused("mode is caller or listener");
    if (!latency.empty() && !milliseconds_of(latency))
        return refused("latency is milliseconds, from 0 to " + std::to_string(most_latency_ms));
    auto output = std::unique_ptr<StreamOutput>(new StreamOutput(url, ring, audience));
    if (output->calls_ && url.host.empty()) return refused("it names no host to call");
    return output;
}

StreamOutput::~StreamOutput() {
    end();
    if (thread_.joinable()) thread_.join();
}

void StreamOutput::end() {
    stop_ = true;
    time_.end();
}

Result<void> StreamOutput::start() {
    silence_ffmpeg();
    return start_thread(thread_, "stream-output", "that sends a stream", [this] {
        send_all();
        is_over_ = true;
    });
}

void StreamOutput::set_options(AVDictionary*& options) const {
    av_dict_set(&options, "protocol_whitelist", url_.protocols().c_str(), 0);
    if (url_.transport == StreamTransport::udp) {
        av_dict_set(&options, "pkt_size", datagram_bytes, 0);
        for (const char* const key : {"localaddr", "ttl"})
            if (const std::string value = url_.value(key); !value.empty())
                av_dict_set(&options, key, value.c_str(), 0);
        return;
    }
    constexpr std::int64_t us_per_ms = 1000;
    av_dict_set(&options, "mode", calls_ ? "caller" : "listener", 0);
    av_dict_set(&options, "payload_size", datagram_bytes, 0);
    if (const auto latency_ms = milliseconds_of(url_.value("latency")))
        av_dict_set_int(&options, "latency", *latency_ms * us_per_ms, 0);
    for (const char* const key : {"passphrase", "pbkeylen"})
        if (const std::string value = url_.value(key); !value.empty())
            av_dict_set(&options, key, value.c_str(), 0);
    if (const std::string value = url_.value("streamid"); !value.empty())
        av_dict_set(&options, "srt_streamid", value.c_str(), 0);
}

/// Waits for the caller, or calls; null where it is to end, or nobody answers.
StreamOutput::Output StreamOutput::open() {
    // Whoever waits for a caller waits no longer than there is something to send.
    const AVIOInterruptCB interrupt{[](void* self) {
                                        const auto& it = *static_cast<StreamOutput*>(self);
                                        const bool is_late = !it.is_open_ && it.ring_.is_ended();
                                        return it.stop_ || is_late ? 1 : 0;
                                    },
                                    this};
    const std::string host = url_.host.find(':') == std::string::npos ? url_.host : "[" + url_.host + "]";
    const std::string name = (url_.transport == StreamTransport::udp ? "udp://" : "srt://") + host + ":" +
                             std::to_string(url_.port);
    AVDictionary* options = nullptr;
    set_options(options);
    AVIOContext* io = nullptr;
    is_open_ = false;
    failure_ = avio_open2(&io, name.c_str(), AVIO_FLAG_WRITE, &interrupt, &options);
    av_dict_free(&options);
    is_open_ = failure_ >= 0;
    return Output(io);
}

/// SRT paces what it sends itself. By UDP a key would come as a burst that few receivers have room for: it is
/// spread over a hundredth of a second.
bool StreamOutput::give_all(AVIOContext& output, std::span<const std::uint8_t> bytes) {
    constexpr std::size_t piece = 7 * 1316;
    constexpr std::int64_t spread_ns = 10'000'000;
    const bool is_udp = url_.transport == StreamTransport::udp;
    const auto pieces = static_cast<std::int64_t>(is_udp ? bytes.size() / piece + 1 : 1);
    const std::int64_t begin_ns = time_.now_ns();
    for (std::int64_t k = 0; k < pieces; ++k) {
        if (k > 0 && !time_.wait_until(begin_ns + spread_ns * k / pieces)) return false;
        const auto some = k + 1 < pieces ? bytes.first(piece) : bytes;
        avio_write(&output, some.data(), static_cast<int>(some.size()));
        avio_flush(&output);
        bytes = bytes.subspan(some.size());
    }
    return output.error >= 0;
}

/// Until all was sent, which is no failure, or it cannot be sent any further: why not.
std::string StreamOutput::send_to(AVIOContext& output, ListenerFigures& figures) {
    constexpr std::chrono::milliseconds a_while{20};
    const auto give = [&](std::span<const std::uint8_t> bytes) { return give_all(output, bytes); };
    auto cursor = ring_.join();
    StreamRing::Bytes header;
    while (!stop_ && !ring_.is_over(cursor)) {
        const auto block = ring_.wait_next(cursor, a_while);
        figures.dropped = cursor.dropped();
        if (!block) continue;
        const bool had_header = std::exchange(header, ring_.header()) != nullptr;
        if ((!had_header && !give(*header)) || !give(block->bytes)) return stop_ ? "is cut off" : "has gone";
        ++figures.sent;
    }
    if (!stop_) wait_for_arrival();
    return stop_ ? "is cut off" : "";
}

/// What is on its way when SRT is closed is lost; its own way to wait for that (linger) nobody can end.
void StreamOutput::wait_for_arrival() {
    if (url_.transport != StreamTransport::srt) return;
    constexpr std::int64_t ns_per_ms = 1'000'000, least_ms = 1000;
    const std::int64_t latency_ms = milliseconds_of(url_.value("latency")).value_or(0);
    (void)time_.wait_until(time_.now_ns() + (least_ms + 2 * latency_ms) * ns_per_ms);
}

/// False where there is nothing more to try.
bool StreamOutput::waits_for_next(int calls) {
    if (stop_ || ring_.is_ended()) return false;
    return time_.wait_until(time_.now_ns() + wait_before_call_ns(calls));
}

/// Sends to whoever is there now. False where that one has gone before there was anything to speak of.
bool StreamOutput::was_for_long(AVIOContext& output) {
    constexpr std::int64_t short_ns = 1'000'000'000;
    const bool is_udp = url_.transport == StreamTransport::udp;
    const std::int64_t begin_ns = time_.now_ns();
    // Of UDP nobody knows whether anybody is there.
    ListenerFigures figures{url_.name() + (calls_ ? "" : ": a caller")};
    audience_.came(figures.name, is_udp ? "is sent to, whoever listens" : "listens");
    figures.end = send_to(output, figures);
    if (is_udp && figures.end.empty()) figures.end = "was sent all";
    const bool is_short = figures.sent == 0 || time_.now_ns() - begin_ns < short_ns;
    audience_.went(std::move(figures));
    return !is_short;
}

/// That nobody answers, that something is wrong here, or that whoever was called goes at once is said once
/// until somebody stays.
void StreamOutput::send_all() {
    const std::string name = url_.name();
    bool is_said = false, is_short_said = false;
    for (int calls = 1; !stop_ && !ring_.is_ended();) {
        auto output = open();
        if (output) {
            const bool stayed = was_for_long(*output);
            output.reset();
            if (stayed || !calls_) {
                calls = 1;
                is_said = is_short_said = false;
                continue;
            }
            if (!stop_ && !ring_.is_ended() && !std::exchange(is_short_said, true))
                audience_.remark(name + ": goes again within a second; called less and less often");
        } else if (!stop_ && !ring_.is_ended() && !std::exchange(is_said, true)) {
            audience_.remark(name + (calls_ ? ": nobody answers (" : ": cannot wait for a caller there (") +
                             ffmpeg_text(failure_) + "); tried again until somebody does");
        }
        if (!waits_for_next(calls++)) return;
    }
}

}  // namespace touchable
