// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec2.hpp>
#include <optional>
#include <span>
#include <vector>

#include "haptics_cpu/height_field.hpp"
#include "player/draw/finger_marks.hpp"
#include "player/view/view.hpp"

namespace touchable {

/// A ring round a finger in the picture. It keeps the finger visible on a surface of the same colour, and
/// shows the distance to the surface and the force.
struct FingerHalo {
    glm::dvec2 at{0.0};     ///< pixels
    double radius = 0;      ///< of the finger, pixels
    double ring = 0;        ///< of the ring, pixels: `ring_radii` times radius
    double share = 0;       ///< of the largest force, 0 to 1: this share of the ring is drawn strongly
    glm::dvec2 arrow{0.0};  ///< from the finger to the tip of its force's arrow, pixels
    double aside = 0;       ///< of the arrow: the sine of its angle to the line of sight
    double newtons = 0;
    double doubt = 0;  ///< of the force's direction: its error bar over what a hand notices, 0 to 1
    bool touching = false;
    bool towards_eye = false;  ///< the arrow's direction
};

/// The ring's radius, in finger radii: 1.55 when the finger touches. It grows by 0.4 for each radius above
/// the surface, to 2.35 at most, and shrinks by 0.09 per newton up to 5 N (or proportionally up to a smaller
/// limit), to 1.1.
double ring_radii(double radii_above, double newtons, double limit_newtons);

/// The rings of the visible fingers.
std::vector<FingerHalo> finger_halos(std::span<const FingerMark> fingers, const MarkSizes& sizes,
                                     const HeightField& field, const ViewCamera& camera);

/// An occupied part of the picture, pixels.
struct LabelBox {
    glm::dvec2 least, most;
};
/// The upper left of a label of this size beside `at`, `gap` from it: to the right, the left, above or below,
/// the first free one. nullopt: none is free.
std::optional<glm::dvec2> place_label(const glm::dvec2& at, double gap, const glm::dvec2& size,
                                      std::span<const LabelBox> taken);

/// Draws below all panels, between ImGuiLayer's `begin` and `draw`. A force whose arrow is seen end on is
/// drawn as a point in a circle if it comes towards the eye, or as a cross if it goes away. Newtons are
/// written beside it, and beside arrows foreshortened to less than half, if there is room. The force's share
/// of the ring is white without doubt of its direction, and the more amber the larger `doubt`.
void draw_finger_halos(std::span<const FingerHalo> halos, float scale);

}  // namespace touchable
