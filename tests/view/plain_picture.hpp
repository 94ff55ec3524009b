#pragma once

#include "player/view/picture_planes.hpp"
#include "player/view/view_camera.hpp"

namespace touchable::test {

/// What painters draw, one triangle after the other, pixel by pixel: the definition that they are held
/// against.
PicturePlanes plain_picture(const ViewSurface& surface, const ViewCamera& camera);

}  // namespace touchable::test
