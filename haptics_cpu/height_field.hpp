#pragma once

// The surface as the solver sees it: a pair of frames at a moment, without a copy.
//
// A HeightField blends the depths of two frames of a SurfaceTimeline at a tick's moment and computes vertices
// only where it is asked; bounds of tiles say what is certainly out of reach. WorldSpace is that surface in
// the world, as flat triangles (a VertexCache keeps the vertices of one solve). A Place is a feature of the
// lattice with a local fraction; the functions at the end give the depth, the point and the normal form of
// places. A Proxy is a finger's god-object: a free point or a place. docs/solver.md has the mathematics.
//
// An object is one thread's, and neither waits nor allocates after the start.

/// Places on the surface: w, linear on faces and edges of the chart, and the normal form of a place (the rim
/// of a face is its edges', their ends are vertices).

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>

#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// What a proxy rests on. Cell (i, j) has the corners (i, j) to (i+1, j+1) and is cut by the diagonal between
/// them; its lower face lies where a >= b, its upper face where a <= b.
enum class Feature : std::uint8_t {
    free,
    face_lower,  ///< (i, j), (i+1, j), (i+1, j+1)
    face_upper,  ///< (i, j), (i+1, j+1), (i, j+1)
    edge_h,      ///< (i, j) to (i+1, j)
    edge_v,      ///< (i, j) to (i, j+1)
    edge_d,      ///< (i, j) to (i+1, j+1)
    vertex       ///< (i, j)
};

/// A place on the lattice's surface: an integer cell and a local fraction, never a global float.
struct Place {
    Feature feature = Feature::free;
    std::int64_t i = 0, j = 0;
    double a = 0, b = 0;  ///< image location (i + a, j + b), 0 <= a, b <= 1

    double x() const { return static_cast<double>(i) + a; }
    double y() const { return static_cast<double>(j) + b; }
    bool on_surface() const { return feature != Feature::free; }
};

/// A finger's god-object (Zilles and Salisbury 1995): a free point, or a place. A place is on the surface by
/// construction, and stays on its pixel's ray when the surface moves.
struct Proxy : Place {
    /// In the space of the solve (the world, or pixels and levels): the free point; of a place, where the
    /// surface had it when it was last looked at.
    glm::dvec3 point{0.0};
    /// It has moved along the surface in its last tick: dynamic friction holds it back, not static.
    bool sliding = false;
};

/// A lattice vertex where distances are measured, and its height in the chart (larger is nearer to the
/// camera).
struct SpaceVertex {
    glm::dvec3 position;
    double w;
    bool valid;  ///< false: an invalid pixel or the ring
};

/// The vertices of a tick that were computed last: a slide passes from cell to cell, and each cell brings one
/// new vertex. Direct-mapped by the low bits of (i, j). For one thread.
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
    /// Null for one that it does not hold.
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
    // Places beside the vertices, so that a tick begins by clearing 16 numbers; of an entry without a vertex
    // only i is written.
    std::array<std::int64_t, 16> i_, j_;
    std::array<SpaceVertex, 16> vertices_;
};

/// Depth of a lattice vertex at the moment of the field, height taken off.
struct FieldVertex {
    double depth;  ///< scene units, of the coding's semantics
    bool valid;    ///< false: an invalid pixel or the ring, at the far plane
};

/// Stiffness and friction at the corners (i, j), (i+1, j), (i, j+1), (i+1, j+1) of a cell.
using CornerProperties = std::array<HapticProperties, 4>;

/// Bilinear at (a, b) of a cell, 0 <= a, b <= 1, by its corners in that order.
inline double bilinear(double a, double b, double v00, double v10, double v01, double v11) {
    const double top = v00 + (v10 - v00) * a;
    const double bottom = v01 + (v11 - v01) * a;
    return top + (bottom - top) * b;
}

/// The surface under the hand at one moment: a pair of frames and a blend, seen as a lattice of vertices with
/// one per pixel, a ring at the far plane around the picture, and flat strips beyond it, so that every
/// integer (i, j) is a vertex (docs/conventions.md, From stored value to surface 6 to 9, and Time). Nothing
/// is computed but what is asked for. Cheap to make; refers to the scene and the frames.
class HeightField {
public:
    HeightField(const Scene& scene, const FramePair& pair);

