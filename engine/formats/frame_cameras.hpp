#pragma once

#include <span>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/scene/camera.hpp"

namespace touchable {

/// The cameras in these files (camera_file.hpp), one a frame, for pictures of this size. An error names the
/// file and the frame.
Result<std::vector<Camera>> read_frame_cameras(const PictureFiles& files, int width, int height);

/// Each of the four numbers is the median (the lower of two in the middle) of all; of one or more.
Camera median_camera(std::span<const Camera> cameras);

/// How far two cameras show the same ray apart, pixels: at most so many columns and rows over a picture.
struct PixelShift {
    double columns = 0, rows = 0;
    bool is_inside = true;  ///< the stored picture has all that the clip's camera sees
    double length() const;
    /// Whether the nearest pixel is anywhere another one.
    bool moves() const { return columns >= 0.5 || rows >= 0.5; }
};
PixelShift shift_between(const Camera& clip, const Camera& stored, int width, int height);

}  // namespace touchable
