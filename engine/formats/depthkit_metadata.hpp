#pragma once

#include <filesystem>

#include "engine/base/result.hpp"
#include "engine/scene/scene_description.hpp"

namespace touchable {

/// The scene of a Depthkit video by the Unity asset that describes it: all but name and rate, lengths in
/// metres. Refused where a field is missing or the pictures are laid out otherwise than one perspective,
/// uncropped, colour above depth.
Result<SceneDescription> read_depthkit_metadata(const std::filesystem::path& file);

}  // namespace touchable
