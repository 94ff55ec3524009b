// SPDX-License-Identifier: Apache-2.0
// LeRobot's depth: its codes, the description of its videos (info.json), and the writer of such a video.

#include "engine/formats/formats_read.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/containers.hpp"
#include "engine/formats/camera_sidecar.hpp"
#include "engine/formats/formats_written.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/formats/source_description.hpp"
#include "engine/scene/checked_json.hpp"
#include "engine/scene/frames.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

using checked_json::Json;
using OrderedJson = nlohmann::ordered_json;

constexpr std::uint16_t largest_lerobot_code = 4095;

/// LeRobot's codes of depth (lerobot 0.6, datasets/depth_utils.py), lengths in metres: 4095 even steps of
/// ln(depth + shift). Code 0 stands for pixels without depth; LeRobot reads it as its nearest depth.
DepthCoding lerobot_coding(double near = 0.01, double far = 10, double shift = 3.5) {
    DepthCoding coding{.kind = DepthCodingKind::log,
                       .semantics = DepthSemantics::planar,
                       .near_is_high = false,
                       .near = near,
                       .far = far,
                       .shift = shift,
                       .code_max = largest_lerobot_code,
                       .invalid_code_count = 1};
    derive_valid_range(coding);
    return coding;
}

/// The same with even steps of depth (`video.use_log` false).
DepthCoding lerobot_linear_coding(double near, double far) {
    DepthCoding coding = lerobot_coding(near, far, 0);
    coding.kind = near > 0 ? DepthCodingKind::linear : DepthCodingKind::metric;
    coding.scale = near > 0 ? 0 : far / coding.code_max;
    derive_valid_range(coding);
    return coding;
}

bool has_lerobot_codes(const Scene& scene) {
    const DepthCoding& depth = scene.depth;
    const bool is_of_it = depth.kind == DepthCodingKind::log || depth.kind == DepthCodingKind::linear;
    const bool is_from_0 = depth.kind == DepthCodingKind::metric && depth.near == 0 &&
                           depth.far == depth.depth(largest_lerobot_code);
    return (is_from_0 || (is_of_it && !depth.near_is_high)) && scene.depth_bits == 12 &&
           depth.code_max == largest_lerobot_code && depth.semantics == DepthSemantics::planar &&
           depth.invalid_code_count == 1 && depth.invalid_codes[0] == 0;
}

/// A member of `info`, or of `video_info` as older data sets call it, with or without "video." before its
/// name.
const Json* member_of(const Json& feature, const std::string& name) {
    for (const char* in : {"info", "video_info"}) {
        const auto info = feature.find(in);
        if (info == feature.end() || !info->is_object()) continue;
        for (const std::string& each : {"video." + name, name})
            if (const auto found = info->find(each); found != info->end()) return &*found;
    }
    return nullptr;
}

/// A member of "features", by its name.
using Feature = std::pair<std::string, Json>;

bool is_depth(const Feature& video) {
    const Json* const said = member_of(video.second, "is_depth_map");
    return said != nullptr && *said == true;
}

/// The features that are videos.
using Videos = std::vector<Feature>;
Videos videos_in(const Json& json) {
    Videos videos;
    const auto features = json.find("features");
    if (features == json.end() || !features->is_object()) return videos;
    for (const auto& [name, feature] : features->items())
        if (feature.is_object() && (feature.contains("info") || feature.contains("video_info")))
            videos.emplace_back(name, feature);
    return videos;
}

Result<double> number_of(const Json& feature, const char* name, double usual, const std::string& where) {
    const Json* const said = member_of(feature, name);
    if (said == nullptr) return usual;
    if (said->is_number() && std::isfinite(said->get<double>())) return said->get<double>();
    return input_error(where + ": video." + name + " is " + printable(said->dump(), 40) +
                       ": must be a number of metres");
}

Result<DepthCoding> coding_of(const Json& feature, const std::string& where) {
    const DepthCoding usual = lerobot_coding();
    TRY_ASSIGN(const auto near, number_of(feature, "depth_min", usual.near, where));
    TRY_ASSIGN(const auto far, number_of(feature, "depth_max", usual.far, where));
    TRY_ASSIGN(const auto shift, number_of(feature, "shift", usual.shift, where));
    const Json* const use_log = member_of(feature, "use_log");
    const bool is_log = use_log == nullptr || *use_log != false;
    if (!(near >= 0 && near < far && far < lerobot_horizon) || (is_log && !(near + shift > 0)))
        return input_error(where +
                           ": its depth_min, depth_max and shift are no range of depth: must be 0 <= "
                           "depth_min < depth_max < " +
                           short_number(lerobot_horizon) +
                           (is_log ? ", and depth_min + shift more than 0" : ""));
    return is_log ? lerobot_coding(near, far, shift) : lerobot_linear_coding(near, far);
}

