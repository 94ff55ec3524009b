// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "device/drivers/device_driver.hpp"
#include "device/drivers/safety_watchdog.hpp"
#include "device/point_motion.hpp"
#include "engine/base/files.hpp"

namespace touchable {

/// How a device is driven.
struct DrivenSettings {
    /// Time for which lost hardware is looked for before it is given up: long enough for the force guard to
    /// take its force away first.
    double away_s = 10;
    double look_again_s = 0.5;  ///< between attempts to open it
    /// Called by the device's thread when it begins, for instance to become real-time.
    std::function<void()> as_thread_begins{};
    /// Unpowers the device if this process is gone or stands still. If set but not working, the device exerts
    /// no force. Null: no other process unpowers the device.
    std::shared_ptr<SafetyWatchdog> watchdog{};
    DriverClock clock = boot_ns;  ///< positions from before a suspension are old after it
    /// Called by the device's thread with the moment (ns) at which a position was received, and at which a
    /// force was sent; they may not wait.
    std::function<void(std::int64_t)> on_received{}, on_sent{};
    /// False: it has no thread; its owner calls `turn` and waits, as tests in virtual time do.
    bool own_thread = true;
};

/// Counters of a device since it was made.
struct DrivenFacts {
    std::int64_t samples = 0;      ///< received samples
    std::int64_t implausible = 0;  ///< finger positions that PlausibleMotion left out
    std::int64_t sent = 0;         ///< sent forces, zeros included
    std::int64_t losses = 0;       ///< times that the hardware was lost
    std::int64_t left_out = -1;    ///< reports that the driver left out (DeviceDriver::left_out)
};

/// A HapticDevice of any backend: its own thread talks to the hardware, the haptic thread takes the newest
/// position and leaves the newest force, and neither waits for the other. The whole safety contract is kept
/// here:
/// - a force is sent only while it is younger than `silence_s` and the finger's newest position is younger
///   than `oldest_s`; otherwise zeros are sent repeatedly. After such a gap the force rises over `rise_s`;
/// - each sent force has passed `force_gate`, whose ceiling is 0 after a gap and rises to the limit over
///   `rise_s`, however late a turn of the thread is;
/// - an impossible or leaping position is left out (PlausibleMotion), as if it had not come;
/// - failed hardware is closed, with zero force if that can still be sent, and looked for. Until it is back
///   its positions are NaN, which the force guard takes for a released hand;
/// - if its thread stands still, the watchdog's process unpowers the device. If that process is gone, the
///   device is closed for good.
class DrivenDevice final : public HapticDevice {
public:
    static constexpr double rise_s = 0.1;

    explicit DrivenDevice(std::unique_ptr<DeviceDriver> driver, DrivenSettings settings = {});
    ~DrivenDevice() override { close(); }

    std::string name() const override { return name_; }
    DeviceLimits limits() const override { return limits_; }
    int fingers() const override { return fingers_; }
    DeviceCapabilities capabilities() const override { return capabilities_; }
    Result<void> open() override;
    void close() override;
    bool read_positions(std::span<glm::dvec3> device_metres) override;
    bool write_forces(std::span<const glm::dvec3> newtons) override;
    std::uint32_t buttons() override { return buttons_; }
    double age_s() const override { return age_s_; }
    bool is_over() const override { return over_.load(std::memory_order_acquire); }
    std::string prompt() const override {
        const std::lock_guard lock(words_mutex_);
        return prompt_;
    }
    std::string why_no_position() const override {
        const std::string known = driver_->why_no_position();
        return known.empty() ? HapticDevice::why_no_position() : known;
    }
    Result<void> health() const override {
        if (const char* misuse = misuse_.load())
            return device_error(name_ + " " + misuse + "; open it again");
        const std::lock_guard lock(words_mutex_);
        if (fault_) return *fault_;
        return {};
    }

    /// One step of the device's thread: sends a force, receives a position, or looks for lost hardware.
    /// False: it is given up.
    bool turn();
    /// Any thread.
    DrivenFacts facts() const {
        return {samples_.load(), implausible_.load(), sent_.load(), losses_.load(), left_out_.load()};
    }

private:
    using Forces = std::array<glm::dvec3, DeviceSample::most_fingers>;
    struct Received {
        DeviceSample sample{};                                            // accepted positions
        std::int64_t time_ns = 0;                                         // 0: nothing yet
        std::array<std::int64_t, DeviceSample::most_fingers> place_ns{};  // of each position; 0: none
    };
    struct Asked {
        Forces newtons{};
        std::int64_t time_ns = 0;
        std::int64_t received_ns = 0;  // time of the position that it answers
    };

    /// On every exit the hardware is closed with zero force.
    void drive() {
        if (settings_.as_thread_begins) settings_.as_thread_begins();
        const StopScope until(stopping_.get_token());
        while (!stop_requested() && turn())
            if (!held_) std::this_thread::sleep_for(std::chrono::milliseconds(5));
        driver_->disconnect();
    }
    Result<void> take_hold();
    Result<void> serve();
    Result<void> receive(std::chrono::microseconds patience);
    Result<void> send();
    Result<void> beat();
    Forces due_forces(std::int64_t now);
    void let_go(const Error& why);
    bool look_for_it();
    void pass_on_prompt() {
        if (std::string prompt = driver_->prompt(); prompt != prompt_)
            set_words(std::nullopt, std::move(prompt));
    }
    void set_words(std::optional<Error> fault, std::string prompt) {
        const std::lock_guard lock(words_mutex_);
        fault_ = std::move(fault);
        prompt_ = std::move(prompt);
    }

    const std::unique_ptr<DeviceDriver> driver_;
    DrivenSettings settings_;
    // The driver's answers, for any thread while the driver's own is busy.
    const std::string name_;
    const int fingers_;
    const DeviceLimits limits_;
    const DeviceCapabilities capabilities_;

    std::thread thread_;
    const Wake wake_;  // a new force, or the end
    std::stop_source stopping_;
    std::atomic<bool> open_{false}, lost_{false}, over_{false};
    std::atomic<const char*> misuse_{nullptr};
    std::atomic<std::int64_t> samples_{0}, implausible_{0}, sent_{0}, losses_{0}, left_out_{-1};
    mutable std::mutex words_mutex_;  // never taken by the haptic thread
    std::optional<Error> fault_;
    std::string prompt_;
    NewestValue<Received> latest_;
    NewestValue<Asked> asked_;
    // Device thread only.
    std::array<PlausibleMotion, DeviceSample::most_fingers> motions_;
    Received received_;  // newest, with accepted positions
    // When each finger's position came back after a gap: an older force answers another position and is not
    // sent.
    std::array<std::int64_t, DeviceSample::most_fingers> found_ns_{};
    struct Rise {
        std::int64_t since_ns = 0;  // start of its force; 0: no force
        double ceiling = 0;         // force_gate's, N
    };
    std::array<Rise, DeviceSample::most_fingers> rises_{};
    std::int64_t sent_ns_ = 0;
    bool held_ = false;  // false: the hardware is looked for
    std::int64_t gone_ns_ = 0, looked_ns_ = 0;
    Error lost_why_;  // while the hardware is looked for
    std::unique_ptr<SafetyWatchdog::Kept> kept_;
    // Haptic thread only.
    std::uint32_t buttons_ = 0;
    std::int64_t received_ns_ = 0;
    double age_s_;
};

}  // namespace touchable
