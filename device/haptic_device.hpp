#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <string>

#include "engine/base/result.hpp"

namespace touchable {

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
    bool own_watchdog = false;  ///< the hardware itself drops a force that nobody renews
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
class HapticDevice {
public:
    static constexpr double silence_s = 0.05;  ///< longest time a force outlives the call that wrote it
    static constexpr double oldest_s = 0.02;   ///< longest time a position is given after it was received

    HapticDevice() = default;
    HapticDevice(const HapticDevice&) = delete;
    HapticDevice& operator=(const HapticDevice&) = delete;
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

}  // namespace touchable
