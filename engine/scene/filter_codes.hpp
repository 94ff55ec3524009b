// SPDX-License-Identifier: Apache-2.0
#pragma once

// The codes that filters work on, and each filter's settings in terms of them.
//
// Stored codes may be too coarse or too uneven to filter (disparity, hue, logarithms): WorkingCodes replace
// them, and say how one becomes the other. A CodeCurve is a length that grows with depth, in codes.
// TerraceFilter, FlyingPixels and TemporalFilter are a Scene's settings in these integers, the same for every
// builder, on the CPU and on the GPU (docs/conventions.md): a builder calls the function of the same name,
// which returns nullopt if the scene does not want that filter. step_of_code, level_distance and kappa
// measure how coarse depth is, for the choice of filters and for reports.
//
// Threads: any; plain values and pure functions. A filter keeps no reference to its scene.

#include <algorithm>
#include <bit>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "engine/scene/scene.hpp"

namespace touchable {

/// A DepthLength that approximates a length that grows as depth does, `share` (z + shift): the one that is
/// off by the same factor at both ends of a range and in between. For near:far 1:3 that factor is 1.07, for
/// 1:8 1.23, for 1:30 1.5.
DepthLength length_along_depth(double share, double shift, double near, double far);

/// Twice this value fits 16 bits.
inline constexpr int code_curve_most = 32767;

/// A DepthLength at a code, in codes, in integers (docs/conventions.md): a polynomial of second degree in the
/// code's distance from one end. For inverse depth w it is constant w^2 + quadratic. For log codes it equals
/// the length at both planes and in the middle. It is never negative. Only the linear coefficient can be
/// negative, for log codes and for codes with a shift; then the minimum can lie between the ends.
struct CodeCurve {
    std::uint16_t constant = 0, linear = 0, quadratic = 0;  ///< each at most a third of 65535
    bool falls = false;                                     ///< the linear coefficient counts as negative
    std::uint16_t last = 0;                                 ///< largest code
    int shift = 0;                                          ///< left shift by which a distance fills 16 bits
    bool from_last = false;                                 ///< distances are taken from `last`, not from 0

    /// At most code_curve_most.
    int at(std::uint16_t code) const {
        const std::uint32_t n = static_cast<std::uint32_t>(from_last ? last - code : code) << shift;
        const std::uint32_t sloped = linear * n >> 16;
        std::uint32_t value = constant + (quadratic * (n * n >> 16) >> 16);
        value = falls ? value - std::min(value, sloped) : value + sloped;
        return static_cast<int>(std::min<std::uint32_t>(value, code_curve_most));
    }
    bool is_zero() const { return (constant | linear | quadratic) == 0; }
    bool operator==(const CodeCurve&) const = default;
};
/// The codes in which terraces are removed and noise is averaged, so fine that the mean of two stored codes
/// is a code: `factor` times as many. If these would not fit 15 bits, or would be coarse near the hand, a
/// table gives other codes: even steps of 1 / (depth + shift), which are about equally fine against a pixel's
/// width at every depth. docs/conventions.md has the arithmetic.
struct WorkingCodes {
    int factor = 1;
    std::shared_ptr<const std::vector<std::uint16_t>> table{};  ///< of all 65536 codes; null: multiplied
    DepthCoding coding{};                                       ///< of the working codes

    std::uint16_t of(int code) const {
        return table ? (*table)[static_cast<std::size_t>(code)] : static_cast<std::uint16_t>(code * factor);
    }
    /// Converts `count` codes of a row.
    template <class To>
    void row(const std::uint16_t* codes, int count, To* to) const {
        if (const std::uint16_t* const found = table ? table->data() : nullptr)
            for (int k = 0; k < count; ++k) to[k] = static_cast<To>(found[codes[k]]);
        else
            for (int k = 0; k < count; ++k)
                to[k] = static_cast<To>(static_cast<std::uint16_t>(codes[k] * factor));
    }
    bool operator==(const WorkingCodes& other) const {
        return factor == other.factor && !table == !other.table && coding == other.coding;
    }
};

/// Upper limit of a working code plus a gate of terrace removal. A second difference that leaves 16 bits and
/// wraps around is then still beyond twice the gate; so is one with the code 65535, which is not finer.
inline constexpr int terrace_range = 32767;

/// Stored codes, unchanged.
WorkingCodes unchanged_codes(const DepthCoding& coding);
/// The scene's working codes; nullopt if fewer than two codes are valid, or levels are so far apart that no
/// room is left.
std::optional<WorkingCodes> working_codes(const Scene& scene);
/// Whether working_codes returns any; makes no table.
bool has_working_codes(const Scene& scene);

/// The largest code that stands for a depth; for metric codes the last one up to `far`.
int largest_code(const DepthCoding& coding);
/// The coding with `factor` times as many codes, for metric codes a power of two: a multiplied code has the
/// same depth, to the bit. All codes from the least valid one to the largest are valid.
DepthCoding finer(const DepthCoding& coding, int factor);
/// Depth from a code to the next one, scene units; for the last code, from the one before it.
double step_of_code(const DepthCoding& coding, std::uint16_t code);
/// The same as a function of depth.
DepthLength code_step(const DepthCoding& coding);

/// Terrace removal in one scene's codes; docs/conventions.md has the arithmetic.
struct TerraceFilter {
    /// Applied to codes before the passes; unchanged codes if the temporal filter has applied it. The last
    /// pass doubles the codes.
    WorkingCodes working;
    int step = 0;      ///< working codes from one stored code to the next; the least, if that varies
    CodeCurve steps;   ///< the same if it varies; zero: it does not
    CodeCurve levels;  ///< from one level to the next, in working codes; zero: every code is a level
    int fraction = 0;  ///< fractional binary digits of both curves
    int noise = 0;     ///< standard deviation, working codes; for looked-up codes it is in the curves
    int reach = least_terrace_reach;  ///< pixels; a code depends on codes at most this far away
    DepthCoding coding;  ///< of the finer codes; an unchanged multiplied code has the same depth, to the bit

