#include "player/draw/under_finger.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "haptics_cpu/surface_lattice.hpp"
#include "haptics_cpu/world_space.hpp"

namespace touchable {
namespace {

/// Of the surface as it is felt; nothing in a hole and beside the picture.
std::optional<glm::dvec3> felt_point(const WorldSpace& space, double x, double y) {
    const HeightField& field = space.field();
    if (!(x >= 0 && y >= 0 && x < field.width() - 1 && y < field.height() - 1)) return std::nullopt;
    const Place at = face_under(x, y);
    if (is_in_hole(space, at)) return std::nullopt;
    return surface_point(space, at);
}

}  // namespace

std::optional<UnderFinger> under_finger(const HeightField& field, const glm::dvec3& proxy, double reach) {
    const Camera& camera = field.scene().camera;
    const auto seen = project(camera, proxy);
    if (!seen) return std::nullopt;
    const WorldSpace space(field);
    const auto middle = felt_point(space, seen->x, seen->y);
    if (!middle) return std::nullopt;
    const double right = std::max(1.0, std::min(reach * camera.fx / -middle->z, field.width() / 4.0)),
                 down = std::max(1.0, std::min(reach * camera.fy / -middle->z, field.height() / 4.0));
    // Where the surface ends, or goes over into another one, the middle itself is one of the two ends.
    const auto end = [&](double dx, double dy) {
        const auto point = felt_point(space, seen->x + dx, seen->y + dy);
        return point && glm::distance(*point, *middle) < 4 * reach ? *point : *middle;
    };
    const glm::dvec3 normal = glm::cross(end(right, 0) - end(-right, 0), end(0, -down) - end(0, down));
    const double length = glm::length(normal);
    UnderFinger under;
    under.normal = length > 0 ? normal / length : -glm::normalize(*middle);
    under.height = std::max(glm::dot(proxy - *middle, under.normal), 0.0);
    under.foot = proxy - under.normal * glm::dot(proxy - *middle, under.normal);
    return under;
}

}  // namespace touchable
