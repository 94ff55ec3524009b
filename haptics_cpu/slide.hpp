// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include "haptics_cpu/world_space.hpp"

namespace touchable {

/// The next motion of a proxy on the surface, by the goal's pull.
struct Motion {
    enum class Kind {
        stay,   ///< a local minimum of the distance to the goal
        leave,  ///< the pull points off the surface
        face,   ///< along face `feature` of cell (i, j)
        edge    ///< along edge `feature` from (i, j)
    };
    Kind kind = Kind::stay;
    // Written for a face and an edge only.
    Feature feature;
    std::int64_t i, j;
    /// From the proxy to the point of the face's plane (the edge's line) nearest to the goal.
    glm::dvec3 way;
    /// Load of the goal: the square of |G - C| on a face, of the sum of both faces' shares in a valley.
    double load2;
    /// All corners with weight at the proxy, and all of the face or edge, are known to be valid.
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
    double resting = 0;     ///< mu within which it rests where it is
    double stopping = 0;    ///< mu of a slide where it is; all along its way if friction is level
    bool level = true;      ///< mu is the same all over the cell it moves over
    bool presumed = false;  ///< level except for one corner of the cell, which was not tested
    // At the corners (0, 0), (1, 0), (0, 1), (1, 1) of the cell; the lesser of both bilinear maps counts.
    // Written only if not level.
    std::array<double, 4> sliding, most;
};

/// What friction depends on besides the place. By default Coulomb's: mu dynamic at any speed.
struct Slip {
    /// Share of mu static at this tick's speed: mu = mu_d + static_share (mu_s - mu_d).
    double static_share = 0;
    /// A proxy that does not have to move in a tick sticks from then on.
    bool sticks_at_rest = true;
};

/// Stribeck's rule without an exponential: mu(v) = mu_d + (mu_s - mu_d) / (1 + (v / v_s)^2). `speed`: of the
/// proxy over the surface, filtered, m/s; v_s > 0, m/s.
Slip stribeck_slip(double speed, double stribeck_speed);

/// Whether a proxy has become slow enough (v < v_s / 10) to stick wherever mu static holds it.
bool is_slow(double speed, double stribeck_speed);

/// For the corners (0, 0), (1, 0), (0, 1), (1, 1) of a place's cell: whether each is valid, or has no weight
/// there and is not tested.
std::array<bool, 4> valid_corners(const auto& space, const Place& at) {
    const bool right = at.a > 0, below = at.b > 0;
    const auto valid = [&](int di, int dj) { return space.is_valid(at.i + di, at.j + dj); };
    return {valid(0, 0), !right || valid(1, 0), !below || valid(0, 1), !right || !below || valid(1, 1)};
}

/// Stiffness and friction at a place of the surface.
HapticProperties properties_at(const auto& space, const Place& at) {
    return space.field().properties(at.i, at.j, at.a, at.b, valid_corners(space, at));
}

/// A position in a cell: (a, b), 0 to 1.
struct CellPoint {
    double a, b;
};
/// A place in the cell of a motion that begins there.
inline CellPoint in_cell_of(const Motion& motion, const Place& at) {
    return {static_cast<double>(at.i - motion.i) + at.a, static_cast<double>(at.j - motion.j) + at.b};
}

/// The cone of a proxy at `at` in a cell with these corners.
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

/// The cone of a proxy about to move; all zero if the field has no friction.
FrictionCone friction_cone(const auto& space, const Proxy& proxy, const Motion& motion, const Slip& slip) {
    const HeightField& field = space.field();
    if (!field.has_friction()) return {};
    if (field.has_haptic_image() || !motion.corners_valid) return uneven_cone(space, proxy, motion, slip);
    const HapticProperties& p = field.default_properties();
    FrictionCone cone;
    cone.stopping = p.dynamic_friction + slip.static_share * (p.static_friction - p.dynamic_friction);
    cone.resting = proxy.sliding ? cone.stopping : p.static_friction;
    // From a face or a diagonal all corners of the cell were tested.
    cone.presumed = motion.kind == Motion::Kind::face && proxy.feature != motion.feature &&
                    proxy.feature != Feature::edge_d;
    return cone;
}

/// Whether what was presumed of a motion's cone is true: the corner of its cell beyond its face is valid. By
/// Stribeck's rule the minimum at the corners may round to another number: then nothing is presumed.
bool is_as_presumed(const auto& space, const Motion& motion, const Slip& slip) {
    const bool lower = motion.feature == Feature::face_lower;
    return slip.static_share == 0 && space.is_valid(motion.i + !lower, motion.j + lower);
}

/// Whether the proxy does not have to move: the way is inside the cone.
bool rests(const FrictionCone& cone, const Motion& motion);

/// After how many image steps from `from` friction first holds a sliding proxy: the rest of its way is mu
/// times the load, with mu of that very place. Without friction the length of its whole way; may be infinite
/// if it comes to `reach`, the end of the cell, before.
double stopping_length(const FrictionCone& cone, const Motion& motion, const ImageStep& step,
                       const CellPoint& from, double reach);

/// Work of a solve, for figures and certificates.
struct SolveCounts {
    int events = 0;  ///< features passed
    int cells = 0;   ///< lattice lines and faces tested
    /// Ended by a limit: the proxy is on the surface, not yet at the minimum, or free on its way to the goal.
    /// It goes on in the next tick.
    bool capped = false;
};

/// Limits of a solve.
struct SolveLimits {
    int events = 256;
    /// A single way over the largest picture, 16384 pixels square, crosses fewer.
    int cells = 70'000;
};

/// Moves a proxy that rests on the surface, its point up to date, to where the goal pulls it: the exact
/// projected flow (docs/solver.md, Slide), feature by feature, until it is nearest to the goal, held by
/// friction, or off the surface and at the goal. The distance to the goal never grows. Adds to `counts`,
/// which has no event yet.
template <class Space>
void slide(const Space& space, Proxy& proxy, const glm::dvec3& goal, const SolveLimits& limits,
           const Slip& slip, SolveCounts& counts);

}  // namespace touchable
