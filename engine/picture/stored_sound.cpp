#include "engine/picture/stored_sound.hpp"

#include <cmath>
#include <utility>

#include "engine/base/try.hpp"
#include "engine/picture/sound_container.hpp"

namespace touchable {
namespace {

int sound_stream(AVFormatContext& container) {
    return av_find_best_stream(&container, AVMEDIA_TYPE_AUDIO, -1, -1, nullptr, 0);
}

bool is_storable(const AVCodecParameters& codec, const char* container = "matroska") {
    const AVOutputFormat* const format = av_guess_format(container, nullptr, nullptr);
    return format && avformat_query_codec(format, codec.codec_id, FF_COMPLIANCE_NORMAL) == 1;
}

class FfmpegStoredSound final : public StoredSound {
public:
    FfmpegStoredSound(InputPtr container, int stream, double begin_s, const SoundPart& sound)
        : container_(std::move(container)),
          stream_(*container_->streams[stream]),
          file_(sound.file.string()) {
        begin_ms_ = begin_s * 1000 + static_cast<double>(sound.from_ns) * 1e-6;
        length_ms_ = static_cast<double>(sound.to_ns - sound.from_ns) * 1e-6;
        for (unsigned k = 0; k < container_->nb_streams; ++k)
            if (static_cast<int>(k) != stream) container_->streams[k]->discard = AVDISCARD_ALL;
        // What a file without an index holds before is read past.
        const double begin_ticks = begin_ms_ * 0.001 / av_q2d(stream_.time_base);
        if (av_seek_frame(container_.get(), stream, std::llround(begin_ticks), AVSEEK_FLAG_BACKWARD) < 0)
            (void)av_seek_frame(container_.get(), stream, 0, 0);
    }

    const AVCodecParameters& codec() const override { return *stream_.codecpar; }

    Result<Packet> next(std::int64_t until_ms) override {
        while (!ahead_ && !ended_) TRY(read_one());
        if (!ahead_ || ahead_->pts > until_ms) return Packet();
        return std::move(ahead_);
    }

private:
    /// One packet of any stream: into `ahead_` if it is heard in the stretch.
    Result<void> read_one() {
        Packet packet(av_packet_alloc());
        if (!packet) return Error{ErrorKind::internal, "out of memory"};
        const int status = av_read_frame(container_.get(), packet.get());
        ended_ = status == AVERROR_EOF && container_->pb->error >= 0;
        if (ended_) return {};
        if (status < 0)
            return error_at(file_ + ": its sound cannot be read further", input_failure(*container_, status));
        if (packet->stream_index != stream_.index || packet->pts == AV_NOPTS_VALUE) return {};
        const double to_ms = 1000 * av_q2d(stream_.time_base);
        const double at_ms = static_cast<double>(packet->pts) * to_ms - begin_ms_;
        // Rounded, what begins with the first frame may be half a millisecond early.
        if (at_ms < -0.5) return {};
        ended_ = at_ms >= length_ms_;
        if (ended_) return {};
        packet->pts = packet->dts = std::llround(std::max(at_ms, 0.0));
        packet->duration = std::llround(static_cast<double>(packet->duration) * to_ms);
        ahead_ = std::move(packet);
        return {};
    }

    InputPtr container_;
    const AVStream& stream_;
    std::string file_;
    double begin_ms_ = 0, length_ms_ = 0;
    Packet ahead_;
    bool ended_ = false;
};

}  // namespace

void StoredSound::PacketDeleter::operator()(AVPacket* packet) const {
    av_packet_free(&packet);
}

std::optional<SoundFacts> sound_of(const std::filesystem::path& file) {
    const InputPtr container = open_sound_container(file);
    const int stream = container ? sound_stream(*container) : -1;
    if (stream < 0) return std::nullopt;
    const AVCodecParameters& codec = *container->streams[stream]->codecpar;
    const bool in_mp4 = is_storable(codec) && is_storable(codec, "mp4");
    const bool told_by_packets = codec.codec_id == AV_CODEC_ID_AC3 || codec.codec_id == AV_CODEC_ID_EAC3;
    return SoundFacts{avcodec_get_name(codec.codec_id), is_storable(codec), in_mp4,
                      in_mp4 && !told_by_packets};
}

Result<std::unique_ptr<StoredSound>> StoredSound::open(const SoundPart& sound) {
    InputPtr container = open_sound_container(sound.file);
    const int stream = container ? sound_stream(*container) : -1;
    if (stream < 0 || !is_storable(*container->streams[stream]->codecpar))
        return input_error(sound.file.string() + ": has no sound that a clip can hold");
    const PacketPtr packet(av_packet_alloc());
    if (!packet) return Error{ErrorKind::internal, "out of memory"};
    const double begin_s = begin_of_pictures(*container, *packet);
    return std::unique_ptr<StoredSound>(
        std::make_unique<FfmpegStoredSound>(std::move(container), stream, begin_s, sound));
}

}  // namespace touchable
