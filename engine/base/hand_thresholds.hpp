// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a hand just notices: errors of a force are told as shares of these. Divide an angle by `seen_degrees`
// (direction_jnd), and look `just_noticed_newtons` up for a size.
//
// Threads: constants and pure functions; any thread may use them.

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>

#include "engine/base/same_bits.hpp"
#include "engine/base/words.hpp"

namespace touchable {

/// Just noticeable differences (JND) of people.
namespace hand_thresholds {
/// Direction of a force, where the hand's owner sees the scene, and by touch alone: Barbagli, Salisbury, Ho,
/// Spence, Tan, "Haptic discrimination of force direction and the influence of visual information", ACM
/// Transactions on Applied Perception 3(2), 2006.
inline constexpr double seen_degrees = 18.4, felt_degrees = 25.6;
/// Size of a force, as a share of it, between these forces: Pang, Tan, Durlach, "Manual discrimination of
/// force using active finger motion", Perception & Psychophysics 49(6), 1991.
inline constexpr double size_share = 0.07, size_from_n = 2.5, size_to_n = 10;
}  // namespace hand_thresholds

/// Angle between two directions of any length; 0 where one has none.
inline double degrees_between(const glm::dvec3& a, const glm::dvec3& b) {
    return arctangent2(glm::length(glm::cross(a, b)), glm::dot(a, b)) * 180 / pi;
}

/// An angle between two forces as a multiple of what a hand just notices where it sees the scene.
constexpr double direction_jnd(double degrees) {
    return degrees / hand_thresholds::seen_degrees;
}
inline std::string direction_jnd_words(double degrees) {
    return short_number(direction_jnd(degrees), 2) + " of what a hand just notices where it sees the scene";
}

/// By how much a force must change to be noticed; nothing where that was not measured.
constexpr std::optional<double> just_noticed_newtons(double newtons) {
    using namespace hand_thresholds;
    if (newtons < size_from_n || newtons > size_to_n) return {};
    return size_share * newtons;
}

}  // namespace touchable
