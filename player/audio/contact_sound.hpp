#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "engine/picture/sound.hpp"

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

/// What came from outside, as a number that can be used.
inline double sound_value(float value, double most) {
    return std::isfinite(value) ? std::clamp(static_cast<double>(value), 0.0, most) : 0;
}

/// 0 at 0, a half at the usual value, and towards 1 beyond it.
inline double saturated_share(double value, double usual) {
    return value / (value + usual);
}

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

/// A sound that begins at once, softly, and fades: a sine with an envelope.
class FadingTone {
public:
    /// `fade_s`: until 1/e of it is left; `rise_s`: until all but 1/e of it is there.
    FadingTone(double fade_s, double rise_s);
    /// As loud as `level`, unless it is louder. `hertz` is that of all of it from now on.
    void strike(double level, double hertz);
    bool is_silent() const { return level_ == 0 && heard_ == 0; }
    double next();
    /// Once a tick: what cannot be heard any more ends, and rounding does not add up.
    void settle();

private:
    double fade_, rise_;                      // shares of a sample
    double level_ = 0, heard_ = 0;            // the envelope, and what follows it
    double cosine_ = 1, sine_ = 0;            // the phase
    double turn_cosine_ = 1, turn_sine_ = 0;  // of a sample
};

/// Noise through a band whose place and loudness glide.
class SlidingNoise {
public:
    explicit SlidingNoise(std::uint32_t seed) : random_(seed) {}
    /// For the coming tick.
    void aim(double level, double hertz);
    bool is_silent() const { return from_ == 0 && to_ == 0; }
    /// `share` of the tick that has passed.
    double next(double share);

private:
    std::uint32_t random_;
    double from_ = 0, to_ = 0;  // level
    double tuning_ = 0, tuning_to_ = 0;
    double dull_ = 0, low_ = 0, band_ = 0;
};

/// One finger's sounds: a tap where it meets the surface, noise where it slides, a small knock where it had
/// been stuck.
class FingerSound {
public:
    explicit FingerSound(std::uint32_t seed) : noise_(seed) {}
    void add(const HeardFinger& finger, std::span<StereoSample> to);

private:
    void aim_noise(const HeardFinger& finger);
    void strike(const HeardFinger& finger);

    FadingTone tap_{0.028, 0.0012}, knock_{0.006, 0.0003};
    SlidingNoise noise_;
    double roughness_ = 0, speed_ = 0, level_ = 0;  // followed from tick to tick
    double left_ = 0.7, right_ = 0.7;
};

/// What fingers feel, as a sound: a pure function of the ticks so far. It allocates nothing. Whatever comes
/// in, samples are finite, within `loudest`, and free of jumps.
class ContactSound {
public:
    static constexpr int rate = 48'000, samples_per_tick = 48;
    static constexpr float loudest = 0.5F;
    using Samples = std::array<StereoSample, samples_per_tick>;

    ContactSound();
    /// The next millisecond.
    void render(const HeardTick& tick, Samples& samples);

private:
    std::array<FingerSound, HeardTick::most_fingers> fingers_;
    double volume_ = 1;
};

}  // namespace touchable
