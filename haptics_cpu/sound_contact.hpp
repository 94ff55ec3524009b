#pragma once

#include <algorithm>
#include <glm/geometric.hpp>

#include "haptics_cpu/touch_solver.hpp"

namespace touchable {

// No device and no scene gives values beyond these. Squares and products of values within them are finite.
inline constexpr double most_newtons = 1e30, most_newtons_per_metre = 1e15, farthest_metres = 1e12;

/// False for NaN too.
inline bool is_within(const glm::dvec3& v, double most) {
    return glm::dot(v, v) <= most * most;
}
inline bool is_stiffness(double newtons_per_metre) {
    return newtons_per_metre >= 0 && newtons_per_metre <= most_newtons_per_metre;
}

/// Whether what a contact says of forces can be used: numbers, and of this world.
inline bool has_sound_forces(const Contact& contact) {
    return is_within(contact.force, most_newtons) && is_stiffness(contact.properties.stiffness) &&
           (!contact.jumped || is_within(contact.jumped_force, most_newtons));
}

/// The same of its places; `farthest`: farthest_metres in scene units.
inline bool has_sound_places(const Contact& contact, double farthest) {
    const double squares = glm::dot(contact.goal, contact.goal) + glm::dot(contact.proxy, contact.proxy) +
                           glm::dot(contact.carried, contact.carried);
    return squares <= farthest * farthest &&
           (!contact.carried_stiffness || is_stiffness(*contact.carried_stiffness));
}

}  // namespace touchable
