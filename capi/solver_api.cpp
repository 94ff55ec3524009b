// touch_solver_*: goals of fingers in, forces out.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>

#include "capi/objects.hpp"
#include "capi/status.hpp"

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

Result<TouchSolver> solver_of(const SurfaceObject& surface, const touch_solver_settings& wanted) {
    if (auto valid = validate(guard_of(wanted)); !valid) return usage_error(valid.error().message);
    TouchSettings settings;
    settings.stribeck_speed = wanted.stribeck_m_per_s;
    settings.metres_per_scene_unit = wanted.metres_per_scene_unit;
    if (wanted.metres_per_scene_unit == 0)
        settings.metres_per_scene_unit = surface.hand_scale.load(std::memory_order_acquire);
    if (settings.metres_per_scene_unit == 0)
        return usage_error(
            "metres_per_scene_unit is 0 and no frame was pushed yet; push the first one, or state it");
    auto made = TouchSolver::create(surface.scene, settings);
    if (!made) return usage_error(made.error().message);
    return made;
}

touch_status fail_has_solver(touch_error* error) {
    return fail(error, TOUCH_BUSY, "the surface has a solver already; destroy that first");
}

/// Takes the surface for its own, and gives it back where nothing comes of it.
touch_status create(HandleTable<SurfaceObject>::Use surface, const touch_solver_settings& wanted,
                    touch_solver& solver, touch_error* error) {
    const GuardSettings guard = guard_of(wanted);
    auto made = solver_of(*surface, wanted);
    if (!made) return fail(error, made.error());
    if (surface->has_solver.exchange(true, std::memory_order_acq_rel)) return fail_has_solver(error);
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

/// Writes as much of it as the program's struct has room for.
void write_contact(touch_contact contact, unsigned char* to, std::size_t stride) {
    contact.struct_size = static_cast<std::uint32_t>(std::min(stride, sizeof(touch_contact)));
    std::memcpy(to, &contact, contact.struct_size);
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
    for (std::size_t k = 0; k < to.size(); ++k) {
        write_contact(contact_of(done.contacts[k], done.forces[k]), contacts + k * stride, stride);
        solver.hash.add(done.forces[k].force);
    }
    solver.last_tick = tick;
}

bool is_stride(std::size_t stride) {
    constexpr std::size_t widest = std::size_t{1} << 20;
    return stride >= first_size<touch_contact> && stride <= widest;
}

/// The scene with friction nowhere.
Scene without_friction(Scene scene) {
    scene.default_properties.static_friction = scene.default_properties.dynamic_friction = 0;
    scene.haptic.static_friction = scene.haptic.dynamic_friction = {};
    return scene;
}

constexpr std::size_t resting_at_a_time = 8;  // few: all of them tick until the last one rests
constexpr std::int64_t most_ticks_to_rest = 500;

/// Of a force from one tick to the next.
bool is_steady(const GuardedForce& now, const glm::dvec3& before) {
    constexpr double still = 1e-9;  // newtons, and share of the force
    constexpr std::uint32_t coming = guard_ramp | guard_rise | guard_jump;
    const glm::dvec3 &force = now.force, step = force - before;
    const double length = std::sqrt(force.x * force.x + force.y * force.y + force.z * force.z);
    return (now.reasons & coming) == 0 &&
           std::sqrt(step.x * step.x + step.y * step.y + step.z * step.z) <= still * (1 + length);
}

/// Fingers at rest, `resting_at_a_time` or fewer: each begins where its ray meets the surface, and ticks
/// until its force is steady. It is written then, so that it does not depend on the other fingers.
void rest(TouchStep& step, const Scene& scene, const FramePair& pair, const touch_vec3* points,
          unsigned char* contacts, std::size_t stride) {
    const std::size_t count = step.goals().size();
    for (std::size_t k = 0; k < count; ++k) step.goals()[k] = {points[k].x, points[k].y, points[k].z};
    std::array<glm::dvec3, resting_at_a_time> before;
    std::array<bool, resting_at_a_time> rests{};
    std::size_t moving = count;
    for (std::int64_t tick = 0; tick < most_ticks_to_rest && moving > 0; ++tick) {
        const TouchTick done = step.run(tick, pair.next.time_ns, scene, pair);
        for (std::size_t k = 0; k < count; ++k) {
            if (rests[k]) continue;
            const Contact& met = done.contacts[k];
            const GuardedForce& force = done.forces[k];
            rests[k] = met.goal_held || (tick > 0 && !met.counts.capped && is_steady(force, before[k]));
            before[k] = force.force;
            if (!rests[k] && tick + 1 < most_ticks_to_rest) continue;
            touch_contact contact = contact_of(met, force);
            if (!rests[k]) contact.guard |= TOUCH_GUARD_UNSTEADY;
            write_contact(contact, contacts + k * stride, stride);
            moving -= rests[k];
        }
    }
}

/// The surface's only reader, for as long as it lives.
class Reading {
public:
    explicit Reading(SurfaceObject& surface)
        : surface_(surface), is_only_(!surface.has_solver.exchange(true, std::memory_order_acq_rel)) {}
    Reading(const Reading&) = delete;
    Reading& operator=(const Reading&) = delete;
    ~Reading() {
        if (is_only_) surface_.has_solver.store(false, std::memory_order_release);
    }
    explicit operator bool() const { return is_only_; }

private:
    SurfaceObject& surface_;
    const bool is_only_;
};

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
    constexpr std::size_t most_ticks = std::size_t{1} << 40;
    if (!has_known_size(first) || !goals || !contacts || count > most_ticks ||
        !is_stride(contact_stride_bytes))
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

touch_status touch_surface_forces_at(touch_surface surface, const touch_solver_settings* settings,
                                     const touch_tick* moment, int32_t friction, const touch_vec3* points,
                                     size_t count, touch_contact* contacts, size_t contact_stride_bytes,
                                     touch_error* error) {
    return without_exceptions(error, [&]() -> touch_status {
        constexpr std::size_t most_points = std::size_t{1} << 40;
        if (!has_known_size(moment) || (settings && !has_known_size(settings)) || count > most_points ||
            (count > 0 && (!points || !contacts)) || !is_stride(contact_stride_bytes))
            return fail(
                error, TOUCH_USAGE,
                "moment, points or contacts is NULL, or a struct_size or contact_stride_bytes is not that "
                "of the struct");
        if (friction != TOUCH_FRICTION_OFF && friction != TOUCH_FRICTION_ON)
            return fail(error, TOUCH_USAGE,
                        "friction is " + std::to_string(friction) +
                            "; right would be TOUCH_FRICTION_OFF or TOUCH_FRICTION_ON");
        const touch_tick at = over_defaults(*moment, touch_tick{});
        if (!is_sound(at))
            return fail(error, TOUCH_USAGE, "the moment is out of range; right would be -2^60 to 2^60");
        touch_solver_settings wanted;
        touch_solver_settings_defaults(&wanted, sizeof wanted);
        if (settings) wanted = over_defaults(*settings, wanted);
        wanted.ramp_in_ticks = wanted.waits_to_be_free = 0;
        wanted.stale_after_ns = 0;
        const auto use = surfaces().find(surface.id);
        if (!use) return fail_without(use, error, "surface");
        const auto solver = solver_of(*use, wanted);
        if (!solver) return fail(error, solver.error());
        const Reading reading(*use);
        if (!reading) return fail_has_solver(error);
        FramePair pair;
        if (!use->timeline.pair_at(MediaMoment{at.epoch, at.time_ns, at.epoch_start_ns}, pair))
            return fail(error, TOUCH_USAGE, "no frame was pushed yet; push the first one before");
        const Scene scene = friction == TOUCH_FRICTION_ON ? use->scene : without_friction(use->scene);
        auto* out = reinterpret_cast<unsigned char*>(contacts);
        for (std::size_t k = 0; k < count; k += resting_at_a_time) {
            const std::size_t some = std::min(resting_at_a_time, count - k);
            TouchStep step(*solver, guard_of(wanted), static_cast<int>(some));
            rest(step, scene, pair, points + k, out + k * contact_stride_bytes, contact_stride_bytes);
        }
        return TOUCH_OK;
    });
}
