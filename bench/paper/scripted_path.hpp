// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec2.hpp>
#include <string_view>

namespace touchable {

/// A scripted hand's goal, seen along the optical axis: an ellipse, a line or an eight about the picture's
/// middle, which turns slowly, so that the path never repeats. No person moves like this.
struct ScriptedPath {
    std::string_view name;
    double reach_x, hz_x;  ///< device metres; x = reach_x sin(2 pi hz_x t) before it is turned
    double reach_y, hz_y;  ///< y = reach_y cos(2 pi hz_y t)
    double turn_hz;

    /// Device metres right of and above the middle.
    glm::dvec2 at(double seconds) const;
};

/// Back and forth over 4 cm at up to 10 cm/s, in place of the paper's subject, who was asked to scratch
/// softly.
inline constexpr ScriptedPath scratch{"scratch", 0.020, 0.83, 0.004, 0.31, 0.037};
/// In place of three people who were asked to move as fast as possible: up to 0.3 m/s over 24 mm, the part of
/// a globe of the paper's size that is not too steep.
inline constexpr ScriptedPath fast_hands[] = {{"line", 0.012, 4.0, 0, 0, 0.07},
                                              {"circle", 0.012, 4.0, 0.012, 4.0, 0},
                                              {"eight", 0.012, 3.0, 0.006, 6.0, 0.05}};

}  // namespace touchable
