#include "player/audio/contact_rumble.hpp"

#include <algorithm>
#include <cmath>

namespace touchable {
namespace {

constexpr double most_press = 0.35, usual_press = 1.5;            // of the heavy motor; N
constexpr double usual_knock = 0.06, usual_loosened = 0.3;        // m/s, N
constexpr double usual_roughness = 0.02, usual_work = 0.05;       // N in a millisecond; W
constexpr double knock_fades = 1 / 60.0, rough_fades = 1 / 25.0;  // of a tick
constexpr double least_felt = 0.01;                               // a motor does not turn for less

double value_of(float value, double most) {
    return std::isfinite(value) ? std::clamp(static_cast<double>(value), 0.0, most) : 0;
}
double share_of(double value, double usual) {
    return value / (value + usual);
}
float motor(double value) {
    return value < least_felt ? 0 : static_cast<float>(std::min(value, 1.0));
}

}  // namespace

Rumble ContactRumble::next(const HeardTick& tick) {
    double newtons = 0, knock = 0, rough = 0;
    for (const HeardFinger& finger : tick.fingers) {
        const double pressed = finger.touching ? value_of(finger.share * finger.newtons, 50) : 0;
        if (pressed == 0) continue;
        newtons += pressed;
        knock = std::max({knock, share_of(value_of(finger.met, 10), usual_knock),
                          0.6 * share_of(value_of(finger.let_go, 50), usual_loosened)});
        const double work = pressed * value_of(finger.slip, 5);
        rough = std::max(rough, share_of(value_of(finger.change, 10), usual_roughness) *
                                    std::sqrt(share_of(work, usual_work)));
    }
    if (newtons == 0) {
        knock_ = rough_ = 0;
        return {};
    }
    knock_ = std::max(knock, knock_ * (1 - knock_fades));
    rough_ = std::max(rough, rough_ * (1 - rough_fades));
    return {motor(std::max(most_press * share_of(newtons, usual_press), knock_)), motor(rough_)};
}

std::optional<Rumble> RumbleOrders::at(double now_s, const Rumble& rumble, std::int64_t ticks) {
    if (ticks != ticks_) tick_s_ = now_s;
    ticks_ = ticks;
    const Rumble wanted = now_s - tick_s_ < tick_lasts_s ? rumble : Rumble();
    const bool goes_on = wanted == told_ && (wanted == Rumble() || now_s - told_s_ < renewed_s);
    if (goes_on) return std::nullopt;
    told_ = wanted;
    told_s_ = now_s;
    return wanted;
}

}  // namespace touchable
