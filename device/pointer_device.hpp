#pragma once

#include <array>
#include <atomic>
#include <cstdint>
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
    /// A finger's goal lies at a fixed depth below the visible surface. Along the direction of view the
    /// finger follows it slowly: so it goes along with the surface's large shape, and feels small bumps.
    LeadTimes times{};
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
/// slower towards the end, and from the refuge or whatever place the window says. That is also how they begin
/// after `open`.
class PointerDevice final : public HapticDevice {
public:
    static constexpr int most_fingers = 10;
    static constexpr double farthest = 1000;  ///< a place farther from the device's centre is none, m

    /// 1 to 10 fingers, all away; force is on. `refuge`: device metres.
    PointerDevice(int fingers, const glm::dvec3& refuge, const PointerSettings& settings = {});
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
    void set_force(bool on);
    bool force_is_on() const { return is_on(force_.load(std::memory_order_acquire)); }

private:
    struct Meant {
        std::optional<glm::dvec3> place;   // nothing: no goal
        glm::dvec3 along{0.0};             // unit, away from the eye, or zero
        std::optional<glm::dvec3> from{};  // where it begins if it was away; nothing: at the refuge
    };
    /// One finger on its way.
    struct Led {
        LedPoint point;
        LedPoint quick;          // as quick along the view as across; `point` stays within `leash` of it
        bool comes = true;       // it was away, and has not come to its goal yet
        bool has_begun = false;  // before the surface, since it was away
    };
    static constexpr bool is_on(std::uint32_t force) { return force % 2 == 1; }
    bool works() const;
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
    // The window's.
    std::array<Meant, most_fingers> meant_{};
    // The haptic thread's.
    std::vector<Led> led_;
    std::uint32_t seen_opening_ = 0, seen_force_ = 1;
    // From one to the other.
    NewestValue<std::array<Meant, most_fingers>> intents_;
};

}  // namespace touchable
