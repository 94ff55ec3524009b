#pragma once

#include <array>
#include <vector>

#include "haptics_cpu/world_space.hpp"
#include "tests/reference/surface.hpp"

namespace touchable::reference {

/// A point of the surface as its corners weigh it in the world: one corner, two of an edge, or three of a
/// triangle. Weights add up to 1.
struct Place {
    struct Part {
        Corner corner;
        Real weight = 0;
    };
    std::vector<Part> parts;

    bool has(Corner corner) const;
};

/// The place of a proxy that is on the surface: the same pixel position on the same feature.
Place place_of(const Surface& surface, const Proxy& proxy);
/// The place seen at a position of the picture, on the triangle around (inside_x, inside_y).
Place place_at(const Surface& surface, Real x, Real y, Real inside_x, Real inside_y);
/// Without the corners of no weight: on a triangle's rim, the edge's.
Place reduced(const Place& place);

Vec point_of(const Surface& surface, const Place& place);
ImagePoint image_of(const Surface& surface, const Place& place);
Properties properties_at(const Surface& surface, const Place& place);

using Triangle = std::array<Corner, 3>;
/// Every triangle that has all the corners of the place: one, two or six.
std::vector<Triangle> triangles_around(const Place& place);

}  // namespace touchable::reference
