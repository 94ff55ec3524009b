#pragma once

#include <memory>
#include <vector>

#include "device/hand_control.hpp"
#include "haptics_cpu/haptic_port.hpp"
#include "player/run/device_tick_log.hpp"

namespace touchable {

/// A device that a person holds, with what stands between it and the fingers: mapping, clutch, and the force
/// that is asked for.
class HeldPort final : public HapticPort {
public:
    /// All of them outlive the port; the device is open. `log`: nullptr: nobody wants one.
    HeldPort(HapticDevice& device, HandControl& control, DeviceTickLog* log);
    bool read_goals(std::int64_t tick, const HeightField& field, std::span<glm::dvec3> goals) override;
    void come_back(std::int64_t alone_ms) override { control_.come_back(alone_ms); }
    bool write_forces(std::span<const glm::dvec3> newtons) override;
    /// All of it where the device has no motors: what is told is the scene's then.
    double share(std::size_t finger) const override;

private:
    bool has_place(std::size_t finger) const;

    HapticDevice& device_;
    HandControl& control_;
    DeviceTickLog* log_;
    const bool has_motors_;
    std::vector<glm::dvec3> places_, newtons_;
    std::int64_t tick_ = -1, written_ = -1;
};

}  // namespace touchable
