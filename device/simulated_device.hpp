#pragma once

#include <vector>

#include "device/haptic_device.hpp"

namespace touchable {

/// A device without hardware, in its caller's virtual time: its fingers are where they are put, the forces it
/// exerts can be looked at, and it can be made to fail. It keeps the safety contract as any device must, so
/// that what drives devices can be tested without one.
class SimulatedDevice final : public HapticDevice {
public:
    SimulatedDevice(int fingers, DeviceLimits limits);
    ~SimulatedDevice() override { close(); }

    std::string name() const override { return "simulated"; }
    DeviceLimits limits() const override { return limits_; }
    int fingers() const override { return static_cast<int>(positions_.size()); }
    Result<void> open() override;
    void close() override;
    bool read_positions(std::span<glm::dvec3> device_metres) override;
    bool write_forces(std::span<const glm::dvec3> newtons) override;
    Result<void> health() const override;

    void move(int finger, const glm::dvec3& device_metres);
    void pass_time(double seconds);
    /// Fails as if the hardware had gone: limp at once, until opened again.
    void fail(const char* reason);
    /// What each finger feels now, newtons.
    std::span<const glm::dvec3> exerted() const { return exerted_; }

private:
    void go_limp();

    DeviceLimits limits_;
    std::vector<glm::dvec3> positions_;
    std::vector<glm::dvec3> exerted_;
    double silent_s_ = 0;
    bool open_ = false;
    const char* fault_ = nullptr;
};

}  // namespace touchable
