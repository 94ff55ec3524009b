// SPDX-License-Identifier: Apache-2.0
#include "player/draw/finger_marks.hpp"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "engine/base/same_bits.hpp"
#include "player/draw/light_picture.hpp"
#include "player/view/drawn_surface.hpp"
#include "shaders/cut_rule.h"
#include "shaders/dents.h"
#include "shaders/solid_light.h"

// Fingers as shapes (balls, rods, arrows, threads, shadows), the dents under them, and plain code that draws
// both into a picture in linear light. gpu_fingers.cpp draws the same shapes on a GPU.

namespace touchable {
namespace {

/// A point of the felt surface; nullopt in a hole or beside the picture.
std::optional<glm::dvec3> felt_point(const HeightField& field, double x, double y) {
    if (!(x >= 0 && y >= 0 && x < field.width() - 1 && y < field.height() - 1)) return std::nullopt;
    if (is_in_hole(field, face_under(x, y))) return std::nullopt;
    return point_under(field, x, y);
}

constexpr int solid_sides = 40;

/// Draws a solid of revolution, smoothly lit; opaque solids test and write z.
void draw_rings(const ViewCamera& camera, const Solid& solid, std::span<const Ring> rings,
                LightPicture& picture) {
    const glm::dvec3& along = solid.along;
    const glm::dvec3 other = std::fabs(along.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
    const glm::dvec3 a = glm::normalize(glm::cross(along, other)), b = glm::cross(along, a);
    const SolidMaterial& material = solid.material;
    const glm::vec3 to_eye(glm::normalize(camera.eye - solid.foot));
    auto corner = [&](const Ring& ring, int side) {
        const double angle = 2 * pi * (side % solid_sides) / solid_sides;
        const glm::dvec3 away = cosine(angle) * a + sine(angle) * b;
        const glm::dvec3 point = solid.foot + ring.height * along + ring.radius * away;
        return FillCorner{glm::vec4(camera.clip_from_world * glm::dvec4(point, 1.0)),
                          glm::vec3(ring.normal_along * along + ring.normal_away * away)};
    };
    const auto plot = [&](int x, int y, float z, const glm::vec3& value) {
        const std::size_t at = picture.index(x, y);
        const glm::vec3 normal = glm::normalize(value), lit = solid_light(material.light, normal, to_eye);
        const bool hidden = z < picture.z[at];
        if (material.opacity >= 1) {
            if (hidden) return;
            picture.z[at] = z;
            picture.light[at] = lit;
            return;
        }
        // Only the front of a closed solid is blended.
        const float facing = glm::dot(normal, to_eye);
        if (facing > 0)
            picture.light[at] = glm::mix(picture.light[at], lit, veil(material.opacity, facing, hidden));
    };
    for (std::size_t k = 0; k + 1 < rings.size(); ++k)
        for (int side = 0; side < solid_sides; ++side) {
            const FillCorner c00 = corner(rings[k], side), c01 = corner(rings[k], side + 1);
            const FillCorner c10 = corner(rings[k + 1], side), c11 = corner(rings[k + 1], side + 1);
            fill_triangle({c00, c01, c11}, picture.width, picture.height, plot);
            fill_triangle({c00, c11, c10}, picture.width, picture.height, plot);
        }
}

void add_ball(std::vector<Solid>& solids, const glm::dvec3& centre, double radius,
              const SolidMaterial& material) {
    solids.push_back({centre, {0, 1, 0}, {0, radius, 0, 1}, {}, true, material});
}

/// A rod from `from` to `to` with a radius at either end; none if they coincide.
void add_rod(std::vector<Solid>& solids, const glm::dvec3& from, const glm::dvec3& to, double radius_from,
             double radius_to, const SolidMaterial& material) {
    const double length = glm::length(to - from);
    if (!(length > 0)) return;
    solids.push_back(
        {from, (to - from) / length, {0, radius_from, 0, 1}, {length, radius_to, 0, 1}, false, material});
}

/// Shaft and head from `from` to `to`, with the shaft's radius at either end; a short arrow has a shorter
/// head.
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
    constexpr int steps = solid_sides / 2;
    const double radius = solid.from.radius;
    std::vector<Ring> rings;
    for (int k = 0; k <= steps; ++k) {
        const double angle = pi * k / steps;
        const double up = -cosine(angle), out = k == 0 || k == steps ? 0.0 : sine(angle);
        rings.push_back({radius * up, radius * out, up, out});
    }
    draw_rings(camera, solid, rings, picture);
}

/// Calls use(x, y, place) for every non-empty pixel that a ball may cover; `place`: its world point.
template <class Use>
void for_each_seen(const ViewCamera& camera, const glm::dvec3& centre, double radius,
                   const LightPicture& picture, const Use& use) {
    const auto [x0, y0, x1, y1] = bounds_of_ball(camera, centre, radius).value_or(PixelBounds{});
    for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x)
            if (const float z = picture.z[picture.index(x, y)]; z > 0)
                use(x, y, camera.unproject(x + 0.5, y + 0.5, static_cast<double>(z)));
}

void draw_shadow(const BallShadow& shadow, const ViewCamera& camera, LightPicture& picture) {
    for_each_seen(camera, shadow.centre, shadow.reach, picture, [&](int x, int y, const glm::dvec3& place) {
        const glm::vec3 share((place - shadow.centre) / shadow.reach);
        if (const float squared = glm::dot(share, share); squared < 1)
            picture.light[picture.index(x, y)] *= shadow_light(squared, shadow.darkness);
    });
}

/// Draws rods joined by balls, so that there is no gap.
void draw_thread(std::span<const ThreadPoint> points, const ViewCamera& camera, LightPicture& picture) {
    std::vector<Solid> solids;
    for (std::size_t k = 0; k < points.size(); ++k) {
        const ThreadPoint& to = points[k];
        if (to.is_joined)
            add_rod(solids, points[k - 1].at, to.at, points[k - 1].radius, to.radius, {to.light, 1});
        add_ball(solids, to.at, to.radius, {to.light, 1});
    }
    for (const Solid& solid : solids) draw_solid(camera, solid, picture);
}

void shape_thread(const FingerMark& finger, double radius, const glm::vec3& light,
                  std::vector<ThreadPoint>& points) {
    const auto& trail = finger.trail;
    for (std::size_t k = 0; k < trail.size(); ++k) {
        const double youth = static_cast<double>(k) / static_cast<double>(trail.size());
        const bool is_joined =
            k > 0 && std::max(trail[k - 1].z / trail[k].z, trail[k].z / trail[k - 1].z) < CUT_RULE_RATIO;
        points.push_back({trail[k], 0.22 * radius * (0.15 + 0.85 * youth), light, is_joined});
    }
}

/// The finger's colour at full brightness, so that a thin shaft is visible on dark ground and on snow.
glm::vec3 arrow_light(const glm::vec3& light) {
    const glm::vec3 vivid = light / std::max({light.x, light.y, light.z});
    return glm::mix(vivid, glm::vec3(1.0F), 0.15F);
}

/// Keeps an arrow's tip no wider on the screen than its foot, however near the eye it is. An arrow seen end
/// on is thinner, so that it does not hide the finger, nor its head the shaft.
void shape_arrow(const glm::dvec3& from, const glm::dvec3& arrow, double radius, const glm::dvec3& eye,
                 const glm::vec3& light, std::vector<Solid>& solids) {
    const glm::dvec3 sight = eye - from, to = from + arrow;
    const double distance = glm::length(sight);
    const double nearer = std::clamp(glm::distance(eye, to) / distance, 0.05, 1.0);
    const double aside = glm::length(glm::cross(arrow, sight)) / (glm::length(arrow) * distance);
    const double shaft = 0.34 * radius * glm::mix(0.55, 1.0, std::min(aside / 0.42, 1.0));
    add_arrow(solids, from, to, shaft, nearer * shaft, {arrow_light(light), 1});
}

/// Bilinear between four pixels, in brightness (sRGB), as byte images are mixed.
glm::vec3 brightness_at(const LightPicture& picture, double x, double y) {
    const double left = std::floor(x - 0.5), top = std::floor(y - 0.5);
    const auto at = [&](double column, double row) {
        const int i = std::clamp(static_cast<int>(column), 0, picture.width - 1),
                  j = std::clamp(static_cast<int>(row), 0, picture.height - 1);
        return brightness_of(picture.light[picture.index(i, j)]);
    };
    const auto right = static_cast<float>(x - 0.5 - left), down = static_cast<float>(y - 0.5 - top);
    return glm::mix(glm::mix(at(left, top), at(left + 1, top), right),
                    glm::mix(at(left, top + 1), at(left + 1, top + 1), right), down);
}

}  // namespace

