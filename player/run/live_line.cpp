#include "player/run/live_line.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>

#include "engine/base/number_words.hpp"

namespace touchable {

Result<void> LiveLine::take(const TouchTick& tick) {
    ++ticks_;
    next_ = tick.tick + 1;
    newtons_ = 0;
    is_stale_ = false;
    is_kept_back_ = control_ && control_->waits_to_be_free();
    for (std::size_t finger = 0; finger < tick.forces.size(); ++finger) {
        const GuardedForce& guarded = tick.forces[finger];
        is_stale_ = is_stale_ || (guarded.reasons & guard_stale) != 0;
        newtons_ = std::max(newtons_, glm::length(tick.sent(finger)));
        is_kept_back_ = is_kept_back_ ||
                        (control_ && control_->force_is_asked() && (guarded.reasons & guard_waiting) != 0);
    }
    return {};
}

void LiveLine::show(const LiveStatus& status) {
    if (!line_.is_due()) return;
    const char* const what = !status.is_camera  ? "frames late"
                             : status.has_ended ? "frames felt, and no more come"
                                                : "frames felt";
    std::string words = formatted("live %.1f s, %lld ticks skipped, %lld %s, %.2f N",
                                  static_cast<double>(next_) / 1000, static_cast<long long>(next_ - ticks_),
                                  static_cast<long long>(status.frames), what, newtons_);
    if (device_) words += "; " + device_();
    if (is_stale_) words += "; no new frame comes: the surface is not felt until one does";
    if (is_kept_back_) words += "; lift the finger off the surface: then it is felt";
    line_.show(words);
}

}  // namespace touchable
