#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// A still surface for programs that know no depth video: in metres, X right, Y up, the camera at the origin
/// looking along -Z.
struct FallbackMesh {
    std::vector<std::array<float, 3>> positions;
    std::vector<std::array<float, 2>> texture_places;  ///< of each position: (0, 0) is the upper left corner
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise as the camera sees them
};

/// A frame's depth by at most 97 vertices along its longer side, heights and filters left out. Where it is a
/// hole there is no triangle. Where it falls away so steeply that two surfaces lie behind each other, the
/// deeper one goes on to the edge of the nearer. Of a frame without depth: a rectangle.
FallbackMesh fallback_mesh(const RawFrame& frame, const Scene& scene);

}  // namespace touchable
