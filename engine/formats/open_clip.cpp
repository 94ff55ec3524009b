#include "engine/formats/open_clip.hpp"

#include <algorithm>
#include <string>
#include <system_error>
#include <utility>

#include "engine/base/byte_source.hpp"
#include "engine/base/printable.hpp"
#include "engine/base/stop_request.hpp"
#include "engine/base/try.hpp"
#include "engine/formats/bag_file.hpp"
#include "engine/formats/gltf_clip.hpp"
#include "engine/formats/guessed_scene.hpp"
#include "engine/formats/image_folder.hpp"
#include "engine/formats/lerobot_video.hpp"
#include "engine/formats/open_file.hpp"
#include "engine/formats/pinhole_frames.hpp"
#include "engine/formats/ros2_folder.hpp"
#include "engine/formats/scene_text_clip.hpp"
#include "engine/picture/stored_image.hpp"
#include "engine/scene/scene_file.hpp"
#include "engine/stream/http_source.hpp"
#include "engine/stream/stream_clip.hpp"

namespace touchable {
namespace {

constexpr const char* own_scene_file = "scene.json";  // of a folder that describes itself

bool is_scene_file(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return extension == ".json";
}

Result<std::unique_ptr<ClipReader>> open_described(const std::filesystem::path& path,
                                                   const std::filesystem::path& scene_file,
                                                   const OpenSettings& wanted) {
    TRY_ASSIGN(const auto described, read_scene_file(scene_file));
    const auto& video_source = described.scene.video;
    std::error_code ignored;
    const bool is_file = std::filesystem::is_regular_file(path, ignored);
    if ((is_file || video_source) && described.unstated.camera)  // which only a folder's cameras could give
        return error_at(scene_file.string(), settle(described, {}).error());
    if (!is_file && !video_source && !described.scene.folder)
        return input_error(scene_file.string() +
                           ": has no member \"folder\" or \"video\" that says which pictures to read");
    if (!is_file && video_source && wanted.least_confidence)
        return usage_error(scene_file.string() + ": describes a video, which has no least confidence");
    const auto pictures = std::make_shared<ReadPictures>();
    pictures->trust_from(wanted.least_confidence);
    const SourceFile video(path / (video_source ? video_source->depth : ""));
    const std::string begin = first_bytes(video, telling_bytes);
    const bool is_recording = video_source && is_recording_of_ros(begin);
    auto reader = is_file        ? open_file(path, described, {}, wanted)
                  : is_recording ? open_file(video, described, {}, wanted)
                  : video_source
                      ? open_described_video(path, video, described, wanted)
                      : open_image_folder(path, described, {}, wanted.colour, pictures, wanted.alignment);
    if (reader) (*reader)->add_input(scene_file);
    return reader;
}

/// Of a LeRobot data set with one video of depth that video; of any other folder nothing.
Result<std::optional<std::filesystem::path>> lerobot_video_in(const std::filesystem::path& folder) {
    TRY_ASSIGN(const auto videos, lerobot_depth_videos(folder));
    if (videos.empty()) return std::optional<std::filesystem::path>{};
    if (videos.size() == 1) return std::optional(videos.front());
    return input_error(folder.string() + ": is a LeRobot data set with " + std::to_string(videos.size()) +
                       " videos of depth, each a clip of its own: touchable play " +
                       shell_word(videos.front().string()));
}

/// A folder that describes itself, or is guessed.
Opened open_folder(const std::filesystem::path& folder, const std::optional<SourceDescription>& known,
                   const OpenSettings& wanted) {
    std::error_code failure;
    const auto own = folder / own_scene_file;
    const bool has_own = std::filesystem::is_regular_file(own, failure);
    if (has_own && known)
        return usage_error(own.string() + ": describes these pictures: leave camera, unit and preset out",
                           of_bare_pictures());
    if (has_own) return open_described(folder, own, wanted);
    TRY_ASSIGN(const auto lerobot, lerobot_video_in(folder));
    TRY_ASSIGN(const auto recording, ros2_recording_in(folder));
    if (const auto& only = lerobot ? lerobot : recording)
        return open_file(*only, std::nullopt, known.value_or(SourceDescription()), wanted);
    TRY_ASSIGN(auto guessed, guess_folder(folder, known.value_or(SourceDescription())));
    return with_inputs(
        open_image_folder(folder, guessed, {}, wanted.colour, guessed.pictures, wanted.alignment),
        guessed.inputs);
}

/// A file on a server that names other files: they are not fetched.
std::optional<Error> names_others(const SourceFile& file) {
    if (!is_gltf(file) && !is_scene_text(file) && !is_scene_file(file.path())) return std::nullopt;
    return input_error(file.string() +
                       ": names other files, which are not fetched from there; fetch them all, and open "
                       "them here");
}

/// A stream, or a file on a server.
Opened open_url(const std::filesystem::path& path, const std::optional<std::filesystem::path>& scene_file,
                const std::optional<SourceDescription>& known, const OpenSettings& wanted) {
    TRY_ASSIGN(const auto url, read_stream_url(path.string()));
    StreamSource source{.url = url};
    if (scene_file) {
        TRY_ASSIGN(auto described, read_scene_file(*scene_file));
        source.described = std::move(described);
    }
    if (url.transport == StreamTransport::http && !url.is_playlist()) {
        TRY_ASSIGN(auto found, open_http(url));
        if (found.file) {
            if (auto refused = names_others(*found.file)) return std::move(*refused);
            auto reader =
                open_file(*found.file, source.described, known.value_or(SourceDescription()), wanted);
            if (const auto failure = found.end_opening()) return error_at(url.name(), *failure);
            if (reader) (*reader)->forget_inputs();
            return scene_file ? with_inputs(std::move(reader), {*scene_file}) : std::move(reader);
        }
        source.connection = std::move(found.stream);
        source.wait = source.connection->waits();
    }
    if (known)
        return usage_error(
            url.name() + ": is a stream, which has its scene in it: leave camera, unit and preset out",
            of_bare_pictures());
    auto reader = open_stream_clip(source, wanted.colour);
    return scene_file ? with_inputs(std::move(reader), {*scene_file}) : std::move(reader);
}

/// With the pixels of depth and colour as they are stored. `known` says no least confidence.
Opened open_stored(const std::filesystem::path& path, const std::optional<std::filesystem::path>& scene_file,
                   const std::optional<SourceDescription>& known, const OpenSettings& wanted) {
    if (is_stream_url(path.string())) return open_url(path, scene_file, known, wanted);
    std::error_code failure;
    const auto status = std::filesystem::status(path, failure);
    if (!std::filesystem::exists(status)) return input_error(path.string() + ": does not exist");
    const bool is_folder = std::filesystem::is_directory(status);
    if (!is_folder && !std::filesystem::is_regular_file(status))
        return input_error(path.string() + ": is neither a file nor a folder");
    if (!is_folder && path.extension() == ".m3u8" && !scene_file && !known)
        return open_stream_clip({.url = playlist_in_folder(path.string())}, wanted.colour);
    if (known && scene_file)
        return usage_error(path.string() + ": a scene file describes it: leave camera, unit and preset out",
                           of_bare_pictures());
    const bool is_described = is_folder
                                  ? scene_file || std::filesystem::exists(path / own_scene_file, failure)
                                  : is_scene_file(path);
    if (wanted.least_confidence && !is_described && (is_folder || !is_npy_file(SourceFile(path))))
        return usage_error(path.string() +
                           ": is no .npz with an array conf, of which there could be a least confidence");
    if (!is_folder && is_scene_file(path)) {
        if (scene_file || known)
            return usage_error(path.string() + ": is a scene file itself: leave " +
                                   (scene_file ? "the other one" : "camera, unit and preset") + " out",
                               scene_file ? Hints{{Setting::scene_file}} : of_bare_pictures());
        return open_described(path.parent_path(), path, wanted);
    }
    if (scene_file) return open_described(path, *scene_file, wanted);
    auto reader = is_folder ? open_folder(path, known, wanted)
                            : open_file(path, std::nullopt, known.value_or(SourceDescription()), wanted);
    if (known && !known->file.empty()) return with_inputs(std::move(reader), {known->file});
    return reader;
}

Result<GuessedScene> guess_stored(const std::filesystem::path& path, const SourceDescription& known) {
    if (is_stream_url(path.string()))
        return usage_error(in_quotes(path.string()) + " is no file here; save it first: touchable convert " +
                           shell_word(path.string()) + " clip.mkv");
    std::error_code failure;
    const auto status = std::filesystem::status(path, failure);
    if (!std::filesystem::exists(status)) return input_error(path.string() + ": does not exist");
    if (std::filesystem::is_directory(status)) {
        TRY_ASSIGN(const auto lerobot, lerobot_video_in(path));
        if (lerobot)
            return input_error(path.string() +
                               ": is a LeRobot data set, and a scene file is of its video: "
                               "touchable init-scene " +
                               shell_word(lerobot->string()));
        TRY_ASSIGN(const auto recording, ros2_recording_in(path));
        return recording ? guess_stored(*recording, known) : guess_folder(path, known);
    }
    if (!std::filesystem::is_regular_file(status))
        return input_error(path.string() + ": is neither a file nor a folder");
    return guess_file(SourceFile(path), known);
}

/// What was made of files that were read no further, because somebody gave up, may be wrong.
template <class Made>
Result<Made> unless_given_up(Result<Made> made, const std::filesystem::path& path) {
    const bool is_told = !made && made.error().kind == ErrorKind::interrupted;
    if (is_told || !stop_requested()) return made;
    return Error{ErrorKind::interrupted, path.string() + ": interrupted while it was opened"};
}

}  // namespace

Result<GuessedScene> guess_clip(const std::filesystem::path& path, const SourceDescription& known,
                                std::stop_token given_up) {
    const WorkUntil until(std::move(given_up));
    return unless_given_up(guess_stored(path, known), path);
}

std::vector<ClipFormat> clip_formats() {
    std::vector<ClipFormat> said = file_formats();
    said.push_back({"a folder of pictures, as cameras and data sets have them (TUM, Redwood, 7-Scenes, ...)",
                    "touchable play FOLDER"});
    said.push_back({"a folder, a picture, a video or two with a scene file (docs/scene_file.md)",
                    "touchable play FOLDER",
                    {{Setting::scene_file, "scene.json"}}});
    return said;
}

Result<std::unique_ptr<ClipReader>> open_clip(const std::filesystem::path& path,
                                              const std::optional<std::filesystem::path>& scene_file,
                                              const std::optional<SourceDescription>& known, Colour colour,
                                              std::stop_token given_up, DepthAlignment alignment) {
    const WorkUntil until(std::move(given_up));
    OpenSettings wanted{colour, alignment, known ? known->least_confidence : std::nullopt};
    // Whoever says that alone leaves the rest to a scene file, or to guesses.
    std::optional<SourceDescription> said = known;
    if (said) said->least_confidence.reset();
    if (said == SourceDescription()) said.reset();
    auto reader = open_stored(path, scene_file, said, wanted);
    return unless_given_up(reader ? with_pinhole_frames(std::move(*reader)) : std::move(reader), path);
}

}  // namespace touchable
