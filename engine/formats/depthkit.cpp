// Depthkit's metadata (DepthkitMetadata), and the video that they describe (DepthkitPictures).

#include "engine/formats/formats_read.hpp"

#include <algorithm>
#include <cmath>

#include "engine/base/files.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/tracks.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/formats/stored_clip.hpp"
#include "engine/picture/ffmpeg.hpp"

namespace touchable {
namespace {

/// A colour means a depth if R + G + B > 0.3, with bytes scaled to 0 to 1.
constexpr int least_sum = 77;
/// Hue is a circle: compression may move depth at the near plane, red, past it to the far end. So the last
/// 1/32 of the circle means no depth.
constexpr int deepest_code = DepthCoding::hue_circle - DepthCoding::hue_circle / 32;
/// Textures are compressed in blocks of 4x4 pixels; a median of 5x5 sees beyond one. Holes are specks and the
/// blocks' dark rims.
constexpr FilterSettings usual_filter{5, 2};

/// Reads the few fields that matter from a YAML text that Unity wrote.
class DepthkitMetadata {
public:
    static Result<DepthkitMetadata> read(const std::filesystem::path& file) {
        constexpr std::size_t largest = 1 << 20;
        DepthkitMetadata metadata;
        metadata.file_ = file.string();
        TRY_ASSIGN(metadata.text_,
                   read_given_file(file, metadata.file_, "the metadata of a Depthkit video", largest));
        return metadata;
    }

    /// The value of the one line "field: value", wherever it stands.
    Result<std::string_view> text(std::string_view field) const {
        std::optional<std::string_view> found;
        std::string_view rest = text_;
        while (!rest.empty()) {
            const auto end = std::min(rest.find('\n'), rest.size());
            std::string_view line = trimmed(rest.substr(0, end));
            rest.remove_prefix(std::min(end + 1, rest.size()));
            if (line.starts_with("- ")) line = trimmed(line.substr(2));
            if (!line.starts_with(field) || line.substr(field.size(), 1) != ":") continue;
            if (found)
                return input_error(file_ + ": has " + std::string(field) +
                                   " more than once: only videos of one perspective are read");
            found = trimmed(line.substr(field.size() + 1));
        }
        if (found) return *found;
        return input_error(file_ + ": " + std::string(field) +
                           " is missing: must be there, as Depthkit's Unity plugins write it");
    }

    Result<double> number(std::string_view field) const {
        TRY_ASSIGN(const auto value, text(field));
        if (const auto number = parsed_number(value)) return *number;
        return refuse(field, value, "a number");
    }

    /// A component of a value such as {x: 512, y: 424}.
    Result<double> component(std::string_view field, std::string_view name) const {
        TRY_ASSIGN(const auto value, text(field));
        std::string_view rest = value;
        while (!rest.empty()) {  // up to each comma or brace
            const auto end = std::min(rest.find_first_of("{,}"), rest.size());
            const std::string_view part = trimmed(rest.substr(0, end));
            rest.remove_prefix(std::min(end + 1, rest.size()));
            if (!part.starts_with(name) || part.substr(name.size(), 1) != ":") continue;
            if (const auto number = parsed_number(trimmed(part.substr(name.size() + 1)))) return *number;
            break;
        }
        return refuse(field, value, "such as {x: 512, y: 424}, with a number " + std::string(name));
    }

