// SPDX-License-Identifier: Apache-2.0
#include "tests/import/foreign_video.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <iterator>

#include "tests/picture/results.hpp"

namespace touchable::test {
namespace {

void must_not_fail(int status, const char* what) {
    ASSERT_GE(status, 0) << what << ": " << ffmpeg_text(status);
}

CodecPtr open_encoder(const ForeignVideo& video, bool global_header) {
    const AVCodec* codec = avcodec_find_encoder_by_name(video.codec);
    CodecPtr encoder(avcodec_alloc_context3(codec));
    encoder->width = video.width;
    encoder->height = video.height;
    encoder->pix_fmt = video.format;
    encoder->color_range = video.range;
    encoder->time_base = av_inv_q(video.rate);
    encoder->framerate = video.rate;
    encoder->gop_size = video.interval;
    encoder->max_b_frames = 0;
    encoder->strict_std_compliance = FF_COMPLIANCE_EXPERIMENTAL;
    encoder->flags |= AV_CODEC_FLAG_QSCALE | (global_header ? AV_CODEC_FLAG_GLOBAL_HEADER : 0);
    encoder->global_quality = 2 * FF_QP2LAMBDA;
    AVDictionary* options = nullptr;
    if (std::string(video.codec).starts_with("libx264"))
        av_dict_set(&options, "qp", video.lossless ? "0" : "1", 0);
    if (std::string(video.codec) == "libx265")
        av_dict_set(&options, "x265-params", video.lossless ? "lossless=1:log-level=none" : "log-level=none",
                    0);
    if (std::string(video.codec) == "libvpx-vp9") {
        av_dict_set(&options, "lossless", "1", 0);
        av_dict_set(&options, "cpu-used", "8", 0);
    }
    must_not_fail(avcodec_open2(encoder.get(), codec, &options), video.codec);
    av_dict_free(&options);
    return encoder;
}

void write_packets(AVFormatContext& out, AVCodecContext& encoder) {
    const PacketPtr packet(av_packet_alloc());
    while (avcodec_receive_packet(&encoder, packet.get()) >= 0) {
        if (packet->duration == 0) packet->duration = 1;
        av_packet_rescale_ts(packet.get(), encoder.time_base, out.streams[0]->time_base);
        must_not_fail(av_interleaved_write_frame(&out, packet.get()), "write");
    }
}

}  // namespace

void write_video(const std::filesystem::path& file, const ForeignVideo& video,
                 const std::function<void(AVFrame& frame, int number)>& fill) {
    silence_ffmpeg();
    AVFormatContext* out = nullptr;
    must_not_fail(avformat_alloc_output_context2(&out, nullptr, nullptr, file.c_str()), "container");
    const CodecPtr encoder = open_encoder(video, (out->oformat->flags & AVFMT_GLOBALHEADER) != 0);
    AVStream* stream = avformat_new_stream(out, nullptr);
    stream->time_base = encoder->time_base;
    stream->avg_frame_rate = video.time_of ? AVRational{0, 1} : video.rate;
    must_not_fail(avcodec_parameters_from_context(stream->codecpar, encoder.get()), "parameters");
    stream->codecpar->codec_tag = video.tag;
    must_not_fail(avio_open(&out->pb, file_url(file).c_str(), AVIO_FLAG_WRITE), "create");
    must_not_fail(avformat_write_header(out, nullptr), "header");
    for (int n = 0; n < video.frames; ++n) {
        const FramePtr frame(av_frame_alloc());
        frame->width = video.width;
        frame->height = video.height;
        frame->format = video.format;
        frame->color_range = video.range;
        frame->quality = encoder->global_quality;
        must_not_fail(av_frame_get_buffer(frame.get(), 0), "memory");
        fill(*frame, n);
        frame->pts = video.time_of ? video.time_of(n) : n;
        must_not_fail(avcodec_send_frame(encoder.get(), frame.get()), "encode");
        write_packets(*out, *encoder);
    }
    must_not_fail(avcodec_send_frame(encoder.get(), nullptr), "encode");
    write_packets(*out, *encoder);
    must_not_fail(av_write_trailer(out), "trailer");
    avio_closep(&out->pb);
    avformat_free_context(out);
}

void set_sample(AVFrame& frame, int plane, int x, int y, int value) {
    const AVPixFmtDescriptor& format = *av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
    std::uint8_t* row = frame.data[plane] + std::ptrdiff_t{frame.linesize[plane]} * y;
    const auto word = static_cast<std::uint16_t>(value);
    if (format.comp[0].depth > 8)
        std::memcpy(row + 2 * std::ptrdiff_t{x}, &word, 2);
    else
        row[x] = static_cast<std::uint8_t>(value);
}

void fill_plane(AVFrame& frame, int plane, const std::function<int(int x, int y)>& sample) {
    const AVPixFmtDescriptor& format = *av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
    const int width = plane == 0 ? frame.width : AV_CEIL_RSHIFT(frame.width, format.log2_chroma_w),
              height = plane == 0 ? frame.height : AV_CEIL_RSHIFT(frame.height, format.log2_chroma_h);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) set_sample(frame, plane, x, y, sample(x, y));
}

