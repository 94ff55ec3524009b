// SPDX-License-Identifier: Apache-2.0
#include "player/window/finger_halos.hpp"

#include <glm/geometric.hpp>
#include <numbers>

#include "engine/base/hand_thresholds.hpp"
#include "engine/base/words.hpp"
#include "player/window/panel_parts.hpp"

namespace touchable {
namespace {

constexpr ImU32 light_ink = IM_COL32(255, 255, 255, 235), dark_ink = IM_COL32(0, 0, 0, 130),
                faint_ink = IM_COL32(255, 255, 255, 120);

/// Whether a drawn surface hides the place.
bool is_hidden(const glm::dvec3& place, double radius, const glm::dvec3& screen, const HeightField& field,
               const ViewCamera& camera) {
    const double before = glm::distance(place, camera.eye) - 2.5 * radius;
    const auto met = pick(field, camera, screen.x, screen.y, before);
    return met && met->drawn;
}

/// Draws the force on a dark background, legible on any surface.
void draw_newtons(ImDrawList& list, const FingerHalo& halo, std::vector<LabelBox>& labels, float scale) {
    const std::string words = formatted("%.1f N", halo.newtons);
    const ImVec2 text = ImGui::CalcTextSize(words.c_str());
    const float x = 5 * scale, y = 2 * scale;
    const glm::dvec2 size(text.x + 2 * x, text.y + 2 * y);
    const auto place = place_label(halo.at, halo.ring + 5.0 * static_cast<double>(scale), size, labels);
    if (!place) return;
    labels.push_back({*place, *place + size});
    const ImVec2 at = point_of(*place);
    list.AddRectFilled(at, point_of(*place + size), IM_COL32(14, 17, 22, 190), 5 * scale);
    list.AddText(ImVec2(at.x + x, at.y + y), light_ink, words.c_str());
}

/// Draws the sign for an arrow that is too short on the screen.
void draw_end_on(ImDrawList& list, const FingerHalo& halo, float scale) {
    const float arm = static_cast<float>(halo.radius) * 0.42F;
    const ImVec2 at = point_of(halo.at);
    if (halo.towards_eye) {
        list.AddCircleFilled(at, arm * 0.75F + scale, dark_ink);
        list.AddCircleFilled(at, arm * 0.75F, light_ink);
    } else {
        for (const float thick : {4 * scale, 2 * scale}) {
            const ImU32 ink = thick > 3 * scale ? dark_ink : light_ink;
            list.AddLine(ImVec2(at.x - arm, at.y - arm), ImVec2(at.x + arm, at.y + arm), ink, thick);
            list.AddLine(ImVec2(at.x - arm, at.y + arm), ImVec2(at.x + arm, at.y - arm), ink, thick);
        }
    }
}

}  // namespace

std::optional<glm::dvec2> place_label(const glm::dvec2& at, double gap, const glm::dvec2& size,
                                      std::span<const LabelBox> taken) {
    const glm::dvec2 half = size / 2.0;
    const glm::dvec2 places[] = {{at.x + gap, at.y - half.y},
                                 {at.x - gap - size.x, at.y - half.y},
                                 {at.x - half.x, at.y - gap - size.y},
                                 {at.x - half.x, at.y + gap}};
    for (const glm::dvec2& least : places) {
        const glm::dvec2 most = least + size;
        const bool is_free = std::ranges::none_of(taken, [&](const LabelBox& other) {
            return least.x < other.most.x && other.least.x < most.x && least.y < other.most.y &&
                   other.least.y < most.y;
        });
        if (is_free) return least;
    }
    return std::nullopt;
}

double ring_radii(double radii_above, double newtons, double limit_newtons) {
    if (radii_above > 0) return 1.55 + std::min(0.4 * radii_above, 0.8);
    return 1.55 - 0.45 * std::min(newtons / std::min(limit_newtons, 5.0), 1.0);
}

std::vector<FingerHalo> finger_halos(std::span<const FingerMark> fingers, const MarkSizes& sizes,
                                     const HeightField& field, const ViewCamera& camera) {
    std::vector<FingerHalo> halos;
    for (const FingerMark& finger : fingers) {
        const auto at = camera.project(finger.proxy);
        if (!finger.shown || !at || is_hidden(finger.proxy, sizes.finger_radius, *at, field, camera))
            continue;
        FingerHalo halo;
        halo.at = glm::dvec2(*at);
        halo.touching = finger.touching;
        if (finger.error_degrees > 0) halo.doubt = std::min(direction_jnd(finger.error_degrees), 1.0);
        const double distance = glm::distance(finger.proxy, camera.eye);
        halo.radius = camera.focal * sizes.finger_radius / std::max(distance, sizes.finger_radius);
        halo.newtons = finger.touching ? glm::length(finger.force) : 0;
        const bool is_above = !finger.touching && finger.under;
        const double above = is_above ? finger.under->height / sizes.finger_radius : 0;
        halo.ring = halo.radius * ring_radii(above, halo.newtons, sizes.limit_newtons);
        halo.share = std::min(halo.newtons / sizes.limit_newtons, 1.0);
        const glm::dvec3 arrow = finger.force * sizes.length_per_newton, tip = finger.proxy + arrow;
        const glm::dvec3 sight = camera.eye - finger.proxy;
        halo.towards_eye = glm::distance(tip, camera.eye) < distance;
        if (halo.newtons > 0)
            halo.aside = glm::length(glm::cross(arrow, sight)) / (glm::length(arrow) * distance);
        if (const auto end = camera.project(tip)) halo.arrow = glm::dvec2(*end) - halo.at;
        halos.push_back(halo);
    }
    return halos;
}

void draw_finger_halos(std::span<const FingerHalo> halos, float scale) {
    constexpr double least_newtons = 0.05;
    constexpr float upward = -0.5F * std::numbers::pi_v<float>;
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    std::vector<LabelBox> taken;  // boxes of rings, arrow heads, and labels
    for (const FingerHalo& halo : halos) {
        const glm::dvec2 tip = halo.at + halo.arrow;
        taken.push_back({halo.at - halo.ring, halo.at + halo.ring});
        taken.push_back({tip - halo.radius, tip + halo.radius});
    }
    for (const FingerHalo& halo : halos) {
        const bool pushes = halo.touching && halo.newtons > least_newtons;
        const bool end_on = glm::length(halo.arrow) < 1.9 * halo.radius;
        // A share of the circle, clockwise from straight up. Whole pixels take a third of the triangles.
        const auto draw = [&](double share, float thick, ImU32 ink) {
            const auto turned = static_cast<float>(2 * std::numbers::pi * share);
            list.PathArcTo(point_of(halo.at), static_cast<float>(halo.ring), upward, upward + turned);
            list.PathStroke(ink, 0, std::round(thick * scale));
        };
        draw(1, 3, dark_ink);
        draw(1, 1, halo.touching ? faint_ink : light_ink);
        if (!pushes) continue;
        const auto amber = [&](double less) { return static_cast<int>(255 - less * halo.doubt); };
        draw(halo.share, 6, dark_ink);
        draw(halo.share, 4, IM_COL32(255, amber(95), amber(255), 235));
        if (end_on) draw_end_on(list, halo, scale);
        if (end_on || halo.aside < 0.5) draw_newtons(list, halo, taken, scale);
    }
}

}  // namespace touchable