    Error refuse(std::string_view field, std::string_view value, const std::string& right) const {
        return input_error(file_ + ": " + std::string(field) + " is " + printable(value) + ": must be " +
                           right);
    }
    const std::string& file() const { return file_; }

private:
    std::string file_, text_;
};

Result<int> whole_pixels(const DepthkitMetadata& metadata, std::string_view field,
                         const Result<double>& number) {
    if (!number) return number.error();
    if (*number >= 1 && *number <= 32768 && *number == std::floor(*number)) return static_cast<int>(*number);
    return metadata.refuse(field, std::to_string(*number), "a whole number of pixels, 1 to 32768");
}

/// Refuses other layouts, whose meaning these fields do not tell.
Result<void> check_layout(const DepthkitMetadata& metadata, int width, int height) {
    TRY_ASSIGN(const auto format, metadata.text("format"));
    if (format != "perpixel") return metadata.refuse("format", format, "perpixel");
    for (const auto& [field, size] : {std::pair{"textureWidth", width}, {"textureHeight", 2 * height}}) {
        TRY_ASSIGN(const auto texture, whole_pixels(metadata, field, metadata.number(field)));
        if (texture != size)
            return metadata.refuse(field, std::to_string(texture),
                                   std::to_string(size) + ", of two pictures of depthImageSize");
    }
    for (const auto& [name, whole_picture] : {std::pair{"x", 0.0}, {"y", 0.0}, {"z", 1.0}, {"w", 1.0}}) {
        TRY_ASSIGN(const auto edge, metadata.component("crop", name));
        if (edge != whole_picture)
            return metadata.refuse("crop", *metadata.text("crop"), "{x: 0, y: 0, z: 1, w: 1}, all of it");
    }
    return {};
}

Result<SceneDescription> scene_from(const DepthkitMetadata& metadata) {
    SceneDescription described;
    described.unstated.rate = true;
    described.unstated.filters = {
        .terraces = true, .temporal = true, .flying_pixels = true, .terrace_reach = true};
    Scene& scene = described.scene;
    scene.metres_per_unit = 1;
    scene.filter = usual_filter;
    TRY_ASSIGN(const auto width,
               whole_pixels(metadata, "depthImageSize", metadata.component("depthImageSize", "x")));
    TRY_ASSIGN(const auto height,
               whole_pixels(metadata, "depthImageSize", metadata.component("depthImageSize", "y")));
    TRY(check_layout(metadata, width, height));
    scene.width = width;
    scene.height = height;
    TRY_ASSIGN(scene.camera.fx, metadata.component("depthFocalLength", "x"));
    TRY_ASSIGN(scene.camera.fy, metadata.component("depthFocalLength", "y"));
    TRY_ASSIGN(scene.camera.cx, metadata.component("depthPrincipalPoint", "x"));
    TRY_ASSIGN(scene.camera.cy, metadata.component("depthPrincipalPoint", "y"));
    TRY_ASSIGN(scene.depth.near, metadata.number("nearClip"));
    TRY_ASSIGN(scene.depth.far, metadata.number("farClip"));
    scene.depth.kind = DepthCodingKind::hue;
    scene.depth.semantics = DepthSemantics::planar;
    scene.depth.near_is_high = false;
    scene.depth.code_max = deepest_code;
    scene.depth.far = scene.depth.near + (scene.depth.far - scene.depth.near) * deepest_code /
                                             static_cast<double>(DepthCoding::hue_circle);
    scene.depth.least_sum = least_sum;
    derive_valid_range(scene.depth);
    if (auto valid = validate(scene); !valid)
        return input_error(metadata.file() + ": " + valid.error().message);
    return described;
}

/// Reads pictures at an even rate, each of which holds both planes.
class DepthkitPictures final : public FrameSource {
public:
    explicit DepthkitPictures(const SourceFile& video) : source_(video), file_(video.string()) {}

    Result<void> open() {
        TRY(rewind());
        is_all_keys_ = demuxer_->is_all_keys(stream_);
        return read_rate();
    }

    std::int64_t count() const { return count_; }
    const FrameRate& rate() const { return rate_; }

    std::string where(PlaneRole role, std::int64_t frame) const override {
        return where(frame) + ", " + std::string(role_name(role));
    }

    /// Both planes are views of one picture.
    Result<TrackPicture> picture(PlaneRole role, std::int64_t frame) override {
        if (newest_number_ != frame) {
            newest_number_ = -1;
            newest_ = {};
            TRY(seek(frame));
            TRY_ASSIGN(newest_, next());
            newest_number_ = frame;
        }
        PlaneView half = newest_.view;
        if (half.channels != 3 || half.height % 2 != 0)
            return input_error(where(frame) + ": is " + size_text(half.width, half.height) +
                               (half.channels == 3 ? "" : " grey") +
                               ": a Depthkit video has colour above depth, both of the same size, in RGB");
        half.height /= 2;
        if (role == PlaneRole::depth) half.data = half.row(half.height);
        return lent_picture(decoder_->info(), {half, newest_.storage});
    }

    std::int64_t access_point(std::int64_t frame) const override { return is_all_keys_ ? frame : 0; }

private:
    Result<void> rewind() {
        TRY_ASSIGN(auto demuxer, Demuxer::open_quicktime(source_));
        decoder_.reset();
        demuxer_ = std::move(demuxer);
        const AVFormatContext& container = demuxer_->container();
        const int streams = static_cast<int>(container.nb_streams);
        stream_ = 0;
        while (stream_ < streams && container.streams[stream_]->codecpar->codec_type != AVMEDIA_TYPE_VIDEO)
            ++stream_;
        if (stream_ == streams) return input_error(file_ + ": has no video track");
        TRY_ASSIGN(decoder_, TrackDecoder::open(stream(), PlaneRole::colour, file_));
        demuxer_->select(stream_);
        number_ = 0;
        return {};
    }

