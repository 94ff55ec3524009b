#include "engine/stream/hls_rendition_output.hpp"

#include <algorithm>
#include <utility>

#include "engine/base/try.hpp"

namespace touchable {
namespace {

constexpr AVRational hls_tick{1, 90'000}, hls_ms{1, 1000};

std::int64_t tick_at(std::int64_t ns) {
    return av_rescale(ns, hls_tick.den, 1'000'000'000);
}

RawFrame planes_of(const HlsRenditionForm& form, const RawFrame& frame) {
    RawFrame planes = frame;
    if (form.is_colour)
        planes.depth = planes.haptic = planes.height = {};
    else
        planes.colour = {};
    return planes;
}

}  // namespace

Result<HlsRenditionOutput> HlsRenditionOutput::open(const HlsRenditionForm& form, const RawFrame& first,
                                                    const SceneDescription& described,
                                                    const AVCodecParameters* sound) {
    TRY_ASSIGN(auto encoder,
               LabelledEncoder::open(planes_of(form, first), described, TrackCoding::h264_thrifty,
                                     form.is_low ? TrackCoding::h264_reduced : TrackCoding::h264_visual));
    TRY_ASSIGN(auto muxer, MemoryMuxer::open("mp4"));
    HlsRenditionOutput output(form, std::move(encoder), std::move(muxer));
    TRY(output.begin(sound));
    return output;
}

Result<void> HlsRenditionOutput::begin(const AVCodecParameters* sound) {
    AVFormatContext& context = muxer_->context();
    for (std::size_t k = 0; k < encoder_.tracks(); ++k) {
        AVStream* const stream = avformat_new_stream(&context, nullptr);
        if (!stream) return Error{ErrorKind::internal, "out of memory"};
        if (auto described = encoder_.describe(k, *stream->codecpar); !described) return described;
        stream->time_base = hls_tick;
        stream->id = static_cast<int>(k) + 1;
        av_dict_set(&stream->metadata, "handler_name", encoder_.name(k).c_str(), 0);
    }
    if (sound)
        if (auto begun = begin_sound(*sound); !begun) return begun;
    // A picture of each track by turns: whoever reads on needs no more memory than that.
    return muxer_->begin("movflags=+frag_custom+empty_moov+default_base_moof+cmaf:frag_interleave=1");
}

Result<void> HlsRenditionOutput::begin_sound(const AVCodecParameters& sound) {
    AVFormatContext& context = muxer_->context();
    sound_stream_ = static_cast<int>(context.nb_streams);
    AVStream* const stream = avformat_new_stream(&context, nullptr);
    if (!stream || avcodec_parameters_copy(stream->codecpar, &sound) < 0)
        return Error{ErrorKind::internal, "out of memory"};
    stream->codecpar->codec_tag = 0;  // the other container's
    stream->time_base = {1, std::max(1, stream->codecpar->sample_rate)};
    return {};
}

Result<void> HlsRenditionOutput::add(const RawFrame& frame, const PictureLabel& label, std::int64_t time_ns,
                                     std::int64_t duration_ns, bool is_key) {
    TRY_ASSIGN(auto packets, encoder_.encode(planes_of(form_, frame), label, is_key));
    for (std::size_t k = 0; k < packets.size(); ++k) {
        AVPacket& packet = *packets[k];
        packet.pts = packet.dts = tick_at(time_ns);
        packet.duration = tick_at(time_ns + duration_ns) - tick_at(time_ns);
        if (auto written = muxer_->write(packet, static_cast<int>(k), hls_tick); !written) return written;
    }
    return {};
}

Result<void> HlsRenditionOutput::add_sound(const AVPacket& packet) {
    const PacketPtr own(av_packet_clone(&packet));
    if (!own) return Error{ErrorKind::internal, "out of memory"};
    return muxer_->write(*own, *sound_stream_, hls_ms);
}

Result<std::vector<std::uint8_t>> HlsRenditionOutput::take() {
    TRY(muxer_->flush());
    return muxer_->take();
}

Result<std::string> HlsRenditionOutput::codecs() const {
    std::string codecs;
    for (unsigned k = 0; k < muxer_->context().nb_streams; ++k) {
        const AVCodecParameters& stored = *muxer_->context().streams[k]->codecpar;
        const auto name =
            stored.codec_id == AV_CODEC_ID_H264
                ? avc_codec_name({stored.extradata, static_cast<std::size_t>(stored.extradata_size)})
                : std::optional<std::string>("mp4a.40.2");
        if (!name) return Error{ErrorKind::internal, "encoder: H.264 without its parameters"};
        if (codecs.find(*name) == std::string::npos) codecs += (codecs.empty() ? "" : ",") + *name;
    }
    return codecs;
}

}  // namespace touchable
