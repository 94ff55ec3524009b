// SPDX-License-Identifier: Apache-2.0
#include "bench/live/plain_decoding.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "bench/clocks.hpp"
#include "engine/clip/containers.hpp"
#include "engine/picture/ffmpeg.hpp"

namespace touchable {
namespace {

struct CloseInput {
    void operator()(AVFormatContext* container) const { avformat_close_input(&container); }
};
using InputFile = std::unique_ptr<AVFormatContext, CloseInput>;

Error cannot_decode(const std::filesystem::path& clip, int status) {
    return {ErrorKind::internal, clip.string() + ": FFmpeg: " + ffmpeg_text(status)};
}

/// A track's packets.
struct TrackPackets {
    const AVStream* stream = nullptr;
    std::vector<PacketPtr> packets;
};

bool is_wanted(const AVStream& stream, const std::vector<PlaneRole>& planes) {
    const AVDictionaryEntry* tag = av_dict_get(stream.metadata, clip_tags::role_tag, nullptr, 0);
    const auto role = role_named(tag ? tag->value : "");
    return role && std::ranges::count(planes, *role) > 0;
}

Result<std::vector<TrackPackets>> read_tracks(AVFormatContext& container, const std::filesystem::path& clip,
                                              const std::vector<PlaneRole>& planes) {
    std::vector<TrackPackets> tracks(container.nb_streams);
    for (unsigned n = 0; n < container.nb_streams; ++n)
        if (is_wanted(*container.streams[n], planes)) tracks[n].stream = container.streams[n];
    for (;;) {
        PacketPtr packet(av_packet_alloc());
        const int status = packet ? av_read_frame(&container, packet.get()) : AVERROR(ENOMEM);
        if (status == AVERROR_EOF) break;
        if (status < 0) return cannot_decode(clip, status);
        TrackPackets& track = tracks[static_cast<std::size_t>(packet->stream_index)];
        if (track.stream) track.packets.push_back(std::move(packet));
    }
    std::erase_if(tracks, [](const TrackPackets& track) { return track.packets.empty(); });
    if (tracks.empty()) return input_error(clip.string() + ": has none of these tracks");
    return tracks;
}

/// Decodes a track with the clips' own decoder, on one thread.
int decode_own_track(const TrackPackets& track) {
    const auto decoder = PacketDecoder::open(*track.stream, "");
    const FramePtr frame(av_frame_alloc());
    if (!decoder || !frame) return AVERROR_INVALIDDATA;
    for (const PacketPtr& packet : track.packets) {
        int status = (*decoder)->send(packet.get());
        if (status >= 0) status = (*decoder)->receive(*frame);
        if (status < 0) return status;
        av_frame_unref(frame.get());
    }
    return 0;
}

/// `threads`: 0: FFmpeg's choice, frame threads if the codec supports them.
int decode_track(const TrackPackets& track, int threads) {
    if (track.stream->codecpar->codec_id == AV_CODEC_ID_NONE) return decode_own_track(track);
    const AVCodec* codec = avcodec_find_decoder(track.stream->codecpar->codec_id);
    const CodecPtr decoder(codec ? avcodec_alloc_context3(codec) : nullptr);
    const FramePtr frame(av_frame_alloc());
    if (!decoder || !frame) return AVERROR(ENOMEM);
    int status = avcodec_parameters_to_context(decoder.get(), track.stream->codecpar);
    decoder->thread_count = threads;
    if (status >= 0) status = avcodec_open2(decoder.get(), codec, nullptr);
    const auto receive_all = [&] {
        do status = avcodec_receive_frame(decoder.get(), frame.get());
        while (status >= 0);
    };
    for (const PacketPtr& packet : track.packets) {
        if (status >= 0) status = avcodec_send_packet(decoder.get(), packet.get());
        if (status < 0) return status;
        receive_all();
        if (status != AVERROR(EAGAIN)) return status;
        status = 0;
    }
    status = avcodec_send_packet(decoder.get(), nullptr);
    if (status >= 0) receive_all();
    return status == AVERROR_EOF ? 0 : status;
}

int decode_tracks(const std::vector<TrackPackets>& tracks, int threads) {
    for (const TrackPackets& track : tracks)
        if (const int status = decode_track(track, threads); status < 0) return status;
    return 0;
}

}  // namespace

Result<PlainDecoding> decode_plainly(const std::filesystem::path& clip, const std::vector<PlaneRole>& planes,
                                     int rounds) {
    silence_ffmpeg();
    AVFormatContext* opened = nullptr;
    int status = avformat_open_input(&opened, file_url(clip).c_str(), nullptr, nullptr);
    if (status < 0) return cannot_decode(clip, status);
    const InputFile container(opened);
    const auto tracks = read_tracks(*container, clip, planes);
    if (!tracks) return tracks.error();
    PlainDecoding least{HUGE_VAL, HUGE_VAL};
    for (int round = 0; round < rounds; ++round) {
        const std::int64_t cpu = thread_cpu_ns();
        if (status = decode_tracks(*tracks, 1); status < 0) return cannot_decode(clip, status);
        const std::int64_t wall = monotonic_ns();
        least.cpu_ms = std::min(least.cpu_ms, static_cast<double>(thread_cpu_ns() - cpu) * 1e-6);
        if (status = decode_tracks(*tracks, 0); status < 0) return cannot_decode(clip, status);
        least.wall_ms = std::min(least.wall_ms, static_cast<double>(monotonic_ns() - wall) * 1e-6);
    }
    return least;
}

}  // namespace touchable
