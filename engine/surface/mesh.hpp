#pragma once

// A frame's surface as triangles, in memory and as a PLY file, for other programs.
//
// The mesh has a vertex for each pixel that is valid and two triangles for each cell, cut as the solver cuts
// it. Functions keep no state.

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <vector>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

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

enum class PlyCoordinates { single_precision, double_precision };

/// Binary little-endian PLY: x, y, z in scene units, red, green, blue where there is a colour plane (3
/// channels of 8 bits, of the mesh's picture), and triangles. Whoever owns `file` commits it.
Result<void> write_ply(NewFile& file, const Mesh& mesh, const PlaneView& colour = {},
                       PlyCoordinates coordinates = PlyCoordinates::single_precision);
/// The same, and gives it its name, over an earlier file.
Result<void> write_ply(const std::filesystem::path& file, const Mesh& mesh, const PlaneView& colour = {},
                       PlyCoordinates coordinates = PlyCoordinates::single_precision);

}  // namespace touchable
