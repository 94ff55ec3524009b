// touch_solver_*: goals of fingers in, forces out.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "capi/status.hpp"
#include "capi/touch/objects.hpp"

using namespace touchable;
using namespace touchable::capi;

namespace touchable::capi {

HandleTable<SolverObject>& solvers() {
    static auto& table = *new HandleTable<SolverObject>(3, Forked::refused);
    return table;
}

namespace {

constexpr int most_fingers = 256;
constexpr std::int64_t tick_ns = 1'000'000;

static_assert(TOUCH_GUARD_STIFFNESS == guard_stiffness && TOUCH_GUARD_FORCE == guard_force &&
              TOUCH_GUARD_RAMP == guard_ramp && TOUCH_GUARD_FAULT == guard_fault &&
              TOUCH_GUARD_RISE == guard_rise && TOUCH_GUARD_DAMPING == guard_damping &&
              TOUCH_GUARD_PASSIVITY == guard_passivity && TOUCH_GUARD_JUMP == guard_jump &&
              TOUCH_GUARD_WAITING == guard_waiting && TOUCH_GUARD_GAP == guard_gap &&
              TOUCH_GUARD_STALE == guard_stale);

GuardSettings guard_of(const touch_solver_settings& settings) {
    GuardSettings guard;
    guard.max_force = settings.max_force_n;
    guard.max_stiffness = settings.max_stiffness_n_per_m;
    guard.ramp_in_ticks = settings.ramp_in_ticks;
    guard.ramp_out_ticks = settings.ramp_out_ticks;
    guard.damping = settings.damping_n_s_per_m;
    guard.passivity = settings.passivity_n_s_per_m;
    guard.waits_to_be_free = settings.waits_to_be_free != 0;
    guard.stale_after_ns = settings.stale_after_ns;
    return guard;
}

/// Takes the surface for its own, and gives it back where nothing comes of it.
touch_status create(HandleTable<SurfaceObject>::Use surface, const touch_solver_settings& wanted,
                    touch_solver& solver, touch_error* error) {
    const GuardSettings guard = guard_of(wanted);
    if (auto valid = validate(guard); !valid) return fail(error, TOUCH_USAGE, valid.error().message);
    TouchSettings settings;
    settings.stribeck_speed = wanted.stribeck_m_per_s;
    settings.metres_per_scene_unit = wanted.metres_per_scene_unit;
    if (wanted.metres_per_scene_unit == 0)
        settings.metres_per_scene_unit = surface->hand_scale.load(std::memory_order_acquire);
    if (settings.metres_per_scene_unit == 0)
        return fail(
            error, TOUCH_USAGE,
            "metres_per_scene_unit is 0 and no frame was pushed yet; push the first one, or state it");
    auto made = TouchSolver::create(surface->scene, settings);
    if (!made) return fail(error, TOUCH_USAGE, made.error().message);
    if (surface->has_solver.exchange(true, std::memory_order_acq_rel))
        return fail(error, TOUCH_BUSY, "the surface has a solver already; destroy that first");
    std::shared_ptr<SolverObject> object;
    SurfaceObject& taken = *surface;
    try {
        object = std::make_shared<SolverObject>(std::move(surface), *made, guard, wanted.fingers);
    } catch (...) {
        taken.has_solver.store(false, std::memory_order_release);
        throw;
    }
    return give_handle(solvers(), std::move(object), solver, error);
}

touch_vec3 vec3_of(const glm::dvec3& from) {
    return {from.x, from.y, from.z};
}

touch_contact contact_of(const Contact& contact, const GuardedForce& guarded) {
    touch_contact out{};
    out.guard = guarded.reasons;
    out.force_n = vec3_of(guarded.force);
    out.goal = vec3_of(contact.goal);
    out.proxy = vec3_of(contact.proxy);
    out.pixel_x = contact.pixel_x;
    out.pixel_y = contact.pixel_y;
    if (contact.touching) {
        out.stiffness_n_per_m = contact.properties.stiffness;
        out.static_friction = contact.properties.static_friction;
        out.dynamic_friction = contact.properties.dynamic_friction;
    }
    out.touching = contact.touching;
    out.in_hole = contact.in_hole;
    return out;
}

bool is_sound(const touch_tick& tick) {
    return is_countable(tick.tick) && is_countable(tick.time_ns) && is_countable(tick.epoch_start_ns);
}

/// Of a solver that nobody else uses.
void run_tick(SolverObject& solver, std::int64_t tick, const MediaMoment& moment, const touch_vec3* goals,
              unsigned char* contacts, std::size_t stride) {
    const std::span<glm::dvec3> to = solver.step.goals();
    for (std::size_t k = 0; k < to.size(); ++k) to[k] = {goals[k].x, goals[k].y, goals[k].z};
    solver.surface->timeline.pair_at(moment, solver.pair);
    const TouchTick done = solver.step.run(tick, moment.time_ns, solver.surface->scene, solver.pair);
    const auto size = static_cast<std::uint32_t>(std::min(stride, sizeof(touch_contact)));
    for (std::size_t k = 0; k < to.size(); ++k) {
        touch_contact contact = contact_of(done.contacts[k], done.forces[k]);
        contact.struct_size = size;
        std::memcpy(contacts + k * stride, &contact, size);
        solver.hash.add(done.forces[k].force);
    }
    solver.last_tick = tick;
}

}  // namespace
}  // namespace touchable::capi

