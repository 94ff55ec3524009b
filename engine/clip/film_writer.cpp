#include "engine/clip/film_writer.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include "engine/base/try.hpp"
#include "engine/clip/film_sound.hpp"
#include "engine/clip/track_codecs.hpp"
#include "engine/clip/track_encoder.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/reserved_output.hpp"

namespace touchable {
namespace {

/// Where players can begin, in pictures.
constexpr std::int64_t film_access_interval = 2 * FilmWriter::pictures_per_second;
constexpr std::int64_t samples_per_picture = SoundTrack::rate / FilmWriter::pictures_per_second;
/// Pictures and sound lie no farther apart in the file.
constexpr std::int64_t most_pictures_apart = 2 * FilmWriter::pictures_per_second;

int even(double side) {
    return std::max(2, static_cast<int>(std::floor(side)) / 2 * 2);
}

struct FilmCloser {
    void operator()(AVFormatContext* muxer) const { avformat_free_context(muxer); }
};

class FfmpegFilm final : public FilmWriter {
public:
    FfmpegFilm(const std::filesystem::path& file, Existing existing) : output_(file, existing) {}
    Result<void> open(const char* format);
    Result<void> add(const PlaneView& picture, std::int64_t place) override {
        return keep(show(picture, place));
    }
    Result<void> add_sound(std::int64_t sample, std::span<const StereoSample> samples) override {
        if (!picture_) return refuse("its sound came before its first picture");
        return keep(sound(sample, samples));
    }
    Result<void> finish(std::int64_t end) override;

private:
    Error refuse(const std::string& what) const {
        return input_error(output_.target().string() + ": the film cannot be written: " + what);
    }
    Result<void> check_status(int status) const;
    Result<void> keep(Result<void> done);
    Result<void> show(const PlaneView& picture, std::int64_t place);
    Result<void> sound(std::int64_t sample, std::span<const StereoSample> samples);
    Result<void> end_tracks(std::int64_t end);
    Result<void> begin(int width, int height);
    Result<void> repeat_until(std::int64_t end);
    Result<void> fit(const PlaneView& picture);

