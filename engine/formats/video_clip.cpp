#include "engine/formats/video_clip.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "engine/base/try.hpp"
#include "engine/clip/clip_tags.hpp"
#include "engine/formats/still_maps.hpp"
#include "engine/formats/stored_clip.hpp"
#include "engine/formats/video_picture.hpp"

namespace touchable {
namespace {

/// Depth in a track of one file; colour beside it in the same pictures, or in a track of its own.
class VideoPictures final : public FrameSource {
public:
    VideoPictures(const VideoSource& source, const Scene& scene, std::shared_ptr<VideoFile> depth)
        : source_(source), width_(scene.width), height_(scene.height), depth_(std::move(depth)) {}
    /// Colour as a track of its own, which begins so many seconds before depth does.
    void add_colour(std::unique_ptr<VideoFile> colour, double late) {
        colour_ = std::move(colour);
        colour_late_ = late;
    }
    /// The codes for black and white in depth's first picture.
    Result<CodeRange> code_range();

    std::string where(PlaneRole role, std::int64_t frame) const override {
        const bool is_own = role == PlaneRole::colour && colour_;
        return is_own ? colour_->where(picture_number(role, frame)) : depth_->where(frame);
    }
    Result<TrackPicture> picture(PlaneRole role, std::int64_t frame) override;
    /// Of colour in a track of its own, what is nearest in time.
    std::int64_t picture_number(PlaneRole role, std::int64_t frame) const override {
        const bool is_own = role == PlaneRole::colour && colour_;
        return is_own ? colour_->nearest(depth_->seconds(frame) + colour_late_) : frame;
    }
    std::int64_t access_point(std::int64_t frame) const override { return depth_->access_point(frame); }

private:
    static Result<VideoPicture> read(VideoFile& video, std::int64_t number, RgbConverter& converter);
    Result<VideoPicture*> read_depth(std::int64_t frame);
    int bar_of(int width, int height) const;

