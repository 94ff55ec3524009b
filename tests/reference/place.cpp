#include "tests/reference/place.hpp"

#include <algorithm>
#include <cmath>

namespace touchable::reference {

namespace {

/// From weights in the picture: on a flat triangle a corner weighs in proportion to its q as well.
Place weighed(const Surface& surface, std::vector<Place::Part> parts) {
    Real sum = 0;
    for (Place::Part& part : parts) {
        part.weight = std::max(part.weight, Real(0)) * surface.vertex(part.corner).q;
        sum += part.weight;
    }
    for (Place::Part& part : parts) part.weight /= sum;
    return {std::move(parts)};
}

std::vector<Place::Part> lower_face(Corner c, Real a, Real b) {
    return {{c, 1 - a}, {{c.i + 1, c.j}, a - b}, {{c.i + 1, c.j + 1}, b}};
}
std::vector<Place::Part> upper_face(Corner c, Real a, Real b) {
    return {{c, 1 - b}, {{c.i, c.j + 1}, b - a}, {{c.i + 1, c.j + 1}, a}};
}

}  // namespace

bool Place::has(Corner corner) const {
    return std::any_of(parts.begin(), parts.end(), [&](const Part& part) { return part.corner == corner; });
}

Place place_of(const Surface& surface, const Proxy& proxy) {
    const Corner c{proxy.i, proxy.j};
    const Real a = proxy.a, b = proxy.b;
    switch (proxy.feature) {
        case Feature::free:
            return {};
        case Feature::vertex:
            return weighed(surface, {{c, 1}});
        case Feature::edge_h:
            return weighed(surface, {{c, 1 - a}, {{c.i + 1, c.j}, a}});
        case Feature::edge_v:
            return weighed(surface, {{c, 1 - b}, {{c.i, c.j + 1}, b}});
        case Feature::edge_d:
            return weighed(surface, {{c, 1 - a}, {{c.i + 1, c.j + 1}, a}});
        case Feature::face_lower:
            return weighed(surface, lower_face(c, a, b));
        case Feature::face_upper:
            return weighed(surface, upper_face(c, a, b));
    }
    return {};
}

Place place_at(const Surface& surface, Real x, Real y, Real inside_x, Real inside_y) {
    const Real i = std::floor(inside_x), j = std::floor(inside_y);
    const Corner c{static_cast<std::int64_t>(i), static_cast<std::int64_t>(j)};
    const bool lower = inside_x - i >= inside_y - j;
    return weighed(surface, lower ? lower_face(c, x - i, y - j) : upper_face(c, x - i, y - j));
}

Place reduced(const Place& place) {
    Place out;
    for (const Place::Part& part : place.parts)
        if (part.weight > 0) out.parts.push_back(part);
    return out;
}

Vec point_of(const Surface& surface, const Place& place) {
    Vec sum(0);
    for (const Place::Part& part : place.parts) sum += part.weight * surface.vertex(part.corner).point;
    return sum;
}

ImagePoint image_of(const Surface& surface, const Place& place) {
    // The other way round: in the picture a corner weighs in proportion to weight / q.
    ImagePoint image;
    Real sum = 0;
    for (const Place::Part& part : place.parts) {
        const Real weight = part.weight / surface.vertex(part.corner).q;
        image.x += weight * part.corner.i;
        image.y += weight * part.corner.j;
        sum += weight;
    }
    return {image.x / sum, image.y / sum, 1 / sum};  // sum is the planar depth
}

Properties properties_at(const Surface& surface, const Place& place) {
    const ImagePoint at = image_of(surface, place);
    Corner cell = place.parts.front().corner;
    for (const Place::Part& part : place.parts)
        cell = {std::min(cell.i, part.corner.i), std::min(cell.j, part.corner.j)};
    auto within = [](Real f) { return std::clamp(f, Real(0), Real(1)); };
    return surface.properties(cell, within(at.x - cell.i), within(at.y - cell.j));
}

std::vector<Triangle> triangles_around(const Place& place) {
    const Corner at = place.parts.front().corner;
    std::vector<Triangle> found;
    for (const std::int64_t i : {at.i - 1, at.i})
        for (const std::int64_t j : {at.j - 1, at.j}) {
            const Corner first{i, j}, last{i + 1, j + 1};
            for (const Corner third : {Corner{i + 1, j}, Corner{i, j + 1}}) {
                const Triangle triangle{first, third, last};
                const bool all =
                    std::all_of(place.parts.begin(), place.parts.end(), [&](const Place::Part& part) {
                        return std::find(triangle.begin(), triangle.end(), part.corner) != triangle.end();
                    });
                if (all) found.push_back(triangle);
            }
        }
    return found;
}

}  // namespace touchable::reference
