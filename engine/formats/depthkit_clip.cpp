#include "engine/formats/depthkit_clip.hpp"

#include <cmath>
#include <string>
#include <utility>

#include "engine/base/try.hpp"
#include "engine/clip/clip_tags.hpp"
#include "engine/clip/track_decoder.hpp"
#include "engine/formats/depthkit_metadata.hpp"
#include "engine/formats/stored_clip.hpp"
#include "engine/picture/demuxer.hpp"

extern "C" {
#include <libavutil/rational.h>
}

namespace touchable {
namespace {

/// Pictures at an even rate, each of which holds both planes.
class DepthkitPictures final : public FrameSource {
public:
    explicit DepthkitPictures(const SourceFile& video) : source_(video), file_(video.string()) {}
    Result<void> open();
    std::int64_t count() const { return count_; }
    const FrameRate& rate() const { return rate_; }

    std::string where(PlaneRole role, std::int64_t frame) const override {
        return where(frame) + ", " + std::string(role_name(role));
    }
    Result<TrackPicture> picture(PlaneRole role, std::int64_t frame) override;
    std::int64_t access_point(std::int64_t frame) const override { return is_all_keys_ ? frame : 0; }

private:
    Result<void> rewind();
    Result<void> read_rate();
    Result<void> seek(std::int64_t frame);
    bool begin_at(std::int64_t frame);
    Result<Plane> next();
    double ticks_of(std::int64_t frame) const;
    Result<void> check_time(const TrackDecoder::Picture& picture);
    const AVStream& stream() const { return *demuxer_->container().streams[stream_]; }
    std::string where(std::int64_t frame) const { return file_ + ": frame " + std::to_string(frame); }

    SourceFile source_;
    std::string file_;
    FrameRate rate_;
    std::int64_t count_ = 0;
    bool is_all_keys_ = false;  // so that decoding can begin with any frame

    // Where the reading is; `rewind` makes it anew.
    std::unique_ptr<Demuxer> demuxer_;
    int stream_ = 0;
    std::optional<TrackDecoder> decoder_;
    std::int64_t number_ = 0;  // of the frame that `next` gives
    std::int64_t origin_ = 0;  // timestamp of frame 0

