#include "haptics_cpu/friction.hpp"

#include <cmath>
#include <glm/geometric.hpp>

namespace touchable {

namespace {

// A proxy that was stopped on the cone is inside it, whatever rounding says.
constexpr double on_the_cone = 1.0 + 1e-9;

double length(const glm::dvec3& v) {
    return std::sqrt(glm::dot(v, v));
}

}  // namespace

FrictionCone friction_cone(const HeightField& field, const Proxy& proxy) {
    if (!field.has_friction()) return {};
    const HapticProperties properties = field.properties(proxy.i, proxy.j, proxy.a, proxy.b);
    FrictionCone cone;
    cone.stopping = properties.dynamic_friction;
    cone.resting = proxy.sliding ? properties.dynamic_friction : properties.static_friction;
    return cone;
}

bool rests(const FrictionCone& cone, const Motion& motion) {
    return cone.resting > 0 && length(motion.way) <= cone.resting * motion.load * on_the_cone;
}

double sliding_share(const FrictionCone& cone, const Motion& motion) {
    if (cone.stopping == 0) return 1.0;
    const double share = 1.0 - cone.stopping * motion.load / length(motion.way);
    return share > 0 ? share : 0.0;
}

}  // namespace touchable
