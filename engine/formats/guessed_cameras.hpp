#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "engine/base/result.hpp"
#include "engine/scene/camera.hpp"

namespace touchable {

/// Files that lie in a folder of pictures, with the camera of each frame.
struct GuessedCameras {
    std::string files;  ///< as `FolderSource::cameras`; a single file's name where there is only one
    Camera median;      ///< of those that go with pictures of depth
};

/// Such files as ARKitScenes has them (.pincam), in the folder or one of its folders: of several kinds those
/// of pictures of this size, otherwise those of which there are most. Nothing where there are none; an error
/// names the file that cannot be read.
Result<std::optional<GuessedCameras>> guess_cameras(const std::filesystem::path& folder,
                                                    const std::string& depth_pattern, int width, int height);

}  // namespace touchable
