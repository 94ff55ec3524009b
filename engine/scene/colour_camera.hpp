#pragma once

#include <array>
#include <optional>

#include "engine/scene/camera.hpp"
#include "engine/scene/lens.hpp"

namespace touchable {

/// A rotation, row by row, and then a translation, scene units, between cameras: x to the right, y down, z
/// forward, as cameras' own files have them.
struct CameraPose {
    std::array<double, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};
    std::array<double, 3> translation{};

    /// Back again.
    CameraPose inverse() const;
    /// This one, after `first`.
    CameraPose after(const CameraPose& first) const;
    bool operator==(const CameraPose&) const = default;
};

/// The camera of colour pictures that has a place of its own beside depth's.
struct ColourCamera {
    Camera camera;  ///< its fx, fy, cx, cy; where it stands `from_depth` says
    int width = 0, height = 0;
    LensDistortion lens;
    CameraPose from_depth;  ///< a point of depth's camera is R p + t in this one
};

}  // namespace touchable
