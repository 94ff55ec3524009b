#include "player/session/live_line.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>

namespace touchable {

Result<void> LiveLine::take(const TouchTick& tick) {
    ++ticks_;
    next_ = tick.tick + 1;
    newtons_ = 0;
    for (const GuardedForce& finger : tick.forces)
        newtons_ = std::max(newtons_, std::sqrt(glm::dot(finger.force, finger.force)));
    return {};
}

void LiveLine::show(std::int64_t frames, const char* what, const std::function<std::string()>& device) {
    if (!line_.is_due()) return;
    char text[128];
    std::snprintf(text, sizeof text, "live %.1f s, %lld ticks skipped, %lld %s, %.2f N",
                  static_cast<double>(next_) / 1000, static_cast<long long>(next_ - ticks_),
                  static_cast<long long>(frames), what, newtons_);
    line_.show(device ? text + ("; " + device()) : text);
}

}  // namespace touchable
