#pragma once

#include <optional>
#include <string>

#include "engine/formats/source_description.hpp"
#include "engine/scene/camera.hpp"
#include "engine/scene/remark.hpp"

namespace touchable {

inline constexpr double usual_fov = 60;  ///< degrees, where nothing tells

/// Of pictures of another size than these, that of a camera with the same view.
Camera scaled_camera(const Intrinsics& intrinsics, int width, int height);

/// Square pixels, the axis through the middle; degrees from the left edge to the right one.
Camera camera_of_fov(double degrees, int width, int height);

/// What is said of a field of view that nobody told: how wide it is taken to be, and what that does to shapes
/// if it is wrong. Their depth is right all the same, so all is too narrow or too wide for it.
std::string guessed_field_of_view(double degrees);

/// Doubts the unit of a clip whose median depth, in metres, no depth camera measures; nothing: it may be
/// right. `otherwise` and `hints` are the remark's.
std::optional<Remark> unit_doubt(double median_m, std::string otherwise, Hints hints);

/// What a remark is about, in a scene file's words as well.
bool guesses_camera(const Remark& remark);
bool doubts_unit(const Remark& remark);

}  // namespace touchable
