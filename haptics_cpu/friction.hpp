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

/// The cone at a place of the surface; all zero where the field has no friction.
FrictionCone friction_cone(const HeightField& field, const Proxy& proxy);

/// True where the proxy need not move: the way is inside the cone.
bool rests(const FrictionCone& cone, const Motion& motion);

/// The share (0 to 1) of the motion's way after which a sliding proxy comes to rest.
double sliding_share(const FrictionCone& cone, const Motion& motion);

}  // namespace touchable
