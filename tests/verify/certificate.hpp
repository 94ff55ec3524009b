// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tests/verify/exported_frame.hpp"

namespace touchable::verify {

/// Motion of a finger in a tick.
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

/// The surface as seen from a point on it: the facets that meet there and the edges between them, in turn
/// about the point. Inside a facet there is one facet and no edge; on an edge, two of each; at a vertex, up
/// to six.
struct Star {
    std::vector<Facet> facets;  ///< facet k lies between edge k and edge k + 1, cyclic
    std::vector<Vec3> edges;    ///< unit vectors away from the point
    Vec3 sight;                 ///< from the camera to the point
};

/// Positions closer to a line of the lattice than this count as on it; pixels. A proxy on an edge is written
/// with an error of about 1e-12 pixels.
inline constexpr real lattice_tolerance = 1e-10L;

/// `at`: image of a point on the surface.
Star star_at(const Surface& surface, ImagePosition at);

enum class Verdict {
    minimum,  ///< no way along or off the surface leads closer to the goal
    stuck,    ///< there is a way, but the goal lies within the static friction cone
    leaves,   ///< the straight way to the goal is free
    slides    ///< the goal lies outside the friction cone
};

struct Judgement {
    Verdict verdict = Verdict::minimum;
    real tangential = 0;  ///< distance to the closest point along the steepest way, scene units
    real allowed = 0;     ///< what friction holds, scene units
    bool holds() const { return verdict == Verdict::minimum || verdict == Verdict::stuck; }
};

/// Tolerance of a position: 1e-9 of the distance between proxy and goal, and the rounding of
/// coordinates.
real position_slack(const Vec3& proxy, const Vec3& goal);

/// Is the proxy where Coulomb friction `mu` (0: none) lets it rest while it is pulled to the goal?
///
/// Without friction a point is a local minimum of the distance iff (1) the straight way to the goal does not
/// lead in front of the surface, and (2) on each facet around it no point is closer to the goal. With
/// friction the steepest of the ways of (2) is what the proxy would take; it stays if the way to the closest
/// point is at most mu times what presses it on: the distance of the goal from the facet, or on an edge the
/// sum of both facets' multipliers. On a rim it may also stay one facet's, while its way there does not cross
/// the rim.
Judgement judge(const Star& star, const Vec3& proxy, const Vec3& goal, real mu);

}  // namespace touchable::verify
