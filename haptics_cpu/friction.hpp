#pragma once

#include "haptics_cpu/height_field.hpp"
#include "haptics_cpu/proxy.hpp"
#include "haptics_cpu/tangent_cone.hpp"

namespace touchable {

/// Coulomb friction as a cone around the goal (Melder and Harwin 2004; docs/solver.md, Friction): a proxy
/// rests where the rest of its way to the minimum is at most mu times the load, mu static while it sticks and
/// dynamic while it slides.
struct FrictionCone {
    double resting = 0;   ///< within this mu it rests where it is
    double stopping = 0;  ///< sliding, it comes to rest at this mu
};

/// What friction depends on beside the place. By default Coulomb's: mu dynamic at any speed.
struct Slip {
    /// How much of mu static is left at this tick's speed: mu = mu_d + static_share (mu_s - mu_d).
    double static_share = 0;
    /// A proxy that need not move in a tick sticks from then on.
    bool sticks_at_rest = true;
};

/// Stribeck's rule without an exponential: mu(v) = mu_d + (mu_s - mu_d) / (1 + (v / v_s)^2). `speed`: of the
/// proxy over the surface, filtered, m/s; v_s > 0, m/s.
Slip stribeck_slip(double speed, double stribeck_speed);

/// True where a proxy has become slow enough (v < v_s / 10) to stick wherever mu static holds it.
bool is_slow(double speed, double stribeck_speed);

/// Stiffness and friction at a place of the surface.
template <class Space>
HapticProperties properties_at(const Space& space, const Place& at) {
    // A corner of no weight is not looked at.
    const bool right = at.a > 0, below = at.b > 0;
    const auto valid = [&](int di, int dj) { return space.vertex(at.i + di, at.j + dj).valid; };
    return space.field().properties(
        at.i, at.j, at.a, at.b,
        {valid(0, 0), !right || valid(1, 0), !below || valid(0, 1), !right || !below || valid(1, 1)});
}

/// The cone of a proxy on the surface; all zero where the field has no friction. `corners_valid`: of its
/// motion.
template <class Space>
FrictionCone friction_cone(const Space& space, const Proxy& proxy, const Slip& slip, bool corners_valid) {
    const HeightField& field = space.field();
    if (!field.has_friction()) return {};
    const HapticProperties properties =
        corners_valid ? field.properties(proxy.i, proxy.j, proxy.a, proxy.b, {true, true, true, true})
                      : properties_at(space, proxy);
    const double sliding = properties.dynamic_friction +
                           slip.static_share * (properties.static_friction - properties.dynamic_friction);
    return {proxy.sliding ? sliding : properties.static_friction, sliding};
}

/// True where the proxy need not move: the way is inside the cone.
bool rests(const FrictionCone& cone, const Motion& motion);

/// The share (0 to 1) of the motion's way after which a sliding proxy comes to rest.
double sliding_share(const FrictionCone& cone, const Motion& motion);

}  // namespace touchable
