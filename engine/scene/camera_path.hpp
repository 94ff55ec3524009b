#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/scene/colour_camera.hpp"
#include "engine/scene/frame_rate.hpp"

namespace touchable {

/// Where a clip's camera stood at each frame, as somebody else measured it: a point of the camera is R p + t
/// in a world that stands still. Nothing that is seen or felt goes by it.
struct CameraPath {
    std::vector<std::optional<CameraPose>> poses;  ///< of frames 0, 1, ...; nothing: not known

    std::size_t known() const;
    /// The way from each known place to the next one, scene units.
    double length() const;
    /// Of frames `first`, `first + every`, ... up to `last`.
    CameraPath part(std::int64_t first, std::optional<std::int64_t> last, std::int64_t every) const;
    bool operator==(const CameraPath&) const = default;
};

/// Most frames of a path, whose text a clip's head has room for; and most poses of a list, which may be more
/// often than frames.
inline constexpr std::size_t most_path_frames = 200'000, most_timed_poses = 2'000'000;

/// A camera's pose at a time.
struct TimedPose {
    double seconds = 0;
    CameraPose pose;
};

/// The rotation of a quaternion, which need not be exactly of length 1; nothing where it is no rotation.
std::optional<std::array<double, 9>> rotation_of(double x, double y, double z, double w);
/// At a place in metres; nothing where that is a million kilometres away or more.
std::optional<CameraPose> pose_at(const std::array<double, 9>& rotation, const std::array<double, 3>& metres,
                                  double metres_per_unit);
/// The nearest rotation's matrix is this one but for what digits were rounded off: 1e-3.
bool is_rotation(const std::array<double, 9>& matrix);

/// Lines "time tx ty tz qx qy qz qw", seconds and metres, as TUM RGB-D's groundtruth.txt; '#' begins a
/// remark. An error names the line.
Result<std::vector<TimedPose>> parse_timed_poses(std::string_view text, const std::string& name,
                                                 double metres_per_unit);
/// The known poses in that form, at the times of their frames.
std::string timed_poses_text(const CameraPath& path, const FrameRate& rate, double metres_per_unit);
/// Poses with the frames of these times; those that are at no frame's time are left out.
CameraPath path_of_timed_poses(const std::vector<TimedPose>& poses, const FrameRate& rate);

}  // namespace touchable
