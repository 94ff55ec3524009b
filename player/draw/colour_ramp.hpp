#pragma once

#include <array>

#include "player/draw/view_surface.hpp"

namespace touchable {

/// Colours from dark blue by green to light yellow, lightness growing evenly as eyes see it (OKLab), none of
/// them grey: who does not tell red from green reads it by its lightness and by blue and yellow.
const std::array<PackedColour, 256>& colour_ramp();

/// Its colour at 0 to 1; beyond that, the end's.
PackedColour ramp_colour(double share);

}  // namespace touchable
