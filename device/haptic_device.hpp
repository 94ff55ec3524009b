// SPDX-License-Identifier: Apache-2.0
#pragma once

// Force-feedback devices: `HapticDevice`, the interface with its safety contract, and three devices that need
// no hardware: a group of others, a simulated one, the window's pointer. Devices of hardware, network and
// logs are made by name (device_catalog.hpp); `HandControl` (hand.hpp) is the layer between a device and the
// fingers.
//
//   auto device = make_device("falcon:firmware=FILE", driven);  // or std::make_unique<PointerDevice>(...)
//   TRY((*device)->open());                                     // may wait
//   every millisecond: read_positions(places), then write_forces(newtons)
//   (*device)->close();                                         // zero force; closes the hardware
//
// Threads: one thread calls `open` and `close`, while no other one is in `read_positions` or `write_forces`.
// The haptic thread calls these two, `buttons` and `age_s`: they neither wait nor allocate. Any thread may
// call `name`, `limits`, `fingers`, `capabilities`, `is_over`, `prompt`, `why_no_position` and `health`,
// which may allocate. One thread uses a simulated device; a pointer's functions name their threads.

#include <array>
#include <atomic>
#include <glm/vec3.hpp>
#include <span>

#include "device/point_motion.hpp"
#include "engine/base/result.hpp"
#include "engine/base/threads.hpp"

namespace touchable {

class HeightField;
struct Workspace;

/// The newest value that one thread wrote, for one other thread to read. Neither locks, waits or retries, and
/// a value is never read half-written: of three slots one is the writer's, one the reader's, and each swaps
/// its own for the one in between.
template <class T>
class NewestValue : NonCopyable {
public:
    /// Writer.
    void write(const T& value) {
        places_[writers_] = value;
        writers_ = between_.exchange(writers_ | is_new, std::memory_order_acq_rel) & ~is_new;
    }
    /// Reader. Returns a default value before the first write; the result stays unchanged until the next
    /// call.
    const T& read() {
        if ((between_.load(std::memory_order_relaxed) & is_new) != 0)
            readers_ = between_.exchange(readers_, std::memory_order_acq_rel) & ~is_new;
        return places_[readers_];
    }

private:
    static constexpr std::size_t is_new = 4;

    std::array<T, 3> places_{};
    alignas(64) std::size_t writers_ = 0;
    alignas(64) std::size_t readers_ = 1;
    alignas(64) std::atomic<std::size_t> between_{2};
};

/// What a device can exert and render stably; the force guard is configured with it.
struct DeviceLimits {
    /// Newtons, length of one finger's force, > 0. Too high: motors overheat, and a fault hits the hand
    /// harder.
    double max_force = 0;
    /// Newtons per metre of device space, > 0. Too high: the handle vibrates in contact.
    double max_stiffness = 0;
};

/// Properties of a device, for people and for the mapping of its workspace.
struct DeviceCapabilities {
    int axes_sensed = 3;    ///< of a finger's position
    int axes_driven = 3;    ///< 0: it exerts no force
    glm::dvec3 reach{0.0};  ///< half of the workspace to each side of its centre, metres; 0: unknown
    double rate_hz = 0;     ///< highest rate of positions; 0: unknown
    int buttons = 0;
    bool own_watchdog = false;  ///< the hardware itself drops a force that is not renewed
    bool answers = false;       ///< it sends a position only in answer to a force
    const char* first_button = "the device's first button";  ///< its name in messages
};

/// A force-feedback device with one or more end points (fingers). Positions are in device metres and forces
/// in newtons, axes x right, y up, z towards the person; `Workspace` maps them to the scene.
///
/// Safety contract, for every backend:
/// - No force is exerted before the first `write_forces` after `open`, nor for a finger never written.
/// - A force longer than `limits().max_force` is shortened to it, keeping its direction.
/// - Zero force follows `close`, destruction, any failed call, a force that is not finite, and `silence_s`
///   without a `write_forces`: a caller that hangs or dies leaves an unpowered device. If the hardware has
///   its own watchdog, the backend arms it as well.
/// - After a failure the device stays unpowered, and `health` names the reason, until it is opened again. A
///   device that looks for lost hardware by itself (DrivenDevice) returns NaN positions until it has found
///   it.
/// - A position older than `oldest_s` is never returned: it is read as NaN.
class HapticDevice : NonCopyable {
public:
    static constexpr double silence_s = 0.05;  ///< longest time a force outlives the call that wrote it
    static constexpr double oldest_s = 0.02;   ///< longest time a position is returned after it was received

