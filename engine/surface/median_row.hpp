#pragma once

#include <cstdint>

#include "engine/base/vector_unit.hpp"
#include "engine/surface/code_line.hpp"

namespace touchable {

/// The lower median of the valid codes in each window of Side x Side, of a row of `width` codes; 0 where the
/// centre is invalid. `lines`: the windows' rows from the upper one on, with reach Side / 2. Side: 3 or 5.
template <int Side>
void median_of_row(VectorUnit unit, const CodeLine* const (&lines)[Side], std::uint16_t* codes, int width);

}  // namespace touchable
