#pragma once

#include <optional>
#include <string>

#include "tests/verify/forces_csv.hpp"
#include "tests/verify/surface.hpp"

namespace touchable::verify {

/// What a finger did in a tick.
enum class Motion {
    unknown,
    none,  ///< it stayed where it was in the picture: from then on it sticks
    slid   ///< within one facet at rest, so that it slides until it need not move
};

/// Where a finger was inside a facet, in contact, at the tick before.
struct Before {
    std::int64_t tick = 0;
    Facet facet;
    Vec3 proxy;
    Motion motion = Motion::unknown;
};

enum class Step {
    unknown,  ///< another facet, or too close to tell: nothing can be said
    right,
    wrong
};

/// Coulomb friction within one facet at rest, from one tick to the next. With C the goal's closest point in
/// the facet's plane and h its distance from the goal: a proxy that sticks stays where it is as long as |P -
/// C| <= mu_s h, one that slides as long as |P - C| <= mu_d h. Else it moves straight towards C, as far as
/// the first place at which |P - C| = mu_d h with mu_d of that place. `why` tells what is wrong.
Step judge_step(const Before& before, const ForceRow& row, const Facet& facet, const Surface& surface,
                std::string& why);

}  // namespace touchable::verify
