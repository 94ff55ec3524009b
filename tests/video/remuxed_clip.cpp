// SPDX-License-Identifier: Apache-2.0
#include "tests/video/remuxed_clip.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

#include "engine/clip/clip_file.hpp"
#include "engine/picture/ffmpeg.hpp"

namespace touchable::test {
namespace {

void expect_done(int status, const char* what = "sound") {
    ASSERT_GE(status, 0) << what << ": " << ffmpeg_text(status);
}

struct DemuxerCloser {
    void operator()(AVFormatContext* container) const { avformat_close_input(&container); }
};
using Demuxed = std::unique_ptr<AVFormatContext, DemuxerCloser>;

Demuxed demuxed_clip(const std::filesystem::path& file) {
    AVFormatContext* container = nullptr;
    expect_done(avformat_open_input(&container, file_url(file).c_str(), nullptr, nullptr), "open");
    return Demuxed(container);
}

AVStream* add_copy(const AVStream& from, AVFormatContext& out) {
    AVStream* const to = avformat_new_stream(&out, nullptr);
    avcodec_parameters_copy(to->codecpar, from.codecpar);
    av_dict_copy(&to->metadata, from.metadata, 0);
    to->time_base = from.time_base;
    to->disposition = from.disposition;
    if (to->codecpar->codec_id != AV_CODEC_ID_NONE) to->codecpar->codec_tag = 0;  // else it is the codec
    return to;
}

std::string role_of(const AVStream& stream) {
    const AVDictionaryEntry* tag = av_dict_get(stream.metadata, "T3D_ROLE", nullptr, 0);
    return tag ? tag->value : "";
}

/// Decodes one track and encodes it as 4:2:0.
class Transcoder {
public:
    Transcoder(const AVStream& from, const std::string& codec_name) {
        decoder_.reset(avcodec_alloc_context3(avcodec_find_decoder(from.codecpar->codec_id)));
        avcodec_parameters_to_context(decoder_.get(), from.codecpar);
        expect_done(avcodec_open2(decoder_.get(), nullptr, nullptr), "open decoder");
        const AVCodec* codec = avcodec_find_encoder_by_name(codec_name.c_str());
        encoder_.reset(avcodec_alloc_context3(codec));
        encoder_->width = from.codecpar->width;
        encoder_->height = from.codecpar->height;
        encoder_->pix_fmt = codec_name == "mjpeg" ? AV_PIX_FMT_YUVJ420P : AV_PIX_FMT_YUV420P;
        encoder_->time_base = {1, 1000};
        encoder_->gop_size = 1;
        encoder_->flags |= AV_CODEC_FLAG_QSCALE | AV_CODEC_FLAG_GLOBAL_HEADER;
        encoder_->global_quality = 2 * FF_QP2LAMBDA;
        expect_done(avcodec_open2(encoder_.get(), codec, nullptr), "open encoder");
    }
    const AVCodecContext& codec() const { return *encoder_; }
    void transcode(AVPacket& packet) {
        FramePtr in(av_frame_alloc()), out(av_frame_alloc());
        expect_done(avcodec_send_packet(decoder_.get(), &packet), "decode");
        expect_done(avcodec_receive_frame(decoder_.get(), in.get()), "decode");
        out->format = encoder_->pix_fmt;
        out->width = encoder_->width;
        out->height = encoder_->height;
        out->pts = packet.pts;
        out->quality = encoder_->global_quality;
        expect_done(av_frame_get_buffer(out.get(), 0), "buffer");
        const ScalerPtr scaler(sws_getContext(in->width, in->height, static_cast<AVPixelFormat>(in->format),
                                              out->width, out->height, encoder_->pix_fmt,
                                              SWS_BILINEAR | SWS_ACCURATE_RND, nullptr, nullptr, nullptr));
        sws_scale(scaler.get(), in->data, in->linesize, 0, in->height, out->data, out->linesize);
        const std::int64_t pts = packet.pts, duration = packet.duration;
        av_packet_unref(&packet);
        expect_done(avcodec_send_frame(encoder_.get(), out.get()), "encode");
        expect_done(avcodec_receive_packet(encoder_.get(), &packet), "encode");
        packet.pts = packet.dts = pts;
        packet.duration = duration;
        packet.flags |= AV_PKT_FLAG_KEY;
    }

private:
    CodecPtr decoder_, encoder_;
};

struct RemuxedTrack {
    std::string role;
    int target = -1;  ///< stream written to; -1: none
    int packets = 0;
    std::unique_ptr<Transcoder> transcoder;
};

RemuxedTrack add_track(const AVStream& from, AVFormatContext& out, const Remux& changes) {
    RemuxedTrack track{role_of(from), -1, 0, nullptr};
    const auto renamed = changes.roles.find(track.role);
    if (renamed != changes.roles.end() && renamed->second.empty()) return track;
    AVStream* const to = add_copy(from, out);
    track.target = to->index;
    if (renamed != changes.roles.end()) av_dict_set(&to->metadata, "T3D_ROLE", renamed->second.c_str(), 0);
    const bool attached = from.codecpar->codec_type == AVMEDIA_TYPE_ATTACHMENT;
    if (attached && !changes.attachment_name.empty())
        av_dict_set(&to->metadata, "filename", changes.attachment_name.c_str(), 0);
    if (const auto codec = changes.transcoded.find(track.role); codec != changes.transcoded.end()) {
        track.transcoder = std::make_unique<Transcoder>(from, codec->second);
        avcodec_parameters_from_context(to->codecpar, &track.transcoder->codec());
        to->codecpar->codec_tag = 0;
    }
    return track;
}

// Matroska's times are whole milliseconds, and so are these packets.
constexpr int packets_per_second = 50;

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

Demuxed copy_streams(const std::filesystem::path& file, AVFormatContext& out) {
    Demuxed in = demuxed_clip(file);
    av_dict_copy(&out.metadata, in->metadata, 0);
    for (unsigned k = 0; k < in->nb_streams; ++k) add_copy(*in->streams[k], out);
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

SeenPicture seen_in(const AVFrame& frame, const AVRational& unit) {
    SeenPicture picture{static_cast<double>(frame.pts) * av_q2d(unit), frame.width, frame.height, {}};
    for (int y = 0; y < frame.height; ++y)
        for (int x = 0; x < frame.width; ++x)
            picture.luma.push_back(frame.data[0][std::ptrdiff_t{frame.linesize[0]} * y + x]);
    return picture;
}

}  // namespace

void remux(const std::filesystem::path& from, const std::filesystem::path& to, const Remux& changes) {
    const Demuxed in = demuxed_clip(from);
    AVFormatContext* out = nullptr;
    expect_done(avformat_alloc_output_context2(&out, nullptr, "matroska", nullptr), "muxer");
    av_dict_copy(&out->metadata, in->metadata, 0);
    for (const auto& [name, value] : changes.file_tags)
        av_dict_set(&out->metadata, name.c_str(), value.empty() ? nullptr : value.c_str(), 0);
    std::vector<RemuxedTrack> tracks;
    for (unsigned k = 0; k < in->nb_streams; ++k) tracks.push_back(add_track(*in->streams[k], *out, changes));
    expect_done(avio_open(&out->pb, file_url(to).c_str(), AVIO_FLAG_WRITE), "create");
    AVDictionary* options = nullptr;
    av_dict_set_int(&options, "write_crc32", changes.checksums ? 1 : 0, 0);
    expect_done(avformat_write_header(out, &options), "header");
    ASSERT_EQ(av_dict_count(options), 0);
    const PacketPtr packet(av_packet_alloc());
    while (av_read_frame(in.get(), packet.get()) >= 0) {
        RemuxedTrack& track = tracks[static_cast<std::size_t>(packet->stream_index)];
        if (track.target >= 0 && !changes.drop(track.role, track.packets)) {
            if (track.transcoder) track.transcoder->transcode(*packet);
            packet->stream_index = track.target;
            expect_done(av_interleaved_write_frame(out, packet.get()), "write");
        }
        av_packet_unref(packet.get());
        ++track.packets;
    }
    expect_done(av_write_trailer(out), "trailer");
    avio_closep(&out->pb);
    avformat_free_context(out);
}

std::vector<std::string> packets(const std::filesystem::path& clip) {
    const Demuxed in = demuxed_clip(clip);
    std::vector<std::string> bytes;
    const PacketPtr packet(av_packet_alloc());
    while (av_read_frame(in.get(), packet.get()) >= 0) {
        bytes.emplace_back(reinterpret_cast<const char*>(packet->data),
                           static_cast<std::size_t>(packet->size));
        av_packet_unref(packet.get());
    }
    return bytes;
}

void write_sounding_clip(const std::filesystem::path& file, const std::vector<StereoSample>& sound,
                         const std::filesystem::path& pictures, int rate, int sound_later_ms,
                         int pictures_later_ms) {
    AVFormatContext* out = nullptr;
    expect_done(avformat_alloc_output_context2(&out, nullptr, "matroska", nullptr));
    Demuxed in;
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

std::vector<SeenPicture> seen_in_film(const std::filesystem::path& file) {
    std::vector<SeenPicture> pictures;
    AVFormatContext* opened = nullptr;
    if (avformat_open_input(&opened, file.c_str(), nullptr, nullptr) < 0) return pictures;
    const Demuxed demuxer(opened);
    const AVCodec* codec = nullptr;
    CodecPtr decoder;
    if (avformat_find_stream_info(demuxer.get(), nullptr) >= 0 &&
        av_find_best_stream(demuxer.get(), AVMEDIA_TYPE_VIDEO, -1, -1, &codec, 0) == 0) {
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
    for (; decoder && av_read_frame(demuxer.get(), packet.get()) >= 0; av_packet_unref(packet.get())) {
        if (packet->stream_index == 0) avcodec_send_packet(decoder.get(), packet.get());
        take();
    }
    if (decoder) {
        avcodec_send_packet(decoder.get(), nullptr);
        take();
    }
    return pictures;
}

}  // namespace touchable::test
