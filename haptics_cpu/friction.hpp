#pragma once

#include "haptics_cpu/height_field.hpp"
#include "haptics_cpu/proxy.hpp"
#include "haptics_cpu/tangent_cone.hpp"

namespace touchable {

/// Coulomb friction as a cone around the goal (Melder and Harwin 2004): a proxy rests where the rest of its
/// way to the minimum is at most mu times the load, mu static while it sticks and dynamic while it slides.
struct FrictionCone {
    double resting = 0;   ///< within this mu it rests where it is
    double stopping = 0;  ///< sliding, it comes to rest at this mu
};

/// Stiffness and friction at a place of the surface.
template <class Space>
HapticProperties properties_at(const Space& space, const Proxy& at) {
    // A corner of no weight is not looked at.
    const bool right = at.a > 0, below = at.b > 0;
    const auto valid = [&](int di, int dj) { return space.vertex(at.i + di, at.j + dj).valid; };
    return space.field().properties(
        at.i, at.j, at.a, at.b,
        {valid(0, 0), !right || valid(1, 0), !below || valid(0, 1), !right || !below || valid(1, 1)});
}

/// The cone of a proxy on the surface; all zero where the field has no friction.
template <class Space>
FrictionCone friction_cone(const Space& space, const Proxy& proxy) {
    if (!space.field().has_friction()) return {};
    const HapticProperties properties = properties_at(space, proxy);
    return {proxy.sliding ? properties.dynamic_friction : properties.static_friction,
            properties.dynamic_friction};
}

/// True where the proxy need not move: the way is inside the cone.
bool rests(const FrictionCone& cone, const Motion& motion);

/// The share (0 to 1) of the motion's way after which a sliding proxy comes to rest.
double sliding_share(const FrictionCone& cone, const Motion& motion);

}  // namespace touchable
