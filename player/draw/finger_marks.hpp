#pragma once

// Fingers as a picture shows them.
//
// A `FingerMark` holds what is drawn of a finger: where its hand is (the goal), where the surface holds it
// (the proxy), the force on it, the thread it has left, what its shadow falls on, and how far the surface
// gives way. Its place in a list of fingers gives its colour (`finger_colour`). `mark_sizes` says how large
// fingers and arrows are in a clip's scene; sizes, places and ways are in scene units, forces in newtons.
//
//     FingerMark finger{goal, proxy, force, touching};
//     finger.under = under_finger(field, proxy, sizes.finger_radius);
//     finger.given_way = given_way(force, stiffness, metres_per_scene_unit);
//
// pictures.hpp draws them: a ball, a bubble at the goal, a rod between the two, an arrow for the force, a
// thread, a shadow, a dent. All functions here depend on their arguments alone: any thread may call them.

#include <cstddef>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "haptics_cpu/height_field.hpp"
#include "player/draw/view.hpp"

namespace touchable {

/// A finger as a picture shows it. World, scene units, newtons.
struct FingerMark {
    /// The surface under a finger. World, scene units.
    struct Under {
        glm::dvec3 foot{0.0};    ///< the place of the surface that is nearest to it, as far as that is flat
        glm::dvec3 normal{0.0};  ///< there, unit length, on the side that fingers come from
        double height = 0;       ///< of the finger's proxy above it; 0: it touches, or is below
    };

    glm::dvec3 goal{0.0}, proxy{0.0}, force{0.0};
    bool touching = false;
    std::vector<glm::dvec3> trail{};  ///< where the proxy went, oldest first, as points of the surface drawn
    bool shown = true;                ///< false: not drawn; the others keep their numbers' colours
    /// What its shadow falls on; nothing: on what is around the proxy.
    std::optional<Under> under{};
    glm::dvec3 given_way{0.0};  ///< by the surface under it, which is drawn so (SurfaceDent); scene units
};

/// The surface under a finger whose proxy is there. `reach`: how far round about the surface is taken
/// together to a plane, so that neither its noise nor its relief turns the normal. Nothing where the clip's
/// camera sees no surface behind the finger.
std::optional<FingerMark::Under> under_finger(const HeightField& field, const glm::dvec3& proxy,
                                              double reach);

/// The colour of a finger, by its number.
PackedColour finger_colour(std::size_t finger);

/// How large fingers are drawn.
struct MarkSizes {
    double finger_radius = 1;      ///< scene units
    double length_per_newton = 1;  ///< of the arrow, scene units
    double limit_newtons = 10;     ///< that no force is beyond
};

/// The same share of every picture: a finger is 2 % of the width of what the clip's camera sees as far away
/// as the middle, a newton's arrow 6 %.
MarkSizes mark_sizes(const Scene& scene, const glm::dvec3& middle);

/// How far a surface gives way under a finger, scene units: as a spring of `stiffness` (N/m of the hand) does
/// to the force on the finger, N, in the hand's scale (`metres_per_scene_unit`, S of the Workspace). Zero
/// where there is no such spring.
glm::dvec3 given_way(const glm::dvec3& force, double stiffness, double metres_per_scene_unit);

}  // namespace touchable
