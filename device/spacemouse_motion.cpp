#include "device/spacemouse_motion.hpp"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace touchable {

void SpaceMouseMotion::deflect(const glm::ivec3& counts, std::int64_t now_ns) {
    place(now_ns);
    const glm::dvec3 pushed = glm::dvec3(counts.x, -counts.z, counts.y) / full_deflection;
    const double length = glm::length(pushed);
    const double share = std::min((length - dead_zone) / (1 - dead_zone), 1.0);
    velocity_ = share > 0 ? pushed * (pace_.speed * share / length) : glm::dvec3(0);
    told_ns_ = now_ns;
}

glm::dvec3 SpaceMouseMotion::place(std::int64_t now_ns) {
    const std::int64_t until = std::min(now_ns, told_ns_ + released_ns);
    if (until > now_ns_)
        place_ = glm::clamp(place_ + velocity_ * (static_cast<double>(until - now_ns_) * 1e-9),
                            glm::dvec3(-pace_.reach), glm::dvec3(pace_.reach));
    now_ns_ = std::max(now_ns_, now_ns);
    return place_;
}

}  // namespace touchable
