#include "player/draw/finger_marks.hpp"

#include <algorithm>
#include <array>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "player/draw/surface_dents.hpp"
#include "shaders/cut_rule.h"
#include "shaders/solid_light.h"

namespace touchable {
namespace {

// Okabe and Ito's colours, in the order of the plots (player/plot/style.py): told apart by every kind of eye.
// Three of Tol's follow, so that ten fingers differ.
constexpr std::array<PackedColour, 10> finger_colours{pack_colour(0, 114, 178),   pack_colour(230, 159, 0),
                                                      pack_colour(0, 158, 115),   pack_colour(213, 94, 0),
                                                      pack_colour(204, 121, 167), pack_colour(86, 180, 233),
                                                      pack_colour(240, 228, 66),  pack_colour(51, 34, 136),
                                                      pack_colour(136, 34, 85),   pack_colour(153, 153, 51)};

void draw_shadow(const BallShadow& shadow, const ViewCamera& camera, LightPicture& picture) {
    const auto bounds = bounds_of_ball(camera, shadow.centre, shadow.reach);
    if (!bounds) return;
    const auto [x0, y0, x1, y1] = *bounds;
    for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) {
            const std::size_t at = picture.index(x, y);
            if (!(picture.z[at] > 0)) continue;
            const glm::dvec3 point = camera.unproject(x + 0.5, y + 0.5, static_cast<double>(picture.z[at]));
            const glm::vec3 share((point - shadow.centre) / shadow.reach);
            if (const float squared = glm::dot(share, share); squared < 1)
                picture.light[at] *= shadow_light(squared, shadow.darkness);
        }
}

/// Rods that meet in balls, so that there is no gap.
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

/// The finger's colour as bright as it can be, so that a thin shaft is seen on dark ground as well as on
/// snow.
glm::vec3 arrow_light(const glm::vec3& light) {
    const glm::vec3 vivid = light / std::max({light.x, light.y, light.z});
    return glm::mix(vivid, glm::vec3(1.0F), 0.15F);
}

/// Its tip is no wider on the screen than its foot, however near the eye it comes, and an arrow that is seen
/// end on is thinner: it would hide the finger, and its head the shaft.
void shape_arrow(const glm::dvec3& from, const glm::dvec3& arrow, double radius, const glm::dvec3& eye,
                 const glm::vec3& light, std::vector<Solid>& solids) {
    const glm::dvec3 sight = eye - from, to = from + arrow;
    const double distance = glm::length(sight);
    const double nearer = std::clamp(glm::distance(eye, to) / distance, 0.05, 1.0);
    const double aside = glm::length(glm::cross(arrow, sight)) / (glm::length(arrow) * distance);
    const double shaft = 0.34 * radius * glm::mix(0.55, 1.0, std::min(aside / 0.42, 1.0));
    add_arrow(solids, from, to, shaft, nearer * shaft, {arrow_light(light), 1});
}

}  // namespace

PackedColour finger_colour(std::size_t finger) {
    return finger_colours[finger % finger_colours.size()];
}

MarkSizes mark_sizes(const Scene& scene, const glm::dvec3& middle) {
    const double width = -middle.z * scene.width / scene.camera.fx;
    return {0.02 * width, 0.06 * width};
}

BallShadow shadow_of(const FingerMark& finger, double radius) {
    if (!finger.under) return {finger.proxy, 2.6 * radius, 0.72F};
    // Of the light that models the surface (shaders/surface_light.h), as it would fall on one that faces it
    // from the front: at grazing light a shadow would be far away.
    const glm::dvec3 from_light(0.78, -0.92, -0.78);
    const UnderFinger& under = *finger.under;
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
        // From where it leaves the ball, so that a small force is not lost in it.
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
