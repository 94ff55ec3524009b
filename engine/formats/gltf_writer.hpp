// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// A still surface for programs without support for depth video: in metres, X right, Y up, the camera at the
/// origin looking along -Z.
struct FallbackMesh {
    std::vector<std::array<float, 3>> positions;
    std::vector<std::array<float, 2>> texture_places;     ///< of each position; (0, 0): the upper left corner
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise as the camera sees them
};

/// Makes a mesh of a frame's depth, with at most 97 vertices along its longer side, without heights and
/// filters. Holes have no triangles. If depth changes so steeply that one surface lies behind another, the
/// deeper one is extended to the edge of the nearer. A frame without depth becomes a rectangle.
FallbackMesh fallback_mesh(const RawFrame& frame, const Scene& scene);

}  // namespace touchable
