#pragma once

#include "engine/scene/camera.hpp"
#include "player/view/view_surface.hpp"

namespace touchable {

/// A colour for every vertex of `surface` (its q is read, its colours are not): what `colour` has there, in a
/// gentle light that shows relief; where `colour` is empty, clay in a full one, nearer warmer and farther
/// cooler. The light comes from the upper left behind the clip's camera.
std::vector<PackedColour> lit_colours(const Camera& camera, const ViewSurface& surface,
                                      const PlaneView& colour);

}  // namespace touchable
