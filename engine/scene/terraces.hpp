#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "engine/scene/code_scale.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Terrace removal, as it works on one scene's codes; docs/conventions.md has the arithmetic.
struct TerraceFilter {
    /// Of codes before the passes, nothing to do where the temporal filter did it; the last pass doubles
    /// them.
    CodeScale scale;
    int step = 0;        ///< from one stored code to the next, in multiplied codes
    CodeCurve levels;    ///< from one level to the next, in multiplied codes; zero: every code is one
    int noise = 0;       ///< standard deviation, in multiplied codes
    DepthCoding coding;  ///< of the finer codes; where nothing changed the depth is the same double

    /// At a multiplied code: from one level to the next.
    int level_at(std::uint16_t code) const { return std::clamp(levels.at(code), step, most_level); }
    /// Second differences up to it are terraces, from twice it on they are the surface's own.
    int gate_at(std::uint16_t code) const { return (5 * level_at(code) + 3 * noise) / 4; }
    /// By how much a code may change, before it is doubled.
    int most_at(std::uint16_t code) const { return (4 * level_at(code) + 3 * noise) / 4; }
    static constexpr int most_level = 2900;  ///< so that eight gates, with the most noise, have 15 bits

    bool operator==(const TerraceFilter&) const = default;
};

/// Pixels from one tap to the next, pass by pass. A code depends on those at most terrace_reach away.
inline constexpr int terrace_steps[] = {8, 4, 2, 1, 1};
inline constexpr int terrace_reach = 16;
/// Codes in between and a gate are together at most this. So a second difference that leaves 16 bits and
/// wraps around is beyond twice the gate all the same, and so is one with a code of 65535, which no finer one
/// is.
inline constexpr int terrace_range = 32767;
/// Noise that there is room for, in stored codes.
inline constexpr int most_terrace_noise = 4;

/// Of the codes that filters work on: at most 126 times as many. Nothing where codes are too large to be
/// twice as many, or to become fewer: terrace removal has no room.
std::optional<CodeScale> terrace_scale(const Scene& scene);
/// Codes beyond it leave no room, even where every one of them is a level.
inline constexpr int largest_code_with_terraces = 16378;

/// The largest code that a depth is told by: of metric codes only those up to `far` are.
int largest_code(const DepthCoding& coding);
/// The coding of these codes.
DepthCoding scaled(const DepthCoding& coding, const CodeScale& scale);
/// The coding of codes `factor` times as many, of metric codes a power of two: a multiplied code is the same
/// depth, to the bit. From the least valid code to the
/// largest all are valid.
DepthCoding finer(const DepthCoding& coding, int factor);

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
