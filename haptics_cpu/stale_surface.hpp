#pragma once

#include <algorithm>
#include <cstdint>

#include "haptics_cpu/guard_settings.hpp"

namespace touchable {

/// How much of a live surface is felt, by its age: one that no newer frame has renewed for as long as the
/// settings say goes by the ramp by which forces go, and comes back by that by which they come, once there is
/// a newer frame. A pure function of what it was given so far.
class StaleSurface {
public:
    explicit StaleSurface(const GuardSettings& settings)
        : after_ns_(settings.stale_after_ns),
          falls_(1.0 / std::max(1, settings.ramp_out_ticks)),
          rises_(1.0 / std::max(1, settings.ramp_in_ticks)) {}

    /// The next tick: its newest frame is so old, and so many ticks have passed since the last one. True
    /// where the surface comes back after nothing of it was felt.
    bool look(std::int64_t age_ns, int ticks) {
        if (after_ns_ == 0) return false;
        const bool was_gone = share_ == 0, is_stale = age_ns > after_ns_;
        share_ = std::clamp(is_stale ? share_ - ticks * falls_ : share_ + ticks * rises_, 0.0, 1.0);
        return was_gone && !is_stale;
    }
    /// 0 to 1.
    double share() const { return share_; }

private:
    std::int64_t after_ns_;
    double falls_, rises_;  // per tick
    double share_ = 1;
};

}  // namespace touchable
