#pragma once

#include <cstdint>
#include <optional>

#include "player/audio/heard_tick.hpp"

namespace touchable {

/// How strongly a gamepad's motors turn, 0 to 1: the heavy one and the light one.
struct Rumble {
    float low = 0, high = 0;
    bool operator==(const Rumble&) const = default;
};

/// What fingers feel, as a gamepad's rumble: a pure function of the ticks so far. The heavy motor is for how
/// hard a finger presses, meets the surface and lets go, the light one for slipping over rough land. Where no
/// finger has a force it is zero in that very tick.
class ContactRumble {
public:
    Rumble next(const HeardTick& tick);

private:
    double knock_ = 0, rough_ = 0;
};

/// When motors are told what. They are told for a moment only, again and again, so that they stop by
/// themselves once nobody tells them any more.
class RumbleOrders {
public:
    static constexpr int lasts_ms = 150;         ///< an order, where no other comes
    static constexpr double renewed_s = 0.05;    ///< what goes on is ordered again after that
    static constexpr double tick_lasts_s = 0.1;  ///< without another tick nothing is felt any more

    /// At this moment of a clock that does not go backward: `rumble` of the newest of `ticks` ticks. What is
    /// to be ordered now; nothing: what was ordered goes on.
    std::optional<Rumble> at(double now_s, const Rumble& rumble, std::int64_t ticks);
    /// Whoever was told is gone, and the next one was told nothing.
    void forget() { told_ = {}; }

private:
    Rumble told_;
    double told_s_ = 0, tick_s_ = 0;
    std::int64_t ticks_ = 0;
};

}  // namespace touchable
