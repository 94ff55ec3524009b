#pragma once

#include <filesystem>
#include <memory>

#include "engine/media/clip.hpp"

namespace touchable {

/// Numbered images in `folder`, found by the patterns of the scene's FolderSource.
Result<std::unique_ptr<ClipReader>> open_image_folder(const std::filesystem::path& folder,
                                                      const Scene& scene);

}  // namespace touchable
