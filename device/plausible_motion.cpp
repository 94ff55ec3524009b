#include "device/plausible_motion.hpp"

#include <algorithm>
#include <glm/geometric.hpp>

namespace touchable {

bool PlausibleMotion::reaches(const Seen& from, const glm::dvec3& place, std::int64_t time_ns) {
    const double seconds = std::min(static_cast<double>(time_ns - from.time_ns) * 1e-9, longest_s);
    return glm::length(place - from.place) <= slack + fastest * seconds;
}

std::optional<glm::dvec3> PlausibleMotion::believe(const glm::dvec3& place, std::int64_t time_ns) {
    if (!(glm::length(place) <= farthest)) return std::nullopt;  // nor what is not a number
    if (!last_ || reaches(*last_, place, time_ns)) {
        last_ = Seen{place, time_ns};
        elsewhere_.reset();
        return place;
    }
    if (!elsewhere_ || !reaches(*elsewhere_, place, time_ns)) leapt_ns_ = time_ns;
    elsewhere_ = Seen{place, time_ns};
    if (time_ns - leapt_ns_ < lost_ns) return std::nullopt;
    last_ = elsewhere_;
    elsewhere_.reset();
    return place;
}

}  // namespace touchable
