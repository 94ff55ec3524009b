#include "engine/picture/sound_track.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/sound_container.hpp"

extern "C" {
#include <libswresample/swresample.h>
}

namespace touchable {
namespace {

/// Where times in the file say otherwise by less, samples follow each other without a gap.
constexpr std::int64_t tolerance = SoundTrack::rate / 50;
constexpr int most_faults = 1000;
constexpr double farthest_s = 1e9;  // a time beyond is none
constexpr std::int64_t longest_frame = std::int64_t{SoundTrack::rate} * 10;
/// Of what is recorded anywhere. The tables of a resampler grow with the rate that a file claims, to
/// gigabytes.
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
        for (unsigned k = 0; k < container_->nb_streams; ++k)
            if (static_cast<int>(k) != stream) container_->streams[k]->discard = AVDISCARD_ALL;
        FfmpegSoundTrack::seek(0);
    }

    void seek(std::int64_t sample) override {
        // Codecs whose frames overlap need a little of what comes before.
        constexpr double before_s = 0.1;
        const double seconds = begin_s_ + static_cast<double>(sample) / rate - before_s;
        const auto timestamp = static_cast<std::int64_t>(std::floor(seconds / av_q2d(stream_.time_base)));
        // A file without a way there is read on from where it is.
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
        // What cannot be decoded is left out; the times of what follows make up for it.
        if (avcodec_send_packet(decoder_.get(), packet_.get()) < 0) note_fault();
    }

    /// After a jump a decoder may lack what came before, which is no damage.
    void note_fault() { is_damaged_ = is_damaged_ || next_.has_value(); }

    /// Resamples the frame, and leaves out what nobody waits for any more.
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

    /// Of the decoded frame; nothing where it is of a kind that cannot be.
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
    std::int64_t wanted_ = 0;           // that is read next
    std::optional<std::int64_t> next_;  // that the next frame begins with, unless it says otherwise
    std::vector<StereoSample> decoded_;
    std::int64_t begin_ = 0;  // that they begin with
    bool ended_ = false, is_damaged_ = false;
    int faults_ = 0;  // of the decoder since the last seek
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
    if (!decoder || !packet || !frame) return Error{ErrorKind::internal, "out of memory"};
    int status = avcodec_parameters_to_context(decoder.get(), container->streams[stream]->codecpar);
    if (const int stated = container->streams[stream]->codecpar->sample_rate; stated > highest_rate)
        return refused("it has " + std::to_string(stated) + " samples a second; must be " +
                       std::to_string(highest_rate) + " at most");
    decoder->pkt_timebase = container->streams[stream]->time_base;
    if (status >= 0) status = avcodec_open2(decoder.get(), codec, nullptr);
    if (status < 0) return refused(ffmpeg_text(status));
    return std::unique_ptr<SoundTrack>(std::make_unique<FfmpegSoundTrack>(
        std::move(container), stream, std::move(decoder), std::move(packet), std::move(frame)));
}

}  // namespace touchable
