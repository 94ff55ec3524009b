#pragma once

#include "player/draw/drawn_surface.hpp"
#include "player/draw/view.hpp"

namespace touchable::test {

/// What painters draw, one triangle after the other, pixel by pixel: the definition that they are held
/// against.
PicturePlanes plain_picture(const ViewSurface& surface, const ViewCamera& camera);

}  // namespace touchable::test
