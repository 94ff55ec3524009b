#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "haptics_cpu/proxy.hpp"
#include "haptics_cpu/world_space.hpp"

/// Places on the surface: w, linear on faces and edges of the chart, and the normal form of a place (the rim
/// of a face is its edges', their ends are vertices).
namespace touchable {

/// Exact at both ends, so that all edges meeting at a vertex see the same number there; never less than the
/// lesser, which rounding would make 0 or less where one end is 10^16 times the other.
inline double along_edge(double w0, double w1, double f) {
    if (f <= 0) return w0;
    if (f >= 1) return w1;
    return std::max(w0 + (w1 - w0) * f, std::min(w0, w1));
}

/// w of the surface at a place of the lattice (any feature but free); on a face, too, no less than the least
/// of its corners'.
template <class Space>
[[gnu::always_inline]] inline double surface_w(const Space& space, const Place& at) {
    auto w = [&](int di, int dj) { return space.vertex(at.i + di, at.j + dj).w; };
    switch (at.feature) {
        case Feature::vertex:
            return w(0, 0);
        case Feature::edge_h:
            return along_edge(w(0, 0), w(1, 0), at.a);
        case Feature::edge_v:
            return along_edge(w(0, 0), w(0, 1), at.b);
        case Feature::edge_d:
            return along_edge(w(0, 0), w(1, 1), at.a);
        case Feature::face_lower: {
            const double w00 = w(0, 0), w10 = w(1, 0), w11 = w(1, 1);
            return std::max(w00 + (w10 - w00) * at.a + (w11 - w10) * at.b, std::min(std::min(w00, w10), w11));
        }
        default: {
            const double w00 = w(0, 0), w01 = w(0, 1), w11 = w(1, 1);
            return std::max(w00 + (w01 - w00) * at.b + (w11 - w01) * at.a, std::min(std::min(w00, w01), w11));
        }
    }
}

/// Whether the depth of a place comes from an invalid vertex too: the place is on the wall or on the ground
/// of a hole. The rim, from valid vertex to valid vertex, is not.
template <class Space>
bool is_in_hole(const Space& space, const Place& at) {
    auto invalid = [&](int di, int dj) { return !space.is_valid(at.i + di, at.j + dj); };
    switch (at.feature) {
        case Feature::free:
            return false;
        case Feature::vertex:
            return invalid(0, 0);
        case Feature::edge_h:
            return invalid(0, 0) || invalid(1, 0);
        case Feature::edge_v:
            return invalid(0, 0) || invalid(0, 1);
        case Feature::edge_d:
            return invalid(0, 0) || invalid(1, 1);
        case Feature::face_lower:
            return invalid(0, 0) || invalid(1, 0) || invalid(1, 1);
        case Feature::face_upper:
            return invalid(0, 0) || invalid(0, 1) || invalid(1, 1);
    }
    return false;
}

/// The place of a face at (a, b) of its cell; rounding never leaves the face.
inline Place face_place(Feature face, std::int64_t i, std::int64_t j, double a, double b) {
    auto unit = [](double f) { return f < 0 ? 0.0 : (f > 1 ? 1.0 : f); };
    Place at;
    at.feature = face;
    at.i = i;
    at.j = j;
    at.a = unit(a);
    at.b = unit(b);
    if (face == Feature::face_lower && at.b > at.a) at.b = at.a;
    if (face == Feature::face_upper && at.a > at.b) at.a = at.b;
    return at;
}

/// The face under image location (x, y), of a chart's point or between two.
inline Place face_under(double x, double y) {
    const double fx = std::floor(x), fy = std::floor(y);
    const double a = x - fx, b = y - fy;
    return face_place(a >= b ? Feature::face_lower : Feature::face_upper, static_cast<std::int64_t>(fx),
                      static_cast<std::int64_t>(fy), a, b);
}

/// The place at fraction f of an edge; its ends are vertices.
inline Place edge_place(Feature edge, std::int64_t i, std::int64_t j, double f) {
    const bool along_x = edge != Feature::edge_v, along_y = edge != Feature::edge_h;
    Place at;
    at.feature = edge;
    at.i = i;
    at.j = j;
    if (f <= 0 || f >= 1) {
        at.feature = Feature::vertex;
        if (f >= 1) {
            at.i += along_x ? 1 : 0;
            at.j += along_y ? 1 : 0;
        }
        return at;
    }
    at.a = along_x ? f : 0.0;
    at.b = along_y ? f : 0.0;
    return at;
}

/// A place of a face; on the face's rim, the edge's or the vertex', where both sides count.
inline Place face_or_rim_place(Feature face, std::int64_t i, std::int64_t j, double a, double b) {
    const Place at = face_place(face, i, j, a, b);
    const bool lower = face == Feature::face_lower;
    if (at.a == at.b) return edge_place(Feature::edge_d, i, j, at.a);
    if (at.b == (lower ? 0.0 : 1.0)) return edge_place(Feature::edge_h, i, j + !lower, at.a);
    if (at.a == (lower ? 1.0 : 0.0)) return edge_place(Feature::edge_v, i + lower, j, at.b);
    return at;
}

/// Where a place of the lattice is, in the space.
template <class Space>
[[gnu::always_inline]] inline glm::dvec3 surface_point(const Space& space, const Place& at) {
    return space.position({at.x(), at.y(), surface_w(space, at)});
}

}  // namespace touchable
