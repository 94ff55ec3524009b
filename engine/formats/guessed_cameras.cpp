#include "engine/formats/guessed_cameras.hpp"

#include <algorithm>
#include <vector>

#include "engine/base/try.hpp"
#include "engine/formats/camera_file.hpp"
#include "engine/formats/frame_cameras.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/formats/picture_groups.hpp"

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
    TRY_ASSIGN(const auto frames, depth_files(folder, source));
    TRY_ASSIGN(const auto files, camera_files(folder, source, frames));
    TRY_ASSIGN(const auto cameras, read_frame_cameras(files, width, height));
    return std::optional(GuessedCameras{source.cameras, median_camera(cameras)});
}

}  // namespace touchable
