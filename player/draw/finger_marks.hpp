#pragma once

#include <cstddef>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "player/draw/light_picture.hpp"
#include "player/draw/solids.hpp"
#include "player/draw/under_finger.hpp"
#include "player/draw/view_camera.hpp"
#include "player/draw/view_surface.hpp"

namespace touchable {

/// A finger as a picture shows it. World, scene units, newtons.
struct FingerMark {
    glm::dvec3 goal{0.0}, proxy{0.0}, force{0.0};
    bool touching = false;
    std::vector<glm::dvec3> trail{};  ///< where the proxy went, oldest first, as points of the surface drawn
    bool shown = true;                ///< false: not drawn; the others keep their numbers' colours
    /// What its shadow falls on; nothing: on what is around the proxy.
    std::optional<UnderFinger> under{};
    glm::dvec3 given_way{0.0};  ///< by the surface under it, which is drawn so (SurfaceDent); scene units
};

/// The colour of a finger, by its number.
PackedColour finger_colour(std::size_t finger);

/// How large fingers are drawn.
struct MarkSizes {
    double finger_radius = 1;      ///< scene units
    double length_per_newton = 1;  ///< of the arrow, scene units
    double limit_newtons = 10;     ///< that no force is beyond
};

/// As large in every picture: a finger is 2 % of the width of what the clip's camera sees as far away as the
/// middle, a newton's arrow 6 %.
MarkSizes mark_sizes(const Scene& scene, const glm::dvec3& middle);

/// A point of the thread that a finger leaves. World, scene units.
struct ThreadPoint {
    glm::dvec3 at{0.0};
    double radius = 0;
    glm::vec3 light{1.0F};
    bool is_joined = false;  ///< to the point before
};

/// The soft shadow of a ball on the surface it touches, or is above. World, scene units.
struct BallShadow {
    glm::dvec3 centre{0.0};
    double reach = 0;
    float darkness = 0;  ///< in its middle, 0 to 1
};

/// Of a finger: on the surface under it, away from the light, the farther the higher the finger is, and then
/// the wider and the fainter. It closes in to 1.5 radii and 0.75 where the finger touches; a radius above it
/// is 2.5 radii wide, 0.34 dark, and 1.2 radii aside.
BallShadow shadow_of(const FingerMark& finger, double radius);

/// What fingers are drawn as, whoever draws them, in this order.
struct FingerShapes {
    std::vector<BallShadow> shadows;
    std::vector<ThreadPoint> threads;  ///< one after the other
    std::vector<Solid> solids;
    std::vector<Solid> veils;  ///< seen through: all rods before all balls
};

/// Every finger: its proxy as a ball in its colour, the goal as a bubble seen through what hides it, a rod
/// between them, the force on the finger as an arrow, and the trail as a thread that thins with age.
/// As seen from `eye`: how thick an arrow is depends on it, but neither its direction nor its length.
/// `shapes` is written anew.
void shape_fingers(std::span<const FingerMark> fingers, const MarkSizes& sizes, const glm::dvec3& eye,
                   FingerShapes& shapes);

/// Draws them, and first the dents that they make (SurfaceDent).
void draw_fingers(std::span<const FingerMark> fingers, const MarkSizes& sizes, const ViewCamera& camera,
                  LightPicture& picture);

}  // namespace touchable
