#include "engine/import/depthkit_clip.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "engine/ffmpeg/demuxer.hpp"
#include "engine/import/depthkit_metadata.hpp"
#include "engine/video/clip_tags.hpp"
#include "engine/video/codecs.hpp"
#include "engine/video/track_decoder.hpp"

extern "C" {
#include <libavutil/rational.h>
}

namespace touchable {
namespace {

class DepthkitReader final : public ClipReader {
public:
    explicit DepthkitReader(const SourceFile& video) : source_(video), file_(video.string()) {
        add_input(video.path());
    }
    Result<void> open(const std::filesystem::path& metadata,
                      const std::optional<SceneDescription>& replacement);

    const Scene& scene() const override { return scene_; }
    UnstatedFilters unstated_filters() const override { return unstated_filters_; }
    const std::vector<TrackInfo>& tracks() const override { return infos_; }
    std::optional<std::int64_t> frame_count() const override { return promised_; }
    const std::vector<std::string>& notes() const override { return notes_; }
    Result<std::optional<RawFrame>> next() override;
    Result<void> rewind() override;
    Result<void> seek(std::int64_t frame) override;
    std::int64_t access_point(std::int64_t frame) const override { return is_all_keys_ ? frame : 0; }

private:
    Result<FrameRate> read_rate();
    bool begin_at(std::int64_t frame);
    double ticks_of(std::int64_t frame) const;
    Result<RawFrame> halves(TrackDecoder::Picture picture) const;
    Result<void> check_time(const TrackDecoder::Picture& picture);
    const AVStream& stream() const { return *demuxer_->container().streams[stream_]; }
    std::string where() const { return file_ + ": frame " + std::to_string(number_); }

    SourceFile source_;
    std::string file_;
    Scene scene_;
    UnstatedFilters unstated_filters_;
    FrameRate recorded_rate_;
    std::vector<TrackInfo> infos_;
    std::vector<std::string> notes_;
    std::int64_t promised_ = 0;
    bool is_all_keys_ = false;  // so that decoding can begin with any frame

