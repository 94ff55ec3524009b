#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

#include "engine/clip/clip_file.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "tests/video/sounding_clip.hpp"

namespace touchable::test {
namespace {

// Matroska's times are whole milliseconds, and so are these packets.
constexpr int packets_per_second = 50;

struct SoundInputCloser {
    void operator()(AVFormatContext* container) const { avformat_close_input(&container); }
};
using SoundInput = std::unique_ptr<AVFormatContext, SoundInputCloser>;

void expect_done(int status) {
    EXPECT_GE(status, 0) << ffmpeg_text(status);
}

AVStream* add_sound_stream(AVFormatContext& out, int rate) {
    AVStream* stream = avformat_new_stream(&out, nullptr);
    AVCodecParameters& codec = *stream->codecpar;
    codec.codec_type = AVMEDIA_TYPE_AUDIO;
    codec.codec_id = AV_CODEC_ID_PCM_F32LE;
    codec.format = AV_SAMPLE_FMT_FLT;
    codec.sample_rate = rate;
    codec.bits_per_coded_sample = 32;
    codec.block_align = sizeof(StereoSample);
    av_channel_layout_default(&codec.ch_layout, 2);
    stream->time_base = {1, rate};
    return stream;
}

SoundInput copy_streams(const std::filesystem::path& file, AVFormatContext& out) {
    AVFormatContext* opened = nullptr;
    expect_done(avformat_open_input(&opened, file_url(file).c_str(), nullptr, nullptr));
    SoundInput in(opened);
    av_dict_copy(&out.metadata, in->metadata, 0);
    for (unsigned k = 0; k < in->nb_streams; ++k) {
        AVStream* to = avformat_new_stream(&out, nullptr);
        avcodec_parameters_copy(to->codecpar, in->streams[k]->codecpar);
        av_dict_copy(&to->metadata, in->streams[k]->metadata, 0);
        to->time_base = in->streams[k]->time_base;
        to->disposition = in->streams[k]->disposition;
        if (to->codecpar->codec_id != AV_CODEC_ID_NONE) to->codecpar->codec_tag = 0;
    }
    return in;
}

void write_sound(AVFormatContext& out, const AVStream& stream, const std::vector<StereoSample>& sound,
                 int rate, int later_ms) {
    const auto most = static_cast<std::size_t>(rate / packets_per_second);
    for (std::size_t at = 0; at < sound.size(); at += most) {
        const std::size_t count = std::min(most, sound.size() - at);
        AVPacket* packet = av_packet_alloc();
        expect_done(av_new_packet(packet, static_cast<int>(count * sizeof(StereoSample))));
        std::memcpy(packet->data, &sound[at], count * sizeof(StereoSample));
        packet->stream_index = stream.index;
        packet->pts = packet->dts =
            av_rescale_q(static_cast<std::int64_t>(at) + std::int64_t{rate} * later_ms / 1000, {1, rate},
                         stream.time_base);
        packet->duration = av_rescale_q(static_cast<std::int64_t>(count), {1, rate}, stream.time_base);
        packet->flags |= AV_PKT_FLAG_KEY;
        expect_done(av_interleaved_write_frame(&out, packet));
        av_packet_free(&packet);
    }
}

}  // namespace

void write_sounding_clip(const std::filesystem::path& file, const std::vector<StereoSample>& sound,
                         const std::filesystem::path& pictures, int rate, int sound_later_ms,
                         int pictures_later_ms) {
    AVFormatContext* out = nullptr;
    expect_done(avformat_alloc_output_context2(&out, nullptr, "matroska", nullptr));
    SoundInput in;
    if (!pictures.empty()) in = copy_streams(pictures, *out);
    AVStream* stream = add_sound_stream(*out, rate);
    expect_done(avio_open(&out->pb, file_url(file).c_str(), AVIO_FLAG_WRITE));
    AVDictionary* options = nullptr;
    av_dict_set_int(&options, "write_crc32", 1, 0);
    expect_done(avformat_write_header(out, &options));
    av_dict_free(&options);
    write_sound(*out, *stream, sound, rate, sound_later_ms);
    AVPacket* packet = av_packet_alloc();
    while (in && av_read_frame(in.get(), packet) >= 0) {
        packet->pts += pictures_later_ms;
        packet->dts = packet->pts;
        expect_done(av_interleaved_write_frame(out, packet));
    }
    av_packet_free(&packet);
    expect_done(av_write_trailer(out));
    avio_closep(&out->pb);
    avformat_free_context(out);
}

std::vector<StereoSample> tone(double hertz, double seconds, int rate) {
    std::vector<StereoSample> sound(static_cast<std::size_t>(seconds * rate));
    for (std::size_t k = 0; k < sound.size(); ++k) {
        const double value = 0.5 * std::sin(2 * 3.14159265358979 * hertz * static_cast<double>(k) / rate);
        sound[k] = {static_cast<float>(value), static_cast<float>(0.5 * value)};
    }
    return sound;
}

void write_sounding_film(const std::filesystem::path& file, const std::vector<StereoSample>& sound) {
    auto film = FilmWriter::create(file, Existing::keep);
    ASSERT_TRUE(film) << film.error().message;
    const std::vector<std::uint8_t> grey(3 * 64 * 48, 99);
    EXPECT_TRUE((*film)->add({grey.data(), 3 * 64, 64, 48, 1, 3}, 0));
    EXPECT_TRUE((*film)->add_sound(0, sound));
    EXPECT_TRUE((*film)->finish(std::ssize(sound) * 30 / SoundTrack::rate));
}

std::vector<StereoSample> heard_in(SoundTrack& track, std::int64_t from, std::size_t count) {
    std::vector<StereoSample> samples(count);
    track.seek(from);
    track.read(samples);
    return samples;
}

double largest_difference(std::span<const StereoSample> heard, std::span<const StereoSample> wanted,
                          std::size_t without_first, std::size_t without_last) {
    EXPECT_GE(wanted.size(), heard.size());
    double largest = 0;
    for (std::size_t k = without_first; k + without_last < heard.size(); ++k)
        largest = std::max<double>(largest, std::abs(heard[k].left - wanted[k].left));
    return largest;
}

}  // namespace touchable::test
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
