#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "engine/media/clip.hpp"

namespace touchable {

/// A JPEG with a depth map in its XMP ("GDepth", as phones write it), as a clip of one frame: the JPEG's own
/// picture is its colour. What the file does not say is assumed and noted: a camera of 60 degrees across,
/// metres. `scene` replaces the scene made from the file.
Result<std::unique_ptr<ClipReader>> open_gdepth_image(const std::filesystem::path& file,
                                                      const std::optional<Scene>& scene);

}  // namespace touchable
