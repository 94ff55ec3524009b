#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "engine/content/presets.hpp"
#include "engine/trigonometry.hpp"
#include "haptics_cpu/force_guard.hpp"
#include "tests/haptics/small_field.hpp"
#include "tests/haptics/touch_rig.hpp"

namespace touchable::test {

/// Straight lines from corner to corner, in equal steps no longer than `step` on each.
inline std::vector<glm::dvec3> path_along(const std::vector<glm::dvec3>& corners, double step) {
    std::vector<glm::dvec3> path{corners.at(0)};
    for (std::size_t k = 1; k < corners.size(); ++k) {
        const glm::dvec3 way = corners[k] - corners[k - 1];
        const int steps = static_cast<int>(std::ceil(std::sqrt(glm::dot(way, way)) / step));
        for (int n = 1; n <= steps; ++n) path.push_back(corners[k - 1] + way * (double(n) / steps));
    }
    return path;
}

/// No ramp, so that all that happens is the solver's.
inline GuardSettings without_ramp() {
    GuardSettings settings;
    settings.ramp_in_ticks = 0;
    return settings;
}

/// What became of a finger on a path.
struct PathResult {
    EnergyFigures energy;
    std::vector<Contact> contacts;
    std::vector<GuardedForce> forces;

    int ticks_with(GuardReason reason) const {
        int ticks = 0;
        for (const GuardedForce& force : forces) ticks += (force.reasons & reason) != 0;
        return ticks;
    }
    int touching() const {
        int ticks = 0;
        for (const Contact& contact : contacts) ticks += contact.touching;
        return ticks;
    }
};

/// A new finger along a path; `touch(finger, goal)` is a tick of the solver, `scale` its S.
template <class Touch>
PathResult run_path(const std::vector<glm::dvec3>& path, const GuardSettings& settings, double scale,
                    Touch touch) {
    PathResult result;
    ForceGuard guard(settings, scale);
    FingerState finger;
    for (const glm::dvec3& goal : path) {
        result.contacts.push_back(touch(finger, goal));
        result.forces.push_back(guard.guard(result.contacts.back()));
    }
    result.energy = result.forces.back().energy;
    return result;
}
inline PathResult run_path(const std::vector<glm::dvec3>& path, const GuardSettings& settings,
                           const SmallField& field, const TouchSettings& touch = {}) {
    return run_path(path, settings, 0.001, [&](FingerState& finger, const glm::dvec3& goal) {
        return field.touch(finger, goal, 0, touch);
    });
}
inline PathResult run_path(const std::vector<glm::dvec3>& path, const GuardSettings& settings,
                           TouchRig& rig) {
    rig.lift_fingers();
    return run_path(path, settings, rig.settings.metres_per_scene_unit,
                    [&](FingerState&, const glm::dvec3& goal) { return rig.tick(goal); });
}

/// On the flank of the globe, 45 degrees from its axis: from 1 mm outside straight in to 2 mm, 5 mm along,
/// out and back through free space. Device millimetres; `limbward`: along away from the axis, or towards it.
class FlankLoop {
public:
    FlankLoop(const TouchRig& rig, int width, int height, double azimuth) {
        const GlobeSphere sphere = globe_sphere(CameraPreset::b, width, height);
        scale_ = 0.001 / rig.settings.metres_per_scene_unit;
        const glm::dvec3 aside{cosine(azimuth), sine(azimuth), 0}, axis{0, 0, 1};
        const double half = std::sqrt(0.5);
        out_ = half * (aside + axis);
        along_ = half * (aside - axis);
        touching_ = sphere.centre + sphere.radius * out_;
    }
    std::vector<glm::dvec3> path(double step, bool limbward) const {
        const double near = limbward ? -2.5 : 2.5, far = -near;
        return path_along({at(near, 1), at(near, -2), at(far, -2), at(far, 1), at(near, 1)}, step * scale_);
    }

private:
    glm::dvec3 at(double along, double outside) const {
        return touching_ + scale_ * (along * along_ + outside * out_);
    }
    double scale_;
    glm::dvec3 out_, along_, touching_;
};

}  // namespace touchable::test
