#pragma once

// FFmpeg's C API with owners, for this room's .cpp files only.

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/pixdesc.h>
#include <libswscale/swscale.h>
}

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

namespace touchable {

struct FfmpegDeleter {
    void operator()(AVFrame* frame) const { av_frame_free(&frame); }
    void operator()(AVPacket* packet) const { av_packet_free(&packet); }
    void operator()(AVCodecContext* codec) const { avcodec_free_context(&codec); }
    void operator()(SwsContext* scaler) const { sws_freeContext(scaler); }
};
using FramePtr = std::unique_ptr<AVFrame, FfmpegDeleter>;
using PacketPtr = std::unique_ptr<AVPacket, FfmpegDeleter>;
using CodecPtr = std::unique_ptr<AVCodecContext, FfmpegDeleter>;
using ScalerPtr = std::unique_ptr<SwsContext, FfmpegDeleter>;

/// What FFmpeg means by a negative return value.
std::string ffmpeg_text(int error);

/// A path as FFmpeg takes it: never mistaken for a protocol or an option, whatever its characters.
std::string file_url(const std::filesystem::path& path);

/// Errors come back as Results, so FFmpeg itself prints nothing. Holds for the whole process; called wherever
/// a file or a codec is opened.
void silence_ffmpeg();

// --- What FFmpeg's versions have in different ways: no other file asks for the version.

/// The bytes that an AVIOContext hands to its `write` callback: FFmpeg 7 made them const.
#if LIBAVFORMAT_VERSION_MAJOR >= 61
using MuxedBytes = const std::uint8_t;
#else
using MuxedBytes = std::uint8_t;
#endif

/// Whether a decoder needs no earlier frame for this one (a flag from FFmpeg 6.1 on).
bool is_key_frame(const AVFrame& frame);

/// Whether an encoder takes pictures of this format. One that lists none takes any.
bool encodes(const AVCodec& codec, AVPixelFormat format);

}  // namespace touchable
