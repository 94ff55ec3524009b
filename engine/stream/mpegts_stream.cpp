#include "engine/stream/mpegts_stream.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "engine/base/try.hpp"
#include "engine/clip/matroska_writer.hpp"
#include "engine/stream/labelled_encoder.hpp"
#include "engine/stream/memory_muxer.hpp"

extern "C" {
#include <libavutil/opt.h>
}

namespace touchable {
namespace {

/// MPEG-TS counts so.
constexpr AVRational clock_90_khz{1, 90'000};
constexpr std::int64_t mpegts_ns = 1'000'000'000;
/// Pictures are stamped so much later than their bytes come, which stock players need to have them in time.
constexpr int mpegts_delay_us = 50'000;

class MpegtsMuxer final : public StreamMuxer {
public:
    explicit MpegtsMuxer(const SceneDescription& described) : described_(described) {}
    std::span<const std::uint8_t> header() const override { return {}; }
    std::span<const std::uint8_t> padding() const override {
        static constexpr std::array<std::uint8_t, 188> null_packet{0x47, 0x1F, 0xFF, 0x10};
        return null_packet;
    }
    Result<StreamBlock> add(const RawFrame& frame, const PictureLabel& label, std::int64_t time_ns,
                            bool is_key) override;

private:
    Result<void> open(const RawFrame& first);

    const SceneDescription described_;
    std::optional<LabelledEncoder> encoder_;
    std::unique_ptr<MemoryMuxer> muxer_;
    std::optional<std::int64_t> newest_;  // tick
};

Result<void> MpegtsMuxer::open(const RawFrame& first) {
    TRY_ASSIGN(auto encoder, LabelledEncoder::open(first, described_, TrackCoding::h264_quick));
    TRY_ASSIGN(auto muxer, MemoryMuxer::open("mpegts"));
    AVFormatContext& context = muxer->context();
    context.max_delay = mpegts_delay_us;
    for (std::size_t k = 0; k < encoder.tracks(); ++k) {
        AVStream* const stream = avformat_new_stream(&context, nullptr);
        if (!stream) return Error{ErrorKind::internal, "out of memory"};
        if (auto described = encoder.describe(k, *stream->codecpar); !described) return described;
        stream->time_base = clock_90_khz;
    }
    // A picture's length is said where it can be: then nobody waits for the next one to know its end.
    if (auto begun = muxer->begin("omit_video_pes_length=0"); !begun) return begun;
    encoder_.emplace(std::move(encoder));
    muxer_ = std::move(muxer);
    return {};
}

Result<StreamBlock> MpegtsMuxer::add(const RawFrame& frame, const PictureLabel& label, std::int64_t time_ns,
                                     bool is_key) {
    if (!encoder_) {
        TRY(open(frame));
        is_key = true;
    }
    TRY_ASSIGN(auto packets, encoder_->encode(frame, label, is_key));
    std::int64_t tick = av_rescale(time_ns, clock_90_khz.den, mpegts_ns);
    if (newest_) tick = std::max(tick, *newest_ + 1);
    newest_ = tick;
    if (is_key) av_opt_set(muxer_->context().priv_data, "mpegts_flags", "+resend_headers", 0);
    for (std::size_t k = 0; k < packets.size(); ++k) {
        AVPacket& packet = *packets[k];
        packet.pts = packet.dts = tick;
        TRY(muxer_->write(packet, static_cast<int>(k), clock_90_khz));
    }
    return StreamBlock{label.frame, is_key, muxer_->take()};
}

}  // namespace

Result<std::unique_ptr<StreamMuxer>> make_mpegts_muxer(const SceneDescription& described) {
    TRY(check_storable("the stream", described));
    return std::unique_ptr<StreamMuxer>(std::make_unique<MpegtsMuxer>(described));
}

}  // namespace touchable
