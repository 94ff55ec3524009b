#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "device/haptic_device.hpp"
#include "device/led_point.hpp"
#include "device/newest_value.hpp"

namespace touchable {

/// How a pointer becomes fingers.
struct PointerSettings {
    /// Along the view a finger is so slow that one which rests, meant to be so far under whatever is seen,
    /// goes with the large shape of a surface and feels its small bumps.
    LeadTimes times{};
    /// m: but along the view it is no farther than that from where one is that is as quick as across. Relief
    /// is less high; what is higher is followed at once, so that a slope does not press, nor lift.
    double leash = 0.002;
    double max_speed = 1.0;       ///< m/s: what a finger goes through a jump of the pointer with
    double approach_speed = 0.4;  ///< m/s: what one that was away comes with, until it is there
    /// Of the force: 10 mm into the stiffest stuff of the generated scenes, 2 N/mm. Of the stiffness: all
    /// that a haptic image usually says, 10 N/mm. A pointer is not moved by a force, so that none is
    /// unstable.
    DeviceLimits limits{20, 10'000};
};

/// A mouse, or any pointer, as a device of up to ten fingers. Whoever has the pointer (the window) says where
/// each finger is meant to be, sixty times a second or when it likes; the haptic thread reads at 1 kHz where
/// they are: each reading is a millisecond of a smooth way there. Forces move nothing: the newest are kept,
/// to be shown.
///
/// A finger that is meant nowhere, or is stopped, goes to the *refuge*: a place that no surface can be
/// before, which is that of the clip's camera. On its way there it stays on its pixel, and so crosses no
/// wall.
///
/// Stopping (`set_force(false)`) is at once: from that call on `forces` are zero; the next reading has every
/// finger at the refuge, and there they stay. Once forces are on again they come as fingers come that were
/// away: slowly, and slower towards the end. That is also how they begin after `open`.
class PointerDevice final : public HapticDevice {
public:
    static constexpr int most_fingers = 10;
    static constexpr double farthest = 1000;      ///< a place farther from the device's centre is none, m
    using Clock = std::function<std::int64_t()>;  ///< ns, never backward

    /// 1 to 10 fingers, all away; force is on. `refuge`: device metres. `clock` tells when a force was
    /// written too long ago to be one (`silence_s`); nothing: the system's.
    PointerDevice(int fingers, const glm::dvec3& refuge, const PointerSettings& settings = {},
                  Clock clock = {});
    ~PointerDevice() override { close(); }

    /// Before it is opened, for whoever knows only then where the clip's camera is.
    void set_refuge(const glm::dvec3& device_metres) { refuge_ = device_metres; }

    std::string name() const override { return "pointer"; }
    DeviceLimits limits() const override { return settings_.limits; }
    int fingers() const override { return static_cast<int>(led_.size()); }
    Result<void> open() override;
    void close() override;
    bool read_positions(std::span<glm::dvec3> device_metres) override;
    bool write_forces(std::span<const glm::dvec3> newtons) override;
    Result<void> health() const override;

    // The window's calls, of one thread. They neither wait nor allocate.
    /// Fingers 0 to `places.size()` - 1 are meant to be there, device metres; the others nowhere. A place
    /// that is not finite, or beyond `farthest`, changes nothing for its finger. `eye`: from where it is
    /// looked at, device metres, which says along what a finger is slow.
    void intend(std::span<const glm::dvec3> places, const glm::dvec3& eye);
    /// Newest force of every finger, newtons; zero where the contract says so, and while force is off. Stays
    /// readable until the next call.
    std::span<const glm::dvec3> forces();

    // Any thread but the haptic one.
    void set_force(bool on);
    bool force_is_on() const { return is_on(force_.load(std::memory_order_acquire)); }

private:
    struct Meant {
        std::optional<glm::dvec3> place;  // nothing: nowhere
        glm::dvec3 along{0.0};            // unit, away from the eye, or zero
    };
    struct Written {
        std::uint32_t opening = 0, force = 0;  // of which it is
        std::int64_t time_ns = 0;
        std::array<glm::dvec3, most_fingers> newtons{};
    };
    /// One finger on its way.
    struct Led {
        LedPoint point;
        LedPoint quick;     // along the view as well: who leads `point` by a leash
        bool comes = true;  // was away, and is not there yet
    };
    static constexpr bool is_on(std::uint32_t force) { return force % 2 == 1; }
    bool works() const;
    void lead(const Meant& meant, Led& led) const;
    void retreat();

    const PointerSettings settings_;
    glm::dvec3 refuge_;
    const Clock clock_;
    // Set by any thread. Openings are counted, 0: closed; so are changes of the force, odd: on. So a force
    // that answers what was before any of them is known.
    std::atomic<std::uint32_t> opening_{0};
    std::atomic<std::uint32_t> force_{1};
    std::atomic<const char*> fault_{nullptr};
    std::uint32_t openings_ = 0;
    // The window's.
    std::array<Meant, most_fingers> meant_{};
    // The haptic thread's.
    std::vector<Led> led_;
    std::uint32_t seen_opening_ = 0, seen_force_ = 1;
    // From one to the other.
    NewestValue<std::array<Meant, most_fingers>> intents_;
    NewestValue<Written> written_;
};

}  // namespace touchable
