#include "tests/video/film_reader.hpp"

#include "engine/picture/ffmpeg.hpp"

namespace touchable::test {
namespace {

SeenPicture seen_in(const AVFrame& frame, const AVRational& unit) {
    SeenPicture picture{static_cast<double>(frame.pts) * av_q2d(unit), frame.width, frame.height, {}};
    for (int y = 0; y < frame.height; ++y)
        for (int x = 0; x < frame.width; ++x)
            picture.luma.push_back(frame.data[0][std::ptrdiff_t{frame.linesize[0]} * y + x]);
    return picture;
}

}  // namespace

std::vector<SeenPicture> seen_in_film(const std::filesystem::path& file) {
    std::vector<SeenPicture> pictures;
    AVFormatContext* demuxer = nullptr;
    if (avformat_open_input(&demuxer, file.c_str(), nullptr, nullptr) < 0) return pictures;
    const AVCodec* codec = nullptr;
    CodecPtr decoder;
    if (avformat_find_stream_info(demuxer, nullptr) >= 0 &&
        av_find_best_stream(demuxer, AVMEDIA_TYPE_VIDEO, -1, -1, &codec, 0) == 0) {
        decoder.reset(avcodec_alloc_context3(codec));
        avcodec_parameters_to_context(decoder.get(), demuxer->streams[0]->codecpar);
        if (avcodec_open2(decoder.get(), codec, nullptr) < 0) decoder.reset();
    }
    const PacketPtr packet(av_packet_alloc());
    const FramePtr frame(av_frame_alloc());
    const auto take = [&] {
        while (avcodec_receive_frame(decoder.get(), frame.get()) >= 0)
            pictures.push_back(seen_in(*frame, demuxer->streams[0]->time_base));
    };
    for (; decoder && av_read_frame(demuxer, packet.get()) >= 0; av_packet_unref(packet.get())) {
        if (packet->stream_index == 0) avcodec_send_packet(decoder.get(), packet.get());
        take();
    }
    if (decoder) {
        avcodec_send_packet(decoder.get(), nullptr);
        take();
    }
    avformat_close_input(&demuxer);
    return pictures;
}

}  // namespace touchable::test
