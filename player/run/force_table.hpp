#pragma once

// Tables of forces, read again: as columns, and two of them compared tick by tick (docs/forces.md; the
// command `compare`).
//
// Errors name the file, its line and what would be right. Functions keep no state.

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "engine/base/result.hpp"

namespace touchable {

/// What one finger did in one tick, of a forces file (docs/forces.md).
struct ForceSample {
    glm::dvec3 goal{0.0};   ///< world, scene units
    glm::dvec3 force{0.0};  ///< N, guarded
    bool contact = false;
};

/// A forces file: `fingers` samples of each tick, ticks from 0 on.
struct ForceTable {
    int fingers = 0;
    std::vector<ForceSample> samples;

    std::size_t ticks() const { return samples.size() / static_cast<std::size_t>(fingers); }
    const ForceSample& at(std::size_t tick, int finger) const {
        return samples[tick * static_cast<std::size_t>(fingers) + static_cast<std::size_t>(finger)];
    }
};

/// Reads what `touch --forces` wrote. Refuses (ErrorKind::input, with file and line) a table without its
/// columns, and rows that are not every finger of every tick in order.
Result<ForceTable> read_force_table(const std::string& file);

/// Mean, the value that 95 % are not above, and the largest.
struct Deviation {
    double mean = 0, p95 = 0, max = 0;
};

/// Frequencies that a hand tells apart: what it follows, what it feels as flutter, as vibration, as a hum.
struct NoiseBand {
    double from_hz, to_hz;
};
inline constexpr std::array<NoiseBand, 4> noise_bands{{{4, 30}, {30, 100}, {100, 300}, {300, 500}}};

/// Tick and finger where two runs differ most.
struct WorstTick {
    std::int64_t tick = 0;
    int finger = 0;
    double newtons = 0;  ///< |A - B|
};

/// What differs between two runs of the same hand, sample by sample (a sample: one finger in one tick).
struct ForceComparison {
    std::int64_t ticks = 0;  ///< that both have
    int fingers = 0;
    std::int64_t other_goals = 0;  ///< samples whose goals differ: they are not compared any further
    /// Samples, by who touches.
    std::int64_t both = 0, only_a = 0, only_b = 0, neither = 0;
    // Of the samples where both touch.
    double mean_a_n = 0, mean_b_n = 0;  ///< |A|, |B|
    double longer_n = 0;                ///< mean of |A| - |B|
    Deviation difference_n;             ///< |A - B|
    /// Between A and B, where both are `least_newtons` long.
    Deviation direction_degrees;
    static constexpr double least_newtons = 0.05;
    /// RMS of the force in each band, N, while both touch without a break; nothing where they never do for
    /// `noise_window` ticks.
    std::array<double, noise_bands.size()> noise_a_n{}, noise_b_n{};
    static constexpr std::size_t noise_window = 256;
    std::int64_t noise_windows = 0;
    std::vector<WorstTick> worst;  ///< up to five, at least 50 ms apart, the worst first
};

/// Refuses (ErrorKind::usage) runs of different numbers of fingers, and such as have no goal in common.
Result<ForceComparison> compare_forces(const ForceTable& a, const ForceTable& b);

}  // namespace touchable