    virtual ~HapticDevice() = default;  ///< a backend's destructor closes it

    virtual std::string name() const = 0;
    virtual DeviceLimits limits() const = 0;
    virtual int fingers() const = 0;
    virtual DeviceCapabilities capabilities() const { return {}; }

    /// Opens the hardware and clears an earlier fault. May wait; never called from the haptic thread.
    virtual Result<void> open() = 0;
    /// Sends zero force and closes the hardware. No effect when closed.
    virtual void close() = 0;

    // Called by the haptic thread every millisecond: they neither wait nor allocate. False if the device is
    // closed or has failed; spans hold `fingers()` elements.
    virtual bool read_positions(std::span<glm::dvec3> device_metres) = 0;
    virtual bool write_forces(std::span<const glm::dvec3> newtons) = 0;
    /// After `read_positions`, with the tick's surface: corrects the goals (world, scene units) of fingers
    /// that no hand holds.
    virtual void keep_clear(const HeightField&, const Workspace&, std::span<glm::dvec3>) {}

    // About the newest reading; haptic thread only.
    /// Pressed buttons, one bit each.
    virtual std::uint32_t buttons() { return 0; }
    /// Age of the positions, s; infinite if there were none.
    virtual double age_s() const { return 0; }

    /// Whether no position will come any more, as from a log that was replayed to its end; any thread.
    virtual bool is_over() const { return false; }
    /// What the person at the device has to do or wait for, "pull the grip out, then push it in"; empty:
    /// nothing. May allocate, like `health`.
    virtual std::string prompt() const { return {}; }
    /// Why a run that has ended never had a position. May allocate; any thread.
    virtual std::string why_no_position() const {
        const std::string waits = prompt();
        return "the " + name() + " never told a position" + (waits.empty() ? "" : ": " + waits);
    }
    /// No error, or why the device is unpowered (ErrorKind::device). May allocate: for other threads, or
    /// after a call has returned false.
    virtual Result<void> health() const = 0;
};

/// Several devices, at least one, as the fingers of one hand; the first device's fingers come first. The
/// limits are those of the weakest device, and one failed device is a failure of the group.
std::unique_ptr<HapticDevice> make_device_group(std::vector<std::unique_ptr<HapticDevice>> devices);

/// A device without hardware, in its caller's virtual time: a simulated hand holds each of its handles;
/// forces move the handles and can be read; it can be made to fail. It keeps the safety contract, so that
/// code that drives devices can be tested, and a scene's stability checked, without hardware.
class SimulatedDevice final : public HapticDevice {
public:
    SimulatedDevice(int fingers, DeviceLimits limits, const HandleDynamics& handle = {});

    std::string name() const override { return "simulated"; }
    DeviceLimits limits() const override { return limits_; }
    int fingers() const override { return static_cast<int>(exerted_.size()); }
    Result<void> open() override {
        power_off();
        fault_ = nullptr;
        open_ = true;
        return {};
    }
    void close() override {
        power_off();
        open_ = false;
    }
    bool read_positions(std::span<glm::dvec3> device_metres) override;
    bool write_forces(std::span<const glm::dvec3> newtons) override;
    Result<void> health() const override {
        if (fault_) return device_error("simulated device " + std::string(fault_) + "; open it again");
        return {};
    }

