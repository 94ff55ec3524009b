#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace touchable {

/// What is heard of a finger in a tick. Lengths and speeds are the hand's.
struct HeardFinger {
    bool touching = false;
    float newtons = 0;    ///< across the way it slips: what presses it on the surface
    float slip = 0;       ///< m/s of the proxy over the surface
    float change = 0;     ///< of the force since the tick before, N: what roughness does
    float stiffness = 0;  ///< N/m
    float met = 0;        ///< m/s with which it met the surface in this tick; 0: it did not
    float let_go = 0;     ///< N by which the force fell as it, stuck until then, slipped; 0: it did not
    float side = 0;       ///< place in the picture, -1 left to 1 right
    float share = 1;      ///< of its force that a held device is sent: 0 while forces are off
};

/// Where the clip's own sound is.
struct HeardClip {
    bool plays = false;
    std::int64_t at_ns = 0;  ///< of the clip's time
    std::uint64_t epoch = 0;
    float speed = 1;
};

struct SpokenSound;

/// What is heard of a millisecond.
struct HeardTick {
    static constexpr int most_fingers = 10;
    std::array<HeardFinger, most_fingers> fingers{};
    HeardClip clip;
    const SpokenSound* spoken = nullptr;  ///< that is said; null: nothing yet
    std::uint32_t spoken_number = 0;      ///< another one begins it anew
    bool muted = false;
    float loudness = 1;  ///< factor on all samples, 0 to 1
};

/// As one: the later of two ticks, with all that happened in the earlier.
inline HeardTick merged(const HeardTick& earlier, const HeardTick& later) {
    HeardTick both = later;
    for (std::size_t k = 0; k < both.fingers.size(); ++k) {
        HeardFinger& finger = both.fingers[k];
        const HeardFinger& before = earlier.fingers[k];
        finger.slip = std::max(finger.slip, before.slip);
        finger.change = std::max(finger.change, before.change);
        finger.let_go = std::max(finger.let_go, before.let_go);
        if (before.met <= finger.met) continue;
        finger.met = before.met;
        if (!finger.touching) finger.stiffness = before.stiffness;
    }
    return both;
}

/// Nothing is felt any more, as loud as before.
inline HeardTick silence_after(const HeardTick& tick) {
    HeardTick silence;
    silence.muted = tick.muted;
    silence.loudness = tick.loudness;
    return silence;
}

/// The same going on: nothing begins a second time.
inline HeardTick going_on(HeardTick tick) {
    for (HeardFinger& finger : tick.fingers) finger.met = finger.let_go = 0;
    return tick;
}

}  // namespace touchable
