#pragma once

#include <cstdint>
#include <vector>

#include "device/hand.hpp"
#include "device/simulated_device.hpp"
#include "haptics_cpu/haptic_port.hpp"

namespace touchable {

/// A scripted or recorded hand in place of a device; nobody feels the forces.
class HandPort final : public HapticPort {
public:
    explicit HandPort(Hand& hand) : hand_(hand) {}
    bool read_goals(std::int64_t tick, const HeightField& field, std::span<glm::dvec3> goals) override;
    bool write_forces(std::span<const glm::dvec3>) override { return true; }

private:
    Hand& hand_;
};

/// A device that a person holds: its handles are the fingers.
class DevicePort final : public HapticPort {
public:
    /// The device outlives the port, and is open.
    DevicePort(HapticDevice& device, const Workspace& workspace) : device_(device), workspace_(workspace) {}
    bool read_goals(std::int64_t tick, const HeightField& field, std::span<glm::dvec3> goals) override;
    bool write_forces(std::span<const glm::dvec3> newtons) override { return device_.write_forces(newtons); }

private:
    HapticDevice& device_;
    Workspace workspace_;
};

/// A hand that holds a simulated device: the hand's goals are where it means the handles to be, the handles'
/// places are the goals that are touched with, and their forces move them. At the first tick the handles are
/// where they are meant to be. A tick that is skipped passes for the device all the same.
class SimulatedPort final : public HapticPort {
public:
    /// Both outlive the port; the device is open, with as many fingers as the hand.
    SimulatedPort(Hand& hand, SimulatedDevice& device, const Workspace& workspace);
    bool read_goals(std::int64_t tick, const HeightField& field, std::span<glm::dvec3> goals) override;
    bool write_forces(std::span<const glm::dvec3> newtons) override { return device_.write_forces(newtons); }

private:
    Hand& hand_;
    SimulatedDevice& device_;
    Workspace workspace_;
    std::int64_t ticks_passed_ = -1;
};

}  // namespace touchable
