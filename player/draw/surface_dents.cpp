#include "player/draw/surface_dents.hpp"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "shaders/cut_rule.h"

namespace touchable {

glm::dvec3 given_way(const glm::dvec3& force, double stiffness, double metres_per_scene_unit) {
    if (!(stiffness > 0)) return glm::dvec3(0.0);
    const glm::dvec3 way = force / -(stiffness * metres_per_scene_unit);
    return std::isfinite(glm::dot(way, way)) ? way : glm::dvec3(0.0);
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

namespace {

/// Between the four pixels around a place, as bytes are mixed: brightness, not light.
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

void draw_dents(std::span<const SurfaceDent> dents, const ViewCamera& camera, LightPicture& picture) {
    if (dents.empty()) return;
    const LightPicture flat = picture;
    for (const SurfaceDent& each : dents) {
        const auto bounds = bounds_of_ball(camera, each.centre, each.reach);
        if (!bounds) continue;
        const auto [x0, y0, x1, y1] = *bounds;
        for (int y = y0; y < y1; ++y)
            for (int x = x0; x < x1; ++x) {
                const float z = flat.z[flat.index(x, y)];
                if (!(z > 0)) continue;
                const glm::dvec3 place = camera.unproject(x + 0.5, y + 0.5, static_cast<double>(z));
                const auto at = dented(dents, place);
                const auto there = at ? camera.project(place + glm::dvec3(at->moved)) : std::nullopt;
                if (!there) continue;
                glm::dvec2 source = 2.0 * glm::dvec2(x + 0.5, y + 0.5) - glm::dvec2(*there);
                const int i = std::clamp(static_cast<int>(source.x), 0, flat.width - 1),
                          j = std::clamp(static_cast<int>(source.y), 0, flat.height - 1);
                // Not what stands before the surface.
                if (flat.z[flat.index(i, j)] > z * CUT_RULE_RATIO) source = {x + 0.5, y + 0.5};
                const DentLight light = dent_light(at->normal_before, at->normal);
                picture.light[picture.index(x, y)] =
                    light_of_brightness(brightness_at(flat, source.x, source.y) * light.factor + light.gloss);
            }
    }
}

}  // namespace touchable