    // A position that is not finite has no effect.
    /// Moves a handle to a position at rest, which becomes the hand's target.
    void put(int finger, const glm::dvec3& device_metres);
    /// Sets the hand's target for a handle from now on.
    void intend(int finger, const glm::dvec3& device_metres);
    /// Moves the handles by a millisecond under the exerted forces.
    void pass_tick();
    /// Makes the device fail after so many more ticks.
    void unplug_after(std::int64_t ticks) { ticks_to_unplugging_ = ticks; }
    /// Fails like hardware that is gone: unpowered at once, until opened again.
    void fail(const char* reason) {
        power_off();
        fault_ = reason;
    }
    /// Force on each finger now, newtons.
    std::span<const glm::dvec3> exerted() const { return exerted_; }

private:
    void power_off() { std::fill(exerted_.begin(), exerted_.end(), glm::dvec3(0)); }

    DeviceLimits limits_;
    std::vector<HeldHandle> handles_;
    std::vector<glm::dvec3> exerted_;
    int silent_ticks_ = 0;
    std::optional<std::int64_t> ticks_to_unplugging_;
    bool open_ = false;
    const char* fault_ = nullptr;
};

/// Makes a device from "simulated[:key=value,...]" (docs/devices.md lists every key); refuses an unknown
/// name, key or value with the legal ones.
Result<std::unique_ptr<SimulatedDevice>> make_simulated_device(const std::string& description, int fingers);

/// How a pointer moves fingers.
struct PointerSettings {
    /// A finger's goal lies at a fixed depth below the visible surface. Along the direction of view the
    /// finger follows it slowly: so it follows the surface's large shape, and feels small bumps.
    double across_s = 0.025;  ///< time constant across the direction of view, s, at least a period
    double along_s = 0.09;    ///< along it, s, at least a period
    /// m; along the view, the largest distance of a finger from where it would be with the time constant
    /// `across_s`. Bumps are lower than that; higher shapes are followed at once, so that a slope neither
    /// presses the finger nor lifts it off.
    double leash = 0.002;
    double max_speed = 1.0;       ///< m/s: of a finger, even if the pointer jumps
    double approach_speed = 0.4;  ///< m/s: of a finger that was away, until it reaches its goal
    /// The force allows 10 mm into the stiffest material of the generated scenes, 2 N/mm. The stiffness, 10
    /// N/mm, is the largest that haptic images usually have. Forces do not move a pointer, so none is
    /// unstable.
    DeviceLimits limits{20, 10'000};
};

/// A mouse, or any pointer, as a device of up to ten fingers. The window sets each finger's goal, sixty times
/// a second or at any rate; the haptic thread reads the fingers' positions at 1 kHz. Each reading is a
/// millisecond of a smooth way to the goals. The device exerts no force: written forces are only checked.
///
/// A finger without a goal, or that is stopped, goes to the *refuge*: the position of the clip's camera, in
/// front of every surface. On its way there it stays on its pixel's ray, and so crosses no wall.
///
/// A finger that hovers touches nothing (`keep_clear`): if the surface bars its way, it rises on its ray of
/// the clip's camera, which meets nothing, crosses at that height, and comes down.
///
/// `set_force(false)` stops at once: every finger is at the refuge in the next reading, without contact, and
/// stays there. Once forces are on again, the fingers come as if they had been away: slowly, slower towards
/// the end, and from the refuge or the start that the window sets. `open` begins in the same way.
class PointerDevice final : public HapticDevice {
public:
    static constexpr int most_fingers = 10;
    static constexpr double farthest = 1000;  ///< m from the device's centre; farther positions are ignored

    /// 1 to 10 fingers, all away; force is on. `refuge`: device metres.
    PointerDevice(int fingers, const glm::dvec3& refuge, const PointerSettings& settings = {});

    /// Sets where the clip's camera is, before `open`, if that was unknown at construction.
    void set_refuge(const glm::dvec3& device_metres) { refuge_ = device_metres; }
    /// Stays open from one session to the next, so that its fingers stay in place: while it works, `close`
    /// and `open` have no effect. Before the first `open`.
    void stay_open() { stays_open_ = true; }

