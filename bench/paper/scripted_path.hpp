#pragma once

#include <glm/vec2.hpp>
#include <string_view>

namespace touchable {

/// Where a scripted hand means to be, seen along the optical axis: an ellipse, a line or an eight about the
/// middle of the picture, which turns slowly, so that it is never the same way again. No person moves so.
struct ScriptedPath {
    std::string_view name;
    double reach_x, hz_x;  ///< device metres; x = reach_x sin(2 pi hz_x t) before it is turned
    double reach_y, hz_y;  ///< y = reach_y cos(2 pi hz_y t)
    double turn_hz;

    /// Device metres right of and above the middle.
    glm::dvec2 at(double seconds) const;
};

/// To and fro over 4 cm with 10 cm/s at most, in place of the paper's subject who was to scratch softly.
inline constexpr ScriptedPath scratch{"scratch", 0.020, 0.83, 0.004, 0.31, 0.037};
/// In place of three people who were to move as fast as possible: up to 0.3 m/s over 24 mm, which on the
/// globe of the paper's size is as far as its sides are not too steep.
inline constexpr ScriptedPath fast_hands[] = {{"line", 0.012, 4.0, 0, 0, 0.07},
                                              {"circle", 0.012, 4.0, 0.012, 4.0, 0},
                                              {"eight", 0.012, 3.0, 0.006, 6.0, 0.05}};

}  // namespace touchable
