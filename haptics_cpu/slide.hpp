#pragma once

#include <array>
#include "haptics_cpu/world_space.hpp"

namespace touchable {

/// What a proxy on the surface does next, given where the goal pulls it.
struct Motion {
    enum class Kind {
        stay,   ///< a local minimum of the distance to the goal
        leave,  ///< the pull points off the surface
        face,   ///< along face `feature` of cell (i, j)
        edge    ///< along edge `feature` from (i, j)
    };
    Kind kind = Kind::stay;
    // Only of a face and an edge; else not written.
    Feature feature;
    std::int64_t i, j;
    /// From the proxy to the point of the face's plane (the edge's line) nearest to the goal.
    glm::dvec3 way;
    /// How hard the goal presses: the square of |G - C| on a face, of the sum of both faces' shares in a
    /// valley.
    double load2;
    /// Every corner of weight at the proxy is known to be valid, and every one of the face or edge.
    bool corners_valid;
};

/// Projects the pull v = G - P on the tangent cone of the free space at the proxy (docs/solver.md, Slide):
/// the cone's boundary is a union of face sectors, so the projection is the longest among the projections on
/// incident faces (where it falls into the face's sector) and edges. Exact, also at ridges and saddles, where
/// free space is not convex. `may_leave` false treats a pull off the surface as one along it.
Motion project_on_tangent_cone(const auto& space, const Proxy& proxy, const glm::dvec3& point,
                               const glm::dvec3& pull, bool may_leave);

/// Coulomb friction as a cone around the goal (Melder and Harwin 2004; docs/solver.md, Friction): a proxy
/// rests where the rest of its way to the minimum is at most mu times the load, mu static while it sticks and
/// dynamic while it slides.
struct FrictionCone {
    double resting = 0;     ///< within this mu it rests where it is
    double stopping = 0;    ///< mu of a slide where it is; all along its way where friction is level
    bool level = true;      ///< the cell it moves over has the same mu everywhere
    bool presumed = false;  ///< level but for one corner of the cell, which was not looked at
    // At the corners (0, 0), (1, 0), (0, 1), (1, 1) of the cell: of two bilinear maps the lesser counts.
    // Written only where it is not level.
    std::array<double, 4> sliding, most;
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

/// Of the cell of a place the corners (0, 0), (1, 0), (0, 1), (1, 1): whether each is valid, or has no weight
/// there and is not looked at.
std::array<bool, 4> valid_corners(const auto& space, const Place& at) {
    const bool right = at.a > 0, below = at.b > 0;
    const auto valid = [&](int di, int dj) { return space.is_valid(at.i + di, at.j + dj); };
    return {valid(0, 0), !right || valid(1, 0), !below || valid(0, 1), !right || !below || valid(1, 1)};
}

/// Stiffness and friction at a place of the surface.
HapticProperties properties_at(const auto& space, const Place& at) {
    return space.field().properties(at.i, at.j, at.a, at.b, valid_corners(space, at));
}

/// Where in a cell: (a, b), 0 to 1.
struct CellPoint {
    double a, b;
};
/// A place in the cell of a motion that begins there.
inline CellPoint in_cell_of(const Motion& motion, const Place& at) {
    return {static_cast<double>(at.i - motion.i) + at.a, static_cast<double>(at.j - motion.j) + at.b};
}

/// The cone of a proxy at `at` in a cell with such corners.
FrictionCone cone_over(const CornerProperties& corners, const CellPoint& at, bool sliding, const Slip& slip);

/// The cone of a proxy about to move through a cell whose friction may differ from place to place.
FrictionCone uneven_cone(const auto& space, const Proxy& proxy, const Motion& motion, const Slip& slip) {
    // Along a side of the cell the other side's corners have no weight.
    const bool right = motion.feature != Feature::edge_v, below = motion.feature != Feature::edge_h;
    const auto valid = [&](int di, int dj) { return space.is_valid(motion.i + di, motion.j + dj); };
    CornerProperties corners = space.field().corner_properties(
        motion.i, motion.j,
        {valid(0, 0), !right || valid(1, 0), !below || valid(0, 1), !right || !below || valid(1, 1)});
    if (!right) corners = {corners[0], corners[0], corners[2], corners[2]};
    if (!below) corners = {corners[0], corners[1], corners[0], corners[1]};
    return cone_over(corners, in_cell_of(motion, proxy), proxy.sliding, slip);
}

/// The cone of a proxy about to move; all zero where the field has no friction.
FrictionCone friction_cone(const auto& space, const Proxy& proxy, const Motion& motion, const Slip& slip) {
    const HeightField& field = space.field();
    if (!field.has_friction()) return {};
    if (field.has_haptic_image() || !motion.corners_valid) return uneven_cone(space, proxy, motion, slip);
    const HapticProperties& p = field.default_properties();
    FrictionCone cone;
    cone.stopping = p.dynamic_friction + slip.static_share * (p.static_friction - p.dynamic_friction);
    cone.resting = proxy.sliding ? cone.stopping : p.static_friction;
    // From a face or a diagonal all corners of the cell were looked at.
    cone.presumed = motion.kind == Motion::Kind::face && proxy.feature != motion.feature &&
                    proxy.feature != Feature::edge_d;
    return cone;
}

/// Whether what was presumed of a motion's cone is so: that the corner of its cell beyond its face is valid.
/// By Stribeck's rule the minimum at the corners may round to another number: there nothing is presumed.
bool is_as_presumed(const auto& space, const Motion& motion, const Slip& slip) {
    const bool lower = motion.feature == Feature::face_lower;
    return slip.static_share == 0 && space.is_valid(motion.i + !lower, motion.j + lower);
}

/// True where the proxy need not move: the way is inside the cone.
bool rests(const FrictionCone& cone, const Motion& motion);

/// After how many image steps from `from` friction holds a sliding proxy for the first time: where the rest
/// of its way is mu times the load, with mu of that very place. Without friction the length of its whole way;
/// maybe infinite where it comes to `reach`, the end of the cell, before.
double stopping_length(const FrictionCone& cone, const Motion& motion, const ImageStep& step,
                       const CellPoint& from, double reach);

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