std::optional<FingerMark::Under> under_finger(const HeightField& field, const glm::dvec3& proxy,
                                              double reach) {
    const Camera& camera = field.scene().camera;
    const auto seen = project(camera, proxy);
    if (!seen) return std::nullopt;
    const auto middle = felt_point(field, seen->x, seen->y);
    if (!middle) return std::nullopt;
    const double right = std::max(1.0, std::min(reach * camera.fx / -middle->z, field.width() / 4.0)),
                 down = std::max(1.0, std::min(reach * camera.fy / -middle->z, field.height() / 4.0));
    // Where the surface ends, or continues as another one, the middle replaces that end.
    const auto end = [&](double dx, double dy) {
        const auto point = felt_point(field, seen->x + dx, seen->y + dy);
        return point && glm::distance(*point, *middle) < 4 * reach ? *point : *middle;
    };
    const glm::dvec3 normal = glm::cross(end(right, 0) - end(-right, 0), end(0, -down) - end(0, down));
    const double length = glm::length(normal);
    FingerMark::Under under;
    under.normal = length > 0 ? normal / length : -glm::normalize(*middle);
    under.height = std::max(glm::dot(proxy - *middle, under.normal), 0.0);
    under.foot = proxy - under.normal * glm::dot(proxy - *middle, under.normal);
    return under;
}

