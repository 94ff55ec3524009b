#include "haptics_cpu/passivity_controller.hpp"

#include <algorithm>
#include <glm/geometric.hpp>

#include "haptics_cpu/tick_velocity.hpp"

namespace touchable {

namespace {

// Less than this is the rounding of the books, and nothing that a hand could feel.
constexpr double least_joules = 1e-9;

}  // namespace

glm::dvec3 PassivityController::force(double excess, const glm::dvec3& velocity) const {
    const double speed2 = glm::dot(velocity, velocity);
    if (!(excess > least_joules) || !(speed2 > 0)) return glm::dvec3(0.0);
    return velocity * -std::min(excess / (tick_seconds * speed2), most_);
}

}  // namespace touchable
