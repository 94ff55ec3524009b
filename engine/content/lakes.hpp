#pragma once

#include <vector>

#include "engine/content/globe_maps.hpp"

namespace touchable {

/// Which pixels of the mask are lakes above the sea: connected water of which more than half is above sea
/// level. (At a coast mask and elevation differ by a pixel or two, so elevation alone does not tell.) Row by
/// row; empty where there is none.
std::vector<bool> lakes_above_sea(const GlobeMaps& maps);

}  // namespace touchable
