#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "engine/base/same_bits.hpp"
#include "engine/content/families.hpp"
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

/// A globe to press, slide along and retract from, on its flank 45 degrees from its axis; stiffness 1000 N/m,
/// no friction.
class GlobeFlank : public testing::Test {
protected:
    GlobeFlank() : rig("globe", options(), TouchRig::Depth::codes) {
        rig.scene().default_properties = {1000, 0, 0};
    }
    /// From 1 mm outside straight in to 2 mm, 5 mm along, out and back through free space, in steps of
    /// `step_mm`, millimetres of the device; `limbward`: along away from the axis, or towards it.
    std::vector<glm::dvec3> path(double azimuth, double step_mm, bool limbward) const {
        const GlobeSphere sphere = globe_sphere(CameraPreset::b, options().width, options().height);
        const double scale = 0.001 / rig.settings.metres_per_scene_unit, half = std::sqrt(0.5);
        const glm::dvec3 aside{cosine(azimuth), sine(azimuth), 0}, axis{0, 0, 1};
        const glm::dvec3 out = half * (aside + axis), along = half * (aside - axis);
        const glm::dvec3 touching = sphere.centre + sphere.radius * out;
        auto at = [&](double mm_along, double mm_outside) {
            return touching + scale * (mm_along * along + mm_outside * out);
        };
        const double near = limbward ? -2.5 : 2.5, far = -near;
        return path_along({at(near, 1), at(near, -2), at(far, -2), at(far, 1), at(near, 1)}, step_mm * scale);
    }
    PathResult loop(double azimuth, double step_mm, bool limbward,
                    const GuardSettings& settings = without_ramp()) {
        return run_path(path(azimuth, step_mm, limbward), settings, rig);
    }

    TouchRig rig;

private:
    static SceneOptions options() {
        SceneOptions options;
        options.width = 360;
        options.height = 240;
        return options;
    }
};

}  // namespace touchable::test
