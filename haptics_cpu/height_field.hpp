// SPDX-License-Identifier: Apache-2.0
#pragma once

// The surface as the solver sees it: a pair of frames at a moment, without a copy.
//
// A HeightField blends the depths of two frames of a SurfaceTimeline at a tick's moment and computes vertices
// only on demand; bounds of tiles show what is certainly out of reach. A Place is a feature of the lattice
// with a local fraction: face_under returns the one that is seen at an image location, point_under its point
// in the world, is_in_hole whether it is on a hole's wall. The solver measures the same surface in its own
// space (world_space.hpp). docs/solver.md has the mathematics.
//
// Threads: one uses a HeightField, which neither waits nor allocates, and may not outlive its frames.

#include <array>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>

#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// The feature on which a proxy rests. Cell (i, j) has the corners (i, j) to (i+1, j+1) and is cut by the
/// diagonal between them; its lower face lies where a >= b, its upper face where a <= b.
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

/// The face under image location (x, y).
inline Place face_under(double x, double y) {
    const double fx = std::floor(x), fy = std::floor(y);
    const double a = x - fx, b = y - fy;
    return face_place(a >= b ? Feature::face_lower : Feature::face_upper, static_cast<std::int64_t>(fx),
                      static_cast<std::int64_t>(fy), a, b);
}

/// Whether an invalid vertex of the lattice (a HeightField, or the space of a solve) contributes to the depth
/// of a place: the place is on the wall or on the ground of a hole. The rim, from valid vertex to valid
/// vertex, is not.
bool is_in_hole(const auto& lattice, const Place& at) {
    auto invalid = [&](int di, int dj) { return !lattice.is_valid(at.i + di, at.j + dj); };
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
/// integer (i, j) is a vertex (docs/conventions.md, From stored value to surface 6 to 9, and Time).
/// Everything is computed on demand. Cheap to make; refers to the scene and the frames.
class HeightField {
public:
    HeightField(const Scene& scene, const FramePair& pair);

    const Scene& scene() const { return scene_; }
    int width() const { return scene_.width; }
    int height() const { return scene_.height; }
    /// Blend between the pair's frames in this field: 0 if it holds the earlier one.
    double blend() const { return blend_; }
    /// The moment of this surface, ns on the clip's clock: the earlier frame's if the field holds it.
    double moment_ns() const { return moment_ns_; }
    /// Epoch of the clip's clock. From one to another the surface may change in any way.
    std::uint64_t epoch() const { return epoch_; }
    /// From the pair's earlier frame to its later one, s; nothing if both are the same.
    std::optional<double> frame_interval() const {
        return interval_ns_ > 0 ? std::optional(1e-9 * static_cast<double>(interval_ns_)) : std::nullopt;
    }

    /// Depth and validity at any lattice vertex; beyond the ring, those of the nearest ring vertex.
    FieldVertex vertex(std::int64_t i, std::int64_t j) const;
    /// The same at a lattice vertex in the pair's earlier and later frame; twice the same if this field has
    /// only one of them. `vertex` lies between the two.
    std::array<FieldVertex, 2> vertices_of_frames(std::int64_t i, std::int64_t j) const;
    /// The vertex's validity alone.
    bool is_valid(std::int64_t i, std::int64_t j) const;
    /// Lower bound, not always reached, of the depths of the tile's vertices, ring included.
    double nearest_depth(int tile_x, int tile_y) const;
    /// Lower bound of the depths of all frames of this scene.
    double nearest_depth_anywhere() const { return scene_.depth.nearest_depth() - largest_height_; }
    TileGrid tiles() const { return tiles_; }

    /// Whether a finger may meet friction at all.
    bool has_friction() const { return has_friction_; }
    /// Whether properties differ from place to place.
    bool has_haptic_image() const { return has_haptic_image_; }
    /// Share of holes in the stiffness at (i + a, j + b), 0 <= a, b <= 1, 0 to 1: bilinear, 1 in a cell with
    /// an invalid vertex, 0 from the next but one on. If a hole opens half-way between two frames, it grows
    /// from 0 to 1 until then. 0 everywhere in a scene that does not state how stiff holes are.
    double hole_share(std::int64_t i, std::int64_t j, double a, double b) const {
        return scene_.hole_stiffness ? missing_around(i, j, a, b) : 0;
    }

    /// Of the frame nearer in time; for display and tables, never for a force.
    ErrorBar error_bar(double x, double y) const { return nearer_->signs.bar_at(x, y); }

    /// Properties of valid pixels in a frame without a haptic image, far from holes.
    const HapticProperties& default_properties() const { return default_properties_; }
    /// Stiffness and friction at (i + a, j + b), 0 <= a, b <= 1: each frame's, linear in time, bilinear in
    /// space; the stiffness then mixed with that of holes. Friction is 0 at invalid and ring vertices, and
    /// dynamic friction never exceeds static.
    HapticProperties properties(std::int64_t i, std::int64_t j, double a, double b) const;
    /// The same, if the validity of the corners (i, j), (i+1, j), (i, j+1), (i+1, j+1) is known already.
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
    /// What the corners (i, j), (i+1, j), (i, j+1), (i+1, j+1) contribute to the mean, by their known
    /// validity: dynamic friction may exceed static here, and stiffness never includes that of holes.
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
    /// A vertex between two frames. Not inlined, nor are the solver's other such functions: a third of
    /// this module's compile time went into their copies, which make no tick faster.
    [[gnu::noinline]] FieldVertex between(const FieldVertex& prev, int x, int y) const;
    FieldVertex frame_vertex(const SurfaceFrame& frame, const SurfaceFrame* codes, int x, int y) const;

    const Scene& scene_;
    const SurfaceFrame* prev_;
    const SurfaceFrame* prev_codes_;            // VertexSource::read_from
    const SurfaceFrame* next_ = nullptr;        // null: nothing to interpolate, or both are the same
    const SurfaceFrame* next_codes_ = nullptr;  // of next_
    const SurfaceFrame* nearer_;                // in time: decides on half-valid pixels
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

/// World point of the surface that is seen at image location (x, y).
glm::dvec3 point_under(const HeightField& field, double x, double y);
/// Planar depth of a place on it.
double surface_depth(const HeightField& field, const Place& at);

}  // namespace touchable