    /// Whether gates are the same at every code.
    bool is_even() const { return levels.is_zero() && steps.is_zero(); }
    /// Distance from one level to the next at a working code.
    int level_at(std::uint16_t code) const {
        return std::clamp(std::max(levels.at(code), steps.at(code)) >> fraction, step, most_level);
    }
    /// Second differences up to this gate are terraces, from twice the gate on they belong to the surface.
    int gate_at(std::uint16_t code) const { return (5 * level_at(code) + 3 * noise) / 4; }
    /// The same in a pass. Taps that are far apart see more of the surface's own shape, and have a stricter
    /// gate, so that real steps stay (docs/measurements.md).
    int gate_at(std::uint16_t code, int tap) const { return is_wide(tap) ? most_at(code) : gate_at(code); }
    /// The largest change of a code, before it is doubled.
    int most_at(std::uint16_t code) const { return (4 * level_at(code) + 3 * noise) / 4; }
    static constexpr int most_level = 2900;  ///< so that eight gates with the most noise fit 15 bits

    int passes() const { return std::bit_width(static_cast<unsigned>(reach)); }
    /// Pixels from the centre to the taps of a pass: half of the reach, half of that, and so on, 1, and 1
    /// again.
    int tap_of(int pass) const { return std::max(reach >> (pass + 1), 1); }
    static constexpr bool is_wide(int tap) { return tap > least_terrace_reach / 2; }

    bool operator==(const TerraceFilter&) const = default;
};

/// Number of passes with the farthest reach.
inline constexpr int most_terrace_passes = std::bit_width(unsigned{most_terrace_reach});
/// Largest terrace_noise for which there is room, in stored codes.
inline constexpr int most_terrace_noise = 4;

/// Distance between levels at a depth, scene units: a code's step, or the scene's `levels` if larger.
double level_distance(const Scene& scene, double depth);
/// How steep one step of the staircase feels: level_distance / width of one pixel, at that depth.
double kappa_of_depth(const Scene& scene, double depth);
/// The same half-way between the depths of the nearest and the farthest valid code.
double kappa_of_scene(const Scene& scene);

/// From this kappa_of_scene on the filter makes both direction and length of the force more exact
/// (docs/measurements.md, Terraces).
inline constexpr double kappa_of_terraces = 0.25;
/// Whether terrace removal is worthwhile: enough kappa, and room for working codes.
bool terraces_advised(const Scene& scene);

/// The scene's filter; nullopt: none. Needs a scene that `validate` accepts.
std::optional<TerraceFilter> terrace_filter(const Scene& scene);

/// Pulls pixels that hang in the air between two surfaces, because they saw some of both, to one of them;
/// docs/conventions.md has the rule.
struct FlyingPixels {
    CodeCurve gate;  ///< codes that differ by no more belong to one surface

    int gate_at(std::uint16_t code) const { return std::max(gate.at(code), 1); }
    bool operator==(const FlyingPixels&) const = default;
};

/// Steps of the widest ramp between two surfaces whose pixels are pulled: edges of depth that was enlarged,
/// as phones store it.
inline constexpr int widest_ramp = 12;
/// Pixels along a line, to each side of a code, that decide about it.
inline constexpr int flying_reach = widest_ramp;

/// The scene's filter; nullopt: none. Needs a scene that `validate` accepts.
std::optional<FlyingPixels> flying_pixels(const Scene& scene);

/// Number of frames for which a pixel that loses its depth keeps the last one.
inline constexpr int temporal_hold_frames = 3;
/// If a clip is not read from its beginning, the filter starts empty this many frames before the first one
/// that is wanted.
inline constexpr int temporal_warm_up_frames = 16;

/// The temporal filter in one scene's codes; docs/conventions.md has the arithmetic.
struct TemporalFilter {
    WorkingCodes working;  ///< applied first
    CodeCurve gate;        ///< largest change of a code from frame to frame by noise alone
    DepthCoding coding;    ///< of the working codes
    bool operator==(const TemporalFilter&) const = default;
};

/// The scene's filter; nullopt: none. Needs a scene that `validate` accepts.
std::optional<TemporalFilter> temporal_filter(const Scene& scene);

}  // namespace touchable
