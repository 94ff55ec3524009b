// SPDX-License-Identifier: Apache-2.0
// Depthkit's metadata (DepthkitMetadata), and the video that they describe.

#include "engine/formats/formats_read.hpp"

#include <algorithm>
#include <cmath>

#include "engine/base/files.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/containers.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/formats/stored_clip.hpp"

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
            std::string_view line = trimmed(cut_line(rest));
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

Result<int> whole_pixels(const DepthkitMetadata& metadata, std::string_view field, Result<double> number) {
    TRY_ASSIGN(const double pixels, std::move(number));
    if (pixels >= 1 && pixels <= 32768 && pixels == std::floor(pixels)) return static_cast<int>(pixels);
    return metadata.refuse(field, std::to_string(pixels), "a whole number of pixels, 1 to 32768");
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
    TRY_ASSIGN(scene.width,
               whole_pixels(metadata, "depthImageSize", metadata.component("depthImageSize", "x")));
    TRY_ASSIGN(scene.height,
               whole_pixels(metadata, "depthImageSize", metadata.component("depthImageSize", "y")));
    TRY(check_layout(metadata, scene.width, scene.height));
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
    TRY(error_at(metadata.file(), validate(scene)));
    return described;
}

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
    TRY_ASSIGN(std::shared_ptr<VideoFile> pictures, VideoFile::open(video.source, PlaneRole::depth));
    const FrameRate& rate = pictures->rate();
    if (rate.own_times)
        return input_error(file.string() + ": its frames are not evenly spaced: must be, as Depthkit's are");
    TRY_ASSIGN(auto scene,
               video.scene ? Result<SceneDescription>(*video.scene) : read_depthkit_metadata(metadata));
    if (!video.scene) scene.scene.name = file.stem().string();
    StoredClip clip{file.string(), std::move(scene)};
    if (pictures->note()) clip.notes.push_back(*pictures->note());
    if (!clip.described.unstated.rate)
        if (auto note = clip_tags::rate_note(clip.described.scene.rate, rate))
            clip.notes.push_back(std::move(*note));
    clip.count = pictures->count();
    clip.roles = {PlaneRole::depth, PlaneRole::colour};
    clip.found.rate = rate;
    clip.inputs = {file, metadata};
    clip.pictures = pictures_of_halves({file.filename().string(), "", VideoLayout::bottom, VideoValues::hue},
                                       pictures, clip.notes);
    return open_stored_clip(std::move(clip));
}

}  // namespace touchable