/// Files that may describe a video, the nearest first.
std::vector<fs::path> descriptions_of(const fs::path& video) {
    std::vector<fs::path> files{lerobot_info_file(video)};
    std::error_code failure;
    fs::path folder = fs::absolute(video, failure).lexically_normal().parent_path();
    constexpr int folders_of_data_set = 4;  // videos/KEY/chunk-000, and the data set's own
    for (int up = 0; up < folders_of_data_set && !failure; ++up, folder = folder.parent_path())
        files.push_back(folder / "meta" / "info.json");
    return files;
}

bool is_in_path(const fs::path& video, const std::string& name) {
    std::error_code ignored;
    const fs::path whole = fs::absolute(video, ignored);
    return std::find(whole.begin(), whole.end(), name) != whole.end();
}

/// "observation.images.wrist" of "observation.images.wrist_depth".
std::string without_depth(std::string name) {
    for (const char* word : {"_depth", "depth_", ".depth", "depth."})
        if (const auto at = name.find(word); at != std::string::npos)
            name.erase(at, std::string_view(word).size());
    return name;
}

/// The colour video that lies in the data set as this depth video does: with the same name, or the only one.
fs::path colour_of(const fs::path& video, const std::string& depth, const Videos& videos) {
    std::vector<std::string> names;
    for (const Feature& each : videos)
        if (!is_depth(each)) names.push_back(each.first);
    const auto same = std::ranges::find(names, without_depth(depth));
    if (same != names.end()) names = {*same};
    if (names.size() != 1) return {};
    std::error_code ignored;
    const fs::path own = fs::absolute(video, ignored).lexically_normal();
    fs::path other;
    for (const fs::path& part : own) other /= part == depth ? fs::path(names.front()) : part;
    if (other == own || !is_file(other)) return {};
    return other.lexically_relative(own.parent_path());
}

/// The videos in a description; none if the file describes something else.
Result<Videos> read_videos(const fs::path& file) {
    constexpr std::size_t largest = std::size_t{16} << 20;
    TRY_ASSIGN(auto text, read_given_file(file, file.string(), "a LeRobot data set's description", largest));
    return checked_json::checked(file.string(),
                                 [&] { return videos_in(checked_json::parse(text, largest)); });
}

/// What a description says of this video; nothing if it does not describe it. `is_usual`: the video may be
/// the description's only one of depth, wherever it lies.
Result<std::optional<LeRobotDepth>> read_description(const fs::path& file, const fs::path& video,
                                                     bool is_usual) {
    TRY_ASSIGN(const Videos videos, read_videos(file));
    const auto find = [&](auto is_it) { return std::ranges::find_if(videos, is_it); };
    auto found = find([&](const auto& each) { return is_in_path(video, each.first); });
    const bool is_only = std::ranges::count_if(videos, is_depth) == 1;
    if (found == videos.end() && is_only && is_usual) found = find(is_depth);
    if (found == videos.end() || !is_depth(*found)) return std::optional<LeRobotDepth>{};
    TRY_ASSIGN(const auto coding, coding_of(found->second, file.string() + ": " + printable(found->first)));
    return std::optional(LeRobotDepth{coding, file, colour_of(video, found->first, videos),
                                      intrinsics_in_json(found->second.dump())});
}

class LeRobotWriter final : public MuxedClipWriter {
public:
    LeRobotWriter(const fs::path& path, const Scene& scene, Existing existing)
        : MuxedClipWriter(path, scene, {}, existing, "mp4"), info_(lerobot_info_file(path), existing) {}
    Result<void> finish() override {
        TRY(info_.write(description()));
        TRY(MuxedClipWriter::finish());
        return info_.commit();
    }

private:
    Result<void> add(const RawFrame& frame) override {
        if (!encoder_) TRY(begin());
        const FramePtr picture = blank_picture(AV_PIX_FMT_GRAY12, scene_.width, scene_.height);
        if (!picture) return memory_error();
        picture->color_range = AVCOL_RANGE_JPEG;
        frame.depth.copy_rows(picture->data[0], static_cast<std::size_t>(picture->linesize[0]));
        picture->pts = tick_of(frame.number);
        return send(picture.get());
    }

    Result<void> add_rest() override { return send(nullptr); }

