#pragma once

#include "engine/base/result.hpp"
#include "engine/scene/raw_frame.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Refuses planes that are not of the scene's size, or whose samples are not what the scene says; the message
/// names frame and plane.
Result<void> check_raw_frame(const RawFrame& raw, const Scene& scene);

}  // namespace touchable
