// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "bench/real/depth_map.hpp"

namespace touchable {

/// The plane 1 / depth = at + right (i - x) + down (j - y) around pixel (x, y): flat in the world.
struct DepthPlane {
    int x = 0, y = 0;
    double at = 0, right = 0, down = 0;  ///< 1/mm
    double residual_mm = 0;              ///< RMS, in depth at the plane's middle

    double depth(double i, double j) const { return 1 / (at + right * (i - x) + down * (j - y)); }
};

/// Least squares over the (2 reach + 1)^2 pixels around (x, y). Nothing if one is outside or has no depth.
std::optional<DepthPlane> plane_around(const DepthMap& map, int x, int y, int reach);
/// The planes around pixels `step` apart with a residual below constant + quadratic depth^2 (`flat`).
std::vector<DepthPlane> flat_places(const DepthMap& map, int step, int reach, const DepthLength& flat);

/// Unit vector out of the surface, towards the camera.
glm::dvec3 normal_of(const DepthPlane& plane, const Camera& camera);
/// Standard error of that direction, degrees. Neighbouring residuals are correlated, so each block of 8x8
/// pixels counts as one observation (a cluster-robust error: Liang and Zeger 1986).
double standard_error_deg(const DepthMap& map, const DepthPlane& plane, int reach);

}  // namespace touchable
