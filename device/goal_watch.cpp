#include "device/goal_watch.hpp"

#include "engine/base/number_words.hpp"

namespace touchable {

void GoalWatch::look(const SurfaceProbe& probe, std::span<glm::dvec3> goals) {
    for (glm::dvec3& goal : goals) {
        ++goals_;
        // Written so that NaN is outside.
        if (!(goal.z < 0)) {
            ++outside_;
            continue;
        }
        const glm::dvec3 seen = probe.project(goal);
        const bool inside =
            seen.x >= 0 && seen.x <= probe.width() - 1 && seen.y >= 0 && seen.y <= probe.height() - 1;
        if (!inside) {
            ++outside_;
            continue;
        }
        const auto surface = probe.depth_under(seen.x, seen.y);
        if (!surface) continue;
        const double below = (seen.z - *surface) * metres_per_scene_unit_;
        far_below_ += below > far_below;
        if (deepest_ && below > *deepest_)
            goal = probe.unproject(seen.x, seen.y, *surface + *deepest_ / metres_per_scene_unit_);
    }
}

std::vector<std::string> GoalWatch::remarks() const {
    std::vector<std::string> out;
    const auto say = [&](std::int64_t some, const std::string& what) {
        const double percent =
            goals_ > 0 ? 100.0 * static_cast<double>(some) / static_cast<double>(goals_) : 0;
        if (percent < 1) return;
        out.push_back(formatted("%.1f %% of the goals ", percent) + what);
    };
    say(outside_, "lie outside the picture, where there is only the wall around it");
    say(far_below_,
        deepest_ ? "were more than 10 mm below the surface, and were raised"
                 : "lie more than 10 mm below the surface; depth=MM among the hand's keys raises them");
    return out;
}

}  // namespace touchable
