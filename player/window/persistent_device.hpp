// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "device/hand.hpp"
#include "device/haptic_device.hpp"

namespace touchable {

/// A haptic device in a window, shared by successive sessions: it stays open from one to the next. After a
/// permanent failure the session continues without a device, until a new search.
class PersistentDevice final : public HapticDevice {
public:
    /// Does not open the device.
    explicit PersistentDevice(std::shared_ptr<HapticDevice> device);
    ~PersistentDevice() override;  ///< closes the device

    std::string name() const override { return device_->name(); }
    DeviceLimits limits() const override { return device_->limits(); }
    int fingers() const override { return device_->fingers(); }
    DeviceCapabilities capabilities() const override { return device_->capabilities(); }
    /// Opens the device the first time.
    Result<void> open() override;
    /// Leaves zero force, and keeps the device open.
    void close() override {
        if (state() == State::open) device_->write_forces(zeros_);
    }
    bool read_positions(std::span<glm::dvec3> device_metres) override;
    bool write_forces(std::span<const glm::dvec3> newtons) override;
    std::uint32_t buttons() override { return state() == State::open ? device_->buttons() : 0; }
    double age_s() const override { return age_s_.load(std::memory_order_relaxed); }  ///< any thread
    std::string prompt() const override { return device_->prompt(); }
    std::string why_no_position() const override { return device_->why_no_position(); }
    Result<void> health() const override { return device_->health(); }

    // The window's thread only.
    /// Whether it has failed, and needs `look_again`.
    bool is_gone() const { return state() == State::gone; }
    bool is_looked_for() const { return state() == State::looked_for; }
    /// Reopens a failed device, on a separate thread.
    void look_again();
    /// From the session's next tick on, no caller's force reaches the device; opening it is cancelled. Does
    /// not wait; permanent.
    void power_off() {
        is_unpowered_.store(true, std::memory_order_release);
        ending_.request_stop();
    }

private:
    enum class State { closed, open, gone, looked_for };
    State state() const { return state_.load(std::memory_order_acquire); }

    const std::shared_ptr<HapticDevice> device_;
    // While `open`, the device belongs to the session's haptic thread; otherwise to the thread that opens it.
    std::atomic<State> state_{State::closed};
    std::atomic<double> age_s_;
    std::atomic<bool> is_unpowered_{false};
    std::stop_source ending_;
    const std::vector<glm::dvec3> zeros_;
    std::thread looking_;
};

/// Whether a haptic device exerts forces, and what the user may do.
struct HandState {
    enum class What { away, has_no_force, repositioned, on, off };
    What what = What::off;
    std::string words;             ///< always visible in the picture
    std::string remark;            ///< what the user has to do (HapticDevice::prompt); empty: nothing
    bool has_to_come_out = false;  ///< `remark` asks to lift the finger off the surface first
};

/// `is_inside`: the guard withholds a finger's force until it has been free.
HandState hand_state(const PersistentDevice& hand, const HandControl& control, bool is_inside = false);

/// The panel's facts about a device.
struct HandFacts {
    std::string device;  ///< its name
    HandState state;
    double age_s = 0;            ///< of the positions; infinite: there are none
    double scene_per_metre = 1;  ///< metres of finger motion in the scene per metre of the hand
    int buttons = 0;
};

}  // namespace touchable
