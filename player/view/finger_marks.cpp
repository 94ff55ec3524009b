#include "player/view/finger_marks.hpp"

#include <algorithm>
#include <array>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "player/view/solids.hpp"
#include "shaders/cut_rule.h"

namespace touchable {
namespace {

// Okabe and Ito's colours, in the order of the plots (player/plot/style.py): told apart by every kind of eye.
// Three of Tol's follow, so that ten fingers differ.
constexpr std::array<PackedColour, 10> finger_colours{pack_colour(0, 114, 178),   pack_colour(230, 159, 0),
                                                      pack_colour(0, 158, 115),   pack_colour(213, 94, 0),
                                                      pack_colour(204, 121, 167), pack_colour(86, 180, 233),
                                                      pack_colour(240, 228, 66),  pack_colour(51, 34, 136),
                                                      pack_colour(136, 34, 85),   pack_colour(153, 153, 51)};

/// Darkens what is drawn near a ball: its soft shadow on the surface it touches.
void draw_shadow(const glm::dvec3& centre, double radius, const ViewCamera& camera, LightPicture& picture) {
    const double reach = 2.6 * radius;
    const auto middle = camera.project(centre);
    if (!middle) return;
    const double distance = std::max(camera.near / middle->z, reach * 1.01);
    const double pixels = camera.focal * reach / (distance - reach);
    auto span = [&](double at, int size) {
        return std::array<int, 2>{
            static_cast<int>(std::clamp(at - pixels, 0.0, static_cast<double>(size))),
            static_cast<int>(std::clamp(at + pixels + 1, 0.0, static_cast<double>(size)))};
    };
    const auto [x0, x1] = span(middle->x, picture.width);
    const auto [y0, y1] = span(middle->y, picture.height);
    for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) {
            const std::size_t at = picture.index(x, y);
            if (!(picture.z[at] > 0)) continue;
            const glm::dvec3 point = camera.unproject(x + 0.5, y + 0.5, static_cast<double>(picture.z[at]));
            const double share = glm::length(point - centre) / reach;
            if (share >= 1) continue;
            const double fade = (1 - share * share);
            picture.light[at] *= static_cast<float>(1 - 0.72 * fade * fade);
        }
}

}  // namespace

PackedColour finger_colour(std::size_t finger) {
    return finger_colours[finger % finger_colours.size()];
}

MarkSizes mark_sizes(const Scene& scene, const glm::dvec3& middle) {
    const double width = -middle.z * scene.width / scene.camera.fx;
    return {0.02 * width, 0.06 * width};
}

void draw_fingers(std::span<const FingerMark> fingers, const MarkSizes& sizes, const ViewCamera& camera,
                  LightPicture& picture) {
    const double radius = sizes.finger_radius;
    for (const FingerMark& finger : fingers) draw_shadow(finger.proxy, radius, camera, picture);
    for (std::size_t k = 0; k < fingers.size(); ++k) {
        const FingerMark& finger = fingers[k];
        const Material solid{light_of(finger_colour(k)), 1};
        const auto points = static_cast<double>(finger.trail.size());
        auto thread = [&](std::size_t at) {
            return 0.22 * radius * (0.15 + 0.85 * static_cast<double>(at) / points);
        };
        for (std::size_t at = 1; at < finger.trail.size(); ++at) {
            const glm::dvec3 &from = finger.trail[at - 1], &to = finger.trail[at];
            if (std::max(from.z / to.z, to.z / from.z) < CUT_RULE_RATIO)
                draw_rod(camera, from, to, thread(at - 1), thread(at), solid, picture);
            draw_sphere(camera, to, thread(at), solid, picture);  // rods meet without a gap
        }
        draw_sphere(camera, finger.proxy, radius, solid, picture);
        if (!finger.touching) continue;
        // From where it leaves the ball, so that a small force is not lost in it.
        const glm::dvec3 arrow = finger.force * sizes.length_per_newton;
        const double length = glm::length(arrow);
        if (!(length > 0)) continue;
        const glm::dvec3 from = finger.proxy + arrow * (0.95 * radius / length);
        draw_arrow(camera, from, from + arrow, 0.34 * radius,
                   {glm::mix(solid.light, glm::vec3(1.0F), 0.35F), 1}, picture);
    }
    for (std::size_t k = 0; k < fingers.size(); ++k) {
        const FingerMark& finger = fingers[k];
        if (!finger.touching) continue;
        const glm::vec3 light = glm::mix(light_of(finger_colour(k)), glm::vec3(1.0F), 0.3F);
        draw_rod(camera, finger.goal, finger.proxy, 0.14 * radius, 0.14 * radius, {light, 0.9F}, picture);
        draw_sphere(camera, finger.goal, 0.8 * radius, {light, 0.8F}, picture);
    }
}

}  // namespace touchable
