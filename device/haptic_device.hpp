#pragma once

// Force-feedback devices as the rest of the program sees them: `HapticDevice`, the interface with its safety
// contract, and the three that need no hardware: a group of others, a simulated one, the window's pointer.
// Hardware, the network and logs are made by their names (device_catalog.hpp); `HandControl` (hand.hpp)
// stands between a device and the fingers.
//
//   auto device = make_device("falcon:firmware=FILE", driven);  // or std::make_unique<PointerDevice>(...)
//   TRY((*device)->open());                                     // may wait
//   every millisecond: read_positions(places), then write_forces(newtons)
//   (*device)->close();                                         // zero force, the hardware is let go of
//
// Threads: one thread calls `open` and `close`, while no other one is at `read_positions` or `write_forces`.
// These two, `buttons` and `age_s` are the haptic thread's: they neither wait nor allocate. `name`, `limits`,
// `fingers`, `capabilities`, `is_over`, `prompt`, `why_no_position` and `health` are any thread's, but may
// allocate. A simulated device is all of one thread; what other threads may ask of a pointer stands there.

#include <glm/vec3.hpp>
#include <span>

#include "engine/base/result.hpp"
#include "engine/base/threads.hpp"

namespace touchable {

class HeldHandle;
struct HandleDynamics;

/// ns by the clock that goes on while the machine is suspended (CLOCK_BOOTTIME), so that what a device said
/// before that is old afterwards. Never backward, even if the time of day is set.
inline std::int64_t steady_ns() {
    return boot_ns();
}

/// What a device can exert and render stably; the force guard is configured with it.
struct DeviceLimits {
    double max_force = 0;      ///< newtons, length of one finger's force, > 0
    double max_stiffness = 0;  ///< newtons per metre of device space, > 0
};

/// What a device has; for people, and for the mapping of its workspace.
struct DeviceCapabilities {
    int axes_sensed = 3;    ///< of a finger's position
    int axes_driven = 3;    ///< 0: it exerts no force
    glm::dvec3 reach{0.0};  ///< half of the workspace to each side of its centre, metres; 0: not known
    double rate_hz = 0;     ///< at which positions come at most; 0: not known
    int buttons = 0;
    bool own_watchdog = false;  ///< the hardware itself drops a force that is not renewed
    bool answers = false;       ///< it sends a position only in answer to a force
    const char* first_button = "the device's first button";  ///< what messages call it
};

/// A force-feedback device with one or more end points (fingers). Positions are in device metres and forces
/// in newtons, axes x right, y up, z towards the person; `Workspace` maps them to the scene.
///
/// Safety contract, for every backend:
/// - No force is exerted before the first `write_forces` after `open`, nor for a finger never written.
/// - A force longer than `limits().max_force` is shortened to it, keeping its direction.
/// - Zero force follows `close`, destruction, any failed call, a force that is not finite, and `silence_s`
///   without a `write_forces`: a caller that hangs or dies leaves an unpowered device. Where the hardware has
///   a watchdog of its own, the backend arms it as well.
/// - After a failure the device stays unpowered, and `health` names the reason, until it is opened again. A
///   device that looks for lost hardware by itself (DrivenDevice) gives positions that are not numbers until
///   it has found it.
/// - A position older than `oldest_s` is never given: what is read in its place is not a number.
class HapticDevice : NonCopyable {
public:
    static constexpr double silence_s = 0.05;  ///< longest time a force outlives the call that wrote it
    static constexpr double oldest_s = 0.02;   ///< longest time a position is given after it was received

    virtual ~HapticDevice() = default;  ///< a backend's destructor closes it

    virtual std::string name() const = 0;
    virtual DeviceLimits limits() const = 0;
    virtual int fingers() const = 0;
    virtual DeviceCapabilities capabilities() const { return {}; }

    /// Takes hold of the hardware and clears an earlier fault. May wait; never called from the haptic thread.
    virtual Result<void> open() = 0;
    /// Leaves zero force and lets go of the hardware. Does nothing when closed.
    virtual void close() = 0;

    // The haptic thread's calls: made every millisecond, so they neither wait nor allocate. False when the
    // device is closed or has failed; spans hold `fingers()` elements.
    virtual bool read_positions(std::span<glm::dvec3> device_metres) = 0;
    virtual bool write_forces(std::span<const glm::dvec3> newtons) = 0;

    // Of the newest reading, the haptic thread's.
    /// Buttons that were pressed, one bit each.
    virtual std::uint32_t buttons() { return 0; }
    /// How old the positions were, s; infinite where there were none.
    virtual double age_s() const { return 0; }

