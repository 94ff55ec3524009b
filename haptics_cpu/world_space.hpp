// SPDX-License-Identifier: Apache-2.0
#pragma once

// The surface of a HeightField in the space in which distances are measured: the world.
//
// WorldSpace is that surface as flat triangles; a VertexCache keeps the vertices of one solve. A Proxy is a
// finger's god-object: a free point or a place. surface_w and surface_point return w and position of a place
// on the surface; edge_place and face_or_rim_place return the normal form of a place: the rim of a face is
// its edges', their ends are vertices. PixelSpace (cast.hpp) has the members of WorldSpace.

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>

#include "haptics_cpu/height_field.hpp"

namespace touchable {

/// A finger's god-object (Zilles and Salisbury 1995): a free point, or a place. A place is on the surface by
/// construction, and stays on its pixel's ray when the surface moves.
struct Proxy : Place {
    /// In the space of the solve (the world, or pixels and levels): the free point; for a place, its position
    /// on the surface when that was last computed.
    glm::dvec3 point{0.0};
    /// It moved along the surface in its last tick: dynamic friction holds it back, not static.
    bool sliding = false;
};

/// A lattice vertex in the space of distances, and its height in the chart (larger is nearer to the camera).
struct SpaceVertex {
    glm::dvec3 position;
    double w;
    bool valid;  ///< false: an invalid pixel or the ring
};

/// The last computed vertices of a tick: a slide passes from cell to cell, and each cell brings one new
/// vertex. Direct-mapped by the low bits of (i, j). For one thread.
class VertexCache {
public:
    VertexCache() { i_.fill(std::numeric_limits<std::int64_t>::min()); }
    template <class Compute>
    const SpaceVertex& at(std::int64_t i, std::int64_t j, Compute compute) {
        const std::size_t entry = entry_of(i, j);
        if (!holds(entry, i, j)) {
            vertices_[entry] = compute();
            i_[entry] = i;
            j_[entry] = j;
        }
        return vertices_[entry];
    }
    /// Null if the vertex is not cached.
    const SpaceVertex* find(std::int64_t i, std::int64_t j) const {
        const std::size_t entry = entry_of(i, j);
        return holds(entry, i, j) ? &vertices_[entry] : nullptr;
    }

private:
    static std::size_t entry_of(std::int64_t i, std::int64_t j) {
        return static_cast<std::size_t>((i & 3) | ((j & 3) << 2));
    }
    bool holds(std::size_t entry, std::int64_t i, std::int64_t j) const {
        return i_[entry] == i && j_[entry] == j;
    }
    // Separate from the vertices, so that a tick begins by clearing 16 numbers; for an entry without a vertex
    // only i is written.
    std::array<std::int64_t, 16> i_, j_;
    std::array<SpaceVertex, 16> vertices_;
};

/// A point as the image sees it: pixel coordinates and w. Straight lines and flat triangles of the space are
/// straight and flat in (x, y, w).
struct ChartPoint {
    double x, y, w;
};
/// Image of a straight move p + s d: (dx, dy) times s / (1 + s stretch).
struct ImageStep {
    double dx, dy;
    double stretch;
    /// Infinite if the move reaches the camera's plane before s.
    double length_at(double s) const {
        const double denominator = 1.0 + s * stretch;
        return denominator > 0 ? s / denominator : std::numeric_limits<double>::infinity();
    }
};
/// The part of a straight way that can meet the surface, as the image sees it.
struct ChartWay {
    ChartPoint begin, end;
    bool from_the_start;  ///< nothing was cut off before `begin`
};

/// Farther from the picture than any useful lattice place, and well inside the range of integers.
inline constexpr double farthest_pixel = 1e15;

/// The solver's exact metric: world space, scene units. w = q = 1 / planar depth makes (x, y, q) a projective
/// chart of it: incidence is decided in the chart, distance in the world (docs/solver.md, Why not in pixel
/// space).
class WorldSpace {
public:
    /// For one tick, and one thread at a time.
    explicit WorldSpace(const HeightField& field);

    std::optional<glm::dvec3> from_world(const glm::dvec3& point) const { return point; }
    glm::dvec3 to_world(const glm::dvec3& point) const { return point; }

    const HeightField& field() const { return field_; }
    /// The reference is valid until a vertex more than three away in i or j is requested.
    const SpaceVertex& vertex(std::int64_t i, std::int64_t j) const {
        return cache_.at(i, j, [=, this] { return compute_vertex(i, j); });
    }
    /// Validity of a vertex, without computing its position.
    bool is_valid(std::int64_t i, std::int64_t j) const {
        const SpaceVertex* known = cache_.find(i, j);
        return known ? known->valid : field_.is_valid(i, j);
    }
    glm::dvec3 position(const ChartPoint& at) const;
    /// Where a point is seen: the only way from the world to the lattice. Nothing for a point that no pixel
    /// worth the name sees (behind the camera, in its plane, or so near to that plane that it lies farther
    /// than `farthest_pixel` from the picture) and for NaN. Such a point counts as in front of the surface.
    std::optional<ChartPoint> chart(const glm::dvec3& point) const;
    ImageStep image_step(const glm::dvec3& point, const glm::dvec3& direction) const;
    /// Cuts off what is nearer to the camera than half the nearest possible surface, and what no pixel sees.
    std::optional<ChartWay> way(const glm::dvec3& from, const glm::dvec3& to) const;
    /// Upper bound of w of the tile's surface points.
    double largest_w(int tile_x, int tile_y) const;

private:
    SpaceVertex compute_vertex(std::int64_t i, std::int64_t j) const;
    glm::dvec3 at_depth(double x, double y, double planar_depth) const;
    double nearest_planar_depth() const;
    std::optional<ChartWay> countable(const glm::dvec3& from, const glm::dvec3& to,
                                      bool from_the_start) const;

    const HeightField& field_;
    double per_fx_, per_fy_;  // 1 / focal length
    bool range_;
    mutable VertexCache cache_;
};

/// Exact at both ends, so that all edges meeting at a vertex have the same number there; never less than the
/// lesser, which rounding would make 0 or less if one end is 10^16 times the other.
inline double along_edge(double w0, double w1, double f) {
    if (f <= 0) return w0;
    if (f >= 1) return w1;
    return std::max(w0 + (w1 - w0) * f, std::min(w0, w1));
}

/// w of the surface at a place of the lattice (any feature but free); on a face, at least the least of its
/// corners'.
[[gnu::always_inline]] inline double surface_w(const auto& space, const Place& at) {
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

/// A place of a face; on the face's rim, the place of the edge or vertex, at which both sides count.
inline Place face_or_rim_place(Feature face, std::int64_t i, std::int64_t j, double a, double b) {
    const Place at = face_place(face, i, j, a, b);
    const bool lower = face == Feature::face_lower;
    if (at.a == at.b) return edge_place(Feature::edge_d, i, j, at.a);
    if (at.b == (lower ? 0.0 : 1.0)) return edge_place(Feature::edge_h, i, j + !lower, at.a);
    if (at.a == (lower ? 1.0 : 0.0)) return edge_place(Feature::edge_v, i + lower, j, at.b);
    return at;
}

/// Position of a place of the lattice, in the space.
[[gnu::always_inline]] inline glm::dvec3 surface_point(const auto& space, const Place& at) {
    return space.position({at.x(), at.y(), surface_w(space, at)});
}

}  // namespace touchable
