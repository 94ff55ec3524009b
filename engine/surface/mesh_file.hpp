#pragma once

#include <filesystem>

#include "engine/base/new_file.hpp"
#include "engine/base/result.hpp"
#include "engine/scene/plane_view.hpp"
#include "engine/surface/mesh.hpp"

namespace touchable {

enum class PlyCoordinates { single_precision, double_precision };

/// Binary little-endian PLY: x, y, z in scene units, red, green, blue where there is a colour plane (3
/// channels of 8 bits, of the mesh's picture), and triangles. Whoever owns `file` commits it.
Result<void> write_ply(NewFile& file, const Mesh& mesh, const PlaneView& colour = {},
                       PlyCoordinates coordinates = PlyCoordinates::single_precision);
/// The same, and gives it its name, over an earlier file.
Result<void> write_ply(const std::filesystem::path& file, const Mesh& mesh, const PlaneView& colour = {},
                       PlyCoordinates coordinates = PlyCoordinates::single_precision);

}  // namespace touchable
