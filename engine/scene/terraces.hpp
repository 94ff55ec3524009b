#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <optional>

#include "engine/scene/code_curve.hpp"
#include "engine/scene/scene.hpp"
#include "engine/scene/working_codes.hpp"

namespace touchable {

/// Terrace removal, as it works on one scene's codes; docs/conventions.md has the arithmetic.
struct TerraceFilter {
    /// Of codes before the passes, nothing to do where the temporal filter did it; the last pass doubles
    /// them.
    WorkingCodes working;
    int step = 0;      ///< from one stored code to the next, in working codes; at least, where that differs
    CodeCurve steps;   ///< the same where it differs; zero: it does not
    CodeCurve levels;  ///< from one level to the next, in working codes; zero: every code is one
    int fraction = 0;  ///< binary digits of both curves that are behind the point
    int noise = 0;     ///< standard deviation, in working codes; of looked-up ones it is in the curves
    int reach = least_terrace_reach;  ///< a code depends on those at most so many pixels away
    DepthCoding coding;  ///< of the finer codes; of an unchanged multiplied code the depth is the same double

    /// Whether gates are the same at every code.
    bool is_even() const { return levels.is_zero() && steps.is_zero(); }
    /// At a working code: from one level to the next.
    int level_at(std::uint16_t code) const {
        return std::clamp(std::max(levels.at(code), steps.at(code)) >> fraction, step, most_level);
    }
    /// Second differences up to it are terraces, from twice it on they are the surface's own.
    int gate_at(std::uint16_t code) const { return (5 * level_at(code) + 3 * noise) / 4; }
    /// The same in a pass. Taps that are wide apart see more of the surface's own, and are stricter, so that
    /// steps stay (docs/measurements.md).
    int gate_at(std::uint16_t code, int tap) const { return is_wide(tap) ? most_at(code) : gate_at(code); }
    /// By how much a code may change, before it is doubled.
    int most_at(std::uint16_t code) const { return (4 * level_at(code) + 3 * noise) / 4; }
    static constexpr int most_level = 2900;  ///< so that eight gates, with the most noise, have 15 bits

    int passes() const { return std::bit_width(static_cast<unsigned>(reach)); }
    /// Pixels from the centre to its taps in a pass: half of the reach, half of that, and so on, 1, and 1
    /// again.
    int tap_of(int pass) const { return std::max(reach >> (pass + 1), 1); }
    static constexpr bool is_wide(int tap) { return tap > least_terrace_reach / 2; }

    bool operator==(const TerraceFilter&) const = default;
};

/// Passes of the farthest reach.
inline constexpr int most_terrace_passes = std::bit_width(unsigned{most_terrace_reach});
/// Noise that there is room for, in stored codes.
inline constexpr int most_terrace_noise = 4;

/// From one level to the next at a depth, scene units: a code's step, or what the scene says where that is
/// more.
double level_distance(const Scene& scene, double depth);
/// How steep one step of the staircase feels: level_distance / width of one pixel, at that depth.
double kappa_of_depth(const Scene& scene, double depth);
/// The same half-way between the depths of the nearest and the farthest valid code.
double kappa_of_scene(const Scene& scene);

/// From this kappa_of_scene on the filter makes both direction and length of the force more exact
/// (docs/measurements.md, Terraces).
inline constexpr double kappa_of_terraces = 0.25;
/// Whether it is worth while: enough kappa, and room for it.
bool terraces_advised(const Scene& scene);

/// What the scene asks for; nothing: no filter. Needs a scene that `validate` accepts.
std::optional<TerraceFilter> terrace_filter(const Scene& scene);

}  // namespace touchable
