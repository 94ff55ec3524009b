#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/plane_role.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// The files of a plane, one a frame. The last serves all frames that come after it as well: of a still and
/// of a stack, which has millions of frames where somebody says so, it is the only one.
struct PictureFiles {
    std::vector<std::filesystem::path> files;
    /// What orders them, if anything: numbers in their names, or the times of a list. As many as files.
    std::vector<double> keys;
    bool has_decimals = false;   ///< keys were written with a point: they are seconds, even if whole
    std::filesystem::path list;  ///< that names them, if one does
    std::string remark;          ///< of numbers that are missing, and of times that cannot be

    std::size_t frames = 0;  ///< where they are more than files

    std::size_t count() const { return std::max(frames, files.size()); }
    const std::filesystem::path& file(std::size_t frame) const {
        return files[std::min(frame, files.size() - 1)];
    }
};

/// What the depth pattern of `source` stands for in `folder` (FolderSource). Its remark says which numbers a
/// row lacks. An error names what is missing.
Result<PictureFiles> depth_files(const std::filesystem::path& folder, const FolderSource& source);

/// A file of another plane for each of `depth`: that of the same number, that which is nearest by key where
/// both have keys, otherwise that of the same place in its row; or the same still for all. Its remark says
/// which of depth's numbers it has not.
Result<PictureFiles> files_beside(const std::filesystem::path& folder, PlaneRole role,
                                  const FolderSource& source, const PictureFiles& depth);

/// The file of `source.cameras` for each of `depth`, paired likewise.
Result<PictureFiles> camera_files(const std::filesystem::path& folder, const FolderSource& source,
                                  const PictureFiles& depth);

/// The files of a star pattern or a list alone.
Result<PictureFiles> found_files(const std::filesystem::path& folder, const std::string& pattern);

/// The place of the nearest of sorted keys, of which there is one.
std::size_t nearest_key(const std::vector<double>& keys, double key);

/// When frames with these times, which do not go backward, were taken: evenly, where all keep to the median
/// step within 2 ms, otherwise at their own times, or where some are less than 1 ms apart evenly at their
/// mean. Nothing of fewer than two, and where they are no times of frames.
std::optional<FrameRate> rate_of_seconds(const std::vector<double>& seconds);
/// The times of pictures, seconds, as a list or their names have them; empty where keys are no times.
std::vector<double> seconds_of_day(const PictureFiles& pictures);
/// The same of pictures whose keys are times.
std::optional<FrameRate> rate_of(const PictureFiles& pictures);
/// Why the times of a list are of no use; empty where they are, and where there is no list of times.
std::string unusable_times(const PictureFiles& pictures);
/// Their own times wherever they can be, however even: to a clip that was written as a list not a nanosecond
/// is lost.
std::optional<FrameRate> own_rate_of(const PictureFiles& pictures);

}  // namespace touchable
