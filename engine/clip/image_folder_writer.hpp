#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "engine/clip/clip_reader.hpp"
#include "engine/clip/clip_writer.hpp"
#include "engine/new_file.hpp"
#include "engine/result.hpp"
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

/// Every file that `create_still` may write.
std::vector<std::filesystem::path> still_files(const std::filesystem::path& picture);

}  // namespace touchable
