#pragma once

#include <filesystem>
#include <memory>

#include "engine/base/new_file.hpp"
#include "engine/clip/clip_writer.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// The feature that such a video is of, in its description.
inline constexpr const char* lerobot_feature = "observation.images.depth";

/// "NAME.info.json" of "NAME.mp4".
std::filesystem::path lerobot_info_file(const std::filesystem::path& video);

/// A video of depth as LeRobot writes it: MP4, HEVC of 12 bits that keeps every value, depth alone. Beside it
/// a file that says what its codes are, as "features" of a data set's meta/info.json, and its camera.
/// `scene`: of LeRobotCodes. Both files have their names once both are complete.
Result<std::unique_ptr<ClipWriter>> create_lerobot_video(const std::filesystem::path& path,
                                                         const Scene& scene, Existing existing);

}  // namespace touchable
