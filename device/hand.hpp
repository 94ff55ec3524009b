// SPDX-License-Identifier: Apache-2.0
#pragma once

// Hands: sources of the fingers' goals. `make_hand` makes one from a description ("wander:speed=0.2",
// "csv:FILE:columns=x+y+z"): a path over the picture or a recorded motion, which returns goals tick by tick
// and knows of the surface only what a `SurfaceProbe` says. If a person holds a device instead, `HandControl`
// is the layer between it (haptic_device.hpp) and the fingers: it maps positions of the device to the scene,
// and decides whether forces reach the hand.
//
//   TRY_ASSIGN(auto hand, make_hand("press:depth=3", 1, workspace, probe));
//   every tick: hand->goals_at(tick, probe, goals)
//
// `GoalWatch` reports how recorded goals fit the surface.
//
// Threads: a hand and a watch are used by one thread. The thread that ticks calls HandControl's
// `come_back`, `to_goals` and `to_device`, which neither wait nor allocate; functions for any thread are
// marked.

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <span>

#include "engine/base/result.hpp"
#include "haptics_cpu/touch_step.hpp"

namespace touchable {

/// A scripted hand's view of the surface at the moment of the tick.
class SurfaceProbe {
public:
    virtual ~SurfaceProbe() = default;
    virtual int width() const = 0;   ///< pixels
    virtual int height() const = 0;  ///< pixels
    /// Planar depth of the surface under pixel (x, y), height taken off, scene units; nothing if a vertex of
    /// its cell is invalid or lies outside the picture.
    virtual std::optional<double> depth_under(double x, double y) const = 0;
    /// World point of pixel (x, y) at a planar depth, scene units.
    virtual glm::dvec3 unproject(double x, double y, double planar_depth) const = 0;
    /// Pixel of a world point in front of the camera (z < 0): (x, y, planar depth).
    virtual glm::dvec3 project(const glm::dvec3& point) const = 0;
};

/// A source of goals: one per finger and tick. Deterministic: the same options, probe and ticks give the same
/// bits.
class Hand {
public:
    virtual ~Hand() = default;
    virtual int fingers() const = 0;
    /// Goals of tick `tick` (at `tick` ms), world, scene units. Called with consecutive ticks from 0.
    virtual void goals_at(std::int64_t tick, const SurfaceProbe& probe, std::span<glm::dvec3> goals) = 0;
    /// Whether the goal of the last tick lifted the finger over broken or rough ground, wholly or in part.
    virtual bool hops(std::size_t) const { return false; }
    /// Length of the motion in ticks, if it ends; afterwards the hand rests at its last goals.
    virtual std::optional<std::int64_t> ticks() const { return std::nullopt; }
    /// The file that its motion was read from, if any.
    virtual std::optional<std::string> file() const { return std::nullopt; }
    /// Remarks on the goals so far, for people.
    virtual std::vector<std::string> remarks() const { return {}; }
};

/// Descriptions for make_hand, without keys: "wander", ..., "csv:FILE", "rec:FILE". make_hand does not
/// take rec:FILE; a run opens it itself.
std::vector<std::string> hand_words();

/// Makes a hand from its description: "wander|stroke|press|poke[:key=value,...]" or
/// "csv:FILE[:key=value,...]" (docs/touch.md lists every key). An unknown name, key or an impossible value is
/// refused with the legal ones; a file that cannot be used is refused with its line and column; interrupted if
/// work is to stop. `probe` shows frame 0; `fingers` is 1 to 256.
Result<std::unique_ptr<Hand>> make_hand(const std::string& description, int fingers,
                                        const Workspace& workspace, const SurfaceProbe& probe);

/// Counts recorded goals that do not fit the surface, because they leave the picture or lie far below the
/// surface. On request, raises goals that lie deeper than `deepest`.
class GoalWatch {
public:
    /// Far below the surface is more than this, device metres: no hand gets there against a usual stiffness.
    static constexpr double far_below = 0.01;

    /// `deepest`: limit to which goals are raised, device metres below the surface; nothing: they stay.
    GoalWatch(double metres_per_scene_unit, std::optional<double> deepest)
        : metres_per_scene_unit_(metres_per_scene_unit), deepest_(deepest) {}

