#pragma once

#include <cstdint>
#include <vector>

#include "engine/scene/plane_view.hpp"

namespace touchable {

/// Samples of two bytes go into codecs of one as two planes: the high eight bits, and those below them.
enum class PlanePart { whole, high, low };

/// Eight bits of each sample, in `memory` where they are not the plane itself; `low_bits`: of a sample of two
/// bytes, those that are in the low part.
PlaneView part_of(const PlaneView& plane, PlanePart part, int low_bits, std::vector<std::uint8_t>& memory);

}  // namespace touchable
