#include "tests/video/quicktime.hpp"

#include <cstring>

#include "tests/picture/results.hpp"

namespace touchable::test {

void write_quicktime(const std::filesystem::path& file, const std::vector<Image>& pictures,
                     const FrameRate& rate, const std::function<std::int64_t(int)>& time_of,
                     QuicktimeCodec codec) {
    const bool is_hap = codec == QuicktimeCodec::hap;
    AVFormatContext* out = nullptr;
    ASSERT_GE(avformat_alloc_output_context2(&out, nullptr, "mov", nullptr), 0);
    AVStream* stream = avformat_new_stream(out, nullptr);
    stream->codecpar->codec_type = AVMEDIA_TYPE_VIDEO;
    stream->codecpar->codec_id = is_hap ? AV_CODEC_ID_HAP : AV_CODEC_ID_PNG;
    if (is_hap) stream->codecpar->codec_tag = MKTAG('H', 'a', 'p', '1');
    stream->codecpar->width = pictures.front().width;
    stream->codecpar->height = pictures.front().height;
    const AVRational base = av_make_q(1, static_cast<int>(rate.num));
    stream->time_base = base;
    ASSERT_GE(avio_open(&out->pb, file_url(file).c_str(), AVIO_FLAG_WRITE), 0);
    AVDictionary* options = nullptr;
    av_dict_set_int(&options, "video_track_timescale", rate.num, 0);
    ASSERT_GE(avformat_write_header(out, &options), 0);
    av_dict_free(&options);
    for (std::size_t n = 0; n < pictures.size(); ++n) {
        const Image& picture = pictures[n];
        const int channels = is_hap ? 4 : 3;
        const std::string bytes =
            encoded(is_hap ? "hap" : "png", is_hap ? AV_PIX_FMT_RGBA : AV_PIX_FMT_RGB24, picture.width,
                    picture.height, [&](AVFrame& frame) {
                        for (int y = 0; y < picture.height; ++y)
                            for (int x = 0; x < picture.width; ++x)
                                for (int c = 0; c < channels; ++c)
                                    frame.data[0][std::ptrdiff_t{frame.linesize[0]} * y + channels * x + c] =
                                        c == 3 ? std::uint8_t{255}
                                               : static_cast<std::uint8_t>(picture.view().sample(x, y, c));
                    });
        const PacketPtr packet(av_packet_alloc());
        ASSERT_GE(av_new_packet(packet.get(), static_cast<int>(bytes.size())), 0);
        std::memcpy(packet->data, bytes.data(), bytes.size());
        const int number = static_cast<int>(n);
        packet->pts = packet->dts = time_of ? time_of(number) : number * rate.den;
        packet->duration = rate.den;
        packet->flags |= AV_PKT_FLAG_KEY;
        av_packet_rescale_ts(packet.get(), base, stream->time_base);
        ASSERT_GE(av_write_frame(out, packet.get()), 0);
    }
    ASSERT_GE(av_write_trailer(out), 0);
    avio_closep(&out->pb);
    avformat_free_context(out);
}

}  // namespace touchable::test