    Plane newest_{};
    std::int64_t newest_number_ = -1;
};

Result<void> DepthkitPictures::open() {
    if (auto opened = rewind(); !opened) return opened;
    is_all_keys_ = demuxer_->is_all_keys(stream_);
    return read_rate();
}

/// Two views of one picture.
Result<TrackPicture> DepthkitPictures::picture(PlaneRole role, std::int64_t frame) {
    if (newest_number_ != frame) {
        newest_number_ = -1;
        newest_ = {};
        TRY(seek(frame));
        TRY_ASSIGN(auto plane, next());
        newest_ = std::move(plane);
        newest_number_ = frame;
    }
    PlaneView half = newest_.view;
    if (half.channels != 3 || half.height % 2 != 0)
        return input_error(where(frame) + ": is " + std::to_string(half.width) + "x" +
                           std::to_string(half.height) + (half.channels == 3 ? "" : " grey") +
                           ": a Depthkit video has colour above depth, both of the same size, in RGB");
    half.height /= 2;
    if (role == PlaneRole::depth) half.data = half.row(half.height);
    return lent_picture(decoder_->info(), {half, newest_.storage});
}

Result<void> DepthkitPictures::rewind() {
    TRY_ASSIGN(auto demuxer, Demuxer::open_quicktime(source_));
    decoder_.reset();
    demuxer_ = std::move(demuxer);
    const AVFormatContext& container = demuxer_->container();
    const int streams = static_cast<int>(container.nb_streams);
    stream_ = 0;
    while (stream_ < streams && container.streams[stream_]->codecpar->codec_type != AVMEDIA_TYPE_VIDEO)
        ++stream_;
    if (stream_ == streams) return input_error(file_ + ": has no video track");
    TRY_ASSIGN(auto decoder, TrackDecoder::open(stream(), PlaneRole::colour, file_));
    decoder_ = std::move(decoder);
    demuxer_->select(stream_);
    number_ = 0;
    return {};
}

/// After frame 0, in the stream's time base.
double DepthkitPictures::ticks_of(std::int64_t frame) const {
    const AVRational base = stream().time_base;
    return static_cast<double>(frame) * static_cast<double>(rate_.den) / static_cast<double>(rate_.num) *
           base.den / base.num;
}

Result<void> DepthkitPictures::seek(std::int64_t frame) {
    if (frame == number_) return {};
    const bool is_led = is_all_keys_ && frame > 0 && begin_at(frame);
    if (!is_led && (is_all_keys_ || frame < number_))
        if (auto back = rewind(); !back) return back;
    while (number_ < frame) TRY(next());
    return {};
}

/// False where the index does not lead there: then the reading may be anywhere.
bool DepthkitPictures::begin_at(std::int64_t frame) {
    const double time = static_cast<double>(origin_) + ticks_of(frame);
    const bool is_somewhere = demuxer_->seek(stream_, std::llround(time));
    const auto packet = is_somewhere ? demuxer_->peek(stream_) : Result<const AVPacket*>(nullptr);
    const double nearest = std::min(1.0, ticks_of(1) / 2);
    if (!packet || !*packet || std::fabs(static_cast<double>((*packet)->pts) - time) > nearest) return false;
    decoder_->restart(frame);
    number_ = frame;
    return true;
}

/// Frames by their duration, which is exact where all last equally long; `check_time` finds where not.
Result<void> DepthkitPictures::read_rate() {
    count_ = stream().nb_frames;
    const AVRational base = stream().time_base;
    constexpr std::int64_t most = std::int64_t{1} << 31;
    int num = 0, den = 0;
    if (count_ > 0 && count_ < most && stream().duration > 0 && stream().duration < most) {
        const AVRational per_tick = av_make_q(base.den, base.num);
        av_reduce(&num, &den, count_, stream().duration, 1'000'000'000);
        av_reduce(&num, &den, std::int64_t{num} * per_tick.num, std::int64_t{den} * per_tick.den,
                  1'000'000'000);
    }
    if (num <= 0 || den <= 0)
        return input_error(file_ + ": does not say how many frames it has, or how long");
    rate_ = {num, den};
    return {};
}

Result<Plane> DepthkitPictures::next() {
    while (true) {
        TRY_ASSIGN(auto decoded, decoder_->receive());
        if (decoded) {
            TRY(check_time(*decoded));
            ++number_;
            return std::move(decoded->plane);
        }
        if (decoder_->drained()) break;
        TRY_ASSIGN(const auto packet, demuxer_->next(stream_));
        TRY(decoder_->send(packet.get()));
    }
    return input_error(where(number_) + ": is where the video ends, but it promises " +
                       std::to_string(count_) + " frames: it is truncated or damaged");
}

/// At the frame number's time, up to one tick of the stream's clock.
Result<void> DepthkitPictures::check_time(const TrackDecoder::Picture& picture) {
    if (number_ == 0) origin_ = picture.timestamp;
    const double expected = ticks_of(number_);
    const double actual = static_cast<double>(picture.timestamp) - static_cast<double>(origin_);
    if (picture.timestamp != AV_NOPTS_VALUE && std::fabs(actual - expected) <= 1.0) return {};
    return input_error(where(number_) + ": is not at its time: must be evenly spaced frames, " +
                       clip_tags::rate_text(rate_) + " a second");
}

}  // namespace

std::filesystem::path depthkit_metadata_name(const std::filesystem::path& video) {
    return video.stem().concat(".Metadata.asset");
}

std::optional<std::filesystem::path> depthkit_metadata_of(const std::filesystem::path& video) {
    std::filesystem::path metadata = video.parent_path() / depthkit_metadata_name(video);
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(metadata, ignored)) return std::nullopt;
    return metadata;
}

std::optional<std::filesystem::path> depthkit_video_of(const std::filesystem::path& metadata) {
    const std::filesystem::path stem = metadata.stem().stem();  // without ".Metadata.asset"
    for (const char* extension : {".mov", ".mp4", ".MOV", ".MP4"}) {
        std::filesystem::path video = metadata.parent_path() / stem;
        video += extension;
        std::error_code ignored;
        if (depthkit_metadata_of(video) == metadata && std::filesystem::is_regular_file(video, ignored))
            return video;
    }
    return std::nullopt;
}

Result<std::unique_ptr<ClipReader>> open_depthkit_clip(const SourceFile& video,
                                                       const std::filesystem::path& metadata,
                                                       const std::optional<SceneDescription>& described) {
    auto pictures = std::make_unique<DepthkitPictures>(video);
    TRY(pictures->open());
    auto scene = described ? Result<SceneDescription>(*described) : read_depthkit_metadata(metadata);
    if (!scene) return scene.error();
    if (!described) scene->scene.name = video.path().stem().string();
    StoredClip clip{video.string(), std::move(*scene)};
    const FrameRate& rate = pictures->rate();
    if (!clip.described.unstated.rate)
        if (auto note = clip_tags::rate_note(clip.described.scene.rate, rate))
            clip.notes.push_back(std::move(*note));
    clip.count = pictures->count();
    clip.roles = {PlaneRole::depth, PlaneRole::colour};
    clip.found.rate = rate;
    clip.inputs = {video.path(), metadata};
    clip.pictures = std::move(pictures);
    return open_stored_clip(std::move(clip));
}

}  // namespace touchable
