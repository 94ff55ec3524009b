#pragma once

// The codes that filters work on, and the numbers that each filter's settings become there.
//
// Stored codes need not be even steps of length (disparity, hue, logarithms): WorkingCodes are, and say how
// one becomes the other. A CodeCurve is a length that grows with depth, told in codes. TerraceFilter,
// FlyingPixels and TemporalFilter are what a Scene's settings mean in these integers, the same for every
// builder, on the CPU and on the GPU (docs/conventions.md): a builder asks for each by the function of its
// name, which gives nothing where the scene does not want that filter. step_of_code, level_distance and kappa
// say how coarse depth is, by which filters are advised and reports speak of it.
//
// Plain values and pure functions, for any thread; a filter refers to nothing of its scene.

#include <algorithm>
#include <bit>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "engine/scene/scene.hpp"

namespace touchable {

/// A length (DepthLength) in the place of one that grows as depth does, `share` (z + shift): of those that
/// are off it by the same factor at both ends of a range and in between. Of near:far 1:3 that factor is 1.07,
/// 1:8 1.23, 1:30 1.5.
DepthLength length_along_depth(double share, double shift, double near, double far);

/// So twice as much has 16 bits.
inline constexpr int code_curve_most = 32767;

/// A DepthLength at a code, told in codes, in integers (docs/conventions.md): a polynomial of second degree
/// in the code's distance from one end. For inverse depth w it is constant w^2 + quadratic. For log codes it
/// equals the length at both planes and in the middle. It is not negative. Of its coefficients only the
/// linear one can be, for log codes and where codes have a shift; then it can be least between the ends.
struct CodeCurve {
    std::uint16_t constant = 0, linear = 0, quadratic = 0;  ///< each at most a third of 65535
    bool falls = false;                                     ///< the linear coefficient counts as negative
    std::uint16_t last = 0;                                 ///< largest code
    int shift = 0;                                          ///< by which a distance fills 16 bits
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
/// What stored codes become before terraces are removed and noise is averaged, so that a mean of two has
/// somewhere to lie: `factor` times as many. Or, where these would not fit 15 bits, or be coarse where a hand
/// is, codes of their own, looked up in a table: even steps of 1 / (depth + shift), which are about as fine
/// against a pixel's width at every depth. docs/conventions.md has the arithmetic.
struct WorkingCodes {
    int factor = 1;
    std::shared_ptr<const std::vector<std::uint16_t>> table{};  ///< of all 65536 codes; null: multiplied
    DepthCoding coding{};                                       ///< of the working codes

    std::uint16_t of(int code) const {
        return table ? (*table)[static_cast<std::size_t>(code)] : static_cast<std::uint16_t>(code * factor);
    }
    /// `count` codes of a row at once.
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

/// Working codes and a gate of terrace removal are together at most this. So a second difference that leaves
/// 16 bits and wraps around is beyond twice the gate all the same, and so is one with a code of 65535, which
/// no finer one is.
inline constexpr int terrace_range = 32767;

/// Stored codes as they are.
WorkingCodes unchanged_codes(const DepthCoding& coding);
/// Those of this scene. Nothing where no code is valid, or levels are so far apart that they leave no room.
std::optional<WorkingCodes> working_codes(const Scene& scene);
/// Whether there are any; without making a table.
bool has_working_codes(const Scene& scene);

/// The largest code that stands for a depth: of metric codes only those up to `far` are.
int largest_code(const DepthCoding& coding);
/// The coding of codes `factor` times as many, of metric codes a power of two: a multiplied code is the same
/// depth, to the bit. From the least valid code to the largest all are valid.
DepthCoding finer(const DepthCoding& coding, int factor);
/// Depth from a code to the next one, scene units; of the last code that from the one before it.
double step_of_code(const DepthCoding& coding, std::uint16_t code);
/// The same at any depth: from one stored code to the next.
DepthLength code_step(const DepthCoding& coding);

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

/// Pixels that hang in the air between two surfaces, because they saw some of both, are pulled to one of
/// them; docs/conventions.md has the rule.
struct FlyingPixels {
    CodeCurve gate;  ///< codes that differ by no more belong to one surface

    int gate_at(std::uint16_t code) const { return std::max(gate.at(code), 1); }
    bool operator==(const FlyingPixels&) const = default;
};

/// Steps of the widest ramp from one surface to another whose pixels are pulled in: edges of depth that was
/// made larger, as phones store it.
inline constexpr int widest_ramp = 12;
/// Pixels along a line that a code is judged by, to each side of it.
inline constexpr int flying_reach = widest_ramp;

/// What the scene asks for; nothing: no filter. Needs a scene that `validate` accepts.
std::optional<FlyingPixels> flying_pixels(const Scene& scene);

/// Frames for which a pixel without depth keeps what it had.
inline constexpr int temporal_hold_frames = 3;
/// Where a clip is not read from its beginning, the filter begins empty so many frames before the first that
/// is wanted.
inline constexpr int temporal_warm_up_frames = 16;

/// The temporal filter, as it works on one scene's codes; docs/conventions.md has the arithmetic.
struct TemporalFilter {
    WorkingCodes working;  ///< of codes first
    CodeCurve gate;        ///< how far from one frame to the next a code may be off by noise alone
    DepthCoding coding;    ///< of the working codes
    bool operator==(const TemporalFilter&) const = default;
};

/// What the scene asks for; nothing: no filter. Needs a scene that `validate` accepts.
std::optional<TemporalFilter> temporal_filter(const Scene& scene);

}  // namespace touchable
