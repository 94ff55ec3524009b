#pragma once

#include "tests/verify/exported_frame.hpp"

namespace touchable::verify {

struct ImagePosition {
    real x = 0, y = 0;
};

/// A flat piece of the surface: half of a cell, or one of the unbounded strips outside the ring. `column` and
/// `row` are the cell's (-2 and the picture's size: outside the ring), `half` is 0 above the diagonal and 1
/// below it.
struct FacetId {
    int column = 0, row = 0, half = 0;
    bool operator==(const FacetId&) const = default;
};

struct Facet {
    FacetId id;
    Vec3 point;   ///< on it
    Vec3 normal;  ///< unit, on the camera's side
    bool operator==(const Facet&) const = default;
};

struct Vertex {
    Vec3 position;       ///< world
    real q = 0;          ///< 1 / planar depth
    bool solid = false;  ///< a valid pixel, not a hole or the ring
    real height = 0;     ///< taken off the depth, scene units
};

/// The surface between two exported frames, straight from the written conventions and in extended precision.
class Surface {
public:
    /// The frames must outlive it. 0 <= blend <= 1; 0 where the earlier frame is held.
    Surface(const ExportedFrame& earlier, const ExportedFrame& later, real blend);

    const Meaning& meaning() const { return meaning_; }
    /// -1 <= i <= width, -1 <= j <= height: the picture and its ring.
    Vertex vertex(int i, int j) const;
    /// The facet around a position that lies on no line of the lattice.
    Facet facet_at(ImagePosition at) const;
    /// 1 / planar depth of the surface.
    real q_at(ImagePosition at) const;
    /// Linear in time, bilinear in space; mu_dynamic is at most mu_static.
    Touch touch_at(ImagePosition at) const;

    /// Ray (u, v, -1).
    Vec3 ray(real x, real y) const;
    /// Where a world point in front of the camera is seen.
    ImagePosition project(const Vec3& world) const;

private:
    FacetId facet_id(ImagePosition at) const;
    Touch touch_of_pixel(int i, int j) const;
    real lacks_depth(int i, int j) const;
    real hole_around(int i, int j) const;

    const ExportedFrame& earlier_;
    const ExportedFrame& later_;
    const ExportedFrame& nearer_;
    const Meaning& meaning_;
    real blend_;
};

}  // namespace touchable::verify
