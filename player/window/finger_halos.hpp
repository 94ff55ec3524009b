#pragma once

#include <glm/vec2.hpp>
#include <optional>
#include <span>
#include <vector>

#include "haptics_cpu/height_field.hpp"
#include "player/draw/finger_marks.hpp"
#include "player/draw/view.hpp"

namespace touchable {

/// A ring round a finger in the picture. It makes the finger visible on a surface of the same colour, and
/// shows how near the surface is and how hard it is pressed.
struct FingerHalo {
    glm::dvec2 at{0.0};     ///< pixels
    double radius = 0;      ///< of the finger, pixels
    double ring = 0;        ///< of the ring, pixels: `ring_radii` of them
    double share = 0;       ///< of the largest force, 0 to 1: so much of a turn is drawn strongly
    glm::dvec2 arrow{0.0};  ///< from the finger to the tip of its force's arrow, pixels
    double aside = 0;       ///< of the arrow: the sine of its angle to the line of sight
    double newtons = 0;
    bool touching = false;
    bool towards_eye = false;  ///< the arrow
    std::size_t finger = 0;
};

/// The radius of the ring, in radii of the finger: 1.55 when the finger touches. It grows by 0.4 for each
/// radius above the surface, to 2.35 at most, and tightens by 0.09 for each newton of five (of all of them if
/// the largest force is less than that), to 1.1.
double ring_radii(double radii_above, double newtons, double limit_newtons);

/// The rings of the fingers that are in sight.
std::vector<FingerHalo> finger_halos(std::span<const FingerMark> fingers, const MarkSizes& sizes,
                                     const HeightField& field, const ViewCamera& camera);

/// A part of the picture that is taken, pixels.
struct LabelBox {
    glm::dvec2 least, most;
};
/// The upper left of a label of this size beside `at`, `gap` from it: to the right, the left, above or below,
/// the first that is not taken. Nothing: all are.
std::optional<glm::dvec2> place_label(const glm::dvec2& at, double gap, const glm::dvec2& size,
                                      std::span<const LabelBox> taken);

/// Draws below all panels, between ImGuiLayer's `begin` and `draw`. A force whose arrow is seen end on is
/// drawn as a point in a circle, the tip of an arrow that comes, or as a cross, the feathers of one that
/// goes. Beside it, and beside an arrow that is seen less than half as long as it is, stand its newtons, if
/// there is room.
void draw_finger_halos(std::span<const FingerHalo> halos, float scale);

}  // namespace touchable
