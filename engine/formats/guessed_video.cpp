#include "engine/formats/guessed_video.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "engine/base/byte_source.hpp"
#include "engine/base/number_words.hpp"
#include "engine/base/try.hpp"
#include "engine/clip/video_file.hpp"
#include "engine/formats/camera_file.hpp"
#include "engine/formats/depth_in_video.hpp"
#include "engine/formats/depthkit_clip.hpp"
#include "engine/formats/lerobot_video.hpp"
#include "engine/formats/presets.hpp"
#include "engine/formats/video_picture.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

constexpr const char* otherwise = "a scene file's video.layout and values say otherwise";

/// What Record3D writes behind the pictures of its MP4: {"intrinsicMatrix": [nine numbers], ...}.
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

/// A video of the same name but for the word that says depth: walk.mp4 beside walk_depth.mp4, and
/// walk_src.mp4 beside walk_vis.mp4 as Video Depth Anything has them.
std::optional<std::string> colour_video_beside(const fs::path& depth) {
    const std::string stem = depth.stem().string();
    std::vector<std::string> stems;
    for (const char* word : {"_depths", "-depths", "_depth", "-depth", "_vis"})
        if (stem.size() > std::string_view(word).size() && stem.ends_with(word)) {
            const std::string rest = stem.substr(0, stem.size() - std::string_view(word).size());
            for (const char* colour : {"_src", "_rgb", "-rgb", "_color", "-color", "_colour", ""})
                stems.push_back(rest + colour);
        }
    if (stem.starts_with("depth_")) stems.push_back("rgb_" + stem.substr(6));
    if (stem == "depth") stems.insert(stems.end(), {"rgb", "color", "colour"});
    for (const std::string& other : stems)
        for (const std::string& extension :
             {depth.extension().string(), std::string(".mp4"), std::string(".mov"), std::string(".mkv"),
              std::string(".webm")}) {
            const fs::path file = depth.parent_path() / (other + extension);
            std::error_code ignored;
            if (fs::is_regular_file(file, ignored) && VideoFile::open(file, PlaneRole::colour).ok())
                return file.filename().string();
        }
    return {};
}

DepthCoding hue_coding(double near, double far) {
    constexpr int dark = 77;  // sum of three: three tenths of one channel
    DepthCoding coding;
    coding.kind = DepthCodingKind::hue;
    coding.semantics = DepthSemantics::planar;
    coding.near_is_high = false;
    coding.near = near;
    coding.far = far;
    coding.code_max = DepthCoding::hue_circle;
    coding.least_sum = dark;
    return coding;
}

/// z = 3 m x hue. Red, 0, is no depth.
DepthCoding record3d_coding() {
    constexpr double whole_circle = 3, practically_nothing = 1e-9;  // metres
    DepthCoding coding = hue_coding(practically_nothing, whole_circle);
    coding.invalid_code_count = 1;
    return coding;
}

/// Of a video with Record3D's camera at its end: the left half, which is hue unless it shows that it is not.
std::optional<DepthInVideo> record3d_depth(VideoPicture& picture, std::optional<VideoValues> said) {
    DepthInVideo depth{VideoLayout::left, VideoValues::hue};
    const auto part = depth_part(depth.layout, picture.width(), picture.height());
    if (part) depth.values = said.value_or(values_in(picture, *part).value_or(VideoValues::hue));
    return depth;
}

class VideoGuess {
public:
    VideoGuess(const SourceFile& file, const SourceDescription& known) : file_(file), known_(known) {}
    Result<GuessedScene> make();

private:
    Result<GuessedScene> of_hue(const PicturePart& part, const DepthCoding& coding) const;
    Result<GuessedScene> of_grey(VideoPicture& picture, const PicturePart& part);
    Result<GuessedScene> of_lerobot(const LeRobotDepth& depth, std::shared_ptr<VideoFile> video);
    void add_lerobot_colour(const LeRobotDepth& depth, const VideoFile& video, Scene& scene) const;
    Result<GuessedScene> described(const StoredImage& depth, const DepthCoding* coding = nullptr) const;
    Error refuse(const std::string& what) const { return input_error(file_.string() + ": " + what); }

