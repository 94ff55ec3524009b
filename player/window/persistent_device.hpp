#pragma once

#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "device/haptic_device.hpp"

namespace touchable {

/// A device that a person holds in a window, for sessions that come and go: it stays open from one to the
/// next. Where it has failed for good the session goes on without a hand, until it is looked for again.
class PersistentDevice final : public HapticDevice {
public:
    /// Not opened yet.
    explicit PersistentDevice(std::shared_ptr<HapticDevice> device);
    ~PersistentDevice() override;  ///< closes the device

    std::string name() const override { return device_->name(); }
    DeviceLimits limits() const override { return device_->limits(); }
    int fingers() const override { return device_->fingers(); }
    DeviceCapabilities capabilities() const override { return device_->capabilities(); }
    /// Opens the device the first time.
    Result<void> open() override;
    /// Leaves zero force, and the device open.
    void close() override;
    bool read_positions(std::span<glm::dvec3> device_metres) override;
    bool write_forces(std::span<const glm::dvec3> newtons) override;
    std::uint32_t buttons() override;
    double age_s() const override { return age_s_.load(std::memory_order_relaxed); }  ///< any thread may ask
    std::string prompt() const override { return device_->prompt(); }
    std::string why_no_position() const override { return device_->why_no_position(); }
    Result<void> health() const override { return device_->health(); }

    // The window's.
    /// It has failed, and comes back only when it is looked for.
    bool is_gone() const { return state() == State::gone; }
    bool is_looked_for() const { return state() == State::looked_for; }
    /// Opens the device that is gone again, on a thread of its own; does nothing to one that is not.
    void look_again();
    /// No force reaches the device from the session's next tick on, whoever asks for it. Waits for nobody,
    /// and is for good.
    void power_off() { is_unpowered_.store(true, std::memory_order_release); }

private:
    enum class State { closed, open, gone, looked_for };
    State state() const { return state_.load(std::memory_order_acquire); }

    const std::shared_ptr<HapticDevice> device_;
    // While it is `open` the session's haptic thread has the device; while it is not, whoever opens it.
    std::atomic<State> state_{State::closed};
    std::atomic<double> age_s_;
    std::atomic<bool> is_unpowered_{false};
    const std::vector<glm::dvec3> zeros_;
    std::thread looking_;
};

}  // namespace touchable
