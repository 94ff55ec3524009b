#pragma once

#include <cstddef>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Planar depths of a picture, millimetres, row-major; 0 where there is none.
struct DepthMap {
    int width = 0, height = 0;
    Camera camera;
    std::vector<double> depths;

    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    }
    /// Of the nearest pixel of the picture.
    double at(int x, int y) const;
};

/// What is stored in a raw frame, before any filter; the scene's depth is planar.
DepthMap depths_of(const RawFrame& raw, const Scene& scene);
/// The same room, `factor` times as large.
DepthMap scaled(DepthMap map, double factor);
/// What the camera sees of this surface once it has gone `way` millimetres ahead: each cell's two triangles,
/// flat in the world, are drawn over with a z-buffer. Where depth jumps they stand as walls, as they do for
/// the solver. An error where a pixel sees none, as after a way back.
Result<DepthMap> seen_from(const DepthMap& map, double way);

}  // namespace touchable
