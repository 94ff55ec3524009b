#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/new_file.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/clip/clip_writer.hpp"
#include "engine/scene/scene_description.hpp"

namespace touchable {

// Clips as PNG pictures, which keep every value. Until they are whole they lie in a hidden folder beside
// their place, which goes again where they never are.

/// A folder that opens as a clip as it is: scene.json, depth_000000.png and so on, colour_, haptic_ and
/// height_ likewise; a plane that is the same in every frame is one picture, haptic.png for one. `existing`:
/// whether it takes the place of an earlier folder, of which only one like it (`is_image_folder`) is
/// replaced.
Result<std::unique_ptr<ClipWriter>> create_image_folder(const std::filesystem::path& folder,
                                                        const SceneDescription& described, Existing existing);

/// Whether a folder holds nothing but what `create_image_folder` writes; an empty one does.
bool is_image_folder(const std::filesystem::path& folder);

/// One frame: NAME.png is its depth, NAME.json the scene file that describes it, by which it opens;
/// NAME_colour.png, NAME_haptic.png and NAME_height.png where there are such planes.
Result<std::unique_ptr<ClipWriter>> create_still(const std::filesystem::path& picture,
                                                 const SceneDescription& described, Existing existing);

/// Every file that `create_still` may write; what opens it is the second.
std::vector<std::filesystem::path> still_files(const std::filesystem::path& picture);

/// The text that describes the pictures of one frame, whose names are in `scene.folder`.
using DescribeStill = std::function<std::string(const SceneDescription&)>;
/// One frame that another text than a scene file describes: NAME.ext beside NAME_depth.png, NAME_colour.png
/// and so on. The text opens it.
Result<std::unique_ptr<ClipWriter>> create_described_still(const std::filesystem::path& text,
                                                           const SceneDescription& described,
                                                           Existing existing, DescribeStill describe);
/// Every file that it may write; the first is the text.
std::vector<std::filesystem::path> described_still_files(const std::filesystem::path& text);

}  // namespace touchable