    VideoSource source_;
    int width_, height_;  // of depth
    std::shared_ptr<VideoFile> depth_;
    std::unique_ptr<VideoFile> colour_;
    RgbConverter depth_converter_, colour_converter_;
    double colour_late_ = 0;
    std::optional<VideoPicture> newest_;  // of depth
    std::int64_t newest_number_ = -1;
};

Result<VideoPicture> VideoPictures::read(VideoFile& video, std::int64_t number, RgbConverter& converter) {
    TRY(video.seek(number));
    TRY_ASSIGN(auto frame, video.next());
    return VideoPicture(std::move(frame), converter, video.where(number));
}

/// Once for both planes that may be in it.
Result<VideoPicture*> VideoPictures::read_depth(std::int64_t frame) {
    if (newest_number_ != frame) {
        newest_number_ = -1;
        newest_.reset();
        TRY_ASSIGN(auto picture, read(*depth_, frame, depth_converter_));
        newest_.emplace(std::move(picture));
        newest_number_ = frame;
    }
    return &*newest_;
}

Result<CodeRange> VideoPictures::code_range() {
    TRY_ASSIGN(const auto first, read_depth(0));
    return first->code_range(source_.values);
}

/// Between two parts that are less than halves.
int VideoPictures::bar_of(int width, int height) const {
    const bool is_beside = source_.layout == VideoLayout::left || source_.layout == VideoLayout::right;
    const int side = is_beside ? width : height, bar = side - 2 * (is_beside ? width_ : height_);
    return may_be_bar(bar, side) ? bar : 0;
}

Result<TrackPicture> VideoPictures::picture(PlaneRole role, std::int64_t frame) {
    if (role == PlaneRole::colour && colour_) {
        TRY_ASSIGN(auto picture, read(*colour_, picture_number(role, frame), colour_converter_));
        TRY_ASSIGN(auto rgb, picture.rgb());
        return lent_picture(colour_->info(), std::move(rgb));
    }
    TRY_ASSIGN(const auto picture, read_depth(frame));
    const int width = picture->width(), height = picture->height();
    const int bar = bar_of(width, height);
    const auto part = depth_part(source_.layout, width, height, bar);
    if (!part)
        return input_error(depth_->where(frame) + ": is " + std::to_string(width) + "x" +
                           std::to_string(height) +
                           ": does not divide into two halves, as video.layout says");
    const bool is_depth = role == PlaneRole::depth;
    TRY_ASSIGN(auto plane, is_depth ? picture->depth(source_.values, *part) : picture->rgb());
    if (!is_depth) plane.view = part_of(plane.view, colour_part(source_.layout, width, height, bar));
    TrackPicture made = lent_picture(depth_->info(), std::move(plane));
    // Values of colours that are luma and differences were changed before they were encoded.
    made.lossless =
        made.lossless && (source_.values == VideoValues::grey || made.image.pixel_format == "gbrp");
    return made;
}

/// The planes of the description belong to the codes for black and white. The coding's own are those of its
/// least and greatest code, evenly beyond.
Result<void> settle_relative(const CodeRange& range, const std::string& where, StoredClip& clip) {
    DepthCoding& depth = clip.described.scene.depth;
    const bool is_inverse = depth.kind == DepthCodingKind::inverse;
    const auto value = [&](double length) { return is_inverse ? 1 / length : length; };
    const double low = value(depth.near_is_high ? depth.far : depth.near),
                 high = value(depth.near_is_high ? depth.near : depth.far);
    const double step = (high - low) / (range.most - range.least);
    const double first = low - step * range.least, last = high + step * (depth.code_max - range.most);
    const CodeRange whole{0, depth.code_max};
    if (range != whole) {
        if (range.most > depth.code_max || !(first > 0) || !(last > 0))
            return input_error(where + ": has codes from " + std::to_string(range.least) + " to " +
                               std::to_string(range.most) +
                               ", on which depth.near, far, bits and code_max do not fit");
        (depth.near_is_high ? depth.far : depth.near) = value(first);
        (depth.near_is_high ? depth.near : depth.far) = value(last);
        clip.notes.push_back("depth is luma of the range " + std::to_string(range.least) + " to " +
                             std::to_string(range.most) + ": these are at the far and the near plane");
    }
    clip.described.scene.stored = {};
    derive_valid_range(depth);
    if (auto valid = validate(clip.described); !valid) return error_at(where, valid.error());
    return {};
}

/// `depth` is open.
Result<void> add_colour(const std::filesystem::path& folder, const VideoFile& depth, VideoPictures& pictures,
                        StoredClip& clip) {
    const VideoSource& source = *clip.described.scene.video;
    const bool is_one_file = source.colour == source.depth;
    clip.inputs.push_back(folder / source.colour);
    TRY_ASSIGN(auto opened, VideoFile::open(is_one_file ? depth.file() : SourceFile(clip.inputs.back()),
                                            PlaneRole::colour));
    const VideoFile& colour = *opened;
    if (colour.note()) clip.notes.push_back(*colour.note());
    if (!clip_tags::same_rate(colour.rate(), depth.rate()) || colour.count() != depth.count())
        clip.notes.push_back("colour has " + std::to_string(colour.count()) + " frames at " +
                             clip_tags::rate_text(colour.rate()) + " a second, depth " +
                             std::to_string(depth.count()) + " at " + clip_tags::rate_text(depth.rate()) +
                             ": each depth has the colour that is nearest in time");
    pictures.add_colour(std::move(opened), is_one_file ? depth.start() - colour.start() : 0);
    return {};
}

}  // namespace

bool begins_like_video(std::string_view begin) {
    if (begin.starts_with("\x1a\x45\xdf\xa3")) return true;
    if (begin.size() < 8) return false;
    if (begin.starts_with("RIFF")) return begin.substr(8).starts_with("AVI");
    const std::string_view box = begin.substr(4, 4);
    constexpr std::string_view boxes[] = {"ftyp", "moov", "mdat", "wide", "free", "skip", "pnot"};
    return std::find(std::begin(boxes), std::end(boxes), box) != std::end(boxes);
}

Result<std::unique_ptr<ClipReader>> open_video_clip(const std::filesystem::path& folder,
                                                    const SceneDescription& described, Colour colour,
                                                    std::shared_ptr<VideoFile> depth,
                                                    DepthAlignment alignment) {
    const VideoSource& source = *described.scene.video;
    const StoredDepth& stored = described.scene.stored;
    StoredClip clip{(folder / source.depth).string(), described};
    if (stored.kind == StoredDepth::Kind::disparity || stored.bytes_swapped || stored.rotated > 0)
        return input_error(
            clip.name +
            ": depth.coding disparity, depth.bytes and depth.rotated are of pictures in files, "
            "not of videos: must be linear, inverse, metric, hue, relative or relative-inverse");
    clip.inputs = {folder / source.depth};
    clip.alignment = alignment;
    if (!depth) {
        TRY_ASSIGN(auto opened, VideoFile::open(clip.inputs.front(), PlaneRole::depth));
        depth = std::move(opened);
    }
    clip.count = depth->count();
    clip.found.rate = depth->rate();
    if (depth->note()) clip.notes.push_back(*depth->note());
    if (!described.unstated.rate)
        if (auto note = clip_tags::rate_note(described.scene.rate, depth->rate()))
            clip.notes.push_back(std::move(*note));
    auto pictures = std::make_unique<VideoPictures>(source, described.scene, depth);
    if (!source.colour.empty()) TRY(add_colour(folder, *depth, *pictures, clip));
    if (stored.kind == StoredDepth::Kind::relative) {
        TRY_ASSIGN(const auto range, pictures->code_range());
        clip.has_no_scale = true;
        TRY(settle_relative(range, depth->where(0), clip));
    }
    clip.roles = {PlaneRole::depth};
    if (!source.colour.empty() || source.layout != VideoLayout::alone)
        clip.roles.push_back(PlaneRole::colour);
    clip.pictures = std::move(pictures);
    StillMaps maps;
    if (!source.haptic.empty()) maps.haptic = folder / source.haptic;
    if (!source.height.empty()) maps.height = folder / source.height;
    return with_still_maps(open_stored_clip(std::move(clip), colour), maps);
}

}  // namespace touchable