MarkSizes mark_sizes(const Scene& scene, const glm::dvec3& middle) {
    const double width = -middle.z * scene.width / scene.camera.fx;
    return {0.02 * width, 0.06 * width};
}

glm::dvec3 given_way(const glm::dvec3& force, double stiffness, double metres_per_scene_unit) {
    if (!(stiffness > 0)) return glm::dvec3(0.0);
    const glm::dvec3 way = force / -(stiffness * metres_per_scene_unit);
    return std::isfinite(glm::dot(way, way)) ? way : glm::dvec3(0.0);
}

glm::dmat4 clip_from_pixel(const ViewCamera& camera) {
    glm::dmat4 matrix(1.0);
    matrix[0][0] = 2.0 / camera.width;
    matrix[1][1] = 2.0 / camera.height;
    matrix[3] = {-1, -1, 0, 1};
    return matrix;
}

std::optional<PixelBounds> bounds_of_ball(const ViewCamera& camera, const glm::dvec3& centre, double radius) {
    const auto middle = camera.project(centre);
    if (!middle) return std::nullopt;
    const double distance = std::max(camera.near / middle->z, radius * 1.01);
    const double pixels = camera.focal * radius / (distance - radius);
    auto clamped = [](double at, int size) {
        return static_cast<int>(std::clamp(at, 0.0, static_cast<double>(size)));
    };
    return PixelBounds{clamped(middle->x - pixels, camera.width), clamped(middle->y - pixels, camera.height),
                       clamped(middle->x + pixels + 1, camera.width),
                       clamped(middle->y + pixels + 1, camera.height)};
}

std::optional<PixelBounds> bounds_in_sight(const ViewCamera& camera, const glm::dvec3& centre,
                                           double radius) {
    const auto bounds = bounds_of_ball(camera, centre, radius);
    return bounds && bounds->x1 > bounds->x0 && bounds->y1 > bounds->y0 ? bounds : std::nullopt;
}

glm::vec4 clip_bounds(const std::optional<PixelBounds>& bounds, const ViewCamera& camera) {
    if (!bounds) return glm::vec4(0.0F);
    const double w = camera.width, h = camera.height;
    return glm::vec4(2 * bounds->x0 / w - 1, 2 * bounds->y0 / h - 1, 2 * bounds->x1 / w - 1,
                     2 * bounds->y1 / h - 1);
}

BallShadow shadow_of(const FingerMark& finger, double radius) {
    if (!finger.under) return {finger.proxy, 2.6 * radius, 0.72F};
    // Direction of the light that models the surface (shaders/surface_light.h), as for a surface that faces
    // it from the front: grazing light would put the shadow far away.
    const glm::dvec3 from_light(0.78, -0.92, -0.78);
    const FingerMark::Under& under = *finger.under;
    const double height = finger.touching ? 0 : under.height, radii = height / radius;
    const glm::dvec3 aside = from_light - under.normal * glm::dot(from_light, under.normal);
    return {under.foot + aside * height, radius * (1.5 + radii),
            static_cast<float>(0.75 / (1 + 1.2 * radii))};
}

