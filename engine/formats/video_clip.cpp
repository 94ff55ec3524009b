// SPDX-License-Identifier: Apache-2.0
// VideoGuess guesses the scene of a video without a scene file by its first picture; VideoPictures reads what
// a scene's VideoSource names.

#include "engine/formats/formats_read.hpp"

#include <algorithm>

#include "engine/base/files.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/containers.hpp"
#include "engine/formats/camera_sidecar.hpp"
#include "engine/formats/colour_video.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/formats/source_description.hpp"
#include "engine/formats/stored_clip.hpp"
#include "engine/formats/video_picture.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

constexpr const char* otherwise = "a scene file's video.layout and values say otherwise";

/// The camera that Record3D writes at the end of its MP4: {"intrinsicMatrix": [nine numbers], ...}.
std::optional<Intrinsics> record3d_camera(const SourceFile& file) {
    constexpr std::uint64_t longest = 1 << 16;
    const auto bytes = bytes_of_file(file);
    const std::uint64_t length = bytes ? (*bytes)->size() : 0;
    std::string tail(static_cast<std::size_t>(std::min(length, longest)), '\0');
    if (!bytes || !(*bytes)->read(length - tail.size(), tail.data(), tail.size())) return {};
    const auto named = tail.rfind("\"intrinsicMatrix\"");
    const auto begin = named == std::string::npos ? named : tail.rfind('{', named);
    const auto end = tail.rfind('}');
    if (begin == std::string::npos || end == std::string::npos || end < named) return {};
    return intrinsics_in_json(tail.substr(begin, end + 1 - begin));
}

DepthCoding hue_coding(double near, double far) {
    constexpr int dark = 77;  // sum of three: three tenths of one channel
    return {.kind = DepthCodingKind::hue,
            .semantics = DepthSemantics::planar,
            .near_is_high = false,
            .near = near,
            .far = far,
            .code_max = DepthCoding::hue_circle,
            .least_sum = dark};
}

/// z = 3 m x hue. Red, 0, is no depth.
DepthCoding record3d_coding() {
    constexpr double whole_circle = 3, practically_nothing = 1e-9;  // metres
    DepthCoding coding = hue_coding(practically_nothing, whole_circle);
    coding.invalid_code_count = 1;
    return coding;
}

/// Depth in a video with Record3D's camera at its end: the left half, as hue unless its look differs.
std::optional<DepthInVideo> record3d_depth(VideoPicture& picture, std::optional<VideoValues> said) {
    DepthInVideo depth{VideoLayout::left, VideoValues::hue};
    const auto part = depth_part(depth.layout, picture.width(), picture.height());
    if (part) depth.values = said.value_or(values_in(picture, *part).value_or(VideoValues::hue));
    return depth;
}

class VideoGuess {
public:
    VideoGuess(const SourceFile& file, const SourceDescription& known) : file_(file), known_(known) {}

