#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "device/haptic_device.hpp"
#include "device/held_handle.hpp"

namespace touchable {

/// A device without hardware, in its caller's virtual time: a hand holds each of its handles, the forces it
/// exerts move them and can be looked at, and it can be made to fail. It keeps the safety contract as any
/// device must, so that what drives devices can be tested, and a scene felt for its stability, without one.
class SimulatedDevice final : public HapticDevice {
public:
    SimulatedDevice(int fingers, DeviceLimits limits, const HandleDynamics& handle = {});
    ~SimulatedDevice() override { close(); }

    std::string name() const override { return "simulated"; }
    DeviceLimits limits() const override { return limits_; }
    int fingers() const override { return static_cast<int>(handles_.size()); }
    Result<void> open() override;
    void close() override;
    bool read_positions(std::span<glm::dvec3> device_metres) override;
    bool write_forces(std::span<const glm::dvec3> newtons) override;
    Result<void> health() const override;

    // A place that is not finite changes nothing.
    /// Takes a handle to a place; there it rests, and there the hand means it to be.
    void put(int finger, const glm::dvec3& device_metres);
    /// Where the hand means a handle to be from now on.
    void intend(int finger, const glm::dvec3& device_metres);
    /// Handles move for a millisecond under what is exerted.
    void pass_tick();
    /// Fails by itself once so many ticks have passed from now on.
    void unplug_after(std::int64_t ticks) { ticks_to_unplugging_ = ticks; }
    /// Fails as if the hardware had gone: unpowered at once, until opened again.
    void fail(const char* reason);
    /// What each finger feels now, newtons.
    std::span<const glm::dvec3> exerted() const { return exerted_; }

private:
    void power_off();

    DeviceLimits limits_;
    std::vector<HeldHandle> handles_;
    std::vector<glm::dvec3> exerted_;
    int silent_ticks_ = 0;
    std::optional<std::int64_t> ticks_to_unplugging_;
    bool open_ = false;
    const char* fault_ = nullptr;
};

/// From its description, "simulated[:key=value,...]" (docs/devices.md lists every key); an unknown name, key
/// or value is refused with the legal ones.
Result<std::unique_ptr<SimulatedDevice>> make_simulated_device(const std::string& description, int fingers);

}  // namespace touchable
