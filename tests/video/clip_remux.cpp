#include "tests/video/clip_remux.hpp"

#include <gtest/gtest.h>

#include <memory>

#include "engine/picture/ffmpeg.hpp"

namespace touchable::test {
namespace {

void check(int status, const char* what) {
    ASSERT_GE(status, 0) << what << ": " << ffmpeg_text(status);
}

struct InputCloser {
    void operator()(AVFormatContext* container) const { avformat_close_input(&container); }
};
using Input = std::unique_ptr<AVFormatContext, InputCloser>;

Input open_input(const std::filesystem::path& file) {
    AVFormatContext* container = nullptr;
    check(avformat_open_input(&container, file_url(file).c_str(), nullptr, nullptr), "open");
    return Input(container);
}

std::string role_of(const AVStream& stream) {
    const AVDictionaryEntry* tag = av_dict_get(stream.metadata, "T3D_ROLE", nullptr, 0);
    return tag ? tag->value : "";
}

/// Decodes one track and encodes it as 4:2:0.
class Transcoder {
public:
    Transcoder(const AVStream& from, const std::string& codec_name, int scale) {
        decoder_.reset(avcodec_alloc_context3(avcodec_find_decoder(from.codecpar->codec_id)));
        avcodec_parameters_to_context(decoder_.get(), from.codecpar);
        check(avcodec_open2(decoder_.get(), nullptr, nullptr), "open decoder");
        const AVCodec* codec = avcodec_find_encoder_by_name(codec_name.c_str());
        encoder_.reset(avcodec_alloc_context3(codec));
        encoder_->width = scale * from.codecpar->width;
        encoder_->height = scale * from.codecpar->height;
        encoder_->pix_fmt = codec_name == "mjpeg" ? AV_PIX_FMT_YUVJ420P : AV_PIX_FMT_YUV420P;
        encoder_->time_base = {1, 1000};
        encoder_->gop_size = 1;
        encoder_->flags |= AV_CODEC_FLAG_QSCALE | AV_CODEC_FLAG_GLOBAL_HEADER;
        encoder_->global_quality = 2 * FF_QP2LAMBDA;
        check(avcodec_open2(encoder_.get(), codec, nullptr), "open encoder");
    }
    const AVCodecContext& codec() const { return *encoder_; }
    void transcode(AVPacket& packet) {
        FramePtr in(av_frame_alloc()), out(av_frame_alloc());
        check(avcodec_send_packet(decoder_.get(), &packet), "decode");
        check(avcodec_receive_frame(decoder_.get(), in.get()), "decode");
        out->format = encoder_->pix_fmt;
        out->width = encoder_->width;
        out->height = encoder_->height;
        out->pts = packet.pts;
        out->quality = encoder_->global_quality;
        check(av_frame_get_buffer(out.get(), 0), "buffer");
        const ScalerPtr scaler(sws_getContext(in->width, in->height, static_cast<AVPixelFormat>(in->format),
                                              out->width, out->height, encoder_->pix_fmt,
                                              SWS_BILINEAR | SWS_ACCURATE_RND, nullptr, nullptr, nullptr));
        sws_scale(scaler.get(), in->data, in->linesize, 0, in->height, out->data, out->linesize);
        const std::int64_t pts = packet.pts, duration = packet.duration;
        av_packet_unref(&packet);
        check(avcodec_send_frame(encoder_.get(), out.get()), "encode");
        check(avcodec_receive_packet(encoder_.get(), &packet), "encode");
        packet.pts = packet.dts = pts;
        packet.duration = duration;
        packet.flags |= AV_PKT_FLAG_KEY;
    }

private:
    CodecPtr decoder_, encoder_;
};

struct Track {
    std::string role;
    int target = -1;  ///< stream written to; -1: none
    int packets = 0;
    std::unique_ptr<Transcoder> transcoder;
};

Track add_track(const AVStream& from, AVFormatContext& out, const Remux& changes) {
    Track track{role_of(from), -1, 0, nullptr};
    const auto renamed = changes.roles.find(track.role);
    if (renamed != changes.roles.end() && renamed->second.empty()) return track;
    AVStream* to = avformat_new_stream(&out, nullptr);
    avcodec_parameters_copy(to->codecpar, from.codecpar);
    av_dict_copy(&to->metadata, from.metadata, 0);
    to->time_base = from.time_base;
    to->disposition = from.disposition;
    track.target = to->index;
    if (renamed != changes.roles.end()) av_dict_set(&to->metadata, "T3D_ROLE", renamed->second.c_str(), 0);
    const bool attached = from.codecpar->codec_type == AVMEDIA_TYPE_ATTACHMENT;
    if (attached && !changes.attachment_name.empty())
        av_dict_set(&to->metadata, "filename", changes.attachment_name.c_str(), 0);
    if (const auto codec = changes.transcoded.find(track.role); codec != changes.transcoded.end()) {
        track.transcoder = std::make_unique<Transcoder>(from, codec->second, changes.transcoded_scale);
        avcodec_parameters_from_context(to->codecpar, &track.transcoder->codec());
    }
    if (to->codecpar->codec_id != AV_CODEC_ID_NONE) to->codecpar->codec_tag = 0;  // else it is the codec
    return track;
}

}  // namespace

void remux(const std::filesystem::path& from, const std::filesystem::path& to, const Remux& changes) {
    const Input in = open_input(from);
    AVFormatContext* out = nullptr;
    check(avformat_alloc_output_context2(&out, nullptr, "matroska", nullptr), "muxer");
    av_dict_copy(&out->metadata, in->metadata, 0);
    for (const auto& [name, value] : changes.file_tags)
        av_dict_set(&out->metadata, name.c_str(), value.empty() ? nullptr : value.c_str(), 0);
    std::vector<Track> tracks;
    for (unsigned k = 0; k < in->nb_streams; ++k) tracks.push_back(add_track(*in->streams[k], *out, changes));
    check(avio_open(&out->pb, file_url(to).c_str(), AVIO_FLAG_WRITE), "create");
    AVDictionary* options = nullptr;
    av_dict_set_int(&options, "write_crc32", changes.checksums ? 1 : 0, 0);
    check(avformat_write_header(out, &options), "header");
    ASSERT_EQ(av_dict_count(options), 0);
    const PacketPtr packet(av_packet_alloc());
    while (av_read_frame(in.get(), packet.get()) >= 0) {
        Track& track = tracks[static_cast<std::size_t>(packet->stream_index)];
        if (track.target >= 0 && !changes.drop(track.role, track.packets)) {
            if (track.transcoder) track.transcoder->transcode(*packet);
            packet->stream_index = track.target;
            check(av_interleaved_write_frame(out, packet.get()), "write");
        }
        av_packet_unref(packet.get());
        ++track.packets;
    }
    check(av_write_trailer(out), "trailer");
    avio_closep(&out->pb);
    avformat_free_context(out);
}

std::vector<std::string> packets(const std::filesystem::path& clip) {
    const Input in = open_input(clip);
    std::vector<std::string> bytes;
    const PacketPtr packet(av_packet_alloc());
    while (av_read_frame(in.get(), packet.get()) >= 0) {
        bytes.emplace_back(reinterpret_cast<const char*>(packet->data),
                           static_cast<std::size_t>(packet->size));
        av_packet_unref(packet.get());
    }
    return bytes;
}

}  // namespace touchable::test