    Result<void> begin() {
        const AVCodec* const codec = avcodec_find_encoder_by_name("libx265");
        if (!codec) return failed("this FFmpeg has none (libx265)");
        // A build of x265 may lack 8, 10 or 12 bits.
        if (!encodes(*codec, AV_PIX_FMT_GRAY12))
            return failed("this machine's libx265 was built without 12 bits (gray12le)");
        encoder_.reset(avcodec_alloc_context3(codec));
        AVStream* const stream = avformat_new_stream(muxer_.get(), nullptr);
        if (!encoder_ || !stream) return memory_error();
        encoder_->width = scene_.width;
        encoder_->height = scene_.height;
        encoder_->pix_fmt = AV_PIX_FMT_GRAY12;
        encoder_->color_range = AVCOL_RANGE_JPEG;
        encoder_->time_base = tick();
        encoder_->framerate = {static_cast<int>(scene_.rate.num), static_cast<int>(scene_.rate.den)};
        encoder_->flags |= AV_CODEC_FLAG_BITEXACT | AV_CODEC_FLAG_GLOBAL_HEADER;
        AVDictionary* options = nullptr;
        av_dict_set(&options, "x265-params", "lossless=1:bframes=0:keyint=30:log-level=none", 0);
        const int status = avcodec_open2(encoder_.get(), codec, &options);
        av_dict_free(&options);
        if (status < 0)
            return usage_error("pictures of " + size_text(scene_.width, scene_.height) +
                               " cannot be HEVC: " + ffmpeg_text(status));
        if (avcodec_parameters_from_context(stream->codecpar, encoder_.get()) < 0) return memory_error();
        stream->codecpar->codec_tag = MKTAG('h', 'v', 'c', '1');
        stream->id = 1;
        stream->time_base = tick();
        stream->avg_frame_rate = encoder_->framerate;
        return write_header();
    }

    Result<void> send(const AVFrame* picture) {
        int status = avcodec_send_frame(encoder_.get(), picture);
        while (status >= 0) {
            const PacketPtr packet(av_packet_alloc());
            if (!packet) return memory_error();
            status = avcodec_receive_packet(encoder_.get(), packet.get());
            if (status == AVERROR(EAGAIN) || status == AVERROR_EOF) return {};
            if (status < 0) break;
            TRY(write_picture(*packet, 0, tick()));
        }
        return failed(ffmpeg_text(status));
    }

    /// The description file, in metres as LeRobot's own.
    std::string description() const {
        const DepthCoding& depth = scene_.depth;
        const double metres = scene_.metres_per_unit;
        const bool is_log = depth.kind == DepthCodingKind::log;
        OrderedJson info;
        info["video.height"] = scene_.height;
        info["video.width"] = scene_.width;
        info["video.codec"] = "hevc";
        info["video.pix_fmt"] = "gray12le";
        info["is_depth_map"] = true;
        info["video.fps"] = scene_.rate.per_second();
        info["video.channels"] = 1;
        info["has_audio"] = false;
        info["video.depth_min"] = depth.near * metres;
        info["video.depth_max"] = depth.far * metres;
        info["video.shift"] = is_log ? depth.shift * metres : 3.5;
        info["video.use_log"] = is_log;
        const Camera& camera = scene_.camera;
        info["camera"] = {{"fx", camera.fx}, {"fy", camera.fy},       {"cx", camera.cx},
                          {"cy", camera.cy}, {"width", scene_.width}, {"height", scene_.height}};
        OrderedJson all;
        all["features"]["observation.images.depth"] = {{"dtype", "video"},
                                                       {"shape", {scene_.height, scene_.width, 1}},
                                                       {"names", {"height", "width", "channels"}},
                                                       {"info", info}};
        return all.dump(2) + "\n";
    }

    Error failed(const std::string& why) const {
        return internal_error(output_.target().string() + ": the encoder of HEVC: " + why);
    }

    NewFile info_;
    CodecPtr encoder_;
};

}  // namespace

LeRobotCodes::LeRobotCodes(const Scene& scene) : from_(scene), scene_(scene) {
    scene_.height_coding = {};
    are_kept_ = has_lerobot_codes(scene);
    if (are_kept_) return;
    const DepthCoding& stored = scene.depth;
    const DepthCoding usual = lerobot_coding();
    const double metres = scene.metres_per_unit;
    DepthCoding& depth = scene_.depth;
    depth = lerobot_coding(std::min(usual.near, stored.nearest_depth() * metres),
                           std::max(usual.far, stored.deepest_depth() * metres));
    const double units = 1 / metres;
    for (double* const length : {&depth.near, &depth.far, &depth.shift, &depth.scale}) *length *= units;
    derive_valid_range(depth);
    scene_.depth_bits = 12;
    table_.assign(65536, 0);
    for (int code = stored.valid_min; code <= stored.valid_max; ++code)
        if (const auto each = static_cast<std::uint16_t>(code); stored.is_valid(each))
            table_[each] = depth.code(stored.depth(each));
}