    const SourceFile& file_;
    SourceDescription known_;
    VideoSource source_;
};

Result<GuessedScene> VideoGuess::described(const StoredImage& depth, const DepthCoding* coding) const {
    auto guessed = guess_scene(file_.path().parent_path(), depth, known_, coding);
    if (!guessed) return error_at(file_.string(), guessed.error());
    return guessed;
}

Result<GuessedScene> VideoGuess::of_hue(const PicturePart& part, const DepthCoding& coding) const {
    if (known_.metres_per_code)
        return usage_error(file_.string() +
                               ": a unit is of grey depth, and here depth is hue: a scene file's "
                               "depth.near and far say what hues stand for; leave the unit out",
                           {{Setting::depth_unit}});
    StoredImage size;
    size.image = {part.width, part.height, 1, 3, {}};
    return described(size, &coding);
}

/// Samples of up to 11 bits are guessed as those of 8 are: they are too few for lengths.
Result<GuessedScene> VideoGuess::of_grey(VideoPicture& picture, const PicturePart& part) {
    constexpr int fewest_of_lengths = 12;
    auto plane = picture.depth(source_.values, part);
    if (!plane && source_.values == VideoValues::grey) {
        source_.values = VideoValues::mean;
        plane = picture.depth(VideoValues::mean, part);
    }
    if (!plane) return plane.error();
    const int bits = source_.values == VideoValues::mean ? 8 : picture.bits(),
              bytes = bits < fewest_of_lengths ? 1 : 2;
    StoredImage stored;
    stored.bits = bits < fewest_of_lengths ? 8 : bits;
    stored.image = {part.width, part.height, bytes, 1, {}};
    for (int y = 0; y < part.height; ++y)
        for (int x = 0; x < part.width; ++x) {
            const auto code =
                static_cast<std::uint16_t>(plane->view.sample(x, y) >> (bytes == 1 ? bits - 8 : 0));
            const auto* bytes_of = reinterpret_cast<const std::uint8_t*>(&code);
            if (bytes == 1)
                stored.image.samples.push_back(static_cast<std::uint8_t>(code));
            else
                stored.image.samples.insert(stored.image.samples.end(), bytes_of, bytes_of + 2);
        }
    auto guessed = described(stored);
    if (!guessed) return guessed;
    Scene& scene = guessed->scene;
    scene.depth_bits = bits;
    scene.depth.code_max = static_cast<std::uint16_t>((1 << bits) - 1);
    if (guessed->unstated.far) scene.depth.far = scene.depth.scale * scene.depth.code_max;
    derive_valid_range(scene.depth);
    return guessed;
}

