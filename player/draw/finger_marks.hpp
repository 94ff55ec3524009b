// SPDX-License-Identifier: Apache-2.0
#pragma once

// Fingers as drawn in a picture.
//
// A `FingerMark` holds what is drawn of a finger: the goal (the hand's position), the proxy (held by the
// surface), the force on it, its trail, the surface under it, which gets the shadow, and the surface's
// deformation. Its index in a list of fingers gives its colour (`finger_colour`). `mark_sizes` gives the
// sizes of fingers and arrows in a clip's scene. Sizes, positions and displacements are in scene units,
// forces in newtons.
//
//     FingerMark finger{goal, proxy, force, touching};
//     finger.under = under_finger(field, proxy, sizes.finger_radius);
//     finger.given_way = given_way(force, stiffness, metres_per_scene_unit);
//
// pictures.hpp draws them: a ball, a bubble at the goal, a rod between the two, an arrow for the force, a
// thread, a shadow, a dent.
// Threads: any; functions depend only on their arguments.

#include <cstddef>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <vector>

#include "haptics_cpu/height_field.hpp"
#include "player/view/view.hpp"

namespace touchable {

/// A finger as a picture shows it. World, scene units, newtons.
struct FingerMark {
    /// The surface under a finger. World, scene units.
    struct Under {
        glm::dvec3 foot{0.0};    ///< the proxy's foot on the surface's tangent plane
        glm::dvec3 normal{0.0};  ///< of the surface there, unit length, towards the side that fingers come
                                 ///< from
        double height = 0;       ///< of the proxy above the surface; 0: it touches, or is below
    };

    glm::dvec3 goal{0.0}, proxy{0.0}, force{0.0};
    bool touching = false;
    std::vector<glm::dvec3> trail{};  ///< the proxy's path, oldest first, as points of the drawn surface
    bool shown = true;                ///< false: not drawn; the others keep their colours
    /// The surface that gets the shadow; nullopt: whatever is around the proxy.
    std::optional<Under> under{};
    glm::dvec3 given_way{0.0};  ///< displacement of the surface under the finger (SurfaceDent); scene units
    double error_degrees = std::numeric_limits<double>::quiet_NaN();  ///< of Contact
};

/// The surface under a finger with that proxy. `reach`: radius of the plane fit, which keeps noise and relief
/// from turning the normal. nullopt if the clip's camera sees no surface behind the finger.
std::optional<FingerMark::Under> under_finger(const HeightField& field, const glm::dvec3& proxy,
                                              double reach);

/// How large fingers are drawn.
struct MarkSizes {
    double finger_radius = 1;      ///< scene units
    double length_per_newton = 1;  ///< of the arrow, scene units
    double limit_newtons = 10;     ///< the greatest force
};

/// The same share of every picture: a finger is 2 % of the width that the clip's camera sees at the middle's
/// distance, a newton's arrow 6 %.
MarkSizes mark_sizes(const Scene& scene, const glm::dvec3& middle);

/// Displacement of a surface under a finger, scene units: that of a spring of `stiffness` (N/m of the hand)
/// under the force on the finger, N, in the hand's scale (`metres_per_scene_unit`, S of the Workspace). Zero
/// without such a spring.
glm::dvec3 given_way(const glm::dvec3& force, double stiffness, double metres_per_scene_unit);

}  // namespace touchable
