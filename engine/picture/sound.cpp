// SPDX-License-Identifier: Apache-2.0
#include "engine/picture/sound.hpp"

extern "C" {
#include <libswresample/swresample.h>
}

#include <algorithm>
#include <cmath>

#include "engine/base/try.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/input.hpp"

namespace touchable {

namespace {

/// Opens a file of a kind that may have sound: Matroska, QuickTime and MP4, WAV. Null for others, and if it
/// is no ordinary file.
InputPtr open_sound_container(const std::filesystem::path& file) {
    auto bytes = bytes_of_file(file);
    if (!bytes) return nullptr;
    const auto end = end_of_container(**bytes, file.string());
    if (!end || !check_box_tables(**bytes, *end)) return nullptr;
    auto container = open_input(std::move(*bytes), *end, file.string(), {.formats = "matroska,mov,wav"});
    return container ? std::move(*container) : nullptr;
}

/// Seconds at which the clip's first frame is shown, time 0 of its sound; 0 if no frame is near the file's
/// begin. Reads on in the file.
double begin_of_pictures(AVFormatContext& container, AVPacket& packet) {
    constexpr int most_packets = 1000;
    const int pictures = av_find_best_stream(&container, AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
    if (pictures < 0) return 0;
    double seconds = 0;
    for (int k = 0; k < most_packets && av_read_frame(&container, &packet) >= 0; ++k) {
        const bool is_first = packet.stream_index == pictures && packet.pts != AV_NOPTS_VALUE;
        if (is_first)
            seconds = static_cast<double>(packet.pts) * av_q2d(container.streams[pictures]->time_base);
        av_packet_unref(&packet);
        if (is_first) break;
    }
    return seconds;
}

void leave_out_all_but(int stream, AVFormatContext& container) {
    for (unsigned k = 0; k < container.nb_streams; ++k)
        if (static_cast<int>(k) != stream) container.streams[k]->discard = AVDISCARD_ALL;
}

/// If times in the file differ by less, samples follow each other without a gap.
constexpr std::int64_t tolerance = SoundTrack::rate / 50;
constexpr int most_faults = 1000;
constexpr double farthest_s = 1e9;  // later times are ignored
constexpr std::int64_t longest_frame = std::int64_t{SoundTrack::rate} * 10;
/// Highest rate in use. The tables of a resampler grow with the rate that a file claims, to gigabytes.
constexpr int highest_rate = 768'000;

struct ResamplerDeleter {
    void operator()(SwrContext* resampler) const { swr_free(&resampler); }
};
using ResamplerPtr = std::unique_ptr<SwrContext, ResamplerDeleter>;

class FfmpegSoundTrack final : public SoundTrack {
public:
    FfmpegSoundTrack(InputPtr container, int stream, CodecPtr decoder, PacketPtr packet, FramePtr frame)
        : container_(std::move(container)),
          stream_(*container_->streams[stream]),
          begin_s_(begin_of_pictures(*container_, *packet)),
          decoder_(std::move(decoder)),
          packet_(std::move(packet)),
          frame_(std::move(frame)) {
        leave_out_all_but(stream, *container_);
        FfmpegSoundTrack::seek(0);
    }

    void seek(std::int64_t sample) override {
        // Codecs whose frames overlap need a little of what comes before.
        constexpr double before_s = 0.1;
        const double seconds = begin_s_ + static_cast<double>(sample) / rate - before_s;
        const auto timestamp = static_cast<std::int64_t>(std::floor(seconds / av_q2d(stream_.time_base)));
        // If the file offers no way there, reading goes on from where it is.
        if (av_seek_frame(container_.get(), stream_.index, timestamp, AVSEEK_FLAG_BACKWARD) < 0)
            (void)av_seek_frame(container_.get(), stream_.index, timestamp, 0);  // before the first
        avcodec_flush_buffers(decoder_.get());
        resampler_.reset();
        decoded_.clear();
        wanted_ = sample;
        next_.reset();
        ended_ = false;
        faults_ = 0;
    }

    void read(std::span<StereoSample> to) override {
        while (!to.empty()) {
            if (decoded_.empty() && !ended_) {
                decode();
                continue;
            }
            const bool is_silent = decoded_.empty() || begin_ > wanted_;
            const std::size_t there = decoded_.empty() ? to.size()
                                      : is_silent      ? static_cast<std::size_t>(begin_ - wanted_)
                                                       : decoded_.size();
            const std::size_t count = std::min(there, to.size());
            if (is_silent) {
                std::fill_n(to.begin(), count, StereoSample{});
            } else {
                std::copy_n(decoded_.begin(), count, to.begin());
                decoded_.erase(decoded_.begin(), decoded_.begin() + static_cast<std::ptrdiff_t>(count));
                begin_ += static_cast<std::int64_t>(count);
            }
            wanted_ += static_cast<std::int64_t>(count);
            to = to.subspan(count);
        }
    }

    bool is_damaged() const override { return is_damaged_; }

private:
    /// Takes one frame out of the decoder, or puts a packet into it.
    void decode() {
        const int status = avcodec_receive_frame(decoder_.get(), frame_.get());
        if (status >= 0) return take();
        if (status != AVERROR(EAGAIN) && status != AVERROR_EOF) note_fault();
        if (status == AVERROR_EOF || (status != AVERROR(EAGAIN) && ++faults_ > most_faults)) {
            ended_ = true;
            return;
        }
        do {
            av_packet_unref(packet_.get());
            if (av_read_frame(container_.get(), packet_.get()) < 0) {
                (void)avcodec_send_packet(decoder_.get(), nullptr);
                return;
            }
        } while (packet_->stream_index != stream_.index);
        // Packets that cannot be decoded are left out; later times make up for them.
        if (avcodec_send_packet(decoder_.get(), packet_.get()) < 0) note_fault();
    }

    /// After a seek a decoder may lack earlier packets, which is no damage.
    void note_fault() { is_damaged_ = is_damaged_ || next_.has_value(); }

    /// Resamples the frame, and drops samples before `wanted_`.
    void take() {
        decoded_ = resampled();
        const auto stated = sample_of(*frame_);
        if (stated && (!next_ || std::abs(*stated - *next_) > tolerance)) next_ = *stated;
        begin_ = next_.value_or(wanted_);
        const auto count = static_cast<std::int64_t>(decoded_.size());
        next_ = begin_ + count;
        const std::int64_t missed = std::clamp<std::int64_t>(wanted_ - begin_, 0, count);
        decoded_.erase(decoded_.begin(), decoded_.begin() + missed);
        begin_ += missed;
    }

    std::optional<std::int64_t> sample_of(const AVFrame& frame) const {
        if (frame.best_effort_timestamp == AV_NOPTS_VALUE) return std::nullopt;
        const double seconds =
            static_cast<double>(frame.best_effort_timestamp) * av_q2d(stream_.time_base) - begin_s_;
        if (!(std::abs(seconds) < farthest_s)) return std::nullopt;
        return std::llround(seconds * rate);
    }

    /// The decoded frame, resampled; empty if its kind is not supported.
    std::vector<StereoSample> resampled() {
        if (!resampler_ || frame_->sample_rate != from_rate_ || frame_->format != from_format_ ||
            frame_->ch_layout.nb_channels != from_channels_)
            resampler_ = resampler_for(*frame_);
        const auto room =
            static_cast<std::int64_t>(frame_->nb_samples) * rate / std::max(frame_->sample_rate, 1);
        if (!resampler_ || room > longest_frame) return {};
        std::vector<StereoSample> samples(static_cast<std::size_t>(room) + 256);
        auto* to = reinterpret_cast<std::uint8_t*>(samples.data());
        const int made =
            swr_convert(resampler_.get(), &to, static_cast<int>(samples.size()),
                        const_cast<const std::uint8_t**>(frame_->extended_data), frame_->nb_samples);
        samples.resize(static_cast<std::size_t>(std::max(made, 0)));
        return samples;
    }

    ResamplerPtr resampler_for(AVFrame& frame) {
        from_rate_ = frame.sample_rate;
        from_format_ = frame.format;
        from_channels_ = frame.ch_layout.nb_channels;
        if (frame.sample_rate > highest_rate) return {};
        AVChannelLayout stereo = AV_CHANNEL_LAYOUT_STEREO;
        SwrContext* made = nullptr;
        const int status =
            swr_alloc_set_opts2(&made, &stereo, AV_SAMPLE_FMT_FLT, rate, &frame.ch_layout,
                                static_cast<AVSampleFormat>(frame.format), frame.sample_rate, 0, nullptr);
        ResamplerPtr resampler(made);
        if (status < 0 || swr_init(made) < 0) resampler.reset();
        return resampler;
    }

    InputPtr container_;
    const AVStream& stream_;
    double begin_s_;
    CodecPtr decoder_;
    PacketPtr packet_;
    FramePtr frame_;
    ResamplerPtr resampler_;
    int from_rate_ = 0, from_format_ = -1, from_channels_ = 0;
    std::int64_t wanted_ = 0;           // sample that is read next
    std::optional<std::int64_t> next_;  // that of the next frame, unless it states another
    std::vector<StereoSample> decoded_;
    std::int64_t begin_ = 0;  // sample that decoded_ begins with
    bool ended_ = false, is_damaged_ = false;
    int faults_ = 0;  // of the decoder since the last seek
};

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
        leave_out_all_but(stream, *container_);
        // In a file without an index earlier packets are skipped.
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
    /// Reads a packet of any stream, into `ahead_` if it is heard in the stretch.
    Result<void> read_one() {
        Packet packet(av_packet_alloc());
        if (!packet) return memory_error();
        const int status = av_read_frame(container_.get(), packet.get());
        ended_ = status == AVERROR_EOF && container_->pb->error >= 0;
        if (ended_) return {};
        if (status < 0)
            return error_at(file_ + ": its sound cannot be read further", input_failure(*container_, status));
        if (packet->stream_index != stream_.index || packet->pts == AV_NOPTS_VALUE) return {};
        const double to_ms = 1000 * av_q2d(stream_.time_base);
        const double at_ms = static_cast<double>(packet->pts) * to_ms - begin_ms_;
        // Rounding may put a packet half a millisecond before the first frame.
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

Result<std::unique_ptr<SoundTrack>> SoundTrack::open(const std::filesystem::path& file) {
    std::unique_ptr<SoundTrack> none;
    InputPtr container = open_sound_container(file);
    if (!container) return none;
    const AVCodec* codec = nullptr;
    const int stream = av_find_best_stream(container.get(), AVMEDIA_TYPE_AUDIO, -1, -1, &codec, 0);
    if (stream == AVERROR_STREAM_NOT_FOUND) return none;
    const auto refused = [&](const std::string& why) {
        return input_error(file.string() + ": its sound cannot be decoded: " + why);
    };
    if (stream < 0) return refused(ffmpeg_text(stream));
    CodecPtr decoder(avcodec_alloc_context3(codec));
    PacketPtr packet(av_packet_alloc());
    FramePtr frame(av_frame_alloc());
    if (!decoder || !packet || !frame) return memory_error();
    int status = avcodec_parameters_to_context(decoder.get(), container->streams[stream]->codecpar);
    if (const int stated = container->streams[stream]->codecpar->sample_rate; stated > highest_rate)
        return refused("it has " + std::to_string(stated) + " samples a second; must be " +
                       std::to_string(highest_rate) + " at most");
    decoder->pkt_timebase = container->streams[stream]->time_base;
    if (status >= 0) status = avcodec_open2(decoder.get(), codec, nullptr);
    if (status < 0) return refused(ffmpeg_text(status));
    return std::make_unique<FfmpegSoundTrack>(std::move(container), stream, std::move(decoder),
                                              std::move(packet), std::move(frame));
}

std::array<std::int16_t, 2> in_16_bits(const StereoSample& sample) {
    const auto whole = [](float value) {
        const float bounded = std::isfinite(value) ? std::clamp(value, -1.0F, 1.0F) : 0;
        return static_cast<std::int16_t>(std::lround(bounded * 32767));
    };
    return {whole(sample.left), whole(sample.right)};
}

void StoredSound::PacketDeleter::operator()(AVPacket* packet) const {
    av_packet_free(&packet);
}

std::optional<StoredSound::Facts> sound_of(const std::filesystem::path& file) {
    const InputPtr container = open_sound_container(file);
    const int stream = container ? sound_stream(*container) : -1;
    if (stream < 0) return std::nullopt;
    const AVCodecParameters& codec = *container->streams[stream]->codecpar;
    const bool in_mp4 = is_storable(codec) && is_storable(codec, "mp4");
    const bool told_by_packets = codec.codec_id == AV_CODEC_ID_AC3 || codec.codec_id == AV_CODEC_ID_EAC3;
    return StoredSound::Facts{avcodec_get_name(codec.codec_id), is_storable(codec), in_mp4,
                              in_mp4 && !told_by_packets};
}

Result<std::unique_ptr<StoredSound>> StoredSound::open(const SoundPart& sound) {
    InputPtr container = open_sound_container(sound.file);
    const int stream = container ? sound_stream(*container) : -1;
    if (stream < 0 || !is_storable(*container->streams[stream]->codecpar))
        return input_error(sound.file.string() + ": has no sound that a clip can hold");
    const PacketPtr packet(av_packet_alloc());
    if (!packet) return memory_error();
    const double begin_s = begin_of_pictures(*container, *packet);
    return std::make_unique<FfmpegStoredSound>(std::move(container), stream, begin_s, sound);
}

}  // namespace touchable