/// Videos of other lengths are of other episodes.
void VideoGuess::add_lerobot_colour(const LeRobotDepth& depth, const VideoFile& video, Scene& scene) const {
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

Result<GuessedScene> VideoGuess::of_lerobot(const LeRobotDepth& depth, std::shared_ptr<VideoFile> video) {
    StoredImage size;
    size.image = {video->info().width, video->info().height, 2, 1, {}};
    if (depth.camera && !known_.intrinsics && !known_.fov) known_.intrinsics = *depth.camera;
    auto guessed = described(size, &depth.coding);
    if (!guessed) return guessed;
    Scene& scene = guessed->scene;
    const DepthCoding& coding = depth.coding;
    scene.depth_bits = 12;
    scene.name = file_.path().stem().string();
    scene.rate = video->rate();
    scene.video = VideoSource{file_.path().filename().string(), "", VideoLayout::alone, VideoValues::grey};
    const std::string steps = coding.kind == DepthCodingKind::log
                                  ? "ln(depth + " + short_number(coding.shift) + " m)"
                                  : std::string("depth");
    const std::string what = "even steps of " + steps + " from " + short_number(coding.near) + " to " +
                             short_number(coding.far) + " m, 0 is no depth";
    const bool is_said = !depth.info.empty();
    if (is_said) guessed->inputs.push_back(depth.info);
    const Remark remark =
        is_said ? Remark{"depth is LeRobot's, as " + depth.info.filename().string() + " says: " + what}
                : Remark{"depth is as LeRobot usually stores it, as it is HEVC of 12 bits: " + what,
                         true,
                         "its data set's meta/info.json, beside the video or above it, says otherwise; where "
                         "codes are lengths, their unit",
                         {{Setting::depth_unit}}};
    scene.remarks = joined_remarks({remark}, scene.remarks);
    add_lerobot_colour(depth, *video, scene);
    guessed->video = std::move(video);
    return guessed;
}

Result<GuessedScene> VideoGuess::make() {
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
        return usage_error(
            file_.string() + ": has no colours, so its depth is grey: leave preset " + known_.preset + " out",
            {{Setting::preset}});
    if (said) known_.preset.clear();
    const auto camera = record3d_camera(file_);
    const bool is_disparity = video->is_disparity();
    if (is_disparity && known_.preset.empty() && !known_.metres_per_code) known_.preset = "relative-inverse";
    const auto found = is_disparity ? DepthInVideo{VideoLayout::alone, VideoValues::grey, 0}
                       : camera     ? record3d_depth(picture, said)
                                    : find_depth_in(picture, said);
    if (!found)
        return refuse("is a video in colour in which no depth was found: frame 0, " +
                      std::to_string(picture.width()) + "x" + std::to_string(picture.height()) +
                      ", has no grey half and is no map of hues; a preset says that it is hue, or the mean "
                      "of colours; a "
                      "scene file with \"video\" says where depth "
                      "is (docs/scene_file.md), then: touchable play SCENE.json; a Depthkit video needs " +
                      depthkit_metadata_name(file_.path()).string() + " beside it");
    const auto part = depth_part(found->layout, picture.width(), picture.height(), found->bar);
    if (!part) return refuse("is of odd width: Record3D's have two halves");
    const bool is_hue = found->values == VideoValues::hue;
    source_ = {file_.path().filename().string(), "", found->layout, found->values};
    if (camera && !known_.intrinsics && !known_.fov) known_.intrinsics = *camera;
    constexpr double assumed_near = 0.5, assumed_far = 1.5;  // metres, of hues from red to red
    auto guessed = is_hue ? of_hue(*part, camera ? record3d_coding() : hue_coding(assumed_near, assumed_far))
                          : of_grey(picture, *part);
    if (!guessed) return guessed;
    Scene& scene = guessed->scene;
    scene.name = file_.path().stem().string();
    scene.rate = video->rate();
    scene.video = source_;
    std::string what = is_disparity ? "depth is the disparity of a Cinematic video" : words_of(*found);
    if (camera && is_hue)
        what =
            "as Record3D exports it: depth is the left half, 3 m x hue, and the camera is what the file's "
            "end says";
    if (found->bar > 0)
        what += ", and " + std::to_string(found->bar) + " columns between them are of neither";
    if (is_disparity && video->has_other_pictures()) {
        scene.video->colour = scene.video->depth;
        what += ", colour is its other track";
    } else if (found->layout == VideoLayout::alone) {
        if (auto colour = colour_video_beside(file_.path())) {
            scene.video->colour = *colour;
            what = "colour is " + *colour + ", " + what.substr(0, what.find(" and has no colour"));
        }
    }
    const Hints values{{Setting::preset, "hue"}, {Setting::preset, "mean"}};
    scene.remarks =
        joined_remarks({{what, true, otherwise, picture.has_colours() ? values : Hints{}}}, scene.remarks);
    if (is_hue && !camera)
        add_remark(scene.remarks, {"red is 0.5 m and the whole circle of hues goes to 1.5 m", true,
                                   "a scene file's depth.near and far say otherwise, touchable init-scene "
                                   "writes one to begin with"});
    guessed->video = std::move(video);
    return guessed;
}

}  // namespace

Result<GuessedScene> guess_video(const SourceFile& file, const SourceDescription& known) {
    return VideoGuess(file, known).make();
}

}  // namespace touchable
