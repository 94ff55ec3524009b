#include "engine/clip/film_sound.hpp"

#include <algorithm>
#include <cmath>

namespace touchable {
namespace {

constexpr std::int64_t film_sound_bits_per_second = 160'000;  // of AAC

std::int16_t as_16_bits(float value) {
    return static_cast<std::int16_t>(std::lround(std::clamp(value, -1.0F, 1.0F) * 32767));
}

/// FLAC's samples are interleaved integers, AAC's planar floats.
void lay(std::span<const StereoSample> samples, AVFrame& to) {
    if (to.format == AV_SAMPLE_FMT_S16) {
        auto* at = reinterpret_cast<std::int16_t*>(to.data[0]);
        for (const StereoSample& sample : samples) {
            *at++ = as_16_bits(sample.left);
            *at++ = as_16_bits(sample.right);
        }
        return;
    }
    auto* const left = reinterpret_cast<float*>(to.data[0]);
    auto* const right = reinterpret_cast<float*>(to.data[1]);
    for (std::size_t k = 0; k < samples.size(); ++k) {
        left[k] = samples[k].left;
        right[k] = samples[k].right;
    }
}

}  // namespace

int FilmSound::open(AVFormatContext& muxer, ReservedOutput& room, bool is_exact) {
    const AVCodec* const codec = avcodec_find_encoder(is_exact ? AV_CODEC_ID_FLAC : AV_CODEC_ID_AAC);
    if (!codec) return AVERROR_ENCODER_NOT_FOUND;
    muxer_ = &muxer;
    room_ = &room;
    codec_.reset(avcodec_alloc_context3(codec));
    frame_.reset(av_frame_alloc());
    packet_.reset(av_packet_alloc());
    if (!codec_ || !frame_ || !packet_) return AVERROR(ENOMEM);
    codec_->sample_fmt = is_exact ? AV_SAMPLE_FMT_S16 : AV_SAMPLE_FMT_FLTP;
    codec_->sample_rate = SoundTrack::rate;
    codec_->ch_layout = AV_CHANNEL_LAYOUT_STEREO;
    codec_->time_base = {1, SoundTrack::rate};
    codec_->bit_rate = film_sound_bits_per_second;
    codec_->flags |= AV_CODEC_FLAG_BITEXACT;
    if (muxer.oformat->flags & AVFMT_GLOBALHEADER) codec_->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    if (const int status = avcodec_open2(codec_.get(), codec, nullptr); status < 0) return status;
    stream_ = avformat_new_stream(&muxer, nullptr);
    if (!stream_) return AVERROR(ENOMEM);
    stream_->time_base = codec_->time_base;
    return avcodec_parameters_from_context(stream_->codecpar, codec_.get());
}

/// Null: what the codec still holds.
int FilmSound::encode(const AVFrame* frame) {
    int status = avcodec_send_frame(codec_.get(), frame);
    while (status >= 0) {
        status = avcodec_receive_packet(codec_.get(), packet_.get());
        if (status == AVERROR(EAGAIN) || status == AVERROR_EOF) return 0;
        if (status < 0) return status;
        if (!room_->reserve_for(*packet_)) return AVERROR(ENOSPC);
        packet_->stream_index = stream_->index;
        av_packet_rescale_ts(packet_.get(), codec_->time_base, stream_->time_base);
        status = av_interleaved_write_frame(muxer_, packet_.get());
    }
    return status;
}

int FilmSound::encode_waiting(int count) {
    av_frame_unref(frame_.get());
    frame_->format = codec_->sample_fmt;
    frame_->sample_rate = codec_->sample_rate;
    frame_->ch_layout = codec_->ch_layout;
    frame_->nb_samples = count;
    frame_->pts = next_ - std::ssize(waiting_);
    if (const int status = av_frame_get_buffer(frame_.get(), 0); status < 0) return status;
    lay(std::span(waiting_).first(static_cast<std::size_t>(count)), *frame_);
    waiting_.erase(waiting_.begin(), waiting_.begin() + count);
    return encode(frame_.get());
}

int FilmSound::add(std::span<const StereoSample> samples) {
    const auto whole = static_cast<std::size_t>(codec_->frame_size);
    while (!samples.empty()) {
        const std::size_t count = std::min(samples.size(), whole - waiting_.size());
        waiting_.insert(waiting_.end(), samples.begin(),
                        samples.begin() + static_cast<std::ptrdiff_t>(count));
        next_ += static_cast<std::int64_t>(count);
        samples = samples.subspan(count);
        if (waiting_.size() < whole) break;
        if (const int status = encode_waiting(codec_->frame_size); status < 0) return status;
    }
    return 0;
}

int FilmSound::fill_until(std::int64_t sample) {
    static constexpr StereoSample silence[1024]{};
    int status = 0;
    while (status >= 0 && next_ < sample)
        status = add(std::span(silence).first(
            static_cast<std::size_t>(std::min<std::int64_t>(sample - next_, std::size(silence)))));
    return status;
}

int FilmSound::finish() {
    if (!waiting_.empty())
        if (const int status = encode_waiting(static_cast<int>(waiting_.size())); status < 0) return status;
    return encode(nullptr);
}

}  // namespace touchable