    const Scene& scene() const { return scene_; }
    int width() const { return scene_.width; }
    int height() const { return scene_.height; }
    /// Between the pair's frames as this field has it: 0 where it holds.
    double blend() const { return blend_; }
    /// The moment this surface is of, ns on the clip's clock: the earlier frame's where it holds.
    double moment_ns() const { return moment_ns_; }
    /// Of the clip's clock. From one to another the surface may do anything.
    std::uint64_t epoch() const { return epoch_; }
    /// From the pair's earlier frame to its later one, s; nothing where both are one.
    std::optional<double> frame_interval() const {
        return interval_ns_ > 0 ? std::optional(1e-9 * static_cast<double>(interval_ns_)) : std::nullopt;
    }

    /// Depth and validity at any lattice vertex; beyond the ring, of the ring vertex nearest to it.
    FieldVertex vertex(std::int64_t i, std::int64_t j) const;
    /// The same at a lattice vertex in the pair's earlier and later frame; twice the same where this field
    /// has only one of them. `vertex` lies between the two.
    std::array<FieldVertex, 2> vertices_of_frames(std::int64_t i, std::int64_t j) const;
    /// The vertex's validity alone.
    bool is_valid(std::int64_t i, std::int64_t j) const;
    /// No vertex of the tile, ring included, has a smaller depth. May be smaller than any of them.
    double nearest_depth(int tile_x, int tile_y) const;
    /// No depth of any frame of this scene is smaller.
    double nearest_depth_anywhere() const { return scene_.depth.nearest_depth() - largest_height_; }
    TileGrid tiles() const { return tiles_; }

    /// True where a finger may meet friction at all.
    bool has_friction() const { return has_friction_; }
    /// True where properties differ from place to place.
    bool has_haptic_image() const { return has_haptic_image_; }
    /// How much of the stiffness at (i + a, j + b), 0 <= a, b <= 1, is that of holes, 0 to 1: bilinear, 1 in
    /// a cell with an invalid vertex, 0 from the next but one on. Where a hole opens half-way between two
    /// frames it grows from 0 to 1 until then. 0 everywhere in a scene that does not say how stiff holes are.
    double hole_share(std::int64_t i, std::int64_t j, double a, double b) const {
        return scene_.hole_stiffness ? missing_around(i, j, a, b) : 0;
    }

    /// Of valid pixels in a frame without a haptic image, far from holes.
    const HapticProperties& default_properties() const { return default_properties_; }
    /// Stiffness and friction at (i + a, j + b), 0 <= a, b <= 1: each frame's, linear in time, bilinear in
    /// space; the stiffness then mixed with that of holes. Friction is 0 at invalid and ring vertices, and
    /// dynamic friction never exceeds static.
    HapticProperties properties(std::int64_t i, std::int64_t j, double a, double b) const;
    /// The same, where the validity of the corners (i, j), (i+1, j), (i, j+1), (i+1, j+1) is known already.
    HapticProperties properties(std::int64_t i, std::int64_t j, double a, double b,
                                const std::array<bool, 4>& valid) const {
        const bool all_valid = valid[0] && valid[1] && valid[2] && valid[3];
        const bool alike = all_valid && !has_haptic_image() && !scene_.hole_stiffness;
        return alike ? default_properties_ : mixed_properties(i, j, a, b, valid);
    }
    /// Stiffness alone, N/m.
    double stiffness(std::int64_t i, std::int64_t j, double a, double b) const {
        const bool alike = !has_haptic_image() && !scene_.hole_stiffness;
        return alike ? default_properties_.stiffness : mixed_stiffness(i, j, a, b);
    }
    /// What the corners (i, j), (i+1, j), (i, j+1), (i+1, j+1) bring into the mean, where their validity is
    /// known: here dynamic friction may exceed static, and stiffness is not that of holes anywhere.
    CornerProperties corner_properties(std::int64_t i, std::int64_t j,
                                       const std::array<bool, 4>& valid) const;

private:
    bool is_pixel(std::int64_t i, std::int64_t j) const {
        return static_cast<std::uint64_t>(i) < static_cast<std::uint64_t>(scene_.width) &&
               static_cast<std::uint64_t>(j) < static_cast<std::uint64_t>(scene_.height);
    }
    double missing(std::int64_t i, std::int64_t j) const;
    double missing_around(std::int64_t i, std::int64_t j, double a, double b) const;
    double with_holes(double stiffness, std::int64_t i, std::int64_t j, double a, double b) const;
    double mixed_stiffness(std::int64_t i, std::int64_t j, double a, double b) const;
    HapticProperties mixed_properties(std::int64_t i, std::int64_t j, double a, double b,
                                      const std::array<bool, 4>& valid) const;
    HapticProperties properties_in(const SurfaceFrame& frame, int x, int y) const;
    HapticProperties vertex_properties(std::int64_t i, std::int64_t j, bool valid) const;
    FieldVertex frame_vertex(const SurfaceFrame& frame, const SurfaceFrame* codes, int x, int y) const;

