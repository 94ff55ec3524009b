#pragma once

#include <memory>
#include <string>
#include <vector>

#include "device/haptic_device.hpp"

namespace touchable {

/// Several devices as the fingers of one hand: those of the first come first. It can exert what the weakest
/// of them can, and has failed where one of them has.
class DeviceGroup final : public HapticDevice {
public:
    /// At least one.
    explicit DeviceGroup(std::vector<std::unique_ptr<HapticDevice>> devices);

    std::string name() const override;
    DeviceLimits limits() const override;
    int fingers() const override { return fingers_; }
    DeviceCapabilities capabilities() const override;
    Result<void> open() override;
    void close() override;
    bool read_positions(std::span<glm::dvec3> device_metres) override;
    bool write_forces(std::span<const glm::dvec3> newtons) override;
    std::uint32_t buttons() override;  ///< that are pressed on any of them
    double age_s() const override;     ///< of the oldest
    bool is_over() const override;     ///< all of them are
    std::string prompt() const override;
    std::string why_no_position() const override;
    Result<void> health() const override;

private:
    std::vector<std::unique_ptr<HapticDevice>> devices_;
    int fingers_ = 0;
};

}  // namespace touchable
