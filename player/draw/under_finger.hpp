#pragma once

#include <glm/vec3.hpp>
#include <optional>

#include "haptics_cpu/height_field.hpp"

namespace touchable {

/// The surface under a finger. World, scene units.
struct UnderFinger {
    glm::dvec3 foot{0.0};    ///< the place of the surface that is nearest to it, as far as that is flat
    glm::dvec3 normal{0.0};  ///< there, unit length, on the side that fingers come from
    double height = 0;       ///< of the finger's proxy above it; 0: it touches, or is below
};

/// Of a finger whose proxy is there. `reach`: how far round about the surface is taken together to a plane,
/// so that neither its noise nor its relief turns the normal. Nothing where the clip's camera sees no surface
/// behind the finger.
std::optional<UnderFinger> under_finger(const HeightField& field, const glm::dvec3& proxy, double reach);

}  // namespace touchable