    /// The rate by frame count and duration, exact if all frames are equally long; `check_time` checks that.
    Result<void> read_rate() {
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

    Result<void> seek(std::int64_t frame) {
        if (frame == number_) return {};
        const bool is_led = is_all_keys_ && frame > 0 && begin_at(frame);
        if (!is_led && (is_all_keys_ || frame < number_)) TRY(rewind());
        while (number_ < frame) TRY(next());
        return {};
    }

    /// Seeks by the index. False if that does not lead there; then the reading position is undefined.
    bool begin_at(std::int64_t frame) {
        const double time = static_cast<double>(origin_) + ticks_of(frame);
        const bool is_somewhere = demuxer_->seek(stream_, std::llround(time));
        const auto packet = is_somewhere ? demuxer_->peek(stream_) : Result<const AVPacket*>(nullptr);
        const double nearest = std::min(1.0, ticks_of(1) / 2);
        if (!packet || !*packet || std::fabs(static_cast<double>((*packet)->pts) - time) > nearest)
            return false;
        decoder_->restart(frame);
        number_ = frame;
        return true;
    }

    Result<Plane> next() {
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

    /// A frame's time after frame 0, in the stream's time base.
    double ticks_of(std::int64_t frame) const {
        const AVRational base = stream().time_base;
        return static_cast<double>(frame) * static_cast<double>(rate_.den) / static_cast<double>(rate_.num) *
               base.den / base.num;
    }

    /// An error if a picture is more than one tick of the stream's clock off its frame number's time.
    Result<void> check_time(const TrackDecoder::Picture& picture) {
        if (number_ == 0) origin_ = picture.timestamp;
        const double expected = ticks_of(number_);
        const double actual = static_cast<double>(picture.timestamp) - static_cast<double>(origin_);
        if (picture.timestamp != AV_NOPTS_VALUE && std::fabs(actual - expected) <= 1.0) return {};
        return input_error(where(number_) + ": is not at its time: must be evenly spaced frames, " +
                           clip_tags::rate_text(rate_) + " a second");
    }

    const AVStream& stream() const { return *demuxer_->container().streams[stream_]; }
    std::string where(std::int64_t frame) const { return file_ + ": frame " + std::to_string(frame); }

    SourceFile source_;
    std::string file_;
    FrameRate rate_;
    std::int64_t count_ = 0;
    bool is_all_keys_ = false;  // decoding can begin with any frame

    // The reading position; `rewind` resets it.
    std::unique_ptr<Demuxer> demuxer_;
    int stream_ = 0;
    std::optional<TrackDecoder> decoder_;
    std::int64_t number_ = 0;  // of the frame that `next` gives
    std::int64_t origin_ = 0;  // timestamp of frame 0

    Plane newest_{};
    std::int64_t newest_number_ = -1;
};

}  // namespace

std::filesystem::path depthkit_metadata_name(const std::filesystem::path& video) {
    return video.stem().concat(".Metadata.asset");
}

std::optional<std::filesystem::path> depthkit_metadata_of(const std::filesystem::path& video) {
    std::filesystem::path metadata = video.parent_path() / depthkit_metadata_name(video);
    return is_file(metadata) ? std::optional(std::move(metadata)) : std::nullopt;
}

std::optional<std::filesystem::path> depthkit_video_of(const std::filesystem::path& metadata) {
    const std::filesystem::path stem = metadata.stem().stem();  // without ".Metadata.asset"
    for (const char* extension : {".mov", ".mp4", ".MOV", ".MP4"}) {
        std::filesystem::path video = metadata.parent_path() / stem;
        video += extension;
        if (depthkit_metadata_of(video) == metadata && is_file(video)) return video;
    }
    return std::nullopt;
}

Result<SceneDescription> read_depthkit_metadata(const std::filesystem::path& file) {
    TRY_ASSIGN(const auto metadata, DepthkitMetadata::read(file));
    return scene_from(metadata);
}

Opened open_depthkit_clip(const Candidate& video) {
    const std::filesystem::path& file = video.source.path();
    const std::filesystem::path metadata = file.parent_path() / depthkit_metadata_name(file);
    auto pictures = std::make_unique<DepthkitPictures>(video.source);
    TRY(pictures->open());
    TRY_ASSIGN(auto scene,
               video.scene ? Result<SceneDescription>(*video.scene) : read_depthkit_metadata(metadata));
    if (!video.scene) scene.scene.name = file.stem().string();
    StoredClip clip{file.string(), std::move(scene)};
    const FrameRate& rate = pictures->rate();
    if (!clip.described.unstated.rate)
        if (auto note = clip_tags::rate_note(clip.described.scene.rate, rate))
            clip.notes.push_back(std::move(*note));
    clip.count = pictures->count();
    clip.roles = {PlaneRole::depth, PlaneRole::colour};
    clip.found.rate = rate;
    clip.inputs = {file, metadata};
    clip.pictures = std::move(pictures);
    return open_stored_clip(std::move(clip));
}

}  // namespace touchable
