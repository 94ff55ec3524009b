#include "bench/media/av_codec.hpp"

namespace touchable {
namespace {

class AvCodec final : public PlaneCodec {
public:
    AvCodec(const AvSettings& settings, const PlaneView& first)
        : settings_(settings), unpacker_(first, settings.packing) {}

    Result<void> open(const PlaneView& first) {
        const AVCodec* codec = avcodec_find_encoder_by_name(settings_.encoder.c_str());
        if (!codec) return failed_at("it is not in this FFmpeg");
        encoder_.reset(avcodec_alloc_context3(codec));
        picture_.reset(av_frame_alloc());
        decoded_.reset(av_frame_alloc());
        out_.reset(av_packet_alloc());
        in_.reset(av_packet_alloc());
        if (!encoder_ || !picture_ || !decoded_ || !out_ || !in_) return failed_at("out of memory");
        AVCodecContext& context = *encoder_;
        context.width = first.width;
        context.height = settings_.packing.halves ? 2 * first.height : first.height;
        context.pix_fmt = settings_.packing.format;
        context.time_base = {1, 30};
        context.gop_size = settings_.access_every;
        context.max_b_frames = 0;
        context.slices = settings_.slices;
        context.thread_count = 1;
        context.level = settings_.encoder == "ffv1" ? 3 : context.level;
        if (first.channels == 1) context.color_range = AVCOL_RANGE_JPEG;
        AVDictionary* options = nullptr;
        for (const auto& [name, value] : settings_.options)
            av_dict_set(&options, name.c_str(), value.c_str(), 0);
        const int status = avcodec_open2(encoder_.get(), codec, &options);
        const bool all_taken = av_dict_count(options) == 0;
        av_dict_free(&options);
        if (status < 0 || !all_taken) return failed_at(status < 0 ? ffmpeg_text(status) : "unknown option");
        picture_->format = context.pix_fmt;
        picture_->width = context.width;
        picture_->height = context.height;
        if (av_frame_get_buffer(picture_.get(), 0) < 0) return failed_at("out of memory");
        return {};
    }

    Result<void> encode(const PlaneView& plane, Packet& packet) override {
        // Encoders with temporal prediction keep references to earlier pictures.
        if (av_frame_make_writable(picture_.get()) < 0) return failed_at("out of memory");
        if (auto packed = pack(plane, settings_.packing, scaler_, *picture_); !packed) return packed;
        picture_->pts = next_++;
        int status = avcodec_send_frame(encoder_.get(), picture_.get());
        if (status >= 0) status = avcodec_receive_packet(encoder_.get(), out_.get());
        if (status < 0) return failed_at("no packet for a frame: " + ffmpeg_text(status));
        packet.assign(out_->data, out_->data + out_->size);
        av_packet_unref(out_.get());
        return {};
    }

    Result<void> decode(const Packet& packet) override {
        if (!decoder_)
            if (auto opened = open_decoder(); !opened) return opened;
        // Without a buffer owner FFmpeg copies the bytes, like bytes read from a file.
        in_->data = const_cast<std::uint8_t*>(packet.data());
        in_->size = static_cast<int>(packet.size());
        // Without this flag FFmpeg adds the previous picture to a PNG.
        in_->flags = settings_.access_every == 1 ? AV_PKT_FLAG_KEY : 0;
        int status = avcodec_send_packet(decoder_.get(), in_.get());
        if (status >= 0) status = avcodec_receive_frame(decoder_.get(), decoded_.get());
        if (status < 0) return failed_at("no frame for a packet: " + ffmpeg_text(status));
        return {};
    }

    Result<PlaneView> plane() override { return unpacker_.plane(*decoded_); }

private:
    Error failed_at(const std::string& what) const {
        return {ErrorKind::internal, "FFmpeg's " + settings_.encoder + ": " + what};
    }

    Result<void> open_decoder() {
        const AVCodec* codec = avcodec_find_decoder(encoder_->codec_id);
        if (!codec) return failed_at("there is no decoder");
        decoder_.reset(avcodec_alloc_context3(codec));
        AVCodecParameters* stored = avcodec_parameters_alloc();
        int status = decoder_ && stored ? avcodec_parameters_from_context(stored, encoder_.get()) : -1;
        if (status >= 0) status = avcodec_parameters_to_context(decoder_.get(), stored);
        avcodec_parameters_free(&stored);
        if (status < 0) return failed_at("out of memory");
        decoder_->thread_count = 1;
        status = avcodec_open2(decoder_.get(), codec, nullptr);
        if (status < 0) return failed_at("its decoder: " + ffmpeg_text(status));
        return {};
    }

    AvSettings settings_;
    Unpacker unpacker_;
    CodecPtr encoder_, decoder_;
    FramePtr picture_, decoded_;
    PacketPtr out_, in_;
    ScalerPtr scaler_;
    std::int64_t next_ = 0;
};

}  // namespace

Result<std::unique_ptr<PlaneCodec>> open_av_codec(const AvSettings& settings, const PlaneView& first) {
    silence_ffmpeg();
    auto codec = std::make_unique<AvCodec>(settings, first);
    if (auto opened = codec->open(first); !opened) return opened.error();
    return std::unique_ptr<PlaneCodec>(std::move(codec));
}

}  // namespace touchable
