#include "device/simulated_device.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>

#include "device/hand_options.hpp"

namespace touchable {

namespace {

constexpr double period_s = 0.001;

bool is_finite(const glm::dvec3& v) {
    return std::isfinite(glm::dot(v, v));
}

constexpr HandleDynamics standard;
constexpr std::array<HandKey, 8> device_keys{{
    {"mass", "kg", 0.05, 10, standard.mass},
    {"damping", "N s/m", 0, 50, standard.damping},
    {"friction", "N", 0, 5, standard.friction},
    {"quantum", "um", 0, 1000, standard.quantum * 1e6},
    {"hand", "N/mm", 0.01, 5, standard.hand_stiffness / 1000},
    {"force", "N", 0.1, 1000, 10},
    {"stiffness", "N/mm", 0.01, 1000, 10},
    {"unplug", "s", 0.001, 1e6, 0},
}};

}  // namespace

SimulatedDevice::SimulatedDevice(int fingers, DeviceLimits limits, const HandleDynamics& handle)
    : limits_(limits),
      handles_(static_cast<std::size_t>(fingers), HeldHandle(handle, period_s)),
      exerted_(static_cast<std::size_t>(fingers), glm::dvec3(0)) {
    assert(fingers > 0 && limits.max_force > 0 && limits.max_stiffness > 0);
}

Result<void> SimulatedDevice::open() {
    power_off();
    fault_ = nullptr;
    open_ = true;
    return {};
}

void SimulatedDevice::close() {
    power_off();
    open_ = false;
}

bool SimulatedDevice::read_positions(std::span<glm::dvec3> device_metres) {
    if (!open_ || fault_) return false;
    assert(device_metres.size() == handles_.size());
    for (std::size_t finger = 0; finger < handles_.size(); ++finger)
        device_metres[finger] = handles_[finger].reading();
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
    silent_ticks_ = 0;
    return true;
}

Result<void> SimulatedDevice::health() const {
    if (fault_)
        return Error{ErrorKind::device, "simulated device " + std::string(fault_) + "; open it again"};
    return {};
}

void SimulatedDevice::put(int finger, const glm::dvec3& device_metres) {
    if (is_finite(device_metres))
        handles_[static_cast<std::size_t>(finger)].put(device_metres, glm::dvec3(0));
    intend(finger, device_metres);
}

void SimulatedDevice::intend(int finger, const glm::dvec3& device_metres) {
    if (is_finite(device_metres)) handles_[static_cast<std::size_t>(finger)].intend(device_metres);
}

void SimulatedDevice::pass_tick() {
    for (std::size_t finger = 0; finger < handles_.size(); ++finger)
        handles_[finger].advance(exerted_[finger]);
    ++silent_ticks_;
    if (silent_ticks_ * period_s > silence_s) power_off();
    if (ticks_to_unplugging_ && --*ticks_to_unplugging_ <= 0) {
        ticks_to_unplugging_.reset();
        fail("was unplugged");
    }
}

void SimulatedDevice::fail(const char* reason) {
    power_off();
    fault_ = reason;
}

void SimulatedDevice::power_off() {
    std::fill(exerted_.begin(), exerted_.end(), glm::dvec3(0));
}

Result<std::unique_ptr<SimulatedDevice>> make_simulated_device(const std::string& description, int fingers) {
    const std::size_t colon = description.find(':');
    if (description.substr(0, colon) != "simulated")
        return usage_error("unknown device '" + description.substr(0, colon) +
                           "'; the one there is is simulated");
    const auto given = HandOptions::parse(
        "device 'simulated'", colon == std::string::npos ? "" : description.substr(colon + 1), device_keys);
    if (!given.ok()) return given.error();
    HandleDynamics handle;
    handle.mass = given->number("mass");
    handle.damping = given->number("damping");
    handle.friction = given->number("friction");
    handle.quantum = given->number("quantum") / 1e6;
    handle.hand_stiffness = given->number("hand") * 1000;
    const DeviceLimits limits{given->number("force"), given->number("stiffness") * 1000};
    auto device = std::make_unique<SimulatedDevice>(fingers, limits, handle);
    if (given->given("unplug"))
        device->unplug_after(static_cast<std::int64_t>(given->number("unplug") / period_s + 0.5));
    return device;
}

}  // namespace touchable
