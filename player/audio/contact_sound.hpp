#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "engine/picture/sound_track.hpp"
#include "player/audio/heard_tick.hpp"

namespace touchable {

/// A sound that begins at once, softly, and fades: a sine with an envelope.
class FadingTone {
public:
    /// `fade_s`: until 1/e of it is left; `rise_s` likewise until it is there.
    FadingTone(double fade_s, double rise_s);
    /// As loud as `level`, unless it is louder. `hertz` is that of all of it from now on.
    void strike(double level, double hertz);
    bool is_silent() const { return level_ == 0 && heard_ == 0; }
    double next();
    /// Once a tick: what nobody hears any more ends, and rounding does not add up.
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
