#pragma once

#include <optional>
#include <string>

#include "tests/verify/forces_csv.hpp"
#include "tests/verify/surface.hpp"

namespace touchable::verify {

/// Where a finger was inside a facet, in contact, at the tick before.
struct Before {
    std::int64_t tick = 0;
    Facet facet;
    Vec3 proxy;
    Touch touch;
    bool at_rest = false;  ///< it did not move over the picture in its last tick
};

enum class Step {
    unknown,  ///< another facet, uneven friction, or too close to tell: nothing can be said
    right,
    wrong
};

/// Coulomb friction within one facet at rest, from one tick to the next. With C the goal's closest point in
/// the facet's plane and h its distance from the goal: a proxy at rest stays where it is as long as |P - C|
/// <= mu_s h. Else it moves straight towards C until |P - C| = mu_d h. One that is moving may stop as soon as
/// the static cone holds it, or keep to the dynamic cone. `why` tells what is wrong.
Step judge_step(const Before& before, const ForceRow& row, const Facet& facet, const Touch& touch,
                std::string& why);

}  // namespace touchable::verify
