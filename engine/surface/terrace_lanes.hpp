#pragma once

#include <cstdint>
#include <cstring>

/// The arithmetic of terrace removal on several pixels at once, without a branch. 16 bits are enough, though
/// second differences may leave them (terrace_range). `Lanes`: a vector of 16-bit values with a sign.
namespace touchable {

template <class Lanes>
[[gnu::always_inline]] inline Lanes lanes_at(const std::int16_t* from) {
    Lanes values;
    std::memcpy(&values, from, sizeof(values));
    return values;
}

template <class Lanes>
[[gnu::always_inline]] inline Lanes clamped(const Lanes& value, const Lanes& most) {
    const Lanes below = value < most ? value : most;
    return below > -most ? below : -most;
}

template <class Lanes>
struct SecondDifferences {
    Lanes across, down, falling, rising;
};

/// 16 times what a pass adds to a code. Tents are 2 clamped(d, gate) - clamped(d, 2 gate), summed before they
/// are multiplied.
template <class Lanes>
[[gnu::always_inline]] inline Lanes levelling(const SecondDifferences<Lanes>& d, const Lanes& gate) {
    const Lanes wide = gate + gate;
    const Lanes straight = clamped(d.across, gate) + clamped(d.down, gate);
    const Lanes straight_wide = clamped(d.across, wide) + clamped(d.down, wide);
    const Lanes diagonal = clamped(d.falling, gate) + clamped(d.rising, gate);
    const Lanes diagonal_wide = clamped(d.falling, wide) + clamped(d.rising, wide);
    const Lanes half = straight + straight + diagonal - straight_wide;
    return half + half - diagonal_wide;
}

}  // namespace touchable