    std::string name() const override { return "pointer"; }
    DeviceLimits limits() const override { return settings_.limits; }
    int fingers() const override { return static_cast<int>(led_.size()); }
    Result<void> open() override {
        if (stays_open_ && works()) return {};
        fault_.store(nullptr, std::memory_order_relaxed);
        opening_.store(++openings_, std::memory_order_release);
        return {};
    }
    void close() override {
        if (!stays_open_) opening_.store(0, std::memory_order_release);
    }
    bool read_positions(std::span<glm::dvec3> device_metres) override;
    bool write_forces(std::span<const glm::dvec3> newtons) override;
    void keep_clear(const HeightField& field, const Workspace& workspace,
                    std::span<glm::dvec3> goals) override;
    Result<void> health() const override {
        if (const char* fault = fault_.load(std::memory_order_relaxed))
            return device_error("pointer " + std::string(fault) + "; open it again");
        return {};
    }

    // Window thread only; they neither wait nor allocate.
    /// Sets the goals of fingers 0 to `places.size()` - 1, device metres; the others get none. A position
    /// that is not finite, or beyond `farthest`, leaves its finger's goal unchanged. `eye`: viewpoint, device
    /// metres; along the line from there a finger is slow.
    void intend(std::span<const glm::dvec3> places, const glm::dvec3& eye);
    /// Sets the goal of a single finger. If it was away, and has not arrived yet, it begins at `from`: a
    /// position in front of every surface, and so near its goal that it arrives at once, however far the
    /// clip's camera is. An invalid `from` is ignored. `hovers`: it does not press.
    void intend(std::size_t finger, const glm::dvec3& place, const glm::dvec3& from, const glm::dvec3& eye,
                bool hovers = false);
    /// Removes a finger's goal.
    void withdraw(std::size_t finger);

    // Any thread but the haptic one.
    void set_force(bool on) {
        std::uint32_t now = force_.load(std::memory_order_relaxed);
        while (is_on(now) != on && !force_.compare_exchange_weak(now, now + 1, std::memory_order_acq_rel,
                                                                 std::memory_order_relaxed)) {
        }
    }
    bool force_is_on() const { return is_on(force_.load(std::memory_order_acquire)); }

private:
    /// A finger's goal from the window.
    struct Meant {
        std::optional<glm::dvec3> place{};  // nothing: no goal
        glm::dvec3 along{0.0};              // unit, away from the eye, or zero
        std::optional<glm::dvec3> from{};   // start if it was away; nothing: the refuge
        bool hovers = false;
    };
    /// One finger on its way.
    struct Led {
        LedPoint point;
        LedPoint quick;          // as quick along the view as across; `point` stays within `leash` of it
        bool comes = true;       // it was away, and has not reached its goal yet
        bool has_begun = false;  // from Meant::from, since it was away
        bool hovers = true;
        std::optional<glm::dvec3> clear{};  // if it hovers: its last goal, in front of the surface, world
    };
    static constexpr bool is_on(std::uint32_t force) { return force % 2 == 1; }
    bool works() const {
        return opening_.load(std::memory_order_acquire) != 0 && !fault_.load(std::memory_order_relaxed);
    }
    void lead(const Meant& meant, Led& led) const;
    glm::dvec3 next_clear(const HeightField& field, const Workspace& workspace, const glm::dvec3& from,
                          const glm::dvec3& wanted) const;
    void retreat();

    const PointerSettings settings_;
    glm::dvec3 refuge_;
    bool stays_open_ = false;
    // Set by any thread. They count openings (0: closed) and changes of the force (odd: on), so that a
    // reading notices those that came and went since the last one.
    std::atomic<std::uint32_t> opening_{0};
    std::atomic<std::uint32_t> force_{1};
    std::atomic<const char*> fault_{nullptr};
    std::uint32_t openings_ = 0;
    std::array<Meant, most_fingers> meant_{};                // window thread only
    NewestValue<std::array<Meant, most_fingers>> newest_{};  // from the window to the haptic thread
    // Haptic thread only.
    std::vector<Led> led_;
    std::uint32_t seen_opening_ = 0, seen_force_ = 1;
};

}  // namespace touchable
