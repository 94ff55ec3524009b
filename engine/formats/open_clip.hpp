#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/clip/readers.hpp"
#include "engine/formats/guessed_scene.hpp"
#include "engine/formats/source_description.hpp"

namespace touchable {

// Opens clips of every kind: our own in Matroska and MP4, glTF, texts of MPEG-4 scenes, recordings of cameras
// and of ROS, photographs of phones, videos and pictures of depth, folders of pictures, streams.
//
// `open_clip` recognises a file by its first bytes, in the order of `clip_formats`, and returns a ClipReader
// at the clip's beginning. What a file does not say of its depth and its camera comes from a scene file, or
// from a SourceDescription, which is what a person knows of them; the rest is guessed, and each guess is a
// remark of the reader's scene. `guess_clip` returns that description alone, to be written as a scene file
// and corrected. `with_still_maps` lays pictures of touch under all frames of an open clip.
//
// All functions may be called by any thread, also by several threads at once. They wait for disks and
// servers: another thread ends that by `given_up`, and soon after it the result is an error of kind
// interrupted. A reader is used by one thread at a time. Errors are one line with the file's name; below
// `player/commands` they name a Setting, never an option.

/// A kind of clip that can be opened.
struct ClipFormat {
    const char* what;     ///< in words
    const char* command;  ///< how it is opened, such as "touchable play FOLDER"
    Hints settings{};     ///< with these
};
/// All of them, in the order in which they are tried.
std::vector<ClipFormat> clip_formats();

/// The scene of a path that has no scene file: a folder of pictures, a picture or video of depth, a
/// recording. Of a clip of ours, the scene that is in it.
Result<GuessedScene> guess_clip(const std::filesystem::path& path, const SourceDescription& known,
                                std::stop_token given_up = {});

/// Opens a file, a folder, a URL, or a scene file, whose patterns are relative to it. A folder is described
/// by `scene_file`, by a scene.json in it, or by `known` and guesses. With a clip that has a scene,
/// `scene_file` replaces that scene. Colour that is left out need not be decoded. `alignment`: of depth
/// without a scale (with_aligned_depth); where it is `on`, of any clip that can have it.
Result<std::unique_ptr<ClipReader>> open_clip(const std::filesystem::path& path,
                                              const std::optional<std::filesystem::path>& scene_file = {},
                                              const std::optional<SourceDescription>& known = {},
                                              Colour colour = Colour::wanted, std::stop_token given_up = {},
                                              DepthAlignment alignment = DepthAlignment::automatic);

/// The video, or the two, that the scene's VideoSource names in `folder`; `depth`: the first of them, if the
/// caller has opened it already.
Result<std::unique_ptr<ClipReader>> open_video_clip(const std::filesystem::path& folder,
                                                    const SceneDescription& described,
                                                    Colour colour = Colour::wanted,
                                                    std::shared_ptr<VideoFile> depth = nullptr,
                                                    DepthAlignment alignment = DepthAlignment::automatic);

/// Pictures of touch that serve a whole clip, in place of its own.
struct StillMaps {
    /// A picture (RGB: stiffness, static and dynamic friction; grey: stiffness), X3D with a
    /// HapticTexturesSurface, or glTF with MPEG_haptic_material.
    std::optional<std::filesystem::path> haptic;
    std::optional<std::filesystem::path> height;  ///< a picture in grey
};
/// The clip with these maps under every frame.
Result<std::unique_ptr<ClipReader>> with_still_maps(Result<std::unique_ptr<ClipReader>> clip,
                                                    const StillMaps& maps);
/// One such map. `scene` gets the ranges that the file states; a scene without heights gets some, white being
/// one level of depth high.
Result<StillPlane> read_haptic_map(const std::filesystem::path& file, Scene& scene);
Result<StillPlane> read_height_map(const std::filesystem::path& file, Scene& scene);

}  // namespace touchable
