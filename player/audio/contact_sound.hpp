// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "engine/picture/sound.hpp"
#include "haptics_cpu/touch_step.hpp"

namespace touchable {

/// A finger's contact in a tick, as input of sound. Lengths and speeds are the hand's.
struct HeardFinger {
    bool touching = false;
    float newtons = 0;    ///< pressing force: the component perpendicular to the slip
    float slip = 0;       ///< m/s of the proxy over the surface
    float change = 0;     ///< of the force since the previous tick, N: due to roughness
    float stiffness = 0;  ///< N/m
    float met = 0;        ///< m/s of meeting the surface in this tick; 0: no new contact
    float let_go = 0;     ///< N by which the force fell as a stuck finger slipped; 0: it did not
    float side = 0;       ///< place in the picture, -1 left to 1 right
    float share = 1;      ///< share of its force sent to a haptic device: 0 while forces are off
};

/// Position of the clip's own sound.
struct HeardClip {
    bool plays = false;
    std::int64_t at_ns = 0;  ///< of the clip's time
    std::uint64_t epoch = 0;
    float speed = 1;
};

struct SpokenSound;

/// Inputs of a millisecond of sound.
struct HeardTick {
    static constexpr int most_fingers = 10;
    std::array<HeardFinger, most_fingers> fingers{};
    HeardClip clip;
    const SpokenSound* spoken = nullptr;  ///< the spoken sound; null: none yet
    std::uint32_t spoken_number = 0;      ///< a new number starts the sound
    bool muted = false;
    float loudness = 1;  ///< factor on all samples, 0 to 1
};

/// An external value made finite and clamped to [0, most].
inline double sound_value(float value, double most) {
    return std::isfinite(value) ? std::clamp(static_cast<double>(value), 0.0, most) : 0;
}

/// 0 at 0, 1/2 at the usual value, approaching 1 beyond it.
inline double saturated_share(double value, double usual) {
    return value / (value + usual);
}

/// Merges two ticks: the later one, with all events of the earlier.
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

/// No contacts; volume as before.
inline HeardTick silence_after(const HeardTick& tick) {
    HeardTick silence;
    silence.muted = tick.muted;
    silence.loudness = tick.loudness;
    return silence;
}

/// The same tick continued, without its events.
inline HeardTick going_on(HeardTick tick) {
    for (HeardFinger& finger : tick.fingers) finger.met = finger.let_go = 0;
    return tick;
}

/// What is heard of a session's contacts, tick by tick.
class HeardContacts {
public:
    /// `width`: of the clip, pixels.
    explicit HeardContacts(int width) : width_(width) {}
    HeardTick hear(const TouchTick& tick);

private:
    /// A finger's state in the previous tick.
    struct Before {
        bool touching = false, stuck = false;
        glm::dvec3 goal{0.0}, force{0.0};
    };
    HeardFinger hear(const TouchTick& tick, std::size_t finger);

    int width_;
    std::array<Before, HeardTick::most_fingers> before_{};
};

/// Speeds of a gamepad's motors, 0 to 1: the heavy one and the light one.
struct alignas(8) Rumble {
    float low = 0, high = 0;
    bool operator==(const Rumble&) const = default;
};

/// Contacts as a gamepad's rumble: a pure function of the ticks so far. The heavy motor is for pressing,
/// meeting the surface and letting go, the light one for slipping over rough surfaces. Without force on any
/// finger, it is zero in the same tick.
class ContactRumble {
public:
    Rumble next(const HeardTick& tick);

private:
    double knock_ = 0, rough_ = 0;
};

/// A sine with a fast soft attack and an exponential decay.
class FadingTone {
public:
    /// `fade_s`: time constant of the decay; `rise_s`: time constant of the attack.
    FadingTone(double fade_s, double rise_s);
    /// Raises the envelope to `level`, unless it is higher. `hertz` is the new frequency.
    void strike(double level, double hertz);
    bool is_silent() const { return level_ == 0 && heard_ == 0; }
    double next();
    /// Once a tick: ends inaudible tones, and removes accumulated rounding.
    void settle();

private:
    double fade_, rise_;                      // per sample
    double level_ = 0, heard_ = 0;            // the envelope, and its smoothed value
    double cosine_ = 1, sine_ = 0;            // the phase
    double turn_cosine_ = 1, turn_sine_ = 0;  // rotation per sample
};

/// Band-passed noise with gliding frequency and level.
class SlidingNoise {
public:
    explicit SlidingNoise(std::uint32_t seed) : random_(seed) {}
    /// Sets the target for the next tick.
    void aim(double level, double hertz);
    bool is_silent() const { return from_ == 0 && to_ == 0; }
    /// `share` of the tick that has passed, 0 to 1.
    double next(double share);

private:
    std::uint32_t random_;
    double from_ = 0, to_ = 0;  // level at the tick's start and end
    double tuning_ = 0, tuning_to_ = 0;
    double dull_ = 0, low_ = 0, band_ = 0;
};

/// One finger's sounds: a tap when it meets the surface, noise while it slides, a small knock when it comes
/// unstuck.
class FingerSound {
public:
    explicit FingerSound(std::uint32_t seed) : noise_(seed) {}
    void add(const HeardFinger& finger, std::span<StereoSample> to);

private:
    void aim_noise(const HeardFinger& finger);
    void strike(const HeardFinger& finger);

    FadingTone tap_{0.028, 0.0012}, knock_{0.006, 0.0003};
    SlidingNoise noise_;
    double roughness_ = 0, speed_ = 0, level_ = 0;  // smoothed over ticks
    double left_ = 0.7, right_ = 0.7;
};

/// The sound of contacts: a pure function of the ticks so far. Does not allocate. For any input, samples are
/// finite, within `loudest`, and free of jumps.
class ContactSound {
public:
    static constexpr int rate = 48'000, samples_per_tick = 48;
    static constexpr float loudest = 0.5F;
    using Samples = std::array<StereoSample, samples_per_tick>;

    ContactSound();
    /// Renders the next millisecond.
    void render(const HeardTick& tick, Samples& samples);

private:
    std::array<FingerSound, HeardTick::most_fingers> fingers_;
    double volume_ = 1;
};

}  // namespace touchable
