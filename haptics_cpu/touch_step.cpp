// SPDX-License-Identifier: Apache-2.0
#include "haptics_cpu/touch_step.hpp"

#include <bit>
#include <chrono>

namespace touchable {

namespace {

// A proxy is on the surface by construction; this allows for roundings of the check in the world.
constexpr double behind_tolerance = 1e-9;

bool fits(const SurfaceFrame* frame, const Scene& scene) {
    return frame && has_size(*frame, scene.width, scene.height);
}

}  // namespace

Workspace default_workspace(int width, double fx, double median_depth) {
    constexpr double picture_width = 0.16;  // of device space, metres
    const double scene_width = width / fx * median_depth;
    return {picture_width / scene_width, {0, 0, -median_depth}};
}

Workspace default_workspace(const Scene& scene, double median_depth) {
    Workspace workspace = default_workspace(scene.width, scene.camera.fx, median_depth);
    workspace.metres_per_scene_unit = scene.device_metres_per_unit.value_or(workspace.metres_per_scene_unit);
    return workspace;
}

TouchStep::TouchStep(const TouchSolver& solver, const GuardSettings& guard, int fingers)
    : solver_(solver), waits_to_be_free_(guard.waits_to_be_free), stale_(guard) {
    const auto count = static_cast<std::size_t>(fingers);
    goals_.resize(count);
    hops_.resize(count);
    fingers_.resize(count);
    contacts_.resize(count);
    guards_.assign(count, FingerGuard(guard, solver.settings().metres_per_scene_unit));
    forces_.resize(count);
}

/// As at the start, but with the last goal, which is used while there is none.
void TouchStep::meet_anew(std::size_t finger) {
    const glm::dvec3 goal = fingers_[finger].goal;
    fingers_[finger] = {};
    fingers_[finger].goal = goal;
    guards_[finger].surface_is_new();
}

void TouchStep::meet_new_surface() {
    for (std::size_t k = 0; k < fingers_.size(); ++k) meet_anew(k);
}

void TouchStep::come_back() {
    came_back_ = true;
    let_go();
}

/// Hands have no force any more. Fingers inside a surface when they come back wait to be free, or feel it
/// ramp in.
void TouchStep::let_go() {
    for (std::size_t k = 0; k < fingers_.size(); ++k) {
        guards_[k].let_go();
        if (waits_to_be_free_) meet_anew(k);
    }
}

/// Ticks since the previous one; 1 if the count begins anew.
int TouchStep::ticks_until(std::int64_t tick) {
    const std::int64_t last = std::exchange(last_tick_, tick).value_or(tick - 1);
    return last < tick ? static_cast<int>(std::min<std::int64_t>(tick - last, longest_ticks)) : 1;
}

void TouchStep::solve(const HeightField& field, int ticks) {
    solver_.tick(field, goals_, fingers_, contacts_, ticks);
    for (std::size_t k = 0; k < guards_.size(); ++k) {
        forces_[k] = guards_[k].guard(contacts_[k], stale_.share());
        // A hand that comes back may be anywhere.
        if (waits_to_be_free_ && contacts_[k].goal_held && guards_[k].has_let_go()) meet_anew(k);
    }
}

/// For a tick without a surface: contacts that the guards take for a fault.
void TouchStep::meet_nothing() {
    for (std::size_t k = 0; k < guards_.size(); ++k) {
        contacts_[k] = {};
        contacts_[k].goal = contacts_[k].proxy = fingers_[k].goal;
        contacts_[k].goal_held = true;
        forces_[k] = guards_[k].guard(contacts_[k]);
    }
}

void TouchStep::each_state(StateBytes& bytes) {
    bytes(came_back_, last_tick_, stale_);
    bytes.expect(!last_tick_ || std::abs(*last_tick_) <= std::int64_t{1} << 60);
    for (FingerState& finger : fingers_) {
        Proxy& at = finger.proxy;
        bytes(at.feature, at.i, at.j, at.a, at.b, at.point, at.sliding, finger.started, finger.goal,
              finger.slip_speed, finger.ticks_held, finger.moment_ns, finger.epoch, finger.stiffness,
              finger.near_hole, finger.place);
        constexpr std::int64_t widest = 1 << 20;  // pixels
        bytes.expect(at.feature <= Feature::vertex && std::max(std::abs(at.i), std::abs(at.j)) <= widest);
        bytes.expect(std::min(at.a, at.b) >= 0 && std::max(at.a, at.b) <= 1 && finger.ticks_held >= 0);
    }
    for (FingerGuard& guard : guards_) bytes(guard);
}

TouchTick TouchStep::run(std::int64_t tick, std::int64_t time_ns, const Scene& scene, const FramePair& pair) {
    using std::chrono::steady_clock;
    const auto start = steady_clock::now();
    const int ticks = ticks_until(tick);
    if (ticks > longest_gap_ticks) come_back();
    TouchTick done;
    if (fits(pair.prev.frame, scene) && fits(pair.next.frame, scene)) {
        const HeightField field(scene, pair);
        if (stale_.look(time_ns - std::max(pair.prev.time_ns, pair.next.time_ns), ticks)) let_go();
        solve(field, ticks);
        done.solve_us = std::chrono::duration<double, std::micro>(steady_clock::now() - start).count();
        done.blend = field.blend();
        // A hand that has let go is nowhere, even if the surface has passed it since.
        for (std::size_t k = 0; k < contacts_.size(); ++k)
            done.behind |= !(contacts_[k].goal_held && guards_[k].has_let_go()) &&
                           is_behind_surface(field, contacts_[k].proxy, behind_tolerance);
    } else {
        meet_nothing();
    }
    for (std::size_t k = 0; k < hops_.size(); ++k) contacts_[k].hops = hops_[k] != 0;
    if (std::exchange(came_back_, false))
        for (GuardedForce& force : forces_) force.reasons |= guard_gap;
    done.tick = tick;
    done.time_ns = time_ns;
    done.pair = pair;
    done.goals = goals_;
    done.contacts = contacts_;
    done.forces = forces_;
    done.metres_per_scene_unit = solver_.settings().metres_per_scene_unit;
    return done;
}

void ForceHash::add(const glm::dvec3& force) {
    std::array<std::uint8_t, 24> bytes;
    std::size_t at = 0;
    for (const double component : {force.x, force.y, force.z}) {
        const auto bits = std::bit_cast<std::uint64_t>(component == 0 ? 0.0 : component);
        for (int shift = 0; shift < 64; shift += 8) bytes[at++] = static_cast<std::uint8_t>(bits >> shift);
    }
    hash_.add(bytes.data(), bytes.size());
}

}  // namespace touchable
