#pragma once

#include "haptics_cpu/touch_solver.hpp"
#include "tests/reference/solver.hpp"

namespace touchable::reference {

/// The fast solver's proxy beside the slow one's, from the same state, over the same surface, to the same
/// goal.
struct Comparison {
    bool same_basin = false;  ///< both free, or on the same triangle, on an edge or a corner of it
    Real distance_ratio = 1;  ///< |P - G| over the reference's; 1 where both are nought
    Real angle_degrees = 0;   ///< between both forces, less what the rounding of coordinates explains
    Real farther = 0;         ///< growth of |P - G| in the tick, over 1 + |P - G|; 0 or less
    bool capped = false;      ///< the reference did not come to rest
};

/// `before`, `after`: the proxy before and after the tick that gave `contact`.
Comparison compare(const Surface& surface, const Proxy& before, const Proxy& after, const Contact& contact);

}  // namespace touchable::reference
