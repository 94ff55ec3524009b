#include <atomic>
#include <span>
#include <thread>
#include <utility>

#include "engine/ffmpeg/ffmpeg.hpp"
#include "engine/start_thread.hpp"
#include "engine/stream/sender_time.hpp"
#include "engine/stream/stream_output.hpp"

namespace touchable {
namespace {

struct Closer {
    void operator()(AVIOContext* io) const { avio_closep(&io); }
};
using Output = std::unique_ptr<AVIOContext, Closer>;

class UdpOutput final : public StreamOutput {
public:
    UdpOutput(const StreamUrl& url, const StreamRing& ring, StreamAudience& audience)
        : StreamOutput(url), ring_(ring), audience_(audience) {}
    ~UdpOutput() override {
        UdpOutput::end();
        if (thread_.joinable()) thread_.join();
    }
    Result<void> start() override {
        silence_ffmpeg();
        return start_thread(thread_, "stream-output", "that sends a stream", [this] {
            send_all();
            is_over_ = true;
        });
    }
    void end() override {
        stop_ = true;
        time_.end();
    }
    bool is_over() const override { return is_over_; }
    bool calls() const override { return true; }

private:
    Output open();
    bool give_all(AVIOContext& output, std::span<const std::uint8_t> bytes);
    std::string send_to(AVIOContext& output, ListenerFigures& figures);
    void send_all();

    const StreamRing& ring_;
    StreamAudience& audience_;
    SteadySenderTime time_;
    int failure_ = 0;  // FFmpeg's, of the newest `open`
    std::atomic<bool> stop_{false}, is_over_{false};
    std::thread thread_;
};

/// Null where the system refuses, or it is to end.
Output UdpOutput::open() {
    const AVIOInterruptCB interrupt{[](void* self) { return static_cast<UdpOutput*>(self)->stop_ ? 1 : 0; },
                                    this};
    const std::string host = url_.host.find(':') == std::string::npos ? url_.host : "[" + url_.host + "]";
    AVDictionary* options = nullptr;
    av_dict_set(&options, "protocol_whitelist", url_.protocols().c_str(), 0);
    av_dict_set(&options, "pkt_size", "1316", 0);  // seven packets of MPEG-TS
    for (const char* const key : {"localaddr", "ttl"})
        if (const std::string value = url_.value(key); !value.empty())
            av_dict_set(&options, key, value.c_str(), 0);
    AVIOContext* io = nullptr;
    const std::string name = "udp://" + host + ":" + std::to_string(url_.port);
    failure_ = avio_open2(&io, name.c_str(), AVIO_FLAG_WRITE, &interrupt, &options);
    av_dict_free(&options);
    return Output(io);
}

/// A key would come as a burst that few receivers have room for: it is spread over a hundredth of a second.
bool UdpOutput::give_all(AVIOContext& output, std::span<const std::uint8_t> bytes) {
    constexpr std::size_t piece = 7 * 1316;
    constexpr std::int64_t spread_ns = 10'000'000;
    const auto pieces = static_cast<std::int64_t>(bytes.size() / piece + 1);
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

/// Until all was sent, or it cannot be sent any further: how it ended.
std::string UdpOutput::send_to(AVIOContext& output, ListenerFigures& figures) {
    constexpr std::chrono::milliseconds a_while{20};
    auto cursor = ring_.join();
    StreamRing::Bytes header;
    while (!stop_ && !ring_.is_over(cursor)) {
        const auto block = ring_.wait_next(cursor, a_while);
        figures.dropped = cursor.dropped();
        if (!block) continue;
        const bool had_header = std::exchange(header, ring_.header()) != nullptr;
        if ((!had_header && !give_all(output, *header)) || !give_all(output, block->bytes))
            return stop_ ? "is cut off" : "has gone";
        ++figures.sent;
    }
    return stop_ ? "is cut off" : "was sent all";
}

void UdpOutput::send_all() {
    bool is_said = false;
    for (int calls = 1; !stop_ && !ring_.is_ended();) {
        if (auto output = open()) {
            ListenerFigures figures{url_.name()};
            audience_.came(figures.name, "is sent to, whoever listens");
            figures.end = send_to(*output, figures);
            audience_.went(std::move(figures));
            is_said = false;
        } else if (!stop_ && !std::exchange(is_said, true)) {
            audience_.remark(url_.name() + ": cannot be sent to (" + ffmpeg_text(failure_) +
                             "); tried again until it can");
        }
        if (stop_ || ring_.is_ended() || !time_.wait_until(time_.now_ns() + wait_before_call_ns(calls++)))
            return;
    }
}

}  // namespace

Result<std::unique_ptr<StreamOutput>> make_udp_output(const StreamUrl& url, const StreamRing& ring,
                                                      StreamAudience& audience) {
    if (url.host.empty()) return usage_error("it names no host to call");
    return std::unique_ptr<StreamOutput>(std::make_unique<UdpOutput>(url, ring, audience));
}

}  // namespace touchable