double LeRobotCodes::step_at_a_metre() const {
    const double metres = scene_.metres_per_unit;
    const int code = std::min<int>(scene_.depth.code(1 / metres), largest_lerobot_code - 1);
    const auto depth = [&](int of) { return metres * scene_.depth.depth(static_cast<std::uint16_t>(of)); };
    return depth(code + 1) - depth(code);
}

RawFrame LeRobotCodes::of(const RawFrame& frame) const {
    RawFrame made;
    made.number = frame.number;
    made.time_ns = frame.time_ns;
    made.epoch = frame.epoch;
    made.depth = frame.depth;
    made.storage = frame.storage;
    if (are_kept_) return made;
    const PlaneView& from = frame.depth;
    const DepthCoding& stored = from_.depth;
    const Camera& camera = from_.camera;
    const auto codes = std::make_shared<std::vector<std::uint16_t>>();
    codes->reserve(pixel_count(from.width, from.height));
    for (int y = 0; y < from.height; ++y)
        for (int x = 0; x < from.width; ++x) {
            const std::uint16_t code = stored_code(from, stored, x, y);
            if (stored.semantics == DepthSemantics::planar || !stored.is_valid(code)) {
                codes->push_back(table_[code]);
                continue;
            }
            const double right = (x - camera.cx) / camera.fx, down = (y - camera.cy) / camera.fy;
            codes->push_back(
                scene_.depth.code(stored.depth(code) / std::sqrt(1 + right * right + down * down)));
        }
    made.depth = plane_of_codes(codes->data(), from.width, from.height);
    made.storage = codes;
    return made;
}

Result<std::optional<LeRobotDepth>> find_lerobot_depth(const SourceFile& video, const std::string& codec,
                                                       const std::string& pixel_format) {
    const bool is_usual = codec == "hevc" && pixel_format == "gray12le";
    for (const fs::path& file : descriptions_of(video.path())) {
        if (!is_file(file)) continue;
        const bool is_its_own = file.filename() != "info.json";
        auto found = read_description(file, video.path(), is_usual || is_its_own);
        // Other programs have such files: an invalid one is ignored if the video cannot be LeRobot's depth.
        if (!found && !is_usual) continue;
        if (!found) return found.error();
        if (!*found) continue;
        if (is_usual) return found;
        return input_error(
            video.string() + ": is " + codec + " of pixel format " + pixel_format + ", but " + file.string() +
            " says that it is LeRobot's depth, which is hevc of gray12le: it was encoded anew, "
            "and its depths are lost; take the data set's own file");
    }
    if (!is_usual) return std::optional<LeRobotDepth>{};
    return std::optional(LeRobotDepth{lerobot_coding()});
}

Result<std::vector<fs::path>> lerobot_depth_videos(const fs::path& folder) {
    std::error_code ignored;
    const fs::path info = folder / "meta" / "info.json";
    std::vector<fs::path> found;
    if (!is_file(info)) return found;
    TRY_ASSIGN(const auto videos, read_videos(info));
    const bool has_depth = std::ranges::any_of(videos, is_depth);
    constexpr std::size_t most_entries = 100'000;
    std::size_t entries = 0;
    if (has_depth)
        for (auto each = fs::recursive_directory_iterator(folder / "videos", ignored);
             !ignored && each != fs::end(each) && entries < most_entries; each.increment(ignored), ++entries)
            if (each->path().extension() == ".mp4" && std::ranges::any_of(videos, [&](const Feature& video) {
                    return is_depth(video) && is_in_path(each->path(), video.first);
                }))
                found.push_back(each->path());
    std::ranges::sort(found);
    return found;
}

fs::path lerobot_info_file(const fs::path& video) {
    return fs::path(video).replace_extension(".info.json");
}

Result<std::unique_ptr<ClipWriter>> create_lerobot_video(const fs::path& path, const Scene& scene,
                                                         Existing existing) {
    return opened_as<ClipWriter>(std::make_unique<LeRobotWriter>(path, scene, existing), std::nullopt);
}

}  // namespace touchable
