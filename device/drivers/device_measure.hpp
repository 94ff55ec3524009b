// SPDX-License-Identifier: Apache-2.0
#pragma once

// Parts of device measurement (device_catalog.hpp): figures of times and positions, and a spring trial.

#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "device/drivers/device_catalog.hpp"
#include "engine/base/result.hpp"

namespace touchable {

WatchFigures::Percentiles percentiles_of(std::vector<double> values);

/// Intervals between successive times, s.
std::vector<double> intervals_between(std::span<const std::int64_t> times_ns);

/// Times (s) from each of `times` to the first of `others` that is not earlier, unless the next of `times`
/// comes first; both lists ascend.
std::vector<double> until_the_next(std::span<const std::int64_t> times_ns,
                                   std::span<const std::int64_t> others_ns);

/// `metres`: finite positions in order of time.
WatchFigures::Rest rest_of(std::span<const glm::dvec3> metres);

/// Rest position of a handle with no hand on it.
struct HandleRest {
    glm::dvec3 metres{0.0};
    glm::dvec3 noise_m{0.0};  ///< standard deviation along each axis
};

/// A spring about the rest position of a device's first finger. A nudge shows whether it stays quiet.
class SpringTrial : NonCopyable {
public:
    static constexpr int ticks = 2000;
    static constexpr int nudge_ticks = 10;
    static constexpr double farthest_m = 0.003;  ///< from rest; beyond it force ends

    struct Verdict {
        bool quiet = false;
        std::string why;     ///< why it is not quiet
        bool moved = false;  ///< whether the nudge moved the handle
    };

    /// `most_force` (N): limit of spring plus nudge; a third of it nudges. The arguments outlive the trial.
    SpringTrial(HapticDevice& device, const TickPace& pace, double most_force)
        : device_(device),
          pace_(pace),
          most_force_(most_force),
          metres_(static_cast<std::size_t>(device.fingers())),
          newtons_(metres_.size(), glm::dvec3(0)) {}
    ~SpringTrial() { power_off(); }

    /// Waits, without force, until the handle is still. Error (ErrorKind::device): it does not come to rest.
    Result<HandleRest> wait_for_rest();
    /// Tries a spring of `stiffness` N/m. Force ends on return and at the first sign of growth. Errors: the
    /// device failed or has no position (ErrorKind::device), cancelled (ErrorKind::interrupted).
    Result<Verdict> try_spring(double stiffness, const HandleRest& rest) {
        auto verdict = feel(stiffness, rest);
        power_off();
        return verdict;
    }

private:
    Result<glm::dvec3> read() {
        if (!device_.read_positions(metres_)) return failure_of(device_);
        if (std::isfinite(metres_[0].x + metres_[0].y + metres_[0].z)) return metres_[0];
        const std::string prompt = device_.prompt();
        return device_error(device_.name() + ": lost its position while a spring was tried" +
                            (prompt.empty() ? "" : "; " + prompt));
    }
    Result<void> push(const glm::dvec3& newtons) {
        newtons_[0] = newtons;
        if (!device_.write_forces(newtons_)) return failure_of(device_);
        if (!pace_.next_tick()) return interrupted_error();
        return {};
    }
    void power_off() {
        newtons_[0] = glm::dvec3(0);
        device_.write_forces(newtons_);
    }
    Result<Verdict> feel(double stiffness, const HandleRest& rest);

    HapticDevice& device_;
    const TickPace& pace_;
    const double most_force_;
    std::vector<glm::dvec3> metres_, newtons_;
};

}  // namespace touchable
