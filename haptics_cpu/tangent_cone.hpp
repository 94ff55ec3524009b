#pragma once

#include "haptics_cpu/proxy.hpp"

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
template <class Space>
Motion project_on_tangent_cone(const Space& space, const Proxy& proxy, const glm::dvec3& point,
                               const glm::dvec3& pull, bool may_leave);

}  // namespace touchable
