#pragma once

#include "device/workspace.hpp"
#include "engine/frame/surface_frame.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Where a device stands over a clip whose frame 0 is `first`: at the scene's `device_metres_per_unit` where
/// that is given. Otherwise, of a device that reaches so far to each side (`reach`, metres, > 0), the picture
/// and nearly all of its depths lie within reach, with a fifth in front of them to come from; of others the
/// picture at its median depth is as wide as `default_workspace` says.
Workspace clip_workspace(const Scene& scene, const SurfaceFrame& first,
                         const glm::dvec3& reach = glm::dvec3(0));

}  // namespace touchable
