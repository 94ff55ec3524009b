#include "player/window/touch_meter.hpp"

#include <algorithm>
#include <glm/geometric.hpp>

namespace touchable {

Result<void> TouchMeter::take(const TouchTick& tick) {
    const std::lock_guard lock(mutex_);
    touched_.resize(tick.contacts.size());
    constexpr int most_ticks = 100;  // that a late tick stands for
    double largest = 0;
    int ticks = 0;
    for (std::size_t k = 0; k < tick.contacts.size(); ++k) {
        const bool does = tick.contacts[k].touching;
        measured_.touches += does && !touched_[k];
        touched_[k] = does;
        if (!does) continue;
        ticks = std::max(ticks, std::min(tick.contacts[k].ticks, most_ticks));
        largest =
            std::max(largest, glm::length(force_ == StudyForce::on ? tick.sent(k) : tick.forces[k].force));
    }
    if (ticks == 0) return {};
    contact_ticks_ += ticks;
    sum_newtons_ += ticks * largest;
    measured_.most_newtons = std::max(measured_.most_newtons, largest);
    return {};
}

/// A finger that touches already has come to the surface for this touch, too.
void TouchMeter::begin(StudyForce force) {
    const std::lock_guard lock(mutex_);
    force_ = force;
    contact_ticks_ = 0;
    sum_newtons_ = 0;
    measured_ = {};
    touched_.clear();
}

TouchMeasures TouchMeter::measures() const {
    const std::lock_guard lock(mutex_);
    TouchMeasures measures = measured_;
    measures.contact_s = static_cast<double>(contact_ticks_) * 1e-9 * tick_ns;
    if (contact_ticks_ > 0) measures.mean_newtons = sum_newtons_ / static_cast<double>(contact_ticks_);
    return measures;
}

}  // namespace touchable
