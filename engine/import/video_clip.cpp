#include "engine/import/video_clip.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "engine/clip/far_plane.hpp"
#include "engine/import/guess/number_words.hpp"
#include "engine/import/touch_maps/still_maps.hpp"
#include "engine/import/video_picture.hpp"
#include "engine/video/clip_tags.hpp"
#include "engine/video/codecs.hpp"

namespace touchable {
namespace {

std::string size_text(int width, int height) {
    return std::to_string(width) + "x" + std::to_string(height);
}

class VideoReader final : public ClipReader {
public:
    VideoReader(std::filesystem::path folder, SceneDescription described, std::shared_ptr<VideoFile> depth)
        : folder_(std::move(folder)),
          described_(std::move(described)),
          source_(*described_.scene.video),
          depth_(std::move(depth)) {}
    Result<void> open();
    bool leaves_far_open() const { return described_.unstated.far; }

    const Scene& scene() const override { return scene_; }
    UnstatedFilters unstated_filters() const override { return described_.unstated.filters; }
    const std::vector<TrackInfo>& tracks() const override { return infos_; }
    std::optional<std::int64_t> frame_count() const override { return depth_->count(); }
    const std::vector<std::string>& notes() const override { return notes_; }
    Result<std::optional<RawFrame>> next() override;
    Result<void> rewind() override { return seek(0); }
    Result<void> seek(std::int64_t frame) override;
    std::int64_t access_point(std::int64_t frame) const override { return depth_->access_point(frame); }
    void leave_out_colour() override { with_colour_ = false; }

private:
    Result<void> open_files();
    Result<void> read_first();
    Result<void> settle_relative(const CodeRange& range);
    void add_notes(const RawFrame& first);
    Result<VideoPicture> picture(VideoFile& video, RgbConverter& converter);
    Result<Plane> depth_of(VideoPicture& picture, std::int64_t frame) const;
    Result<Plane> colour_beside(std::int64_t frame);
    bool has_colour() const { return colour_ != nullptr || source_.layout != VideoLayout::alone; }