    /// Counts the goals of a tick, and raises too deep ones along their pixels' rays. World, scene units.
    void look(const SurfaceProbe& probe, std::span<glm::dvec3> goals);
    /// Remarks such as "12.3 % of the goals ..."; none on what concerns less than 1 % of them.
    std::vector<std::string> remarks() const;

private:
    double metres_per_scene_unit_;
    std::optional<double> deepest_;
    std::int64_t goals_ = 0, outside_ = 0, far_below_ = 0;
};

/// Mapping of device positions to the scene.
struct HandMapping {
    Workspace workspace{};
    glm::dmat3 turn{1.0};    ///< a rotation: from the device's axes to x right, y up, z towards the person
    glm::dvec3 offset{0.0};  ///< metres, in those axes: added after `turn`
};

/// Layer between a device that a person holds and the fingers: maps positions of the device to the scene, and
/// decides whether forces reach the hand.
///
/// - Forces are off until `ask_force` or the first button. From then on each finger's force rises over
///   `rise_ticks` once the finger has been free. Turning forces off is immediate.
/// - Forces go off again after a second without any finger's position, as another person may take the device
///   then. (Not after `insist_on_force`.)
/// - A gap of more than 50 ms closes a finger's gate, as if forces had just been requested: a gap without
///   ticks (`come_back`) for all fingers, a gap without a position (`away_ticks`) for that finger.
/// - The clutch holds the fingers still in the scene while the device is repositioned: no force, and closed
///   gates afterwards. Its release moves a finger that is inside the surface out of it, towards the camera,
///   and the others with it: so it is free, and its next contact is felt.
/// - Recentring maps the hand's present position to the workspace's centre, and closes all gates.
///
/// The first button requests forces; while they are on, it is the clutch. The second one stops them. A button
/// that is already pressed at the device's first position does nothing.
class HandControl {
public:
    static constexpr int most_fingers = 80;  // eight devices of ten
    static constexpr int rise_ticks = 300;
    static constexpr int longest_away_ticks = 1000;
    /// Ticks without a position after which a finger has to be free once more. A device repeats its last
    /// position for 20 ms (HapticDevice::oldest_s), so this is 50 ms after it, as for a gap without ticks.
    static constexpr int away_ticks = 30;
    static constexpr double out_of_it = 0.001;  ///< m; a finger comes out to this distance before the surface

    /// How a device was held, in ticks.
    struct Figures {
        std::int64_t ticks = 0;
        std::int64_t placeless = 0;  ///< without any finger's position
        std::int64_t exerting = 0;   ///< forces were requested, and not kept back by the clutch
    };

    HandControl(int fingers, const HandMapping& mapping)
        : mapping_(mapping), count_(static_cast<std::size_t>(fingers)), offset_(mapping.offset) {
        assert(fingers >= 1 && fingers <= most_fingers);
    }

    // Haptic thread, every tick: neither waits nor allocates.
    /// To be called after the haptic thread did not run for `alone_ms`: every finger has to be free once more
    /// before it feels a force.
    void come_back(std::int64_t alone_ms) {
        close_gates();
        pressed_ = ~0U;  // buttons pressed meanwhile do nothing
        absent_ticks_ = std::max(absent_ticks_, alone_ms);
        give_up_forces();
    }
    /// In: device metres, NaN without a position. Out: goals, scene units. `surface`: this tick's, out of
    /// which the fingers come when the clutch is released; nullptr: none.
    void to_goals(std::span<glm::dvec3> places, std::uint32_t buttons, const SurfaceProbe* surface = nullptr);
    /// Forces that reach the device, in its axes, from guarded ones. `ticks`: passed since the last call.
    void to_device(std::span<const glm::dvec3> guarded, int ticks, std::span<glm::dvec3> newtons);
    /// Whether any finger may feel a force in this tick.
    bool exerts() const { return passes_; }
    const Figures& figures() const { return figures_; }  ///< any thread, after the last tick

