#include "player/view/solids.hpp"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <vector>

#include "engine/trigonometry.hpp"
#include "player/view/triangle_fill.hpp"

namespace touchable {
namespace {

constexpr int sides = 40;

struct Painter {
    const ViewCamera& camera;
    glm::dvec3 to_eye;  // unit, from the solid
    Material material;
    LightPicture& picture;

    glm::vec3 lit(const glm::dvec3& normal) const {
        static const glm::dvec3 key = glm::normalize(glm::dvec3(-0.55, 0.65, 0.55));
        const double facing = std::max(0.0, glm::dot(normal, to_eye));
        const double diffuse =
            0.30 + 0.12 * normal.y + 0.55 * std::max(0.0, glm::dot(normal, key)) + 0.12 * facing;
        const glm::dvec3 half = glm::normalize(key + to_eye);
        const double gloss = std::max(0.0, glm::dot(normal, half));
        const double gloss2 = gloss * gloss, gloss4 = gloss2 * gloss2, gloss8 = gloss4 * gloss4;
        const double highlight = 0.28 * gloss8 * gloss8 * gloss8 * gloss8 * gloss8;
        return glm::vec3(glm::dvec3(material.light) * diffuse + highlight);
    }

    void plot(int x, int y, float z, const glm::vec3& value) {
        const std::size_t at = picture.index(x, y);
        const glm::dvec3 normal = glm::normalize(glm::dvec3(value));
        const bool hidden = z < picture.z[at];
        if (material.opacity >= 1) {
            if (hidden) return;
            picture.z[at] = z;
            picture.light[at] = lit(normal);
            return;
        }
        // Thicker towards the rim, as a bubble is; of a closed solid only the front counts.
        const double facing = glm::dot(normal, to_eye);
        if (facing <= 0) return;
        const double rim = (1 - facing) * (1 - facing);
        const double opacity = material.opacity * (hidden ? 0.75 : 1.0) * (0.45 + 1.3 * rim);
        picture.light[at] =
            glm::mix(picture.light[at], lit(normal), static_cast<float>(std::min(opacity, 1.0)));
    }
};

}  // namespace

void draw_solid(const ViewCamera& camera, const glm::dvec3& foot, const glm::dvec3& along,
                std::span<const Ring> rings, const Material& material, LightPicture& picture) {
    const glm::dvec3 other = std::fabs(along.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
    const glm::dvec3 a = glm::normalize(glm::cross(along, other)), b = glm::cross(along, a);
    Painter painter{camera, glm::normalize(camera.eye - foot), material, picture};
    auto corner = [&](const Ring& ring, int side) {
        const double angle = 2 * pi * (side % sides) / sides;
        const glm::dvec3 away = cosine(angle) * a + sine(angle) * b;
        const glm::dvec3 point = foot + ring.height * along + ring.radius * away;
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

void draw_sphere(const ViewCamera& camera, const glm::dvec3& centre, double radius, const Material& material,
                 LightPicture& picture) {
    constexpr int steps = sides / 2;
    std::vector<Ring> rings;
    for (int k = 0; k <= steps; ++k) {
        const double angle = pi * k / steps;
        const double up = -cosine(angle), out = k == 0 || k == steps ? 0.0 : sine(angle);
        rings.push_back({radius * up, radius * out, up, out});
    }
    draw_solid(camera, centre, {0, 1, 0}, rings, material, picture);
}

void draw_rod(const ViewCamera& camera, const glm::dvec3& from, const glm::dvec3& to, double radius_from,
              double radius_to, const Material& material, LightPicture& picture) {
    const double length = glm::length(to - from);
    if (!(length > 0)) return;
    const Ring rings[] = {{0, radius_from, 0, 1}, {length, radius_to, 0, 1}};
    draw_solid(camera, from, (to - from) / length, rings, material, picture);
}

void draw_arrow(const ViewCamera& camera, const glm::dvec3& from, const glm::dvec3& to, double shaft_radius,
                const Material& material, LightPicture& picture) {
    const double length = glm::length(to - from);
    if (!(length > 0)) return;
    const double head = std::min(7.0 * shaft_radius, 0.6 * length), neck = length - head;
    const double head_radius = head * (2.6 / 7.0), slope = head_radius / head;
    const Ring shaft[] = {{0, shaft_radius, 0, 1}, {neck, shaft_radius, 0, 1}};
    const Ring collar[] = {{neck, 0, -1, 0}, {neck, head_radius, -1, 0}};
    const Ring cone[] = {{neck, head_radius, slope, 1}, {length, 0, slope, 1}};
    const glm::dvec3 along = (to - from) / length;
    for (const auto& part :
         {std::span<const Ring>(shaft), std::span<const Ring>(collar), std::span<const Ring>(cone)})
        draw_solid(camera, from, along, part, material, picture);
}

}  // namespace touchable
