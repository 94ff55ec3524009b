#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "engine/scene/scene.hpp"
#include "engine/scene/surface_frame.hpp"

namespace touchable {

/// The surface as triangles in the world (X right, Y up, camera at the origin looking along -Z), in scene
/// units. Every valid pixel is a vertex, height taken off; every cell of four valid pixels is two triangles,
/// cut by the diagonal from (i, j) to (i+1, j+1), counter-clockwise as the camera sees them.
struct Mesh {
    int width = 0, height = 0;                            ///< of the picture
    std::vector<glm::dvec3> positions;                    ///< row by row
    std::vector<std::uint32_t> pixels;                    ///< y * width + x of each position, ascending
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices of positions
};

/// Of a frame from any builder; `scene` is the one it was built for.
Mesh make_mesh(const SurfaceFrame& frame, const Scene& scene);

}  // namespace touchable
