#pragma once

#include <memory>
#include <optional>

#include "engine/content/cube_pyramid.hpp"
#include "engine/content/displaced_sphere.hpp"
#include "engine/content/globe_maps.hpp"

namespace touchable {

/// Maps of a globe, made into what its pictures are made of. Lengths are in radii, directions in the globe's
/// own frame.
struct MappedGround {
    /// Channels of `look`: linear light; how much of it is land; how high, of the relief, above the sea.
    enum Channel : std::size_t { red, green, blue, land, elevation };

    double relief;  ///< of elevation 1
    DisplacedSphere shape;
    CubePyramid<5> look;
    std::optional<CubePyramid<3>> touch;  ///< haptic codes as shares of 255
    double largest_height;                ///< of the relief over the shape; 0: all relief is in the shape
};

/// `finest`: the angle of the smallest pixel in radians, beyond which no detail of a map is kept. Refused are
/// maps that make no globe (check_globe_maps). Takes seconds for large pictures,
/// and looks at stop_requested.
Result<std::unique_ptr<const MappedGround>> map_ground(const GlobeMaps& maps, double finest, RowBands& rows);

}  // namespace touchable
