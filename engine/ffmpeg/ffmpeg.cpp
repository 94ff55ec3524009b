#include "engine/ffmpeg/ffmpeg.hpp"

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

}  // namespace touchable