    std::filesystem::path folder_;
    const SceneDescription described_;
    Scene scene_;
    const VideoSource& source_;
    std::vector<TrackInfo> infos_;
    std::vector<std::string> notes_;
    std::shared_ptr<VideoFile> depth_, colour_;  // colour_: where it is a track of its own
    RgbConverter depth_converter_, colour_converter_;
    double colour_late_ = 0;  // seconds from colour's first frame to depth's, where one file has both
    bool with_colour_ = true;
    std::int64_t number_ = 0;            // of the frame that `next` gives
    std::int64_t colour_number_ = 0;     // of the colour file, that it gives next
    std::optional<Plane> colour_plane_;  // the last that it gave
    std::optional<RawFrame> first_;      // read to learn how frames are stored, not yet given away
};

Result<void> VideoReader::open() {
    const StoredDepth& stored = described_.scene.stored;
    if (stored.kind == StoredDepth::Kind::disparity || stored.bytes_swapped || stored.rotated > 0)
        return input_error(
            (folder_ / source_.depth).string() +
            ": depth.coding disparity, depth.bytes and depth.rotated are of pictures in files, "
            "not of videos: must be linear, inverse, metric, hue, relative or relative-inverse");
    if (auto opened = open_files(); !opened) return opened;
    if (auto read = read_first(); !read) return read;
    return {};
}

Result<void> VideoReader::open_files() {
    add_input(folder_ / source_.depth);
    if (!depth_) {
        auto depth = VideoFile::open(folder_ / source_.depth, PlaneRole::depth);
        if (!depth) return depth.error();
        depth_ = std::move(*depth);
    } else if (auto begun = depth_->seek(0); !begun) {
        return begun;
    }
    if (depth_->note()) notes_.push_back(*depth_->note());
    auto scene = settle(described_, {.rate = depth_->rate()});
    if (!scene) return input_error((folder_ / source_.depth).string() + ": " + scene.error().message);
    scene_ = std::move(*scene);
    if (!described_.unstated.rate)
        if (auto note = clip_tags::rate_note(scene_.rate, depth_->rate())) notes_.push_back(std::move(*note));
    if (source_.colour.empty()) return {};
    const bool is_one_file = source_.colour == source_.depth;
    add_input(folder_ / source_.colour);
    auto colour = VideoFile::open(is_one_file ? depth_->file() : SourceFile(folder_ / source_.colour),
                                  PlaneRole::colour);
    if (!colour) return colour.error();
    colour_ = std::move(*colour);
    if (is_one_file) colour_late_ = depth_->start() - colour_->start();
    if (colour_->note()) notes_.push_back(*colour_->note());
    if (!clip_tags::same_rate(colour_->rate(), depth_->rate()) || colour_->count() != depth_->count())
        notes_.push_back("colour has " + std::to_string(colour_->count()) + " frames at " +
                         clip_tags::rate_text(colour_->rate()) + " a second, depth " +
                         std::to_string(depth_->count()) + " at " + clip_tags::rate_text(depth_->rate()) +
                         ": each depth has the colour that is nearest in time");
    return {};
}

Result<VideoPicture> VideoReader::picture(VideoFile& video, RgbConverter& converter) {
    const std::string where = video.where(&video == depth_.get() ? number_ : colour_number_);
    auto frame = video.next();
    if (!frame) return frame.error();
    if (!*frame) return input_error(where + ": is beyond the last");
    return VideoPicture(std::move(*frame), converter, where);
}

/// How frame 0 is stored stands for all.
Result<void> VideoReader::read_first() {
    auto first = picture(*depth_, depth_converter_);
    if (!first) return first.error();
    if (scene_.stored.kind == StoredDepth::Kind::relative)
        if (auto settled = settle_relative(first->code_range(source_.values)); !settled) return settled;
    if (auto back = rewind(); !back) return back;
    auto frame = next();
    if (!frame) return frame.error();
    const auto add_info = [&](PlaneRole role, const TrackInfo& stored, const PicturePart& part) {
        infos_.push_back(
            {std::string(role_name(role)), stored.codec, stored.pixel_format, part.width, part.height});
        if (role != PlaneRole::depth && (part.width != scene_.width || part.height != scene_.height))
            notes_.push_back(resampling_note(role, part.width, part.height, scene_));
    };
    const int width = first->width(), height = first->height();
    add_info(PlaneRole::depth, depth_->info(), *depth_part(source_.layout, width, height));
    if (colour_)
        add_info(PlaneRole::colour, colour_->info(), {0, 0, colour_->info().width, colour_->info().height});
    else if (has_colour())
        add_info(PlaneRole::colour, depth_->info(), colour_part(source_.layout, width, height));
    add_notes(**frame);
    first_ = std::move(*frame);
    return {};
}

void VideoReader::add_notes(const RawFrame& first) {
    for (auto& note : {default_touch_note(false, scene_), lossy_note(PlaneRole::depth, depth_->info().codec),
                       no_depth_note(first, scene_.depth)})
        if (note) notes_.push_back(*note);
}

/// The planes of the scene belong to the codes for black and white. The coding's own are those of its least
/// and greatest code, evenly beyond.
Result<void> VideoReader::settle_relative(const CodeRange& range) {
    DepthCoding& depth = scene_.depth;
    const bool is_inverse = depth.kind == DepthCodingKind::inverse;
    const auto value = [&](double length) { return is_inverse ? 1 / length : length; };
    const double low = value(depth.near_is_high ? depth.far : depth.near),
                 high = value(depth.near_is_high ? depth.near : depth.far);
    const double step = (high - low) / (range.most - range.least);
    const double first = low - step * range.least, last = high + step * (depth.code_max - range.most);
    const CodeRange whole{0, depth.code_max};
    if (range != whole) {
        if (range.most > depth.code_max || !(first > 0) || !(last > 0))
            return input_error(depth_->where(0) + ": has codes from " + std::to_string(range.least) + " to " +
                               std::to_string(range.most) +
                               ", on which depth.near, far, bits and code_max do not fit");
        (depth.near_is_high ? depth.far : depth.near) = value(first);
        (depth.near_is_high ? depth.near : depth.far) = value(last);
        notes_.push_back("depth is luma of the range " + std::to_string(range.least) + " to " +
                         std::to_string(range.most) + ": these are at the far and the near plane");
    }
    scene_.stored = {};
    derive_valid_range(depth);
    if (auto valid = validate(scene_); !valid)
        return input_error(depth_->where(0) + ": " + valid.error().message);
    return {};
}

Result<Plane> VideoReader::depth_of(VideoPicture& picture, std::int64_t frame) const {
    const auto part = depth_part(source_.layout, picture.width(), picture.height());
    if (!part)
        return input_error(depth_->where(frame) + ": is " + size_text(picture.width(), picture.height()) +
                           ": does not divide into two halves, as video.layout says");
    auto plane = picture.depth(source_.values, *part);
    if (!plane) return plane.error();
    return fit_plane(PlaneRole::depth, std::move(*plane), scene_, depth_->where(frame));
}

/// Of the colour file, what is nearest to a depth frame in time.
Result<Plane> VideoReader::colour_beside(std::int64_t frame) {
    const std::int64_t wanted = colour_->nearest(depth_->seconds(frame) + colour_late_);
    if (colour_plane_ && colour_number_ == wanted + 1) return *colour_plane_;
    if (auto there = colour_->seek(wanted); !there) return there.error();
    colour_number_ = wanted;
    auto read = picture(*colour_, colour_converter_);
    if (!read) return read.error();
    auto rgb = read->rgb();
    if (!rgb) return rgb.error();
    auto fitted = fit_plane(PlaneRole::colour, std::move(*rgb), scene_, colour_->where(wanted));
    if (!fitted) return fitted.error();
    colour_number_ = wanted + 1;
    colour_plane_ = *fitted;
    return fitted;
}

Result<void> VideoReader::seek(std::int64_t frame) {
    if (auto there = depth_->seek(frame); !there) return there;
    number_ = frame;
    first_.reset();
    return {};
}

Result<std::optional<RawFrame>> VideoReader::next() {
    if (first_) return std::exchange(first_, std::nullopt);
    if (number_ == depth_->count()) return std::optional<RawFrame>{};
    RawFrame frame;
    frame.number = number_;
    frame.time_ns = scene_.rate.time_ns(number_);
    auto read = picture(*depth_, depth_converter_);
    if (!read) return read.error();
    auto depth = depth_of(*read, number_);
    if (!depth) return depth.error();
    add_plane(frame, PlaneRole::depth, std::move(*depth));
    if (with_colour_ && has_colour()) {
        Result<Plane> colour = Error{};
        if (colour_) {
            colour = colour_beside(number_);
        } else if (auto rgb = read->rgb(); rgb) {
            rgb->view = part_of(rgb->view, colour_part(source_.layout, read->width(), read->height()));
            colour = fit_plane(PlaneRole::colour, std::move(*rgb), scene_, depth_->where(number_));
        } else {
            colour = rgb.error();
        }
        if (!colour) return colour.error();
        add_plane(frame, PlaneRole::colour, std::move(*colour));
    }
    ++number_;
    return std::optional(std::move(frame));
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
                                                    std::shared_ptr<VideoFile> depth) {
    auto reader = std::make_unique<VideoReader>(folder, described, std::move(depth));
    if (auto opened = reader->open(); !opened) return opened.error();
    StillMaps maps;
    const VideoSource& source = *described.scene.video;
    if (!source.haptic.empty()) maps.haptic = folder / source.haptic;
    if (!source.height.empty()) maps.height = folder / source.height;
    if (colour == Colour::left_out) reader->leave_out_colour();
    const bool far_is_open = reader->leaves_far_open();
    return with_still_maps(with_far_plane(std::move(reader), far_is_open, folder / source.depth), maps);
}

}  // namespace touchable
