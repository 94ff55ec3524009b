#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>

#include "device/device_driver.hpp"
#include "device/surface_probe.hpp"
#include "haptics_cpu/workspace.hpp"

namespace touchable {

/// How places of a device become places of the scene.
struct HandMapping {
    Workspace workspace{};
    glm::dmat3 turn{1.0};    ///< a rotation: from the device's axes to x right, y up, z towards the person
    glm::dvec3 offset{0.0};  ///< metres, those axes: added to what is turned
};

/// How a hand was held, in ticks.
struct HandFigures {
    std::int64_t ticks = 0;
    std::int64_t placeless = 0;  ///< no finger's place was known
    std::int64_t exerting = 0;   ///< forces were asked for, and not kept back by the clutch
};

/// What stands between a device that a person holds and the fingers: which place of the scene each place of
/// the device is, and whether forces reach the hand.
///
/// - Forces are off until somebody asks for them. From then on each finger feels them once it has been free:
///   they rise over `rise_ticks`. Off is at once.
/// - They are off again once no finger's place was known for a second: another person may take the device
/// then.
///   (Not after `insist_on_force`.)
/// - After a gap of more than 50 ms it is as if forces had just been asked for: a gap without ticks
///   (`come_back`), or of a finger without a place (`away_ticks`), whatever device it is on.
/// - The fingers are held still in the scene while the device is repositioned (clutch): no force, and then
///   as if forces had just been asked for. A finger that is inside the surface then comes out of it, towards
///   the camera, and the others with it: so it is free, and what it presses next is felt.
/// - Recentring makes the place where the hand is now that of the workspace's centre; likewise.
///
/// The first button asks for forces; while they are on, it is the clutch. The second one stops them. A button
/// that is already pressed when the device's first position comes does nothing.
class HandControl {
public:
    static constexpr int most_fingers = 80;  // eight devices of ten
    static constexpr int rise_ticks = 300;
    static constexpr int longest_away_ticks = 1000;
    /// A finger that had no place for so long has to be free once more. A device gives its last place for
    /// 20 ms (HapticDevice::oldest_s), so this is 50 ms after that place: the same as a gap without ticks.
    static constexpr int away_ticks = 30;
    static constexpr double out_of_it = 0.001;  ///< m, before the surface: where a finger comes out to

    HandControl(int fingers, const HandMapping& mapping);

    // The haptic thread's, every tick: neither waits nor allocates.
    /// The haptic thread did not run for `alone_ms`: every finger has to be free once more before it feels a
    /// force.
    void come_back(std::int64_t alone_ms);
    /// In: device metres, not numbers where there is no place. Out: goals, scene units. `surface`: of this
    /// tick, out of which the fingers come where the clutch is released; nullptr: none.
    void to_goals(std::span<glm::dvec3> places, std::uint32_t buttons, const SurfaceProbe* surface = nullptr);
    /// Of guarded forces what reaches the device, in its axes. `ticks`: that have passed since the last call.
    void to_device(std::span<const glm::dvec3> guarded, int ticks, std::span<glm::dvec3> newtons);
    /// Whether any finger may feel a force in this tick.
    bool exerts() const { return passes_; }
    const HandFigures& figures() const { return figures_; }  ///< or once it is at rest, anybody's

    // Any thread.
    /// Forces stay asked for, even where nobody's place was known for a second.
    void insist_on_force() { insists_.store(true, std::memory_order_relaxed); }
    void ask_force(bool on) { asked_.store(on, std::memory_order_relaxed); }
    /// Whether whoever asks for forces, by a button too, gets them; at first so.
    void allow_force(bool on) {
        allowed_.store(on, std::memory_order_relaxed);
        if (!on) ask_force(false);
    }
    bool force_is_asked() const { return asked_.load(std::memory_order_relaxed); }
    void hold(bool on) { held_.store(on, std::memory_order_relaxed); }  ///< the clutch, of a key
    void recentre() { recentrings_.fetch_add(1, std::memory_order_relaxed); }
    /// As before anybody held it: forces off, no clutch of a key, and the device's middle where the mapping
    /// has it.
    void begin_anew() {
        ask_force(false);
        hold(false);
        beginnings_.fetch_add(1, std::memory_order_relaxed);
    }
    /// How often the first button (0) or the second one (1) was pressed since this was asked last.
    int take_presses(std::size_t button) { return presses_[button].exchange(0, std::memory_order_relaxed); }
    /// By a key or a button: the hand moves, and the fingers do not.
    bool is_repositioned() const { return clutched_.load(std::memory_order_relaxed); }
    /// Of a finger's guarded force, how much reached the hand in the newest tick: 0 to 1.
    double share(std::size_t finger) const { return shares_[finger].load(std::memory_order_relaxed); }
    /// Forces are asked for, and a finger that has not been free since then feels none.
    bool waits_to_be_free() const { return waits_.load(std::memory_order_relaxed); }

    /// Before it is used: where the clip's first frame puts the device.
    void set_mapping(const HandMapping& mapping) {
        mapping_ = mapping;
        offset_ = mapping.offset;
    }
    const HandMapping& mapping() const { return mapping_; }
    /// Likewise, after another one that is at rest, for the same hand over the same scene: what was asked of
    /// that one is asked of this one, and the fingers stay where they were, whatever the mapping is now.
    void go_on_from(const HandControl& before);

private:
    struct Finger {
        glm::dvec3 place{0.0};                // the person's axes, metres, before the offset
        glm::dvec3 goal{0.0};                 // where it is held
        std::optional<glm::dvec3> gripped{};  // its place when the clutch began
        int risen = 0;                        // of rise_ticks: the share of its force that reaches the hand
        int placeless = 0;                    // ticks that have passed since its place was known
        bool free = false;                    // has been, since forces were asked for
        bool known = false;
        void close_gate() {
            risen = 0;
            free = false;
        }
    };
    std::optional<glm::dvec3> centre() const;
    glm::dvec3 moved() const;
    void grip();
    void let_go(const SurfaceProbe* surface);
    void come_out(const SurfaceProbe& surface);
    glm::dvec3 offset_in_effect() const { return gripped_ ? offset_ - moved() : offset_; }
    void take_buttons(std::uint32_t buttons, bool known);
    void close_gates();
    void give_up_forces();

    HandMapping mapping_;
    const std::size_t count_;
    std::atomic<bool> asked_{false}, held_{false}, clutched_{false}, waits_{false}, allowed_{true};
    std::array<std::atomic<int>, 2> presses_{};
    std::atomic<std::uint32_t> recentrings_{0}, beginnings_{0};
    std::atomic<bool> insists_{false};
    std::array<std::atomic<double>, most_fingers> shares_{};
    // The haptic thread's.
    std::array<Finger, most_fingers> fingers_{};
    glm::dvec3 offset_{0.0};  // added to places, the person's axes
    bool gripped_ = false;    // by the clutch
    std::uint32_t recentred_ = 0, begun_ = 0;
    std::uint32_t pressed_ = ~0U;  // before
    bool clutch_button_ = false;
    bool passes_ = false;
    std::int64_t nobody_ticks_ = 0;  // in a row
    HandFigures figures_;
};

}  // namespace touchable