void fill_rgb(AVFrame& frame, const std::function<std::array<int, 3>(int x, int y)>& pixel) {
    for (int y = 0; y < frame.height; ++y)
        for (int x = 0; x < frame.width; ++x) {
            std::uint8_t* to = frame.data[0] + std::ptrdiff_t{frame.linesize[0]} * y + 3 * std::ptrdiff_t{x};
            for (const int sample : pixel(x, y)) *to++ = static_cast<std::uint8_t>(sample);
        }
}

void join_tracks(const std::vector<TitledFile>& sources, const std::filesystem::path& file,
                 std::uint32_t tag) {
    AVFormatContext* out = nullptr;
    must_not_fail(avformat_alloc_output_context2(&out, nullptr, nullptr, file.c_str()), "container");
    std::vector<AVFormatContext*> inputs;
    for (const auto& [path, title] : sources) {
        AVFormatContext* in = nullptr;
        ASSERT_GE(avformat_open_input(&in, file_url(path).c_str(), nullptr, nullptr), 0);
        inputs.push_back(in);
        AVStream* const stream = avformat_new_stream(out, nullptr);
        ASSERT_GE(avcodec_parameters_copy(stream->codecpar, in->streams[0]->codecpar), 0);
        stream->codecpar->codec_tag = tag;
        stream->time_base = in->streams[0]->time_base;
        stream->avg_frame_rate = in->streams[0]->avg_frame_rate;
        if (!title.empty()) av_dict_set(&stream->metadata, "title", title.c_str(), 0);
    }
    ASSERT_GE(avio_open(&out->pb, file_url(file).c_str(), AVIO_FLAG_WRITE), 0);
    ASSERT_GE(avformat_write_header(out, nullptr), 0);
    const PacketPtr packet(av_packet_alloc());
    for (std::size_t k = 0; k < inputs.size(); ++k) {
        while (av_read_frame(inputs[k], packet.get()) >= 0) {
            av_packet_rescale_ts(packet.get(), inputs[k]->streams[0]->time_base, out->streams[k]->time_base);
            packet->stream_index = static_cast<int>(k);
            ASSERT_GE(av_interleaved_write_frame(out, packet.get()), 0);
        }
        avformat_close_input(&inputs[k]);
    }
    ASSERT_GE(av_write_trailer(out), 0);
    avio_closep(&out->pb);
    avformat_free_context(out);
}

void join_cinematic(const std::filesystem::path& colour, const std::filesystem::path& disparity,
                    const std::filesystem::path& file) {
    join_tracks({{colour, ""}, {disparity, ""}}, file, MKTAG('h', 'v', 'c', '1'));
    std::ifstream in(file, std::ios::binary);
    std::string bytes{std::istreambuf_iterator<char>(in), {}};
    const auto entry = bytes.rfind("hvc1"), handler = bytes.rfind("mhlrvide");
    ASSERT_NE(entry, std::string::npos);
    ASSERT_NE(handler, std::string::npos);
    bytes.replace(entry, 4, "dish");
    bytes.replace(handler, 8, "mhlrauxv");
    std::filesystem::remove(file);
    std::ofstream(file, std::ios::binary) << bytes;
}

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