    // Any thread.
    /// Forces stay requested, even after a second without any finger's position.
    void insist_on_force() { insists_.store(true, std::memory_order_relaxed); }
    void ask_force(bool on) { asked_.store(on, std::memory_order_relaxed); }
    /// Whether forces may be requested, by a call or a button; at first they may.
    void allow_force(bool on) {
        allowed_.store(on, std::memory_order_relaxed);
        if (!on) ask_force(false);
    }
    bool force_is_asked() const { return asked_.load(std::memory_order_relaxed); }
    void hold(bool on) { held_.store(on, std::memory_order_relaxed); }  ///< the clutch, by a key
    void recentre() { recentrings_.fetch_add(1, std::memory_order_relaxed); }
    /// Resets for another person: forces off, the key's clutch off, and the mapping's own offset.
    void begin_anew() {
        ask_force(false);
        hold(false);
        beginnings_.fetch_add(1, std::memory_order_relaxed);
    }
    /// How often the first button (0) or the second one (1) was pressed since the last call.
    int take_presses(std::size_t button) { return presses_[button].exchange(0, std::memory_order_relaxed); }
    /// Clutched by a key or a button: the hand moves, and the fingers do not.
    bool is_repositioned() const { return clutched_.load(std::memory_order_relaxed); }
    /// Share of a finger's guarded force that reached the hand in the newest tick: 0 to 1.
    double share(std::size_t finger) const { return shares_[finger].load(std::memory_order_relaxed); }
    /// Forces are requested, and a finger that has not been free since then feels none.
    bool waits_to_be_free() const { return waits_.load(std::memory_order_relaxed); }

    /// To be called before use: sets where the clip's first frame puts the device.
    void set_mapping(const HandMapping& mapping) {
        mapping_ = mapping;
        offset_ = mapping.offset;
    }
    const HandMapping& mapping() const { return mapping_; }
    /// To be called before use: continues another control, which no thread ticks any more, for the same hand
    /// over the same scene. Its pending requests apply to this one, and the fingers stay where they were
    /// under the new mapping. (`insist_on_force` is not carried over: only a run that keeps one control to
    /// its end begins with it.)
    void go_on_from(const HandControl& before);

private:
    struct Finger {
        glm::dvec3 place{0.0};                // the person's axes, metres, before the offset
        glm::dvec3 goal{0.0};                 // while it is gripped
        std::optional<glm::dvec3> gripped{};  // its position when the clutch began
        int risen = 0;                        // of rise_ticks: share of its force that reaches the hand
        int placeless = 0;                    // ticks since its position was known
        bool free = false;                    // has been free since forces were requested
        bool known = false;
        void close_gate() {
            risen = 0;
            free = false;
        }
    };
    std::optional<glm::dvec3> centre() const;
    glm::dvec3 moved() const;
    void grip();
    void let_go(const SurfaceProbe* surface) {
        offset_ -= moved();
        gripped_ = false;
        for (Finger& finger : fingers_) finger.gripped.reset();
        close_gates();
        if (surface) come_out(*surface);
    }
    void come_out(const SurfaceProbe& surface);
    glm::dvec3 offset_in_effect() const { return gripped_ ? offset_ - moved() : offset_; }
    void take_buttons(std::uint32_t buttons, bool known);
    void close_gates() {
        for (Finger& finger : fingers_) finger.close_gate();
    }
    /// Turns forces off after the hand has been away for too long.
    void give_up_forces() {
        if (absent_ticks_ > longest_away_ticks && !insists_.load(std::memory_order_relaxed)) ask_force(false);
    }

    HandMapping mapping_;
    const std::size_t count_;
    std::atomic<bool> asked_{false}, held_{false}, clutched_{false}, waits_{false}, allowed_{true};
    std::array<std::atomic<int>, 2> presses_{};
    std::atomic<std::uint32_t> recentrings_{0}, beginnings_{0};
    std::atomic<bool> insists_{false};
    std::array<std::atomic<double>, most_fingers> shares_{};
    // Haptic thread only.
    std::array<Finger, most_fingers> fingers_{};
    glm::dvec3 offset_{0.0};  // added to positions, the person's axes
    bool gripped_ = false;    // by the clutch
    std::uint32_t recentred_ = 0, begun_ = 0;
    std::uint32_t pressed_ = ~0U;  // at the previous tick
    bool clutch_button_ = false;
    bool passes_ = false;
    std::int64_t absent_ticks_ = 0;  // consecutive ticks without any finger's position
    Figures figures_;
};

}  // namespace touchable
