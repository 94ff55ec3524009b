#include "tests/import/foreign_video.hpp"

#include <gtest/gtest.h>

#include <cstring>

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

void join_tracks(const std::vector<std::filesystem::path>& films, const std::filesystem::path& file) {
    AVFormatContext* out = nullptr;
    must_not_fail(avformat_alloc_output_context2(&out, nullptr, "mov", file.c_str()), "container");
    std::vector<AVFormatContext*> inputs(films.size());
    for (std::size_t k = 0; k < films.size(); ++k) {
        ASSERT_GE(avformat_open_input(&inputs[k], file_url(films[k]).c_str(), nullptr, nullptr), 0);
        AVStream* const stream = avformat_new_stream(out, nullptr);
        ASSERT_GE(avcodec_parameters_copy(stream->codecpar, inputs[k]->streams[0]->codecpar), 0);
        stream->codecpar->codec_tag = MKTAG('h', 'v', 'c', '1');
        stream->time_base = inputs[k]->streams[0]->time_base;
    }
    ASSERT_GE(avio_open(&out->pb, file_url(file).c_str(), AVIO_FLAG_WRITE), 0);
    ASSERT_GE(avformat_write_header(out, nullptr), 0);
    const PacketPtr packet(av_packet_alloc());
    for (std::size_t k = 0; k < films.size(); ++k) {
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

}  // namespace touchable::test
