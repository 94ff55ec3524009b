// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Planar depths of a picture, millimetres, row-major; 0: no depth.
struct DepthMap {
    int width = 0, height = 0;
    Camera camera;
    std::vector<double> depths;

    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    }
    /// Depth of the picture's nearest pixel.
    double at(int x, int y) const;
};

/// Stored depths of a raw frame, unfiltered; the scene's depth must be planar.
DepthMap depths_of(const RawFrame& raw, const Scene& scene);
/// The same room scaled by `factor`.
DepthMap scaled(DepthMap map, double factor);
/// The surface seen by the camera after it has moved `way` millimetres forward: each cell's two triangles,
/// flat in the world, are drawn with a z-buffer. At jumps of depth they form walls, as for the solver. An
/// error if a pixel sees none, for example after moving backward.
Result<DepthMap> seen_from(const DepthMap& map, double way);

}  // namespace touchable
