#pragma once

namespace touchable {

/// Time between two ticks.
inline constexpr double tick_seconds = 0.001;

/// Velocities are differences of positions from tick to tick, through a low pass of first order with its
/// cutoff at 80 Hz: below it a hand moves, above it an encoder jumps. 1 - exp(-2 pi 80 Hz 1 ms), rounded here
/// so that it is the same everywhere.
inline constexpr double velocity_share = 0.395;

/// `filtered` after one more tick in which the position changed by `step`; a length or a vector of them.
template <class Value>
Value filtered_velocity(const Value& filtered, const Value& step) {
    return filtered + (step / tick_seconds - filtered) * velocity_share;
}

}  // namespace touchable
