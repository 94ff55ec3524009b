#include "engine/media/sound_container.hpp"

namespace touchable {

ContainerPtr open_sound_container(const std::filesystem::path& file) {
    constexpr const char* kinds_of_files = "matroska,mov,wav";
    silence_ffmpeg();
    AVDictionary* options = nullptr;
    av_dict_set(&options, "format_whitelist", kinds_of_files, 0);
    AVFormatContext* container = nullptr;
    const int status = avformat_open_input(&container, file_url(file).c_str(), nullptr, &options);
    av_dict_free(&options);
    return ContainerPtr(status < 0 ? nullptr : container);
}

double begin_of_pictures(AVFormatContext& container, AVPacket& packet) {
    constexpr int most_packets = 1000;
    const int pictures = av_find_best_stream(&container, AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
    if (pictures < 0) return 0;
    double seconds = 0;
    for (int k = 0; k < most_packets && av_read_frame(&container, &packet) >= 0; ++k) {
        const bool is_first = packet.stream_index == pictures && packet.pts != AV_NOPTS_VALUE;
        if (is_first)
            seconds = static_cast<double>(packet.pts) * av_q2d(container.streams[pictures]->time_base);
        av_packet_unref(&packet);
        if (is_first) break;
    }
    return seconds;
}

}  // namespace touchable
