#pragma once

#include <filesystem>
#include <string>

#include "engine/import/open_clip.hpp"
#include "engine/media/clip.hpp"
#include "engine/result.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// The scene of a single depth picture by the camera that took it: metres, along -Z, 0 is no depth, the far
/// plane as the frame has it.
Result<Scene> bare_picture_scene(const std::filesystem::path& file, const PictureCamera& camera);

/// One picture of depth, which `scene` describes.
Result<std::unique_ptr<ClipReader>> open_bare_picture(const std::filesystem::path& file, Scene scene);

/// That a picture alone does not say what it means, with a scene file that would: on one line, to be copied.
Error no_description(const std::filesystem::path& file);

}  // namespace touchable
