#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

#include "device/drivers/device_catalog.hpp"
#include "device/point_motion.hpp"

namespace touchable::test {

/// A device on a bench with nobody's hand on it, in virtual time: its force acts so many ticks after it was
/// written, and everything that went out is looked at.
class BenchDevice final : public HapticDevice {
public:
    explicit BenchDevice(const HandleDynamics& dynamics, int delay_ticks = 0)
        : handle_(dynamics, 0.001), forces_(static_cast<std::size_t>(delay_ticks) + 1, glm::dvec3(0)) {}

    std::string name() const override { return "bench device"; }
    DeviceLimits limits() const override { return limit; }
    int fingers() const override { return 1; }
    DeviceCapabilities capabilities() const override { return {.axes_driven = driven}; }
    Result<void> open() override { return {}; }
    void close() override {}
    bool read_positions(std::span<glm::dvec3> metres) override {
        if (broken) return false;
        metres[0] = lost ? glm::dvec3(std::numeric_limits<double>::quiet_NaN()) : handle_.reading();
        return true;
    }
    bool write_forces(std::span<const glm::dvec3> newtons) override {
        spent_ns += takes_ns;
        asked = newtons[0];
        longest = std::max(longest, glm::length(asked));
        return !broken;
    }
    double age_s() const override { return 0.0004; }
    Result<void> health() const override { return Error{ErrorKind::device, "bench device: broke"}; }

    TickPace pace() {
        return {[this] { return pass_tick(); }, [this] { return tick * 1'000'000 + spent_ns; }};
    }
    bool pass_tick() {
        forces_[static_cast<std::size_t>(tick) % forces_.size()] = asked;
        handle_.advance(forces_[static_cast<std::size_t>(tick + 1) % forces_.size()]);
        ++tick;
        if (asked != glm::dvec3(0)) farthest = std::max(farthest, glm::length(handle_.place()));
        broken = broken || (breaks_at > 0 && tick >= breaks_at);
        lost = lost || (loses_place_at > 0 && tick >= loses_place_at);
        return stops_at == 0 || tick < stops_at;
    }

    DeviceLimits limit{8, 20'000};
    int driven = 3;
    std::int64_t tick = 0, breaks_at = 0, loses_place_at = 0, stops_at = 0;
    std::int64_t takes_ns = 0, spent_ns = 0;  ///< a call with forces; all of them
    bool broken = false, lost = false;
    glm::dvec3 asked{0.0};
    double longest = 0, farthest = 0;  ///< newtons; metres from where it rested first, while pushed

private:
    HeldHandle handle_;
    std::vector<glm::dvec3> forces_;
};

}  // namespace touchable::test
