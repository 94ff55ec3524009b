#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "engine/media/clip.hpp"
#include "engine/result.hpp"

namespace touchable {

/// What a single depth picture does not say of itself: the camera, pixels, and what a code is. Depth is along
/// the optical axis, and code 0 is none.
struct PictureCamera {
    double fx = 0, fy = 0;
    std::optional<double> cx{}, cy{};  ///< otherwise the middle of the picture
    double metres_per_code = 0.001;
};

/// Opens a touchable Matroska clip (scene attached), a folder of images (`scene_file`, or a scene.json in
/// it), a scene file that describes a folder (patterns relative to the scene file), a Depthkit video with its
/// metadata beside it, a JPEG with a depth map in its XMP, or a single depth picture with a `camera` or a
/// `scene_file`. With `scene_file` and a clip, the file's description replaces the clip's own.
Result<std::unique_ptr<ClipReader>> open_clip(const std::filesystem::path& path,
                                              const std::optional<std::filesystem::path>& scene_file = {},
                                              const std::optional<PictureCamera>& camera = {});

}  // namespace touchable