    Result<GuessedScene> make() {
        TRY_ASSIGN(auto video, VideoFile::open(file_, PlaneRole::depth));
        TRY_ASSIGN(auto frame, video->next());
        if (!frame) return refuse("has no frames");
        if (!known_.metres_per_code && known_.preset.empty()) {
            const TrackInfo info = video->info();
            TRY_ASSIGN(const auto lerobot, find_lerobot_depth(file_, info.codec, info.pixel_format));
            if (lerobot) return of_lerobot(*lerobot, std::move(video));
        }
        RgbConverter converter;
        VideoPicture picture(std::move(frame), converter, video->where(0));
        const auto said = video_values_named(known_.preset);
        if (said && !picture.has_colours())
            return usage_error(file_.string() + ": has no colours, so its depth is grey: leave preset " +
                                   known_.preset + " out",
                               {{Setting::preset}});
        if (said) known_.preset.clear();
        const auto camera = record3d_camera(file_);
        const bool is_disparity = video->is_disparity();
        if (is_disparity && known_.preset.empty() && !known_.metres_per_code)
            known_.preset = "relative-inverse";
        const auto found = is_disparity ? DepthInVideo{VideoLayout::alone, VideoValues::grey, 0}
                           : camera     ? record3d_depth(picture, said)
                                        : find_depth_in(picture, said);
        if (!found)
            return refuse(
                "is a video in colour in which no depth was found: frame 0, " +
                size_text(picture.width(), picture.height()) +
                ", has no grey half and is no map of hues; a preset says that it is hue, or the mean "
                "of colours; a "
                "scene file with \"video\" says where depth "
                "is (docs/scene_file.md), then: touchable play SCENE.json; a Depthkit video needs " +
                depthkit_metadata_name(file_.path()).string() + " beside it");
        const auto part = depth_part(found->layout, picture.width(), picture.height(), found->bar);
        if (!part) return refuse("is of odd width: Record3D's have two halves");
        const bool is_hue = found->values == VideoValues::hue;
        if (is_hue && values_in(picture, *part) == VideoValues::grey)
            return usage_error(file_.string() +
                                   ": is grey in three channels, and its hues are noise: leave "
                                   "preset hue out",
                               {{Setting::preset}});
        source_ = {file_.path().filename().string(), "", found->layout, found->values};
        is_lossless_ = video->info().lossless;
        if (camera && !known_.intrinsics && !known_.fov) known_.intrinsics = *camera;
        TRY_ASSIGN(auto guessed,
                   is_hue ? of_hue(*part, camera ? record3d_coding() : hue_coding(assumed_near, assumed_far))
                          : of_grey(picture, *part));
        Scene& scene = guessed.scene;
        scene.rate = video->rate();
        scene.video = source_;
        std::string what = is_disparity ? "depth is the disparity of a Cinematic video" : words_of(*found);
        if (camera && is_hue)
            what =
                "as Record3D exports it: depth is the left half, 3 m x hue, and the camera is what the "
                "file's "
                "end says";
        if (found->bar > 0)
            what += ", and " + std::to_string(found->bar) + " columns between them are of neither";
        if (is_disparity && video->has_other_pictures()) {
            scene.video->colour = scene.video->depth;
            what += ", colour is its other track";
        } else if (found->layout == VideoLayout::alone && has_colour_track(*video)) {
            scene.video->colour = scene.video->depth;
            what = "colour is another track of the file, " + what;
        } else if (found->layout == VideoLayout::alone) {
            if (auto colour = colour_video_beside(file_.path())) {
                scene.video->colour = colour->name;
                what = "colour is " + colour->name + ", " + what;
            } else if (!is_disparity) {
                what += " and has no colour beside it";
            }
        }
        const Hints values{{Setting::preset, "hue"}, {Setting::preset, "mean"}};
        scene.remarks = joined_remarks({{what, true, otherwise, picture.has_colours() ? values : Hints{}}},
                                       scene.remarks);
        if (is_hue && !camera)
            add_remark(scene.remarks,
                       {"red is 0.5 m and the whole circle of hues goes to 1.5 m",
                        true,
                        "a scene file's depth.near and far say otherwise, touchable init-scene "
                        "writes one to begin with",
                        {},
                        RemarkKind::scale});
        guessed.video = std::move(video);
        return guessed;
    }

private:
    Result<GuessedScene> of_hue(const PicturePart& part, const DepthCoding& coding) const {
        if (known_.metres_per_code)
            return usage_error(file_.string() +
                                   ": a unit is of grey depth, and here depth is hue: a scene file's "
                                   "depth.near and far say what hues stand for; leave the unit out",
                               {{Setting::depth_unit}});
        StoredImage size;
        size.image = {part.width, part.height, 1, 3, {}};
        return guess_scene(file_.path(), size, known_, &coding);
    }

