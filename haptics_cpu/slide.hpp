#pragma once

#include "haptics_cpu/friction.hpp"
#include "haptics_cpu/proxy.hpp"

namespace touchable {

/// What a solve did, for figures and certificates.
struct SolveCounts {
    int events = 0;  ///< features passed
    int cells = 0;   ///< lattice lines and faces looked at
    /// Ended by a limit: the proxy is on the surface, not yet at the minimum, or free on its way to the goal.
    /// It goes on in the next tick.
    bool capped = false;
};

/// How much a solve may do.
struct SolveLimits {
    int events = 256;
    /// A single way over the largest picture, 16384 pixels square, crosses fewer.
    int cells = 70'000;
};

/// Moves a proxy that rests on the surface, its point up to date, to where the goal pulls it: the exact
/// projected flow (docs/solver.md, Slide), feature by feature, until it is nearest to the goal, held by
/// friction, or off the surface and at the goal. The distance to the goal never grows. Adds to `counts`, in
/// which there is no event yet.
template <class Space>
void slide(const Space& space, Proxy& proxy, const glm::dvec3& goal, const SolveLimits& limits,
           const Slip& slip, SolveCounts& counts);

}  // namespace touchable
