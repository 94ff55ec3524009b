#include "engine/media/track_encoder.hpp"

#include <cstring>

extern "C" {
#include <libavutil/imgutils.h>
}

namespace touchable {
namespace {

Error encoder_error(PlaneRole role, const std::string& what) {
    return {ErrorKind::internal, "encoder of track " + std::string(role_name(role)) + ": " + what};
}

/// The smallest grey that holds the values as they are; RGB as FFV1 has it.
AVPixelFormat format_of(PlaneRole role, const PlaneView& plane, const Scene& scene) {
    if (plane.channels == 3) return AV_PIX_FMT_BGR0;
    if (plane.bytes_per_sample == 1) return AV_PIX_FMT_GRAY8;
    if (role == PlaneRole::height || scene.depth_bits > 12) return AV_PIX_FMT_GRAY16;
    return scene.depth_bits > 10 ? AV_PIX_FMT_GRAY12 : AV_PIX_FMT_GRAY10;
}

void copy_samples(const PlaneView& plane, AVFrame& frame) {
    for (int y = 0; y < plane.height; ++y) {
        const std::uint8_t* from = plane.row(y);
        std::uint8_t* to = frame.data[0] + static_cast<std::ptrdiff_t>(frame.linesize[0]) * y;
        if (plane.channels == 1) {
            std::memcpy(to, from, static_cast<std::size_t>(plane.width * plane.bytes_per_sample));
            continue;
        }
        for (int x = 0; x < plane.width; ++x, from += 3, to += 4) {
            to[0] = from[2];
            to[1] = from[1];
            to[2] = from[0];
            to[3] = 0;
        }
    }
}

/// How a picture is cut: n x n slices, which decode side by side, none over 4 megapixels; 0 where FFmpeg's
/// FFV1 has no way to cut it. (It wants at least 2 x 2 slices beyond 352x288, and where a slice would be 1
/// pixel wide or high it writes slice positions that cannot be read back.)
int slice_count(int width, int height) {
    if (width >= 32 && height >= 32) {
        constexpr int largest = 1 << 22;
        int n = 2;
        while (((width + n - 1) / n) * ((height + n - 1) / n) > largest) ++n;
        return n * n;
    }
    if (width > 352 || height > 288) return width >= 4 && height >= 4 ? 4 : 0;
    return width >= 2 && height >= 2 ? 1 : 0;
}

}  // namespace

Result<TrackEncoder> TrackEncoder::open(PlaneRole role, const PlaneView& first, const Scene& scene) {
    const AVCodec* codec = avcodec_find_encoder(AV_CODEC_ID_FFV1);
    if (!codec) return encoder_error(role, "this FFmpeg has no FFV1");
    const int slices = slice_count(first.width, first.height);
    if (slices == 0)
        return usage_error("pictures of " + std::to_string(first.width) + "x" + std::to_string(first.height) +
                           " cannot be stored: FFV1 needs sides of at least 2 pixels, and of 4 where one is "
                           "over 352 wide or 288 high");
    if (av_image_check_size(static_cast<unsigned>(first.width), static_cast<unsigned>(first.height), 0,
                            nullptr) < 0)
        return usage_error("pictures of " + std::to_string(first.width) + "x" + std::to_string(first.height) +
                           " cannot be stored: FFmpeg takes no more than some 16384x16128 pixels");
    TrackEncoder track;
    track.role_ = role;
    track.codec_.reset(avcodec_alloc_context3(codec));
    track.frame_.reset(av_frame_alloc());
    if (!track.codec_ || !track.frame_) return encoder_error(role, "out of memory");
    AVCodecContext& settings = *track.codec_;
    settings.width = first.width;
    settings.height = first.height;
    settings.pix_fmt = format_of(role, first, scene);
    settings.time_base = {1, 1000};
    settings.gop_size = 1;
    settings.slices = slices;
    settings.thread_count = 1;
    settings.level = 3;
    settings.flags |= AV_CODEC_FLAG_BITEXACT | AV_CODEC_FLAG_GLOBAL_HEADER;
    settings.color_range = AVCOL_RANGE_JPEG;  // no player squeezes the values
    AVDictionary* options = nullptr;
    for (const auto& [name, value] : {std::pair{"slicecrc", 1}, {"coder", 1}, {"context", 1}})
        av_dict_set_int(&options, name, value, 0);
    const int status = avcodec_open2(track.codec_.get(), codec, &options);
    const bool all_taken = av_dict_count(options) == 0;
    av_dict_free(&options);
    if (status < 0 || !all_taken)
        return encoder_error(role, status < 0 ? ffmpeg_text(status) : "unknown option");
    track.frame_->format = settings.pix_fmt;
    track.frame_->width = settings.width;
    track.frame_->height = settings.height;
    if (av_frame_get_buffer(track.frame_.get(), 0) < 0) return encoder_error(role, "out of memory");
    return track;
}

Result<PacketPtr> TrackEncoder::encode(const PlaneView& plane) {
    PacketPtr packet(av_packet_alloc());
    if (!packet || av_frame_make_writable(frame_.get()) < 0) return encoder_error(role_, "out of memory");
    copy_samples(plane, *frame_);
    ++frame_->pts;
    int status = avcodec_send_frame(codec_.get(), frame_.get());
    if (status >= 0) status = avcodec_receive_packet(codec_.get(), packet.get());
    if (status < 0) return encoder_error(role_, ffmpeg_text(status));
    return packet;
}

}  // namespace touchable
