#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/aligned_clip.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/formats/guessed_scene.hpp"
#include "engine/formats/source_description.hpp"

namespace touchable {

/// A kind of clip that can be opened.
struct ClipFormat {
    const char* what;     ///< in words
    const char* command;  ///< how it is opened, such as "touchable play FOLDER"
    Hints settings{};     ///< with these
};
/// All of them, in the order in which they are tried.
std::vector<ClipFormat> clip_formats();

/// The scene of what has no scene file of its own: a folder of pictures, a picture or video of depth, a
/// recording; of a clip of ours that which is in it. An error of kind interrupted soon after it was
/// `given_up`, here and below.
Result<GuessedScene> guess_clip(const std::filesystem::path& path, const SourceDescription& known,
                                std::stop_token given_up = {});

/// Opens a touchable Matroska clip (scene attached), a folder of images (`scene_file`, or a scene.json in
/// it), a scene file that describes a folder (patterns relative to the scene file), a recording of ROS 1, a
/// Depthkit video with its metadata beside it, any other video of depth, a JPEG with a depth map in its XMP,
/// or a single picture of depth. With `scene_file` and a clip, the file's description replaces the clip's
/// own. Folders, pictures and videos without any are described by what is `known` of them, and by guesses,
/// which the scene's remarks say. Colour that is left out need not be decoded. `alignment`: of depth
/// without a scale (with_aligned_depth); where it is `on`, of any clip that can have it.
Result<std::unique_ptr<ClipReader>> open_clip(const std::filesystem::path& path,
                                              const std::optional<std::filesystem::path>& scene_file = {},
                                              const std::optional<SourceDescription>& known = {},
                                              Colour colour = Colour::wanted, std::stop_token given_up = {},
                                              DepthAlignment alignment = DepthAlignment::automatic);

}  // namespace touchable
