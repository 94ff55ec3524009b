#pragma once

#include "engine/frame/surface_frame.hpp"

namespace touchable {

/// Stored values of 8 or 16 bits -> codes (0 where invalid) and validity, by `frame.coding`. Gives `frame`
/// the plane's size; no allocation where it had it.
void decode(const PlaneView& depth, SurfaceFrame& frame);

}  // namespace touchable
