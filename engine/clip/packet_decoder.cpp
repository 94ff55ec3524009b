#include "engine/clip/packet_decoder.hpp"

#include <algorithm>
#include <thread>
#include <utility>

#include "engine/clip/codecs.hpp"
#include "engine/clip/rank_zstd.hpp"

namespace touchable {
namespace {

/// From this many pixels on a picture is worth waking threads for.
constexpr std::int64_t pixels_for_threads = 100'000;

/// More threads than cores only take turns, and whoever draws waits for them.
int decoding_threads(const AVCodecParameters& stored, std::size_t tracks) {
    if (std::int64_t{stored.width} * stored.height < pixels_for_threads) return 1;
    const std::size_t cores = std::thread::hardware_concurrency();
    return static_cast<int>(std::clamp<std::size_t>(cores / tracks, 1, 4));
}

class FfmpegDecoder final : public PacketDecoder {
public:
    explicit FfmpegDecoder(CodecPtr codec) : codec_(std::move(codec)) {}
    int send(const AVPacket* packet) override { return avcodec_send_packet(codec_.get(), packet); }
    int receive(AVFrame& picture) override { return avcodec_receive_frame(codec_.get(), &picture); }
    void flush() override { avcodec_flush_buffers(codec_.get()); }
    bool is_one_packet_each() const override {
        return (codec_->codec->capabilities & AV_CODEC_CAP_DELAY) == 0;
    }

private:
    CodecPtr codec_;
};

struct PoolDeleter {
    void operator()(AVBufferPool* pool) const { av_buffer_pool_uninit(&pool); }
};

/// Each packet is a picture of 16 bits. Memory goes back to a pool when nobody looks at a picture any more.
class RankZstdPackets final : public PacketDecoder {
public:
    RankZstdPackets(RankZstdDecoder::Version version, int width, int height)
        : width_(width), height_(height), decoder_(version) {}
    int send(const AVPacket* packet) override;
    int receive(AVFrame& picture) override;
    void flush() override {
        decoded_.reset();
        ended_ = false;
    }
    bool is_one_packet_each() const override { return true; }

private:
    FramePtr blank() const;

    const int width_, height_;
    std::unique_ptr<AVBufferPool, PoolDeleter> pool_;
    RankZstdDecoder decoder_;
    FramePtr decoded_;  // not given yet
    bool ended_ = false;
};

/// A picture of any content.
FramePtr RankZstdPackets::blank() const {
    FramePtr frame(av_frame_alloc());
    if (!frame) return nullptr;
    frame->buf[0] = av_buffer_pool_get(pool_.get());
    if (!frame->buf[0]) return nullptr;
    frame->format = AV_PIX_FMT_GRAY16;
    frame->width = width_;
    frame->height = height_;
    frame->data[0] = frame->buf[0]->data;
    frame->linesize[0] = 2 * width_;
    return frame;
}

int RankZstdPackets::send(const AVPacket* packet) {
    if (decoded_) return AVERROR(EAGAIN);
    ended_ = packet == nullptr;
    if (!packet) return 0;
    const std::size_t samples = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
    const std::span<const std::uint8_t> bytes(packet->data, static_cast<std::size_t>(packet->size));
    if (!decoder_.promises(bytes, samples)) return AVERROR_INVALIDDATA;
    if (!pool_) pool_.reset(av_buffer_pool_init(2 * samples, nullptr));
    FramePtr frame = pool_ ? blank() : nullptr;
    if (!frame) return AVERROR(ENOMEM);
    if (!decoder_.decode(bytes, width_, height_, reinterpret_cast<std::uint16_t*>(frame->data[0]), width_))
        return AVERROR_INVALIDDATA;
    frame->best_effort_timestamp = frame->pts = packet->pts;
    decoded_ = std::move(frame);
    return 0;
}

int RankZstdPackets::receive(AVFrame& picture) {
    if (!decoded_) return ended_ ? AVERROR_EOF : AVERROR(EAGAIN);
    av_frame_move_ref(&picture, decoded_.get());
    decoded_.reset();
    return 0;
}

Error damaged_header(const std::string& where, const std::string& what) {
    return input_error(where + ": its header is damaged: " + what);
}

}  // namespace

Result<std::unique_ptr<PacketDecoder>> PacketDecoder::open(const AVStream& stream, const std::string& where,
                                                           std::int64_t most_pixels, std::size_t tracks) {
    const AVCodecParameters& stored = *stream.codecpar;
    if (const auto version = rank_zstd_version(stored)) {
        if (stored.width <= 0 || stored.height <= 0 ||
            std::int64_t{stored.width} * stored.height > most_pixels)
            return damaged_header(where, "it says " + std::to_string(stored.width) + "x" +
                                             std::to_string(stored.height) + " pixels");
        return std::unique_ptr<PacketDecoder>(
            std::make_unique<RankZstdPackets>(*version, stored.width, stored.height));
    }
    const AVCodec* decoder = avcodec_find_decoder(stored.codec_id);
    if (!decoder)
        return input_error(where + ": has codec " + codec_name(stored) + ", which this FFmpeg cannot decode");
    CodecPtr codec(avcodec_alloc_context3(decoder));
    if (!codec) return Error{ErrorKind::internal, "out of memory"};
    int status = avcodec_parameters_to_context(codec.get(), &stored);
    // Slices of a picture side by side; frames side by side would come late.
    codec->thread_type = FF_THREAD_SLICE;
    codec->thread_count = decoding_threads(stored, tracks);
    codec->pkt_timebase = stream.time_base;
    codec->err_recognition = AV_EF_CRCCHECK | AV_EF_BITSTREAM | AV_EF_BUFFER | AV_EF_EXPLODE;
    codec->max_pixels = most_pixels;
    if (status >= 0) status = avcodec_open2(codec.get(), decoder, nullptr);
    if (status < 0) return damaged_header(where, ffmpeg_text(status));
    return std::unique_ptr<PacketDecoder>(std::make_unique<FfmpegDecoder>(std::move(codec)));
}

}  // namespace touchable
