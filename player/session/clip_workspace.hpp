#pragma once

#include "device/workspace.hpp"
#include "engine/frame/surface_frame.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Where a device stands over a clip whose frame 0 is `first`: at its median depth, and at the scene's
/// `device_metres_per_unit`, or where that is not given so that the picture there is as wide as
/// `default_workspace` says.
Workspace clip_workspace(const Scene& scene, const SurfaceFrame& first);

}  // namespace touchable
