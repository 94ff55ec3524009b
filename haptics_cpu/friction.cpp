#include "haptics_cpu/friction.hpp"

#include <cmath>
#include <glm/geometric.hpp>

namespace touchable {

namespace {

// A proxy that was stopped on the cone is inside it, whatever rounding says.
constexpr double on_the_cone = 1.0 + 2e-9;

}  // namespace

Slip stribeck_slip(double speed, double stribeck_speed) {
    const double ratio = speed / stribeck_speed;
    return {1.0 / (1.0 + ratio * ratio), false};
}

bool is_slow(double speed, double stribeck_speed) {
    return speed < 0.1 * stribeck_speed;
}

bool rests(const FrictionCone& cone, const Motion& motion) {
    const double mu2 = cone.resting * cone.resting;
    return mu2 > 0 && glm::dot(motion.way, motion.way) <= mu2 * motion.load2 * on_the_cone;
}

double sliding_share(const FrictionCone& cone, const Motion& motion) {
    if (cone.stopping == 0) return 1.0;
    const double share = 1.0 - cone.stopping * std::sqrt(motion.load2 / glm::dot(motion.way, motion.way));
    return share > 0 ? share : 0.0;
}

}  // namespace touchable