touch_status touch_solver_settings_defaults(touch_solver_settings* settings, uint32_t struct_size) {
    const GuardSettings guard;
    touch_solver_settings defaults{};
    defaults.fingers = 1;
    defaults.max_force_n = guard.max_force;
    defaults.max_stiffness_n_per_m = guard.max_stiffness;
    defaults.ramp_in_ticks = guard.ramp_in_ticks;
    defaults.ramp_out_ticks = guard.ramp_out_ticks;
    return give_defaults(defaults, settings, struct_size);
}

touch_status touch_solver_create(touch_surface surface, const touch_solver_settings* settings,
                                 touch_solver* solver, touch_error* error) {
    return without_exceptions(error, [&]() -> touch_status {
        if (!solver || (settings && !has_known_size(settings)))
            return fail(error, TOUCH_USAGE,
                        "solver is NULL, or struct_size is not sizeof(touch_solver_settings)");
        touch_solver_settings wanted;
        touch_solver_settings_defaults(&wanted, sizeof wanted);
        if (settings) wanted = over_defaults(*settings, wanted);
        if (wanted.fingers < 1 || wanted.fingers > most_fingers)
            return fail(error, TOUCH_USAGE, "fingers is out of range; right would be 1 to 256");
        auto use = surfaces().find(surface.id);
        if (!use) return fail_without(use, error, "surface");
        return create(std::move(use), wanted, *solver, error);
    });
}

touch_status touch_solver_tick(touch_solver solver, const touch_tick* tick, const touch_vec3* goals,
                               touch_contact* contacts, size_t contact_stride_bytes) {
    return touch_solver_run(solver, tick, 1, goals, contacts, contact_stride_bytes);
}

touch_status touch_solver_run(touch_solver solver, const touch_tick* first, size_t count,
                              const touch_vec3* goals, touch_contact* contacts, size_t contact_stride_bytes) {
    constexpr std::size_t most_ticks = std::size_t{1} << 40, widest = 1 << 20;
    if (!has_known_size(first) || !goals || !contacts || count > most_ticks ||
        contact_stride_bytes < first_size<touch_contact> || contact_stride_bytes > widest)
        return TOUCH_USAGE;
    const touch_tick begin = over_defaults(*first, touch_tick{});
    if (!is_sound(begin)) return TOUCH_USAGE;
    const auto use = solvers().find(solver.id);
    if (!use) return status_without(use);
    const TryLock lock(use->ticking);
    if (!lock) return TOUCH_BUSY;
    if (use->last_tick && begin.tick <= *use->last_tick) return TOUCH_USAGE;
    const auto fingers = static_cast<std::size_t>(use->step.fingers());
    auto* out = reinterpret_cast<unsigned char*>(contacts);
    for (std::size_t k = 0; k < count; ++k) {
        const auto later = static_cast<std::int64_t>(k);
        const MediaMoment moment{begin.epoch, begin.time_ns + later * tick_ns, begin.epoch_start_ns};
        run_tick(*use, begin.tick + later, moment, goals + k * fingers, out, contact_stride_bytes);
        out += fingers * contact_stride_bytes;
    }
    return TOUCH_OK;
}

touch_status touch_solver_come_back(touch_solver solver) {
    const auto use = solvers().find(solver.id);
    if (!use) return status_without(use);
    const TryLock lock(use->ticking);
    if (!lock) return TOUCH_BUSY;
    use->step.come_back();
    return TOUCH_OK;
}

touch_status touch_solver_force_hash(touch_solver solver, uint64_t* hash) {
    if (!hash) return TOUCH_USAGE;
    const auto use = solvers().find(solver.id);
    if (!use) return status_without(use);
    const TryLock lock(use->ticking);
    if (!lock) return TOUCH_BUSY;
    *hash = use->hash.value();
    return TOUCH_OK;
}

touch_status touch_solver_destroy(touch_solver solver) {
    return end(solvers(), solver);
}
