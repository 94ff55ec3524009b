// SPDX-License-Identifier: Apache-2.0
// Films of a window: its pictures as H.264, and its sound as AAC or FLAC; or numbered PNG files.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/containers.hpp"
#include "engine/clip/track_codecs.hpp"
#include "engine/picture/ffmpeg.hpp"

namespace touchable {
namespace {

constexpr std::int64_t film_sound_bits_per_second = 160'000;  // of AAC

/// FLAC's samples are interleaved integers, AAC's planar floats.
void lay_sound(std::span<const StereoSample> samples, AVFrame& to) {
    if (to.format == AV_SAMPLE_FMT_S16) {
        std::ranges::transform(samples, reinterpret_cast<std::array<std::int16_t, 2>*>(to.data[0]),
                               in_16_bits);
        return;
    }
    auto* const left = reinterpret_cast<float*>(to.data[0]);
    auto* const right = reinterpret_cast<float*>(to.data[1]);
    for (std::size_t k = 0; k < samples.size(); ++k) {
        left[k] = samples[k].left;
        right[k] = samples[k].right;
    }
}

/// The sound of a film that is being written: two channels at SoundTrack::rate, from the film's first picture
/// on. Functions return FFmpeg's status, negative on failure.
class FilmSound {
public:
    /// Adds its stream, before the muxer's header is written: AAC, or FLAC if `is_exact`. The muxer writes to
    /// `room`.
    int open(AVFormatContext& muxer, ReservedOutput& room, bool is_exact) {
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

    /// Number of the next sample.
    std::int64_t next() const { return next_; }
    int add(std::span<const StereoSample> samples) {
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

    /// Adds silence up to this sample.
    int fill_until(std::int64_t sample) {
        static constexpr StereoSample silence[1024]{};
        int status = 0;
        while (status >= 0 && next_ < sample)
            status = add(std::span(silence).first(
                static_cast<std::size_t>(std::min<std::int64_t>(sample - next_, std::size(silence)))));
        return status;
    }

    /// Call before the muxer writes its trailer.
    int finish() {
        if (!waiting_.empty())
            if (const int status = encode_waiting(static_cast<int>(waiting_.size())); status < 0)
                return status;
        return encode(nullptr);
    }

private:
    /// Null flushes the codec.
    int encode(const AVFrame* frame) {
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

    int encode_waiting(int count) {
        av_frame_unref(frame_.get());
        frame_->format = codec_->sample_fmt;
        frame_->sample_rate = codec_->sample_rate;
        frame_->ch_layout = codec_->ch_layout;
        frame_->nb_samples = count;
        frame_->pts = next_ - std::ssize(waiting_);
        if (const int status = av_frame_get_buffer(frame_.get(), 0); status < 0) return status;
        lay_sound(std::span(waiting_).first(static_cast<std::size_t>(count)), *frame_);
        waiting_.erase(waiting_.begin(), waiting_.begin() + count);
        return encode(frame_.get());
    }

    AVFormatContext* muxer_ = nullptr;
    ReservedOutput* room_ = nullptr;
    AVStream* stream_ = nullptr;
    CodecPtr codec_;
    FramePtr frame_;
    PacketPtr packet_;
    std::vector<StereoSample> waiting_;  // less than one codec frame
    std::int64_t next_ = 0;
};

constexpr std::int64_t access_interval_s = 2;  // from keyframe to keyframe

int even_side(double side) {
    return std::max(2, static_cast<int>(std::floor(side)) / 2 * 2);
}

class FfmpegFilm final : public FilmWriter {
public:
    FfmpegFilm(const std::filesystem::path& file, Existing existing, int rate)
        : output_(file, existing), rate_(rate), most_apart_s_(std::max(2, 1 + 8 / rate)) {}
    Result<void> open(const char* format) {
        TRY(output_.hold());
        AVFormatContext* muxer = nullptr;
        int status = avformat_alloc_output_context2(&muxer, nullptr, format, nullptr);
        if (status < 0) return refuse(ffmpeg_text(status));
        muxer_.reset(muxer);
        muxer_->flags |= AVFMT_FLAG_BITEXACT;
        status = room_.open(output_.path(), *muxer_);
        return status < 0 ? refuse(ffmpeg_text(status)) : Result<void>();
    }

    Result<void> add(const PlaneView& picture, std::int64_t place) override {
        return keep(show(picture, place));
    }
    Result<void> add_sound(std::int64_t sample, std::span<const StereoSample> samples) override {
        if (!picture_) return refuse("its sound came before its first picture");
        return keep(sound(sample, samples));
    }
    Result<void> finish(std::int64_t end) override {
        if (!picture_) return refuse("there was no picture");
        if (so_far_) so_far_ = end_tracks(end);
        const bool is_cut = room_.is_full() && next_ > 0;  // room for the trailer is reserved
        if (!so_far_ && !is_cut) return so_far_;
        int status = av_write_trailer(muxer_.get());
        if (status >= 0) status = room_.close();
        if (status < 0) return refuse(ffmpeg_text(status));
        if (auto named = output_.commit(); !named || so_far_) return named;
        return refuse("the disk is full; it is kept up to there");
    }

private:
    Error refuse(const std::string& what) const {
        return input_error(output_.target().string() + ": the film cannot be written: " + what);
    }
    Result<void> check_status(int status) const {
        if (status >= 0 && muxer_->pb->error < 0) status = muxer_->pb->error;
        if (status < 0 && room_.is_full()) return refuse("the disk is full");
        return status >= 0 ? Result<void>() : refuse(ffmpeg_text(status));
    }

    Result<void> keep(Result<void> done) {
        if (so_far_) so_far_ = std::move(done);
        return so_far_;
    }

    Result<void> show(const PlaneView& picture, std::int64_t place) {
        if (!so_far_) return so_far_;
        TRY(picture_ ? repeat_until(place) : begin(even_side(picture.width), even_side(picture.height)));
        return fit(picture);
    }

    Result<void> sound(std::int64_t sample, std::span<const StereoSample> samples) {
        if (!so_far_) return so_far_;
        const std::int64_t late = std::clamp<std::int64_t>(sound_.next() - sample, 0, std::ssize(samples));
        samples = samples.subspan(static_cast<std::size_t>(late));
        if (samples.empty()) return {};
        const std::int64_t end = sample + late + std::ssize(samples);
        TRY(repeat_until((end / SoundTrack::rate - most_apart_s_) * rate_));
        TRY(check_status(sound_.fill_until(sample)));
        return check_status(sound_.add(samples));
    }

    /// Makes both tracks equally long and flushes them.
    Result<void> end_tracks(std::int64_t end) {
        TRY(repeat_until(std::max(end, next_ + 1)));
        TRY(check_status(sound_.fill_until(next_ * SoundTrack::rate / rate_)));
        return check_status(sound_.finish());
    }

    Result<void> begin(int width, int height) {
        TRY_ASSIGN(codec_,
                   open_encoder(TrackCoding::h264_visual, AV_PIX_FMT_YUV420P, width, height, {rate_, 1}));
        picture_ = blank_picture(AV_PIX_FMT_YUV420P, width, height);
        if (!picture_) return refuse("out of memory");
        AVStream* const stream = avformat_new_stream(muxer_.get(), nullptr);
        if (!stream || avcodec_parameters_from_context(stream->codecpar, codec_.get()) < 0)
            return refuse("out of memory");
        stream->time_base = codec_->time_base;
        stream->avg_frame_rate = codec_->framerate;
        const bool is_exact = std::strcmp(muxer_->oformat->name, "matroska") == 0;
        TRY(check_status(sound_.open(*muxer_, room_, is_exact)));
        return check_status(avformat_write_header(muxer_.get(), nullptr));
    }

    /// Encodes the newest picture for all places before `end`.
    Result<void> repeat_until(std::int64_t end) {
        for (; next_ < end; ++next_) {
            const std::int64_t shown = next_ * SoundTrack::rate / rate_;
            TRY(check_status(sound_.fill_until(shown - most_apart_s_ * SoundTrack::rate)));
            picture_->pts = next_;
            picture_->pict_type =
                next_ % (access_interval_s * rate_) == 0 ? AV_PICTURE_TYPE_I : AV_PICTURE_TYPE_NONE;
            PacketPtr packet(av_packet_alloc());
            if (!packet) return refuse("out of memory");
            int status = avcodec_send_frame(codec_.get(), picture_.get());
            if (status >= 0) status = avcodec_receive_packet(codec_.get(), packet.get());
            if (status < 0) return refuse(ffmpeg_text(status));
            if (!room_.reserve_for(*packet)) return check_status(AVERROR(ENOSPC));
            packet->stream_index = 0;
            packet->duration = 1;
            av_packet_rescale_ts(packet.get(), codec_->time_base, muxer_->streams[0]->time_base);
            TRY(check_status(av_interleaved_write_frame(muxer_.get(), packet.get())));
        }
        return {};
    }

    /// Scales `picture` into the middle of the film's picture.
    Result<void> fit(const PlaneView& picture) {
        AVFrame& to = *picture_;
        if (av_frame_make_writable(&to) < 0) return refuse("out of memory");
        const double scale = std::min(static_cast<double>(to.width) / picture.width,
                                      static_cast<double>(to.height) / picture.height);
        const bool same = picture.width / 2 * 2 == to.width && picture.height / 2 * 2 == to.height;
        const int width = same ? to.width : even_side(picture.width * scale);
        const int height = same ? to.height : even_side(picture.height * scale);
        if (from_width_ != picture.width || from_height_ != picture.height) {
            const int taken_width = same ? width : picture.width,
                      taken_height = same ? height : picture.height;
            scaler_ = scaler_from_rgb(taken_width, taken_height, AV_PIX_FMT_YUV420P, width, height,
                                      SWS_BILINEAR | SWS_ACCURATE_RND | SWS_BITEXACT);
            if (!scaler_) return refuse("pictures of this size cannot be fitted");
            from_width_ = picture.width;
            from_height_ = picture.height;
            for (int plane = 0; plane < 3; ++plane)
                std::memset(to.data[plane], plane == 0 ? 16 : 128,
                            static_cast<std::size_t>(to.linesize[plane]) *
                                static_cast<std::size_t>(plane == 0 ? to.height : to.height / 2));
        }
        const int x = (to.width - width) / 4 * 2, y = (to.height - height) / 4 * 2;
        std::uint8_t* const rows[] = {to.data[0] + std::ptrdiff_t{y} * to.linesize[0] + x,
                                      to.data[1] + std::ptrdiff_t{y / 2} * to.linesize[1] + x / 2,
                                      to.data[2] + std::ptrdiff_t{y / 2} * to.linesize[2] + x / 2, nullptr};
        const std::uint8_t* const from[] = {picture.data, nullptr, nullptr, nullptr};
        const int strides[] = {static_cast<int>(picture.stride), 0, 0, 0};
        sws_scale(scaler_.get(), from, strides, 0, same ? height : picture.height, rows, to.linesize);
        return {};
    }

    NewFile output_;
    const int rate_;
    const std::int64_t most_apart_s_;  // sound from its picture; the window has some pictures waiting
    ReservedOutput room_;
    MuxedClipWriter::Muxer muxer_;
    CodecPtr codec_;
    FilmSound sound_;
    FramePtr picture_;  // the newest, as it is encoded
    ScalerPtr scaler_;
    int from_width_ = 0, from_height_ = 0;  // input size of the scaler
    std::int64_t next_ = 0;                 // first place not yet encoded
    Result<void> so_far_;                   // the first fault, or none
};

class NumberedPictures final : public FilmWriter {
public:
    NumberedPictures(std::filesystem::path pattern, Existing existing)
        : pattern_(std::move(pattern)), existing_(existing) {}
    Result<void> add(const PlaneView& picture, std::int64_t) override {
        if (!so_far_) return so_far_;
        NewFile out(*numbered_picture(pattern_, ++number_), existing_);
        so_far_ = out.check();
        if (so_far_) so_far_ = write_png_to(out.path(), picture, out.target(), PngEffort::quick);
        if (so_far_) so_far_ = out.commit();
        return so_far_;
    }
    Result<void> add_sound(std::int64_t, std::span<const StereoSample>) override { return so_far_; }
    Result<void> finish(std::int64_t) override { return so_far_; }

private:
    const std::filesystem::path pattern_;
    const Existing existing_;
    std::int64_t number_ = 0;
    Result<void> so_far_;  // the first fault, or none
};

}  // namespace

std::optional<std::filesystem::path> numbered_picture(const std::filesystem::path& pattern,
                                                      std::int64_t number) {
    const std::string name = pattern.filename().string();
    const std::size_t begin = name.find('%'), end = name.find_first_not_of("0123456789", begin + 1);
    if (begin == std::string::npos || end == std::string::npos || name[end] != 'd' || end > begin + 3 ||
        name.find('%', end) != std::string::npos || small_letters(pattern.extension().string()) != ".png")
        return std::nullopt;
    const std::string width = name.substr(begin + 1, end - begin - 1), digits = std::to_string(number);
    const std::size_t wide = width.empty() ? 0 : std::stoul(width);
    const std::string room(wide > digits.size() ? wide - digits.size() : 0, width[0] == '0' ? '0' : ' ');
    return pattern.parent_path() / (name.substr(0, begin) + room + digits + name.substr(end + 1));
}

Result<std::unique_ptr<FilmWriter>> FilmWriter::create(const std::filesystem::path& file, Existing existing,
                                                       int pictures_per_second) {
    if (const auto first = numbered_picture(file, 1)) {
        TRY(NewFile(*first, existing).check());
        return std::make_unique<NumberedPictures>(file, existing);
    }
    silence_ffmpeg();
    const bool is_mp4 = is_mp4_name(file);
    if (!is_mp4 && small_letters(file.extension().string()) != ".mkv")
        return usage_error(file.string() +
                           " is no name of a film; must end in .mp4 or .mkv, or be like shot-%04d.png");
    return opened_as<FilmWriter>(std::make_unique<FfmpegFilm>(file, existing, pictures_per_second),
                                 is_mp4 ? "mp4" : "matroska");
}

}  // namespace touchable