    /// Whether it will give no position any more, as a log that was replayed to its end; any thread.
    virtual bool is_over() const { return false; }
    /// What the person who holds it has to do or wait for, "pull the grip out, then push it in"; empty:
    /// nothing. May allocate, as `health`.
    virtual std::string prompt() const { return {}; }
    /// Why a run that has ended never had a position. May allocate; any thread.
    virtual std::string why_no_position() const {
        const std::string waits = prompt();
        return "the " + name() + " never told a position" + (waits.empty() ? "" : ": " + waits);
    }
    /// Nothing wrong, or why the device is unpowered (ErrorKind::device). May allocate: ask from another
    /// thread, or once a call has returned false.
    virtual Result<void> health() const = 0;
};

/// Several devices as the fingers of one hand, one at least: those of the first come first. It can exert what
/// the weakest of them can, and has failed where one of them has.
std::unique_ptr<HapticDevice> make_device_group(std::vector<std::unique_ptr<HapticDevice>> devices);

/// A device without hardware, in its caller's virtual time: a hand holds each of its handles, the forces it
/// exerts move them and can be looked at, and it can be made to fail. It keeps the safety contract as any
/// device must, so that what drives devices can be tested, and a scene felt for its stability, without one.
class SimulatedDevice final : public HapticDevice {
public:
    SimulatedDevice(int fingers, DeviceLimits limits, const HandleDynamics& handle);
    /// With a handle as it usually is.
    SimulatedDevice(int fingers, DeviceLimits limits);
    ~SimulatedDevice() override;

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
    void fail(const char* reason) {
        power_off();
        fault_ = reason;
    }
    /// What each finger feels now, newtons.
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

/// From its description, "simulated[:key=value,...]" (docs/devices.md lists every key); an unknown name, key
/// or value is refused with the legal ones.
Result<std::unique_ptr<SimulatedDevice>> make_simulated_device(const std::string& description, int fingers);

/// How a pointer becomes fingers.
struct PointerSettings {
    /// A finger's goal lies at a fixed depth below the visible surface. Along the direction of view the
    /// finger follows it slowly: so it goes along with the surface's large shape, and feels small bumps.
    double across_s = 0.025;  ///< time constant across the direction of view, s, at least a period
    double along_s = 0.09;    ///< along it, s, at least a period
    /// m. Along the view the finger is never farther than this from where it would be if it were as quick
    /// there as across. Bumps are less high than that; higher shapes are followed at once, so that a slope
    /// neither presses the finger nor lifts it off.
    double leash = 0.002;
    double max_speed = 1.0;       ///< m/s: of a finger, also where the pointer jumps
    double approach_speed = 0.4;  ///< m/s: of a finger that was away, until it has come to its goal
    /// The force allows 10 mm into the stiffest material of the generated scenes, 2 N/mm. The stiffness, 10
    /// N/mm, is the largest that haptic images usually have. Forces do not move a pointer, so none is
    /// unstable.
    DeviceLimits limits{20, 10'000};
};

/// A mouse, or any pointer, as a device of up to ten fingers. The window says where each finger is meant to
/// be, its goal, sixty times a second or when it likes; the haptic thread reads at 1 kHz where the fingers
/// are. Each reading is a millisecond of a smooth way to the goals. The device exerts no force: forces that
/// are written are only checked.
///
/// A finger without a goal, or that is stopped, goes to the *refuge*: the place of the clip's camera, which
/// is in front of every surface. On its way there it stays on its pixel's ray, and so crosses no wall.
///
/// `set_force(false)` stops at once: the next reading has every finger at the refuge, where nothing is
/// touched, and there they stay. Once forces are on again they come as fingers come that were away: slowly,
/// slower towards the end, and from the refuge or the place that the window says. That is also how they begin
/// after `open`.
class PointerDevice final : public HapticDevice {
public:
    static constexpr int most_fingers = 10;
    static constexpr double farthest = 1000;  ///< a place farther from the device's centre is none, m

    /// 1 to 10 fingers, all away; force is on. `refuge`: device metres.
    PointerDevice(int fingers, const glm::dvec3& refuge, const PointerSettings& settings = {});
    ~PointerDevice() override;

    /// Before it is opened: where the clip's camera is, if that was not known before.
    void set_refuge(const glm::dvec3& device_metres) { refuge_ = device_metres; }

    std::string name() const override { return "pointer"; }
    DeviceLimits limits() const override { return settings_.limits; }
    int fingers() const override;
    Result<void> open() override {
        fault_.store(nullptr, std::memory_order_relaxed);
        opening_.store(++openings_, std::memory_order_release);
        return {};
    }
    void close() override { opening_.store(0, std::memory_order_release); }
    bool read_positions(std::span<glm::dvec3> device_metres) override;
    bool write_forces(std::span<const glm::dvec3> newtons) override;
    Result<void> health() const override {
        if (const char* fault = fault_.load(std::memory_order_relaxed))
            return device_error("pointer " + std::string(fault) + "; open it again");
        return {};
    }

    // The window's call, of one thread. It neither waits nor allocates.
    /// Goals of fingers 0 to `places.size()` - 1, device metres; the others have none. A place that is not
    /// finite, or beyond `farthest`, leaves its finger's goal as it was. `eye`: from where the scene is seen,
    /// device metres; along the line from there a finger is slow.
    void intend(std::span<const glm::dvec3> places, const glm::dvec3& eye);
    /// Of one finger, which is led for itself, and of none else. Where it was away, and has not come yet, it
    /// begins at `from`: a place in front of every surface, and so near to its goal that it is there at once,
    /// however far the clip's camera is. A `from` that is no place counts as none.
    void intend(std::size_t finger, const glm::dvec3& place, const glm::dvec3& from, const glm::dvec3& eye);
    /// That finger has no goal any more.
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
    struct Meant;    // what the window says of a finger
    struct Intents;  // of all fingers, from the window's thread to the haptic one
    struct Led;      // one finger on its way
    static constexpr bool is_on(std::uint32_t force) { return force % 2 == 1; }
    bool works() const {
        return opening_.load(std::memory_order_acquire) != 0 && !fault_.load(std::memory_order_relaxed);
    }
    void lead(const Meant& meant, Led& led) const;
    void retreat();

    const PointerSettings settings_;
    glm::dvec3 refuge_;
    // Set by any thread. Openings are counted, 0: closed; so are changes of the force, odd: on. So a reading
    // finds out about those that came and went since the last one.
    std::atomic<std::uint32_t> opening_{0};
    std::atomic<std::uint32_t> force_{1};
    std::atomic<const char*> fault_{nullptr};
    std::uint32_t openings_ = 0;
    const std::unique_ptr<Intents> intents_;
    // The haptic thread's.
    std::vector<Led> led_;
    std::uint32_t seen_opening_ = 0, seen_force_ = 1;
};

}  // namespace touchable