    /// Samples of up to 11 bits are treated as 8-bit ones: so few bits are no lengths.
    Result<GuessedScene> of_grey(VideoPicture& picture, const PicturePart& part) {
        constexpr int fewest_of_lengths = 12;
        TRY_ASSIGN(const auto plane, picture.depth(source_.values, part));
        const int bits = source_.values == VideoValues::mean ? 8 : picture.bits();
        StoredImage stored;
        stored.bits = bits < fewest_of_lengths ? 8 : bits;
        stored.image = packed_image(plane.view);
        if (bits > stored.bits) {
            stored.image = {part.width, part.height, 1, 1, {}};
            for (int y = 0; y < part.height; ++y)
                for (int x = 0; x < part.width; ++x)
                    stored.image.samples.push_back(
                        static_cast<std::uint8_t>(plane.view.sample(x, y) >> (bits - 8)));
        }
        // Codecs and means of colours move black by a few codes: it stays black, and what it means.
        constexpr std::uint8_t last_black = DepthCoding::max_invalid_codes - 1;
        const bool is_black_moved = bits == 8 && (source_.values == VideoValues::mean || !is_lossless_);
        for (std::uint8_t& code : stored.image.samples)
            if (is_black_moved && code <= last_black) code = 0;
        TRY_ASSIGN(auto guessed, guess_scene(file_.path(), stored, known_));
        Scene& scene = guessed.scene;
        scene.depth_bits = bits;
        scene.depth.code_max = static_cast<std::uint16_t>((1 << bits) - 1);
        if (is_black_moved && !scene.depth.is_valid(0)) {
            if (scene.depth.invalid_code_count == 1) {
                scene.depth.invalid_codes = {0, 1, 2, last_black};
                scene.depth.invalid_code_count = DepthCoding::max_invalid_codes;
            } else if (scene.depth.kind == DepthCodingKind::metric) {  // the codes are given to others
                scene.depth.near = std::max(scene.depth.near, scene.depth.scale * (last_black + 1));
            }
        }
        if (guessed.unstated.far) scene.depth.far = scene.depth.scale * scene.depth.code_max;
        derive_valid_range(scene.depth);
        return guessed;
    }

    Result<GuessedScene> of_lerobot(const LeRobotDepth& depth, std::shared_ptr<VideoFile> video) {
        StoredImage size;
        size.image = {video->info().width, video->info().height, 2, 1, {}};
        if (depth.camera && !known_.intrinsics && !known_.fov) known_.intrinsics = *depth.camera;
        TRY_ASSIGN(auto guessed, guess_scene(file_.path(), size, known_, &depth.coding));
        Scene& scene = guessed.scene;
        const DepthCoding& coding = depth.coding;
        scene.depth_bits = 12;
        scene.rate = video->rate();
        scene.video =
            VideoSource{file_.path().filename().string(), "", VideoLayout::alone, VideoValues::grey};
        const std::string steps = coding.kind == DepthCodingKind::log
                                      ? "ln(depth + " + short_number(coding.shift) + " m)"
                                      : std::string("depth");
        const std::string what = "even steps of " + steps + " from " + short_number(coding.near) + " to " +
                                 short_number(coding.far) + " m, 0 is no depth";
        const bool is_said = !depth.info.empty();
        if (is_said) guessed.inputs.push_back(depth.info);
        const Remark remark =
            is_said
                ? Remark{"depth is LeRobot's, as " + depth.info.filename().string() + " says: " + what}
                : Remark{"depth is as LeRobot usually stores it, as it is HEVC of 12 bits: " + what,
                         true,
                         "its data set's meta/info.json, beside the video or above it, says otherwise; where "
                         "codes are lengths, their unit",
                         {{Setting::depth_unit, "0.001"}},
                         RemarkKind::scale};
        scene.remarks = joined_remarks({remark}, scene.remarks);
        add_lerobot_colour(depth, *video, scene);
        guessed.video = std::move(video);
        return guessed;
    }

    /// Adds colour to the scene; a video of another length is of other episodes, and left out.
    void add_lerobot_colour(const LeRobotDepth& depth, const VideoFile& video, Scene& scene) const {
        if (depth.colour.empty()) return;
        const auto colour = VideoFile::open(file_.path().parent_path() / depth.colour, PlaneRole::colour);
        if (colour && (*colour)->count() == video.count()) {
            scene.video->colour = depth.colour.string();
            add_remark(scene.remarks, {"colour is " + depth.colour.string(), true, otherwise});
        } else {
            add_remark(scene.remarks, {depth.colour.string() + " has " +
                                       (colour ? std::to_string((*colour)->count()) : std::string("no")) +
                                       " frames and depth " + std::to_string(video.count()) +
                                       ": it is left out, as they are not of the same episodes"});
        }
    }