    const Scene& scene_;
    const SurfaceFrame* prev_;
    const SurfaceFrame* prev_codes_;            // VertexSource::read_from
    const SurfaceFrame* next_ = nullptr;        // nothing to interpolate, or both frames are one
    const SurfaceFrame* next_codes_ = nullptr;  // likewise
    const SurfaceFrame* nearer_;                // in time: gives the state of half-valid pixels
    bool has_haptic_image_;
    double blend_ = 0;
    double moment_ns_;
    std::uint64_t epoch_;
    std::int64_t interval_ns_;
    TileGrid tiles_;
    double height_per_code_ = 0;
    double largest_height_ = 0;
    HapticProperties default_properties_;
    bool has_friction_;
};

/// A point as the image sees it: pixel coordinates and w. Straight lines and flat triangles of the space are
/// straight and flat in (x, y, w).
struct ChartPoint {
    double x, y, w;
};
/// How a straight move p + s d runs over the picture: by (dx, dy) times s / (1 + s stretch).
struct ImageStep {
    double dx, dy;
    double stretch;
    /// Infinite where the move reaches the camera's plane before s.
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

/// Farther from the picture than any lattice place that means something, and well inside what integers can
/// count.
inline constexpr double farthest_pixel = 1e15;

/// The solver's metric as it should be: world space, scene units. w = q = 1 / planar depth makes (x, y, q) a
/// projective chart of it: incidence is decided in the chart, distance in the world (docs/solver.md, Why not
/// in pixel space). PixelSpace has the same members.
class WorldSpace {
public:
    /// One tick's; not for two threads at once.
    explicit WorldSpace(const HeightField& field);

    std::optional<glm::dvec3> from_world(const glm::dvec3& point) const { return point; }
    glm::dvec3 to_world(const glm::dvec3& point) const { return point; }

    const HeightField& field() const { return field_; }
    /// Stays as it is until a vertex more than three away in i or j is asked for.
    const SpaceVertex& vertex(std::int64_t i, std::int64_t j) const {
        return cache_.at(i, j, [=, this] { return compute_vertex(i, j); });
    }
    /// Of a vertex whose place is not asked for, and is not computed for this.
    bool is_valid(std::int64_t i, std::int64_t j) const {
        const SpaceVertex* known = cache_.find(i, j);
        return known ? known->valid : field_.is_valid(i, j);
    }
    glm::dvec3 position(const ChartPoint& at) const;
    /// Where a point is seen. This is the one way from the world to the lattice: nothing for a point that no
    /// pixel worth the name sees (behind the camera, in its plane, or so near to that that it lies farther
    /// than `farthest_pixel` from the picture) and for what is no number. Such a point counts as in front of
    /// the surface.
    std::optional<ChartPoint> chart(const glm::dvec3& point) const;
    ImageStep image_step(const glm::dvec3& point, const glm::dvec3& direction) const;
    /// Cuts away what is nearer to the camera than half the nearest possible surface, and what no pixel sees.
    std::optional<ChartWay> way(const glm::dvec3& from, const glm::dvec3& to) const;
    /// No surface point of the tile has a larger w.
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
