#include "device/simulated_device.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>

namespace touchable {

SimulatedDevice::SimulatedDevice(int fingers, DeviceLimits limits)
    : limits_(limits),
      positions_(static_cast<std::size_t>(fingers), glm::dvec3(0)),
      exerted_(static_cast<std::size_t>(fingers), glm::dvec3(0)) {
    assert(fingers > 0 && limits.max_force > 0 && limits.max_stiffness > 0);
}

Result<void> SimulatedDevice::open() {
    go_limp();
    fault_ = nullptr;
    open_ = true;
    return {};
}

void SimulatedDevice::close() {
    go_limp();
    open_ = false;
}

bool SimulatedDevice::read_positions(std::span<glm::dvec3> device_metres) {
    if (!open_ || fault_) return false;
    assert(device_metres.size() == positions_.size());
    std::copy(positions_.begin(), positions_.end(), device_metres.begin());
    return true;
}

bool SimulatedDevice::write_forces(std::span<const glm::dvec3> newtons) {
    if (!open_ || fault_) return false;
    assert(newtons.size() == exerted_.size());
    for (std::size_t finger = 0; finger < newtons.size(); ++finger) {
        const double length = glm::length(newtons[finger]);
        if (!std::isfinite(length)) {
            fail("was given a force that is not finite");
            return false;
        }
        const double shorten = length > limits_.max_force ? limits_.max_force / length : 1.0;
        exerted_[finger] = newtons[finger] * shorten;
    }
    silent_s_ = 0;
    return true;
}

Result<void> SimulatedDevice::health() const {
    if (fault_)
        return Error{ErrorKind::device, "simulated device " + std::string(fault_) + "; open it again"};
    return {};
}

void SimulatedDevice::move(int finger, const glm::dvec3& device_metres) {
    positions_[static_cast<std::size_t>(finger)] = device_metres;
}

void SimulatedDevice::pass_time(double seconds) {
    silent_s_ += seconds;
    if (silent_s_ > silence_s) go_limp();
}

void SimulatedDevice::fail(const char* reason) {
    go_limp();
    fault_ = reason;
}

void SimulatedDevice::go_limp() {
    std::fill(exerted_.begin(), exerted_.end(), glm::dvec3(0));
}

}  // namespace touchable