    /// Whether the file has, beside depth's track, one in colour.
    bool has_colour_track(const VideoFile& depth) const {
        auto other = VideoFile::open(file_, PlaneRole::colour);
        if (!other || (*other)->stream() == depth.stream()) return false;
        RgbConverter converter;
        const auto first = picture_at(**other, 0, converter);
        return first && first->has_colours();
    }

    Error refuse(const std::string& what) const { return input_error(file_.string() + ": " + what); }

    const SourceFile& file_;
    SourceDescription known_;
    VideoSource source_;
    bool is_lossless_ = true;
};

/// Reads depth in a track of one file, and colour in the same pictures or in a track of its own.
class VideoPictures final : public FrameSource {
public:
    /// `depth_size`: of depth's part, which tells if there is a bar between both; 0: there is none.
    VideoPictures(const VideoSource& source, PictureSize depth_size, std::shared_ptr<VideoFile> depth)
        : source_(source), depth_size_(depth_size), depth_(std::move(depth)) {}
    /// Adds colour in a track of its own, which begins `late` seconds before depth.
    void add_colour(std::unique_ptr<VideoFile> colour, double late) {
        colour_ = std::move(colour);
        colour_late_ = late;
    }
    /// The codes for black and white in depth's first picture.
    Result<CodeRange> code_range() {
        TRY_ASSIGN(const auto first, read_depth(0));
        return first->code_range(source_.values);
    }
    /// Adds a remark if depth is said to be hue and frame 0 is grey.
    void doubt_hue(std::vector<ClipNote>& notes) {
        if (source_.values != VideoValues::hue) return;
        const auto first = read_depth(0);
        if (!first) return;
        const int width = (*first)->width(), height = (*first)->height();
        const auto part = depth_part(source_.layout, width, height, bar_of(width, height));
        if (part && values_in(**first, *part) == VideoValues::grey)
            notes.emplace_back(
                "depth is said to be hue, but frame 0 is grey in three channels: its hues are noise");
    }

    std::string where(PlaneRole role, std::int64_t frame) const override {
        const bool is_own = role == PlaneRole::colour && colour_;
        return is_own ? colour_->where(picture_number(role, frame)) : depth_->where(frame);
    }

    Result<TrackPicture> picture(PlaneRole role, std::int64_t frame) override {
        if (role == PlaneRole::colour && colour_) {
            TRY_ASSIGN(auto picture, picture_at(*colour_, picture_number(role, frame), colour_converter_));
            TRY_ASSIGN(auto rgb, picture.rgb());
            return lent_picture(colour_->info(), std::move(rgb));
        }
        TRY_ASSIGN(const auto picture, read_depth(frame));
        const int width = picture->width(), height = picture->height();
        const int bar = bar_of(width, height);
        const auto part = depth_part(source_.layout, width, height, bar);
        if (!part)
            return input_error(depth_->where(frame) + ": is " + size_text(width, height) +
                               ": does not divide into two halves, as video.layout says");
        const bool is_depth = role == PlaneRole::depth;
        TRY_ASSIGN(auto plane, is_depth ? picture->depth(source_.values, *part) : picture->rgb());
        if (!is_depth) plane.view = part_of(plane.view, colour_part(source_.layout, width, height, bar));
        TrackPicture made = lent_picture(depth_->info(), std::move(plane));
        // In pictures of luma and colour differences, hue and mean were changed before encoding.
        made.lossless =
            made.lossless && (source_.values == VideoValues::grey || made.image.pixel_format == "gbrp");
        return made;
    }

    /// For colour in a track of its own, the picture nearest in time.
    std::int64_t picture_number(PlaneRole role, std::int64_t frame) const override {
        const bool is_own = role == PlaneRole::colour && colour_;
        return is_own ? colour_->nearest(depth_->seconds(frame) + colour_late_) : frame;
    }
    std::int64_t access_point(std::int64_t frame) const override { return depth_->access_point(frame); }

private:
    /// Reads a picture once for both planes that may be in it.
    Result<VideoPicture*> read_depth(std::int64_t frame) {
        if (newest_number_ != frame) {
            newest_number_ = -1;
            newest_.reset();
            TRY_ASSIGN(auto picture, picture_at(*depth_, frame, depth_converter_));
            newest_.emplace(std::move(picture));
            newest_number_ = frame;
        }
        return &*newest_;
    }