void shape_fingers(std::span<const FingerMark> fingers, const MarkSizes& sizes, const glm::dvec3& eye,
                   FingerShapes& shapes) {
    shapes.shadows.clear();
    shapes.threads.clear();
    shapes.solids.clear();
    shapes.veils.clear();
    const double radius = sizes.finger_radius;
    for (std::size_t k = 0; k < fingers.size(); ++k) {
        const FingerMark& finger = fingers[k];
        if (!finger.shown) continue;
        const glm::vec3 light = light_of(finger_colour(k)), white(1.0F);
        shapes.shadows.push_back(shadow_of(finger, radius));
        shape_thread(finger, radius, light, shapes.threads);
        add_ball(shapes.solids, finger.proxy, radius, {light, 1});
        if (!finger.touching) continue;
        add_rod(shapes.veils, finger.goal, finger.proxy, 0.14 * radius, 0.14 * radius,
                {glm::mix(light, white, 0.3F), 0.9F});
        // The arrow starts at the ball's surface, so that a small force is visible.
        const glm::dvec3 arrow = finger.force * sizes.length_per_newton;
        const double length = glm::length(arrow);
        if (!(length > 0)) continue;
        const glm::dvec3 from = finger.proxy + arrow * (0.95 * radius / length);
        shape_arrow(from, arrow, radius, eye, light, shapes.solids);
    }
    for (std::size_t k = 0; k < fingers.size(); ++k)
        if (fingers[k].shown && fingers[k].touching)
            add_ball(shapes.veils, fingers[k].goal, 0.8 * radius,
                     {glm::mix(light_of(finger_colour(k)), glm::vec3(1.0F), 0.3F), 0.8F});
}

void shape_dents(std::span<const FingerMark> fingers, const MarkSizes& sizes,
                 std::vector<SurfaceDent>& dents) {
    dents.clear();
    const double most = most_dented * sizes.finger_radius;
    for (const FingerMark& finger : fingers) {
        const double length = glm::length(finger.given_way);
        if (!finger.shown || !finger.touching || !finger.under || !(length > 0)) continue;
        dents.push_back({finger.proxy, finger.under->normal, finger.given_way * std::min(1.0, most / length),
                         dent_reach * sizes.finger_radius});
    }
}

std::optional<DentedPlace> dented(std::span<const SurfaceDent> dents, const glm::dvec3& place) {
    DentedPlace at;
    glm::vec3 normals(0.0F), slope(0.0F);
    for (const SurfaceDent& dent : dents) {
        const glm::vec3 share((place - dent.centre) / dent.reach), normal(dent.normal);
        const float along = dent_share(share);
        at.moved += along * glm::vec3(dent.moved);
        normals += along * normal;
        slope += dent_slope(share, normal, glm::vec3(dent.moved / dent.reach));
    }
    if (!(glm::dot(normals, normals) > 0)) return std::nullopt;
    at.normal_before = glm::normalize(normals);
    at.normal = glm::normalize(at.normal_before + slope);
    return at;
}

void draw_dents(std::span<const SurfaceDent> dents, const ViewCamera& camera, LightPicture& picture) {
    if (dents.empty()) return;
    const LightPicture flat = picture;
    const auto draw = [&](int x, int y, const glm::dvec3& place) {
        const auto at = dented(dents, place);
        const auto there = at ? camera.project(place + glm::dvec3(at->moved)) : std::nullopt;
        if (!there) return;
        glm::dvec2 source = 2.0 * glm::dvec2(x + 0.5, y + 0.5) - glm::dvec2(*there);
        const int i = std::clamp(static_cast<int>(source.x), 0, flat.width - 1),
                  j = std::clamp(static_cast<int>(source.y), 0, flat.height - 1);
        // Objects in front of the surface are not displaced.
        if (flat.z[flat.index(i, j)] > flat.z[flat.index(x, y)] * CUT_RULE_RATIO) source = {x + 0.5, y + 0.5};
        const DentLight light = dent_light(at->normal_before, at->normal);
        picture.light[picture.index(x, y)] =
            light_of_brightness(brightness_at(flat, source.x, source.y) * light.factor + light.gloss);
    };
    for (const SurfaceDent& dent : dents) for_each_seen(camera, dent.centre, dent.reach, flat, draw);
}

void draw_fingers(std::span<const FingerMark> fingers, const MarkSizes& sizes, const ViewCamera& camera,
                  LightPicture& picture) {
    std::vector<SurfaceDent> dents;
    shape_dents(fingers, sizes, dents);
    draw_dents(dents, camera, picture);
    FingerShapes shapes;
    shape_fingers(fingers, sizes, camera.eye, shapes);
    for (const BallShadow& shadow : shapes.shadows) draw_shadow(shadow, camera, picture);
    draw_thread(shapes.threads, camera, picture);
    for (const auto* solids : {&shapes.solids, &shapes.veils})
        for (const Solid& solid : *solids) draw_solid(camera, solid, picture);
}

}  // namespace touchable
