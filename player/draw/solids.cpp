#include "player/draw/solids.hpp"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <span>
#include <vector>

#include "engine/base/trigonometry.hpp"
#include "player/draw/triangle_fill.hpp"
#include "shaders/solid_light.h"

namespace touchable {
namespace {

constexpr int sides = 40;

struct Painter {
    const ViewCamera& camera;
    glm::vec3 to_eye;  // unit, from the solid
    SolidMaterial material;
    LightPicture& picture;

    glm::vec3 lit(const glm::vec3& normal) const { return solid_light(material.light, normal, to_eye); }

    void plot(int x, int y, float z, const glm::vec3& value) {
        const std::size_t at = picture.index(x, y);
        const glm::vec3 normal = glm::normalize(value);
        const bool hidden = z < picture.z[at];
        if (material.opacity >= 1) {
            if (hidden) return;
            picture.z[at] = z;
            picture.light[at] = lit(normal);
            return;
        }
        // Of a closed solid only the front counts.
        const float facing = glm::dot(normal, to_eye);
        if (facing <= 0) return;
        picture.light[at] = glm::mix(picture.light[at], lit(normal), veil(material.opacity, facing, hidden));
    }
};

void draw_rings(const ViewCamera& camera, const Solid& solid, std::span<const Ring> rings,
                LightPicture& picture) {
    const glm::dvec3& along = solid.along;
    const glm::dvec3 other = std::fabs(along.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
    const glm::dvec3 a = glm::normalize(glm::cross(along, other)), b = glm::cross(along, a);
    Painter painter{camera, glm::vec3(glm::normalize(camera.eye - solid.foot)), solid.material, picture};
    auto corner = [&](const Ring& ring, int side) {
        const double angle = 2 * pi * (side % sides) / sides;
        const glm::dvec3 away = cosine(angle) * a + sine(angle) * b;
        const glm::dvec3 point = solid.foot + ring.height * along + ring.radius * away;
        return FillCorner{glm::vec4(camera.clip_from_world * glm::dvec4(point, 1.0)),
                          glm::vec3(ring.normal_along * along + ring.normal_away * away)};
    };
    auto plot = [&](int x, int y, float z, const glm::vec3& value) { painter.plot(x, y, z, value); };
    for (std::size_t k = 0; k + 1 < rings.size(); ++k)
        for (int side = 0; side < sides; ++side) {
            const FillCorner c00 = corner(rings[k], side), c01 = corner(rings[k], side + 1);
            const FillCorner c10 = corner(rings[k + 1], side), c11 = corner(rings[k + 1], side + 1);
            fill_triangle({c00, c01, c11}, picture.width, picture.height, plot);
            fill_triangle({c00, c11, c10}, picture.width, picture.height, plot);
        }
}

}  // namespace

void add_ball(std::vector<Solid>& solids, const glm::dvec3& centre, double radius,
              const SolidMaterial& material) {
    solids.push_back({centre, {0, 1, 0}, {0, radius, 0, 1}, {}, true, material});
}

void add_rod(std::vector<Solid>& solids, const glm::dvec3& from, const glm::dvec3& to, double radius_from,
             double radius_to, const SolidMaterial& material) {
    const double length = glm::length(to - from);
    if (!(length > 0)) return;
    solids.push_back(
        {from, (to - from) / length, {0, radius_from, 0, 1}, {length, radius_to, 0, 1}, false, material});
}

void add_arrow(std::vector<Solid>& solids, const glm::dvec3& from, const glm::dvec3& to, double radius_from,
               double radius_to, const SolidMaterial& material) {
    const double length = glm::length(to - from);
    if (!(length > 0)) return;
    const double head = std::min(7.0 * radius_to, 0.6 * length), neck = length - head;
    const double neck_radius = glm::mix(radius_from, radius_to, neck / length);
    const double head_radius = head * (2.6 / 7.0), slope = head_radius / head;
    const double taper = (radius_from - radius_to) / length;
    const Ring parts[][2] = {{{0, radius_from, taper, 1}, {neck, neck_radius, taper, 1}},  // shaft
                             {{neck, 0, -1, 0}, {neck, head_radius, -1, 0}},               // collar
                             {{neck, head_radius, slope, 1}, {length, 0, slope, 1}}};
    for (const auto& [lower, upper] : parts)
        solids.push_back({from, (to - from) / length, lower, upper, false, material});
}

void draw_solid(const ViewCamera& camera, const Solid& solid, LightPicture& picture) {
    if (!solid.is_ball) {
        const Ring rings[] = {solid.from, solid.to};
        return draw_rings(camera, solid, rings, picture);
    }
    constexpr int steps = sides / 2;
    const double radius = solid.from.radius;
    std::vector<Ring> rings;
    for (int k = 0; k <= steps; ++k) {
        const double angle = pi * k / steps;
        const double up = -cosine(angle), out = k == 0 || k == steps ? 0.0 : sine(angle);
        rings.push_back({radius * up, radius * out, up, out});
    }
    draw_rings(camera, solid, rings, picture);
}

}  // namespace touchable
