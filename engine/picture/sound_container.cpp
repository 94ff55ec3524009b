#include "engine/picture/sound_container.hpp"

#include <utility>

#include "engine/picture/box_tables.hpp"
#include "engine/picture/container_end.hpp"

namespace touchable {

InputPtr open_sound_container(const std::filesystem::path& file) {
    auto bytes = bytes_of_file(file);
    if (!bytes) return nullptr;
    const auto end = end_of_container(**bytes, file.string());
    if (!end || !check_box_tables(**bytes, *end)) return nullptr;
    auto container = open_input(std::move(*bytes), *end, file.string(), {.formats = "matroska,mov,wav"});
    return container ? std::move(*container) : nullptr;
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