    // Where the reading is; `rewind` makes it anew.
    std::unique_ptr<Demuxer> demuxer_;
    int stream_ = 0;
    std::optional<TrackDecoder> decoder_;
    std::int64_t number_ = 0;  // of the frame that `next` gives
    std::int64_t origin_ = 0;  // timestamp of frame 0
};

Result<void> DepthkitReader::open(const std::filesystem::path& metadata,
                                  const std::optional<SceneDescription>& replacement) {
    add_input(metadata);
    if (auto opened = rewind(); !opened) return opened;
    auto rate = read_rate();
    if (!rate) return rate.error();
    recorded_rate_ = *rate;
    is_all_keys_ = demuxer_->is_all_keys(stream_);
    auto described = replacement ? Result<SceneDescription>(*replacement) : read_depthkit_metadata(metadata);
    if (!described) return described.error();
    if (!replacement) described->scene.name = source_.path().stem().string();
    auto scene = settle(*described, {.rate = recorded_rate_});
    if (!scene) return input_error(file_ + ": " + scene.error().message);
    scene_ = std::move(*scene);
    unstated_filters_ = described->unstated.filters;
    if (auto note = clip_tags::rate_note(scene_.rate, recorded_rate_)) notes_.push_back(std::move(*note));
    const auto first = next();
    if (!first) return first.error();
    if (!*first) return input_error(file_ + ": has no frames");
    for (const PlaneRole role : {PlaneRole::depth, PlaneRole::colour})
        infos_.push_back({std::string(role_name(role)), decoder_->info().codec, decoder_->info().pixel_format,
                          decoder_->info().width, decoder_->info().height / 2});
    if (auto note = default_touch_note(false, scene_)) notes_.push_back(std::move(*note));
    if (auto note = lossy_note(PlaneRole::depth, decoder_->info().codec)) notes_.push_back(std::move(*note));
    if (auto note = no_depth_note(**first, scene_.depth)) notes_.push_back(std::move(*note));
    return rewind();
}

Result<void> DepthkitReader::rewind() {
    auto demuxer = Demuxer::open_quicktime(source_);
    if (!demuxer) return demuxer.error();
    decoder_.reset();
    demuxer_ = std::move(*demuxer);
    const AVFormatContext& container = demuxer_->container();
    const int streams = static_cast<int>(container.nb_streams);
    stream_ = 0;
    while (stream_ < streams && container.streams[stream_]->codecpar->codec_type != AVMEDIA_TYPE_VIDEO)
        ++stream_;
    if (stream_ == streams) return input_error(file_ + ": has no video track");
    auto decoder = TrackDecoder::open(stream(), PlaneRole::colour, file_);
    if (!decoder) return decoder.error();
    decoder_ = std::move(*decoder);
    demuxer_->select(stream_);
    number_ = 0;
    return {};
}

/// After frame 0, in the stream's time base.
double DepthkitReader::ticks_of(std::int64_t frame) const {
    const AVRational base = stream().time_base;
    return static_cast<double>(frame) * static_cast<double>(recorded_rate_.den) /
           static_cast<double>(recorded_rate_.num) * base.den / base.num;
}

Result<void> DepthkitReader::seek(std::int64_t frame) {
    if (frame < 0 || frame > promised_)
        return usage_error(file_ + ": has no frame " + std::to_string(frame) + ": must be from 0 to " +
                           std::to_string(promised_ - 1));
    if (frame == number_) return {};
    const bool is_led = is_all_keys_ && frame > 0 && begin_at(std::min(frame, promised_ - 1));
    if (!is_led && (is_all_keys_ || frame < number_))
        if (auto back = rewind(); !back) return back;
    while (number_ < frame) {
        const auto passed = next();
        if (!passed) return passed.error();
        if (!*passed) break;
    }
    return {};
}

/// False where the index does not lead there: then the reading may be anywhere.
bool DepthkitReader::begin_at(std::int64_t frame) {
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
Result<FrameRate> DepthkitReader::read_rate() {
    promised_ = stream().nb_frames;
    const AVRational base = stream().time_base;
    constexpr std::int64_t most = std::int64_t{1} << 31;
    int num = 0, den = 0;
    if (promised_ > 0 && promised_ < most && stream().duration > 0 && stream().duration < most) {
        const AVRational per_tick = av_make_q(base.den, base.num);
        av_reduce(&num, &den, promised_, stream().duration, 1'000'000'000);
        av_reduce(&num, &den, std::int64_t{num} * per_tick.num, std::int64_t{den} * per_tick.den,
                  1'000'000'000);
    }
    if (num <= 0 || den <= 0)
        return input_error(file_ + ": does not say how many frames it has, or how long");
    return FrameRate{num, den};
}

Result<std::optional<RawFrame>> DepthkitReader::next() {
    while (true) {
        auto decoded = decoder_->receive();
        if (!decoded) return decoded.error();
        if (*decoded) {
            if (auto timely = check_time(**decoded); !timely) return timely.error();
            auto frame = halves(std::move(**decoded));
            if (!frame) return frame.error();
            ++number_;
            return std::optional(std::move(*frame));
        }
        if (decoder_->drained()) break;
        const auto packet = demuxer_->next(stream_);
        if (!packet) return packet.error();
        if (auto sent = decoder_->send(packet->get()); !sent) return sent.error();
    }
    if (number_ >= promised_) return std::optional<RawFrame>{};
    return input_error(where() + ": is where the video ends, but it promises " + std::to_string(promised_) +
                       " frames: it is truncated or damaged");
}

/// Two views of one picture.
Result<RawFrame> DepthkitReader::halves(TrackDecoder::Picture picture) const {
    PlaneView colour = picture.plane.view;
    if (colour.channels != 3 || colour.height % 2 != 0)
        return input_error(where() + ": is " + std::to_string(colour.width) + "x" +
                           std::to_string(colour.height) + (colour.channels == 3 ? "" : " grey") +
                           ": a Depthkit video has colour above depth, both of the same size, in RGB");
    colour.height /= 2;
    PlaneView depth = colour;
    depth.data = colour.row(colour.height);
    RawFrame frame;
    frame.number = number_;
    frame.time_ns = scene_.rate.time_ns(number_);
    for (const auto& [role, view] : {std::pair{PlaneRole::depth, depth}, {PlaneRole::colour, colour}}) {
        auto plane = fit_plane(role, {view, picture.plane.storage}, scene_,
                               where() + ", " + std::string(role_name(role)));
        if (!plane) return plane.error();
        add_plane(frame, role, std::move(*plane));
    }
    return frame;
}

/// At the frame number's time, up to one tick of the stream's clock.
Result<void> DepthkitReader::check_time(const TrackDecoder::Picture& picture) {
    if (number_ == 0) origin_ = picture.timestamp;
    const double expected = ticks_of(number_);
    const double actual = static_cast<double>(picture.timestamp) - static_cast<double>(origin_);
    if (picture.timestamp != AV_NOPTS_VALUE && std::fabs(actual - expected) <= 1.0) return {};
    return input_error(where() + ": is not at its time: must be evenly spaced frames, " +
                       clip_tags::rate_text(recorded_rate_) + " a second");
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

Result<std::unique_ptr<ClipReader>> open_depthkit_clip(const SourceFile& video,
                                                       const std::filesystem::path& metadata,
                                                       const std::optional<SceneDescription>& described) {
    auto reader = std::make_unique<DepthkitReader>(video);
    if (auto opened = reader->open(metadata, described); !opened) return opened.error();
    return std::unique_ptr<ClipReader>(std::move(reader));
}

}  // namespace touchable
