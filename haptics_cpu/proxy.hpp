#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

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

}  // namespace touchable
