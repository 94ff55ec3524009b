#pragma once

#include <algorithm>

namespace touchable {

/// Time between two ticks.
inline constexpr double tick_seconds = 0.001;

/// Velocities are differences of positions from tick to tick, through a low pass of first order with its
/// cutoff at 80 Hz: below it a hand moves, above it an encoder jumps. 1 - exp(-2 pi 80 Hz 1 ms), rounded here
/// so that it is the same everywhere.
inline constexpr double velocity_share = 0.395;

/// After so many ticks nothing is left of what was before that a double could tell: 0.605^100 < 2^-72.
inline constexpr int settled_ticks = 100;

/// A pause of more counts as this many: 1000 s.
inline constexpr int longest_ticks = 1'000'000;

/// `filtered` after `ticks` more ticks, 1 or more, in which the position changed by `step` in all; a length
/// or a vector of them. Ticks that were skipped count like ticks in which it moved evenly.
template <class Value>
Value filtered_velocity(Value filtered, const Value& step, int ticks) {
    const Value velocity = step / (ticks * tick_seconds);
    for (int tick = std::min(ticks, settled_ticks); tick > 0; --tick)
        filtered = filtered + (velocity - filtered) * velocity_share;
    return filtered;
}

}  // namespace touchable