    /// The bar between two parts that are less than halves; 0: none.
    int bar_of(int width, int height) const {
        const bool is_beside = is_side_by_side(source_.layout);
        const int side = is_beside ? width : height;
        const int bar = side - 2 * (is_beside ? depth_size_.width : depth_size_.height);
        return may_be_bar(bar, side) ? bar : 0;
    }

    VideoSource source_;
    PictureSize depth_size_;
    std::shared_ptr<VideoFile> depth_;
    std::unique_ptr<VideoFile> colour_;
    RgbConverter depth_converter_, colour_converter_;
    double colour_late_ = 0;
    std::optional<VideoPicture> newest_;  // of depth
    std::int64_t newest_number_ = -1;
};

/// The description's planes are those of the codes for black and white. Moves them, evenly, to the coding's
/// least and greatest code.
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
    return error_at(where, validate(clip.described));
}

/// Opens the scene's colour video; `depth` is open already.
Result<void> add_colour(const fs::path& folder, const VideoFile& depth, VideoPictures& pictures,
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

Result<GuessedScene> guess_video(const SourceFile& file, const SourceDescription& known) {
    return VideoGuess(file, known).make();
}

Opened open_videos(const fs::path& folder, const GuessedScene& described, Colour colour,
                   DepthAlignment alignment) {
    const VideoSource& source = *described.scene.video;
    const StoredDepth& stored = described.scene.stored;
    StoredClip clip{(folder / source.depth).string(), described};
    if (stored.kind == StoredDepth::Kind::disparity || stored.is_reordered() ||
        stored.packed != Packing::none)
        return input_error(
            clip.name +
            ": depth.coding disparity, depth.bytes, rotated, used_bits and packed are of pictures in files, "
            "not of videos: must be linear, inverse, metric, hue, relative or relative-inverse");
    clip.inputs = {folder / source.depth};
    clip.alignment = alignment;
    std::shared_ptr<VideoFile> depth = described.video;
    if (!depth) TRY(assign(depth, VideoFile::open(clip.inputs.front(), PlaneRole::depth)));
    clip.count = depth->count();
    clip.found.rate = depth->rate();
    if (depth->note()) clip.notes.push_back(*depth->note());
    if (!described.unstated.rate)
        if (auto note = clip_tags::rate_note(described.scene.rate, depth->rate()))
            clip.notes.push_back(std::move(*note));
    auto pictures = std::make_unique<VideoPictures>(
        source, PictureSize{described.scene.width, described.scene.height}, depth);
    if (!source.colour.empty()) TRY(add_colour(folder, *depth, *pictures, clip));
    if (stored.kind == StoredDepth::Kind::relative) {
        TRY_ASSIGN(const auto range, pictures->code_range());
        clip.has_no_scale = true;
        TRY(settle_relative(range, depth->where(0), clip));
    }
    clip.roles = {PlaneRole::depth};
    if (!source.colour.empty() || source.layout != VideoLayout::alone)
        clip.roles.push_back(PlaneRole::colour);
    pictures->doubt_hue(clip.notes);
    clip.pictures = std::move(pictures);
    StillMaps maps;
    if (!source.haptic.empty()) maps.haptic = folder / source.haptic;
    if (!source.height.empty()) maps.height = folder / source.height;
    return with_still_maps(open_stored_clip(std::move(clip), colour), maps);
}

std::shared_ptr<FrameSource> pictures_of_halves(const VideoSource& source, std::shared_ptr<VideoFile> video,
                                                std::vector<ClipNote>& notes) {
    auto pictures = std::make_shared<VideoPictures>(source, PictureSize(), std::move(video));
    pictures->doubt_hue(notes);
    return pictures;
}

}  // namespace touchable
