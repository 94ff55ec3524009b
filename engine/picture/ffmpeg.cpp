#include "engine/picture/ffmpeg.hpp"

#include <array>
#include <mutex>

namespace touchable {

std::string ffmpeg_text(int error) {
    std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
    if (av_strerror(error, text.data(), text.size()) < 0) return "FFmpeg error " + std::to_string(error);
    return text.data();
}

std::string file_url(const std::filesystem::path& path) {
    return "file:" + path.string();
}

void silence_ffmpeg() {
    static std::once_flag once;
    std::call_once(once, [] { av_log_set_level(AV_LOG_QUIET); });
}

bool is_key_frame(const AVFrame& frame) {
#if LIBAVUTIL_VERSION_MAJOR >= 59
    return (frame.flags & AV_FRAME_FLAG_KEY) != 0;
#else
    return frame.key_frame != 0;
#endif
}

bool encodes(const AVCodec& codec, AVPixelFormat format) {
    const AVPixelFormat* formats = nullptr;
#if LIBAVCODEC_VERSION_INT >= AV_VERSION_INT(61, 13, 100)
    const void* listed = nullptr;
    if (avcodec_get_supported_config(nullptr, &codec, AV_CODEC_CONFIG_PIX_FORMAT, 0, &listed, nullptr) < 0)
        return false;
    formats = static_cast<const AVPixelFormat*>(listed);
#else
    formats = codec.pix_fmts;
#endif
    if (!formats) return true;
    while (*formats != AV_PIX_FMT_NONE)
        if (*formats++ == format) return true;
    return false;
}

}  // namespace touchable
