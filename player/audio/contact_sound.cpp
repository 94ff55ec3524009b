// SPDX-License-Identifier: Apache-2.0
#include "player/audio/contact_sound.hpp"

#include <glm/geometric.hpp>

#include "engine/base/same_bits.hpp"

namespace touchable {
namespace {

constexpr double rate = ContactSound::rate;
constexpr double inaudible = 1e-5;

// Maximum level, before the limiter, of a tap, a slide and a knock.
constexpr double most_tap = 2.2, most_slide = 6, most_knock = 1.2;
// Values of about half that: m/s, W, N.
constexpr double usual_meeting = 0.08, usual_slide = 0.1, usual_let_go = 0.3;
constexpr double usual_change = 0.02;  // N per millisecond: a rough surface
constexpr double smooth_share = 0.35;  // level of a smooth surface relative to a rough one
constexpr double least_hertz = 350, most_more_hertz = 3500, usual_speed = 0.15;  // of a slide
constexpr double volume_per_tick = 0.05;

/// Low-pass: moves toward a value by the shares `rise` up and `fall` down per tick.
void follow(double& value, double to, double rise, double fall) {
    value += (to - value) * (to > value ? rise : fall);
    if (to == 0 && value < inaudible) value = 0;
}

template <std::size_t... finger>
std::array<FingerSound, sizeof...(finger)> fingers_of(std::index_sequence<finger...>) {
    return {FingerSound(static_cast<std::uint32_t>(finger + 1) * 2654435761U)...};
}

/// Soft limiter: compresses loud values, keeps soft ones.
float limited(double value) {
    const double share = value / std::sqrt(1 + value * value);
    return static_cast<float>(share) * ContactSound::loudest;
}

constexpr double seconds_per_tick = 0.001;
constexpr double creep = 1e-4;  // m/s; slower counts as stuck
/// Ticks from a session's begin, while forces return by the guard's ramp: contacts then come from the new
/// surface, not from a finger's motion.
constexpr std::int64_t settling_ticks = 100;

// Of rumble: the half-way values of its motors.
constexpr double most_press = 0.35, usual_press = 1.5;            // of the heavy motor; N
constexpr double usual_knock = 0.06, usual_loosened = 0.3;        // m/s, N
constexpr double usual_roughness = 0.02, usual_work = 0.05;       // N per millisecond; W
constexpr double knock_fades = 1 / 60.0, rough_fades = 1 / 25.0;  // per tick
constexpr double least_felt = 0.01;                               // motors do not turn below

float motor(double value) {
    return value < least_felt ? 0 : static_cast<float>(std::min(value, 1.0));
}

}  // namespace

FadingTone::FadingTone(double fade_s, double rise_s)
    : fade_(1 - 1 / (fade_s * rate)), rise_(1 / (rise_s * rate)) {}

void FadingTone::strike(double level, double hertz) {
    level_ = std::max(level_, level);
    const double angle = 2 * pi * hertz / rate;
    turn_cosine_ = cosine(angle);
    turn_sine_ = sine(angle);
}

double FadingTone::next() {
    level_ *= fade_;
    heard_ += (level_ - heard_) * rise_;
    const double cosine_before = cosine_;
    cosine_ = cosine_before * turn_cosine_ - sine_ * turn_sine_;
    sine_ = cosine_before * turn_sine_ + sine_ * turn_cosine_;
    return heard_ * sine_;
}

void FadingTone::settle() {
    if (level_ < inaudible && heard_ < inaudible) level_ = heard_ = 0;
    const double length = std::sqrt(cosine_ * cosine_ + sine_ * sine_);
    cosine_ /= length;
    sine_ /= length;
}

void SlidingNoise::aim(double level, double hertz) {
    from_ = std::exchange(to_, level);
    tuning_to_ = 2 * pi * hertz / rate;
    if (is_silent()) dull_ = low_ = band_ = 0;
}

/// A state-variable filter, as wide as its centre frequency, after a low-pass that removes hiss.
double SlidingNoise::next(double share) {
    random_ ^= random_ << 13U;
    random_ ^= random_ >> 17U;
    random_ ^= random_ << 5U;
    const double noise = static_cast<double>(random_) / 2147483648.0 - 1;
    constexpr double width = 1;
    tuning_ += (tuning_to_ - tuning_) / 256;
    dull_ += tuning_ * (noise - dull_);
    low_ += tuning_ * band_;
    band_ += tuning_ * (dull_ - low_ - width * band_);
    return band_ * (from_ + (to_ - from_) * share);
}

/// Level rises with force, speed, and the force's change per tick; pitch rises with speed.
void FingerSound::aim_noise(const HeardFinger& finger) {
    const double newtons = finger.touching ? sound_value(finger.newtons, 50) : 0;
    const double slip = finger.touching ? sound_value(finger.slip, 5) : 0;
    const double power = newtons * slip;
    follow(roughness_, finger.touching ? sound_value(finger.change, 10) : 0, 0.7, 0.25);
    follow(speed_, slip, 0.3, 0.1);
    const double rough = smooth_share + (1 - smooth_share) * saturated_share(roughness_, usual_change);
    follow(level_, power > 0 ? most_slide * rough * std::sqrt(saturated_share(power, usual_slide)) : 0, 0.35,
           0.15);
    const double hertz = least_hertz + most_more_hertz * saturated_share(speed_, usual_speed);
    // Compensates that a higher band contains more noise.
    noise_.aim(level_ / std::sqrt(1 + hertz / 1000), hertz);
}

void FingerSound::strike(const HeardFinger& finger) {
    // Four times the stiffness gives twice the frequency.
    const double hertz =
        std::clamp(320 * std::sqrt(sound_value(finger.stiffness, 1e6) / 1000), 140.0, 1400.0);
    if (const double met = sound_value(finger.met, 10); met > 0) {
        const double level = most_tap * saturated_share(met, usual_meeting);
        tap_.strike(level, hertz);
        knock_.strike(0.2 * level, 2.8 * hertz);
    }
    if (const double let_go = sound_value(finger.let_go, 50); let_go > 0)
        knock_.strike(most_knock * saturated_share(let_go, usual_let_go), 2.8 * hertz);
}

void FingerSound::add(const HeardFinger& finger, std::span<StereoSample> to) {
    aim_noise(finger);
    strike(finger);
    if (noise_.is_silent() && tap_.is_silent() && knock_.is_silent()) return;
    // Pans to the finger's place, never fully to one side.
    const double side = std::isfinite(finger.side) ? std::clamp(finger.side, -1.0F, 1.0F) : 0;
    const double left = std::sqrt(0.5 - 0.35 * side), right = std::sqrt(0.5 + 0.35 * side);
    const auto count = static_cast<double>(to.size());
    for (std::size_t k = 0; k < to.size(); ++k) {
        left_ += (left - left_) / 512;
        right_ += (right - right_) / 512;
        double value = tap_.next() + knock_.next();
        if (!noise_.is_silent()) value += noise_.next(static_cast<double>(k + 1) / count);
        to[k].left += static_cast<float>(value * left_);
        to[k].right += static_cast<float>(value * right_);
    }
    tap_.settle();
    knock_.settle();
}

ContactSound::ContactSound() : fingers_(fingers_of(std::make_index_sequence<HeardTick::most_fingers>())) {}

void ContactSound::render(const HeardTick& tick, Samples& samples) {
    samples.fill({});
    for (std::size_t k = 0; k < fingers_.size(); ++k) fingers_[k].add(tick.fingers[k], samples);
    const double from = volume_, to = tick.muted ? 0 : 1;
    volume_ += std::clamp(to - from, -volume_per_tick, volume_per_tick);
    for (std::size_t k = 0; k < samples.size(); ++k) {
        const double volume = from + (volume_ - from) * static_cast<double>(k + 1) / samples_per_tick;
        samples[k] = {limited(volume * samples[k].left), limited(volume * samples[k].right)};
    }
}

HeardTick HeardContacts::hear(const TouchTick& tick) {
    HeardTick heard;
    const std::size_t fingers = std::min(tick.contacts.size(), heard.fingers.size());
    for (std::size_t k = 0; k < fingers; ++k) heard.fingers[k] = hear(tick, k);
    return heard;
}

HeardFinger HeardContacts::hear(const TouchTick& tick, std::size_t finger) {
    const Contact& contact = tick.contacts[finger];
    const glm::dvec3& force = tick.forces[finger].force;
    Before& before = before_[finger];
    const double metres = tick.metres_per_scene_unit;
    const double seconds = std::max(contact.ticks, 1) * seconds_per_tick;
    const double newtons = glm::length(force), changed = glm::length(force - before.force);
    HeardFinger heard;
    heard.touching = contact.touching;
    heard.share = static_cast<float>(tick.share(finger));
    heard.newtons = static_cast<float>(newtons);
    heard.stiffness = static_cast<float>(contact.properties.stiffness);
    heard.side = static_cast<float>(2 * contact.pixel_x / width_ - 1);
    if (contact.touching && !before.touching) {
        // Speed of the finger, or of the surface against a resting finger: penetration after a tick.
        const glm::dvec3 depth = contact.proxy - contact.goal;
        const double length = glm::length(depth);
        const double came = length > 0 ? glm::dot(before.goal - contact.goal, depth) / length : 0;
        heard.met = static_cast<float>(metres * std::max(came, length) / seconds);
    }
    const bool stays = contact.touching && before.touching && !contact.jumped && contact.carried_stiffness;
    if (stays) {
        const glm::dvec3 slipped = contact.proxy - contact.carried;
        const double way = glm::length(slipped);
        heard.slip = static_cast<float>(metres * way / seconds);
        heard.change = static_cast<float>(changed / std::max(contact.ticks, 1));
        // Friction is along the slip; the pressing force is perpendicular to it.
        const double along = way > 0 ? glm::dot(force, slipped) / way : 0;
        heard.newtons = static_cast<float>(std::sqrt(std::max(newtons * newtons - along * along, 0.0)));
        if (before.stuck && heard.slip > creep) heard.let_go = static_cast<float>(changed);
    }
    if (tick.tick < settling_ticks) heard.met = heard.change = heard.let_go = 0;
    before = {contact.touching, stays && heard.slip <= creep, contact.goal, force};
    return heard;
}

Rumble ContactRumble::next(const HeardTick& tick) {
    double newtons = 0, knock = 0, rough = 0;
    for (const HeardFinger& finger : tick.fingers) {
        const double pressed = finger.touching ? sound_value(finger.share * finger.newtons, 50) : 0;
        if (pressed == 0) continue;
        newtons += pressed;
        knock = std::max({knock, saturated_share(sound_value(finger.met, 10), usual_knock),
                          0.6 * saturated_share(sound_value(finger.let_go, 50), usual_loosened)});
        const double work = pressed * sound_value(finger.slip, 5);
        rough = std::max(rough, saturated_share(sound_value(finger.change, 10), usual_roughness) *
                                    std::sqrt(saturated_share(work, usual_work)));
    }
    if (newtons == 0) {
        knock_ = rough_ = 0;
        return {};
    }
    knock_ = std::max(knock, knock_ * (1 - knock_fades));
    rough_ = std::max(rough, rough_ * (1 - rough_fades));
    return {motor(std::max(most_press * saturated_share(newtons, usual_press), knock_)), motor(rough_)};
}

}  // namespace touchable
