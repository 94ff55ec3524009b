#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <limits>
#include <mutex>
#include <optional>

#include "device/haptic_device.hpp"

namespace touchable::test {

/// A device of one finger that a test holds: from its own thread, or by a motion over the ticks.
class FakeHand final : public HapticDevice {
public:
    std::string name() const override { return "fake"; }
    DeviceLimits limits() const override { return {5, 1000}; }
    int fingers() const override { return 1; }
    DeviceCapabilities capabilities() const override { return {.axes_driven = axes, .buttons = 1}; }
    Result<void> open() override {
        ++openings;
        if (is_slow && !wait_unless_stopped([this] { return !is_slow; }, std::chrono::milliseconds(1)))
            return interrupted_error();
        if (is_unplugged) return *health_of_unplugged();
        has_failed = false;
        return {};
    }
    void close() override { newtons = 0; }
    bool read_positions(std::span<glm::dvec3> places) override {
        if (has_failed) return false;
        const std::lock_guard lock(mutex_);
        if (motion) place_ = motion(reads);
        ++reads;
        places[0] = place_;
        return true;
    }
    bool write_forces(std::span<const glm::dvec3> forces) override {
        if (has_failed) return false;
        newtons = glm::length(forces[0]);
        most_newtons = std::max(most_newtons.load(), newtons.load());
        return true;
    }
    std::uint32_t buttons() override { return pressed; }
    double age_s() const override {
        const std::lock_guard lock(mutex_);
        return std::isnan(place_.x) ? std::numeric_limits<double>::infinity() : 0.001;
    }
    std::string prompt() const override { return is_away ? "looking for the fake again" : ""; }
    Result<void> health() const override {
        if (is_away || has_failed) return *health_of_unplugged();
        return {};
    }

    void put(const glm::dvec3& place) {
        const std::lock_guard lock(mutex_);
        place_ = place;
    }
    void take_away() { put(glm::dvec3(std::numeric_limits<double>::quiet_NaN())); }

    int axes = 3;
    std::function<glm::dvec3(std::int64_t)> motion;  ///< before it is used: where it is at each reading
    std::atomic<std::int64_t> reads{0};
    std::atomic<std::uint32_t> pressed{0};
    std::atomic<double> newtons{0}, most_newtons{0};
    std::atomic<int> openings{0};
    std::atomic<bool> has_failed{false}, is_unplugged{false}, is_slow{false}, is_away{false};

private:
    static std::optional<Error> health_of_unplugged() {
        return Error{ErrorKind::device, "fake: nothing is plugged in"};
    }
    mutable std::mutex mutex_;
    glm::dvec3 place_{0, 0, 0.2};
};

}  // namespace touchable::test
