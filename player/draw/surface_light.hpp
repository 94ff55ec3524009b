#pragma once

#include <functional>
#include <vector>

#include "engine/scene/camera.hpp"
#include "player/draw/view_surface.hpp"

namespace touchable {

/// What becomes of a colour at a vertex.
enum class Lighting {
    lit,    ///< in a gentle light that shows relief
    plain,  ///< as it is: of maps, whose colours say something
};

/// q that 4 % and 96 % of the valid vertices do not exceed, by a sample of them.
struct UsualQ {
    float farthest, nearest;
};
UsualQ usual_q(int width, int height, const std::function<float(int x, int y)>& q_at);

/// A colour for every vertex of `surface` (its q is read, its colours are not): what `colour` has there, in a
/// gentle light that shows relief; where `colour` is empty, clay in a full one, nearer warmer and farther
/// cooler. The light comes from the upper left behind the clip's camera.
std::vector<PackedColour> lit_colours(const Camera& camera, const ViewSurface& surface,
                                      const PlaneView& colour);

}  // namespace touchable
