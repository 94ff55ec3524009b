#include "engine/import/guess/guessed_cameras.hpp"

#include <algorithm>
#include <vector>

#include "engine/import/guess/camera_file.hpp"
#include "engine/import/guess/frame_cameras.hpp"
#include "engine/import/guess/picture_files.hpp"
#include "engine/import/guess/picture_groups.hpp"

namespace touchable {

Result<std::optional<GuessedCameras>> guess_cameras(const std::filesystem::path& folder,
                                                    const std::string& depth_pattern, int width, int height) {
    const std::vector<PictureGroup> groups = camera_groups(folder);
    if (groups.empty()) return std::optional<GuessedCameras>();
    const auto fits = [&](const PictureGroup& group) {
        const auto file = read_camera_file(group.first);
        return file && file->intrinsics.width == width && file->intrinsics.height == height;
    };
    const auto fitting = std::find_if(groups.begin(), groups.end(), fits);
    FolderSource source;
    source.depth = depth_pattern;
    source.cameras = (fitting == groups.end() ? groups.front() : *fitting).pattern;
    const auto frames = depth_files(folder, source);
    if (!frames) return frames.error();
    const auto files = camera_files(folder, source, *frames);
    if (!files) return files.error();
    const auto cameras = read_frame_cameras(*files, width, height);
    if (!cameras) return cameras.error();
    return std::optional(GuessedCameras{source.cameras, median_camera(*cameras)});
}

}  // namespace touchable
