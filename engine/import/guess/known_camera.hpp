#pragma once

#include "engine/import/guess/source_description.hpp"
#include "engine/scene/camera.hpp"

namespace touchable {

inline constexpr double usual_fov = 60;  ///< degrees, where nothing tells

/// Of pictures of another size than these, that of a camera with the same view.
Camera scaled_camera(const Intrinsics& intrinsics, int width, int height);

/// Square pixels, the axis through the middle; degrees from the left edge to the right one.
Camera camera_of_fov(double degrees, int width, int height);

}  // namespace touchable
