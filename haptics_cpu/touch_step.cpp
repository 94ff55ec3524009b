#include "haptics_cpu/touch_step.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "haptics_cpu/tick_velocity.hpp"

namespace touchable {

namespace {

// A proxy is on the surface by construction; this is room for the roundings of checking it in the world.
constexpr double behind_tolerance = 1e-9;

}  // namespace

TouchStep::TouchStep(const TouchSolver& solver, const GuardSettings& guard, int fingers) : solver_(solver) {
    const auto count = static_cast<std::size_t>(fingers);
    goals_.resize(count);
    fingers_.resize(count);
    contacts_.resize(count);
    jumps_.assign(count, JumpCancellation(guard));
    guards_.assign(count, ForceGuard(guard, solver.settings().metres_per_scene_unit));
    forces_.resize(count);
}

GuardedForce TouchStep::force_on(std::size_t finger) {
    const CalmedForce calmed = jumps_[finger].calm(contacts_[finger]);
    if (!calmed.active) return guards_[finger].guard(contacts_[finger]);
    return guards_[finger].guard_calmed(contacts_[finger], calmed.force);
}

/// Since the tick before; a count that begins anew has no tick before.
int TouchStep::ticks_until(std::int64_t tick) {
    const std::int64_t last = std::exchange(last_tick_, tick).value_or(tick - 1);
    return last < tick ? static_cast<int>(std::min<std::int64_t>(tick - last, longest_ticks)) : 1;
}

TouchTick TouchStep::run(std::int64_t tick, std::int64_t time_ns, const Scene& scene, const FramePair& pair) {
    const auto start = std::chrono::steady_clock::now();
    const HeightField field(scene, pair);
    solver_.tick(field, goals_, fingers_, contacts_, ticks_until(tick));
    for (std::size_t k = 0; k < guards_.size(); ++k) forces_[k] = force_on(k);
    const auto end = std::chrono::steady_clock::now();

    TouchTick done;
    done.tick = tick;
    done.time_ns = time_ns;
    done.pair = pair;
    done.blend = field.blend();
    done.goals = goals_;
    done.contacts = contacts_;
    done.forces = forces_;
    done.metres_per_scene_unit = solver_.settings().metres_per_scene_unit;
    done.solve_us = std::chrono::duration<double, std::micro>(end - start).count();
    for (const Contact& contact : contacts_)
        done.behind |= is_behind_surface(field, contact.proxy, behind_tolerance);
    return done;
}

}  // namespace touchable
