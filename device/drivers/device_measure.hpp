#pragma once

// How a device is measured (device_catalog.hpp): figures of times and places, and a spring that is tried.

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

/// From each moment to the next, s.
std::vector<double> intervals_between(std::span<const std::int64_t> times_ns);

/// From each moment to the first of `others` that is not earlier, s, where that comes before the next moment
/// does; both lists rise.
std::vector<double> until_the_next(std::span<const std::int64_t> times_ns,
                                   std::span<const std::int64_t> others_ns);

/// Of finite places, one after the other.
WatchFigures::Rest rest_of(std::span<const glm::dvec3> metres);

/// Where a handle stays by itself, with no hand on it.
struct HandleRest {
    glm::dvec3 metres{0.0};
    glm::dvec3 noise_m{0.0};  ///< standard deviation along each axis
};

/// A spring about the place where a device's first finger rests. It is nudged, and what it does then says
/// whether it stays quiet.
class SpringTrial : NonCopyable {
public:
    static constexpr int ticks = 2000;
    static constexpr int nudge_ticks = 10;
    static constexpr double farthest_m = 0.003;  ///< beyond which it is let go

    struct Verdict {
        bool quiet = false;
        std::string why;     ///< it is not quiet
        bool moved = false;  ///< the nudge was felt
    };

    /// `most_force` (N): of spring and nudge together; a third of it nudges. All of these outlive the trial.
    SpringTrial(HapticDevice& device, const TickPace& pace, double most_force)
        : device_(device),
          pace_(pace),
          most_force_(most_force),
          metres_(static_cast<std::size_t>(device.fingers())),
          newtons_(metres_.size(), glm::dvec3(0)) {}
    ~SpringTrial() { power_off(); }

    /// Waits, without force, until the handle stays where it is. Error (ErrorKind::device): it does not.
    Result<HandleRest> wait_for_rest();
    /// With a spring of `stiffness` N/m. Force ends with it, and at the first sign of growth. Error: the
    /// device failed or has no position (ErrorKind::device), given up (ErrorKind::interrupted).
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