    NewFile output_;
    ReservedOutput room_;
    std::unique_ptr<AVFormatContext, FilmCloser> muxer_;
    CodecPtr codec_;
    FilmSound sound_;
    FramePtr picture_;  // the newest, as it is encoded
    ScalerPtr scaler_;
    int from_width_ = 0, from_height_ = 0;  // of what the scaler takes
    std::int64_t next_ = 0;                 // place that is not encoded yet
    Result<void> fault_;                    // the first
};

Result<void> FfmpegFilm::check_status(int status) const {
    if (status >= 0 && muxer_->pb->error < 0) status = muxer_->pb->error;
    if (status < 0 && room_.is_full()) return refuse("the disk is full");
    return status >= 0 ? Result<void>() : refuse(ffmpeg_text(status));
}

Result<void> FfmpegFilm::keep(Result<void> done) {
    if (fault_.ok()) fault_ = std::move(done);
    return fault_;
}

Result<void> FfmpegFilm::open(const char* format) {
    if (auto usable = output_.check(); !usable.ok()) return usable;
    AVFormatContext* muxer = nullptr;
    int status = avformat_alloc_output_context2(&muxer, nullptr, format, nullptr);
    if (status < 0) return refuse(ffmpeg_text(status));
    muxer_.reset(muxer);
    muxer_->flags |= AVFMT_FLAG_BITEXACT;
    status = room_.open(output_.path(), *muxer_);
    return status < 0 ? refuse(ffmpeg_text(status)) : Result<void>();
}

Result<void> FfmpegFilm::begin(int width, int height) {
    TRY_ASSIGN(auto codec, open_encoder(TrackCoding::h264_visual, AV_PIX_FMT_YUV420P, width, height,
                                        {pictures_per_second, 1}));
    codec_ = std::move(codec);
    picture_.reset(av_frame_alloc());
    if (!picture_) return refuse("out of memory");
    picture_->format = AV_PIX_FMT_YUV420P;
    picture_->width = width;
    picture_->height = height;
    if (av_frame_get_buffer(picture_.get(), 0) < 0) return refuse("out of memory");
    AVStream* const stream = avformat_new_stream(muxer_.get(), nullptr);
    if (!stream || avcodec_parameters_from_context(stream->codecpar, codec_.get()) < 0)
        return refuse("out of memory");
    stream->time_base = codec_->time_base;
    stream->avg_frame_rate = codec_->framerate;
    const bool is_exact = std::strcmp(muxer_->oformat->name, "matroska") == 0;
    if (auto opened = check_status(sound_.open(*muxer_, room_, is_exact)); !opened.ok()) return opened;
    return check_status(avformat_write_header(muxer_.get(), nullptr));
}

/// Into the middle of the film's picture.
Result<void> FfmpegFilm::fit(const PlaneView& picture) {
    AVFrame& to = *picture_;
    if (av_frame_make_writable(&to) < 0) return refuse("out of memory");
    const double scale = std::min(static_cast<double>(to.width) / picture.width,
                                  static_cast<double>(to.height) / picture.height);
    const bool same = picture.width / 2 * 2 == to.width && picture.height / 2 * 2 == to.height;
    const int width = same ? to.width : even(picture.width * scale);
    const int height = same ? to.height : even(picture.height * scale);
    if (from_width_ != picture.width || from_height_ != picture.height) {
        const int taken_width = same ? width : picture.width, taken_height = same ? height : picture.height;
        scaler_.reset(sws_getContext(taken_width, taken_height, AV_PIX_FMT_RGB24, width, height,
                                     AV_PIX_FMT_YUV420P, SWS_BILINEAR | SWS_ACCURATE_RND, nullptr, nullptr,
                                     nullptr));
        if (!scaler_) return refuse("pictures of this size cannot be fitted");
        sws_setColorspaceDetails(scaler_.get(), sws_getCoefficients(SWS_CS_DEFAULT), 1,
                                 sws_getCoefficients(SWS_CS_ITU709), 0, 0, 1 << 16, 1 << 16);
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

/// The newest picture.
Result<void> FfmpegFilm::repeat_until(std::int64_t end) {
    for (; next_ < end; ++next_) {
        const std::int64_t least_heard = (next_ - most_pictures_apart) * samples_per_picture;
        if (auto filled = check_status(sound_.fill_until(least_heard)); !filled.ok()) return filled;
        picture_->pts = next_;
        picture_->pict_type = next_ % film_access_interval == 0 ? AV_PICTURE_TYPE_I : AV_PICTURE_TYPE_NONE;
        PacketPtr packet(av_packet_alloc());
        if (!packet) return refuse("out of memory");
        int status = avcodec_send_frame(codec_.get(), picture_.get());
        if (status >= 0) status = avcodec_receive_packet(codec_.get(), packet.get());
        if (status < 0) return refuse(ffmpeg_text(status));
        if (!room_.reserve_for(*packet)) return check_status(AVERROR(ENOSPC));
        packet->stream_index = 0;
        packet->duration = 1;
        av_packet_rescale_ts(packet.get(), codec_->time_base, muxer_->streams[0]->time_base);
        if (auto written = check_status(av_interleaved_write_frame(muxer_.get(), packet.get()));
            !written.ok())
            return written;
    }
    return {};
}

Result<void> FfmpegFilm::show(const PlaneView& picture, std::int64_t place) {
    if (!fault_.ok()) return fault_;
    if (picture_) {
        if (auto repeated = repeat_until(place); !repeated.ok()) return repeated;
    } else if (auto begun = begin(even(picture.width), even(picture.height)); !begun.ok()) {
        return begun;
    }
    return fit(picture);
}

Result<void> FfmpegFilm::sound(std::int64_t sample, std::span<const StereoSample> samples) {
    if (!fault_.ok()) return fault_;
    const std::int64_t late = std::clamp<std::int64_t>(sound_.next() - sample, 0, std::ssize(samples));
    samples = samples.subspan(static_cast<std::size_t>(late));
    if (samples.empty()) return {};
    const std::int64_t end = sample + late + std::ssize(samples);
    if (auto repeated = repeat_until(end / samples_per_picture - most_pictures_apart); !repeated.ok())
        return repeated;
    if (auto filled = check_status(sound_.fill_until(sample)); !filled.ok()) return filled;
    return check_status(sound_.add(samples));
}

/// Both are as long as each other, and nothing waits.
Result<void> FfmpegFilm::end_tracks(std::int64_t end) {
    if (auto repeated = repeat_until(std::max(end, next_ + 1)); !repeated.ok()) return repeated;
    if (auto filled = check_status(sound_.fill_until(next_ * samples_per_picture)); !filled.ok())
        return filled;
    return check_status(sound_.finish());
}

Result<void> FfmpegFilm::finish(std::int64_t end) {
    if (!picture_) return refuse("there was no picture");
    if (fault_.ok()) fault_ = end_tracks(end);
    const bool is_cut = room_.is_full() && next_ > 0;  // there is room for its end
    if (!fault_.ok() && !is_cut) return fault_;
    int status = av_write_trailer(muxer_.get());
    if (status >= 0) status = room_.close();
    if (status < 0) return refuse(ffmpeg_text(status));
    if (auto named = output_.commit(); !named.ok() || fault_.ok()) return named;
    return refuse("the disk is full; it is kept up to there");
}

}  // namespace

Result<std::unique_ptr<FilmWriter>> FilmWriter::create(const std::filesystem::path& file, Existing existing) {
    silence_ffmpeg();
    std::string end = file.extension().string();
    for (char& letter : end)
        if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');
    const bool is_mp4 = end == ".mp4";
    if (!is_mp4 && end != ".mkv")
        return usage_error(file.string() +
                           " is no name of a film; right would be one that ends in .mp4 or .mkv");
    auto film = std::make_unique<FfmpegFilm>(file, existing);
    TRY(film->open(is_mp4 ? "mp4" : "matroska"));
    return std::unique_ptr<FilmWriter>(std::move(film));
}

}  // namespace touchable
