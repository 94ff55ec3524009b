#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "device/surface_probe.hpp"

namespace touchable {

/// Recorded goals may not fit the surface that they are played over. This counts those that leave the picture
/// or lie far below the surface, and, where asked, raises those that lie deeper than `deepest`.
class GoalWatch {
public:
    /// More than this below the surface is far, device metres: no hand gets there against a usual stiffness.
    static constexpr double far_below = 0.01;

    /// `deepest`: what goals are raised to, device metres below the surface; nothing: they stay.
    GoalWatch(double metres_per_scene_unit, std::optional<double> deepest)
        : metres_per_scene_unit_(metres_per_scene_unit), deepest_(deepest) {}

    /// Counts the goals of a tick, and raises them along their pixels' rays. World, scene units.
    void look(const SurfaceProbe& probe, std::span<glm::dvec3> goals);
    /// What there is to say, as "12.3 % of the goals ..."; nothing of what concerns less than 1 % of them.
    std::vector<std::string> remarks() const;

private:
    double metres_per_scene_unit_;
    std::optional<double> deepest_;
    std::int64_t goals_ = 0, outside_ = 0, far_below_ = 0;
};

}  // namespace touchable
