#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "engine/formats/picture_files.hpp"
#include "engine/scene/camera_path.hpp"

namespace touchable {

/// Where the camera stood, as a file beside pictures says it.
struct FoundPoses {
    CameraPath path;  ///< empty: the file is not understood, as `remark` says
    std::filesystem::path file{};
    std::string remark{};
};

/// In a folder of pictures: poses.txt or groundtruth.txt (TUM RGB-D), trajectory.log or another .log with
/// "traj" in its name (Redwood, Open3D), or metadata.json (Record3D); the first of them that is there and has
/// poses. `rate`: of the frames. Those of a list with times go with the frames that are nearest, at most 20
/// ms away, or, where no times fit and there are as many, one by one. Nothing where there is no such file.
std::optional<FoundPoses> poses_beside(const std::filesystem::path& folder, const PictureFiles& depth,
                                       const FrameRate& rate, double metres_per_unit);

}  // namespace touchable
