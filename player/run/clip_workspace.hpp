#pragma once

#include "engine/scene/scene.hpp"
#include "engine/scene/surface_frame.hpp"
#include "haptics_cpu/workspace.hpp"

namespace touchable {

/// Where a simulated device stands over a clip whose frame 0 is `first`: `default_workspace`, at the scene's
/// `device_metres_per_unit` where that is given.
Workspace clip_workspace(const Scene& scene, const SurfaceFrame& first);

/// Where a device stands that a person holds. Of one that reaches so far to each side (`reach`, metres, > 0)
/// the picture and nearly all of its depths lie within reach, with a fifth in front of them to come from. Of
/// others the picture is as wide as `default_workspace` says, and the centre is free: 0.02 m of device space
/// before nearly all depths. The scale is the scene's `device_metres_per_unit` where that is given.
Workspace held_workspace(const Scene& scene, const SurfaceFrame& first, const glm::dvec3& reach);

}  // namespace touchable
