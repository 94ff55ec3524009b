// SPDX-License-Identifier: Apache-2.0
// libtouchable: scenes (camera and coding), surfaces (frames in, a surface in time) and solvers (goals of
// fingers in, forces out).
#include "capi/api_common.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <limits>
#include <memory>
#include <mutex>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "capi/touchable.h"
#include "engine/base/try.hpp"
#include "engine/run/touch_run.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/depth_estimator.hpp"
#include "engine/surface/surface_builder.hpp"

using namespace touchable;
using namespace touchable::capi;

namespace {

/// The object of a touch_scene. The scene is immutable.
struct SceneObject {
    explicit SceneObject(SceneDescription settled) : described(std::move(settled)) {}
    const Scene& scene() const { return described.scene; }

    const SceneDescription described;  ///< settled; `unstated`: filters that the text does not state
    mutable std::once_flag has_metres;
    mutable std::vector<float> metres;  ///< per code, NaN if invalid (metres_of_codes)
};

constexpr auto scenes = handles<SceneObject, 1, Forked::usable>;

/// The object of a touch_surface. One thread pushes, one solver meets what was pushed.
struct SurfaceObject {
    SurfaceObject(const Scene& of_scene, const touch_surface_settings& of_program)
        : of_integers(of_scene),
          of_floats(scene_of_depth(of_scene, TOUCH_F32)),
          settings(of_program),
          queue(of_integers, nullptr, 0, SurfaceTimeline::Eye::none, std::max(settings.frames, 4)),
          has_solver(settings.frames == 1) {}

    /// Before the first frame: settles the scene by its depth.
    void settle(std::int32_t sample) {
        const Scene& settled = sample == TOUCH_F32 ? of_floats : of_integers;
        scratch.integer_scale = integer_scale_after(of_integers, sample);
        auto builder = make_cpu_builder(settled, CpuPlan{settings.threads});
        if (settings.error_bars == 1) builder = with_error_bars(std::move(builder), settled);
        floats = std::make_unique<FilteredDepth>(settled);
        queue.build_with(settled, std::move(builder));
    }

    struct FramePlace {
        std::int64_t number = 0, time_ns = 0;
    };

    const Scene of_integers, of_floats;
    const touch_surface_settings settings;
    std::atomic_flag pushing = ATOMIC_FLAG_INIT;  ///< guards the members up to the scale
    std::unique_ptr<FilteredDepth> floats;
    bool epoch_has_ended = false;
    std::optional<FramePlace> newest;  ///< of this epoch
    FrameScratch scratch;
    std::atomic<double> hand_scale{0};  ///< 0 until there is a frame
    SurfaceQueue queue;
    std::atomic<bool> has_solver;  ///< or needs none
};

constexpr auto surfaces = handles<SurfaceObject, 2, Forked::refused>;

/// The only reader of a surface; while it exists the surface cannot be destroyed. False: the surface has
/// another reader.
class Reading {
public:
    explicit Reading(HandleTable<SurfaceObject>::Use surface)
        : surface_(std::move(surface)),
          is_only_(!surface_->has_solver.exchange(true, std::memory_order_acq_rel)) {}
    Reading(Reading&& other) noexcept
        : surface_(std::move(other.surface_)), is_only_(std::exchange(other.is_only_, false)) {}
    Reading& operator=(Reading&&) = delete;
    ~Reading() {
        if (is_only_) surface_->has_solver.store(false, std::memory_order_release);
    }
    explicit operator bool() const { return is_only_; }
    SurfaceObject* operator->() const { return &*surface_; }

private:
    HandleTable<SurfaceObject>::Use surface_;
    bool is_only_;
};

/// The object of a touch_solver.
struct SolverObject {
    SolverObject(Reading of_surface, const TouchSolver& solver, const GuardSettings& guard, int fingers)
        : surface(std::move(of_surface)), run(surface->queue, nullptr, solver, guard, fingers) {}

    const Reading surface;
    std::atomic_flag ticking = ATOMIC_FLAG_INIT;  ///< guards the members below
    TouchRun run;
    std::optional<std::int64_t> last_tick;
};

constexpr auto solvers = handles<SolverObject, 3, Forked::refused>;

/// Refuses a member that `validate` would call by another name.
Error camera_error(const char* member, const std::string& right) {
    return usage_error(std::string(member) + " of the camera is out of range; must be " + right);
}

/// Snaps a far plane to a code's depth if equal within rounding, so that the code is included.
double far_plane(double far, double step) {
    const double on_code = std::round(far / step) * step;
    return std::abs(on_code - far) < 1e-9 * far ? on_code : far;
}

Result<Scene> scene_of(const touch_camera& camera) {
    const auto positive = [](double value) { return std::isfinite(value) && value > 0; };
    if (camera.depth_kind != TOUCH_PLANAR && camera.depth_kind != TOUCH_RANGE)
        return camera_error("depth_kind", "TOUCH_PLANAR or TOUCH_RANGE");
    const bool is_open = camera.metres_per_code == 0;
    const double step = is_open ? 0.001 : camera.metres_per_code;
    if (!positive(step)) return camera_error("metres_per_code", "above 0, such as 0.001, or 0 (left open)");
    if (!positive(camera.far_m)) return camera_error("far_m", "above 0, such as 10");
    Scene scene;
    scene.width = camera.width;
    scene.height = camera.height;
    if (!(camera.frames_per_second >= 0.001 && camera.frames_per_second <= 1000))
        return camera_error("frames_per_second", "0.001 to 1000");
    constexpr std::int64_t parts = 1'000'000;
    const std::int64_t rate = std::llround(camera.frames_per_second * static_cast<double>(parts));
    scene.rate = {rate / std::gcd(rate, parts), parts / std::gcd(rate, parts)};
    scene.metres_per_unit = 1;
    scene.camera = {camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px};
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.semantics = camera.depth_kind == TOUCH_RANGE ? DepthSemantics::range : DepthSemantics::planar;
    scene.depth.scale = step;
    scene.depth.code_max = 65535;
    scene.depth.far = far_plane(camera.far_m, step);
    if (is_open) scene.float_scale = camera.far_m / 65534;
    scene.depth_bits = 16;
    scene.default_properties = {camera.stiffness_n_per_m, camera.static_friction, camera.dynamic_friction};
    scene.hole_stiffness = Scene::soft_holes;
    derive_valid_range(scene.depth);
    if (auto valid = validate(scene); !valid) return usage_error(valid.error().message);
    return scene;
}

touch_scene_facts facts_of(const SceneObject& object) {
    const Scene& scene = object.scene();
    touch_scene_facts facts{};
    facts.struct_size = sizeof facts;
    facts.width = scene.width;
    facts.height = scene.height;
    facts.depth_kind = scene.depth.semantics == DepthSemantics::range ? TOUCH_RANGE : TOUCH_PLANAR;
    facts.fx_px = scene.camera.fx;
    facts.fy_px = scene.camera.fy;
    facts.cx_px = scene.camera.cx;
    facts.cy_px = scene.camera.cy;
    facts.metres_per_scene_unit = scene.metres_per_unit;
    facts.near_units = scene.depth.near;
    facts.far_units = scene.depth.far;
    facts.frames_per_second = scene.rate.per_second();
    facts.hand_metres_per_scene_unit = scene.device_metres_per_unit.value_or(0);
    facts.unstated_filters = object.described.unstated.filters.any() ? 1 : 0;
    return facts;
}

/// Whether the stride between frames is valid: size, limit and alignment.
bool holds_frames(std::size_t stride) {
    constexpr std::size_t widest = std::size_t{1} << 20;
    return stride >= first_size<touch_frame> && stride <= widest && stride % alignof(touch_frame) == 0;
}

touch_camera default_camera() {
    constexpr double focal_length = 554.2562584220408;  // 320 / tan 30 degrees
    return {sizeof(touch_camera),
            640,
            480,
            TOUCH_PLANAR,
            focal_length,
            focal_length,
            319.5,
            239.5,
            0,
            10,
            30,
            600,
            0.4,
            0.3};
}

/// Measures the depth of a recording's frames; nothing: no surface in any.
Result<std::optional<MeasuredDepth>> measure(const Scene& scene, const unsigned char* frames,
                                             std::size_t stride, std::size_t count, double integer_scale) {
    DepthEstimator estimator(scene);
    FrameScratch scratch;
    scratch.integer_scale = integer_scale;
    for (std::size_t k = 0; k < count && !estimator.enough(); ++k) {
        const auto* frame = reinterpret_cast<const touch_frame*>(frames + k * stride);
        TRY_ASSIGN(const auto raw, error_at("frame " + std::to_string(k) + " of those given",
                                            raw_frame(*frame, scene, scratch)));
        estimator.add(raw);
    }
    return estimator.measured();
}

const std::vector<float>& metres_of_codes(const SceneObject& object) {
    std::call_once(object.has_metres, [&] {
        object.metres = touchable::metres_of_codes(object.scene().depth, object.scene().metres_per_unit);
    });
    return object.metres;
}

void write_metres(const PlaneView& depth, const DepthCoding& coding, const std::vector<float>& metres,
                  unsigned char* rows, std::int64_t stride) {
    const bool is_wide = coding.kind != DepthCodingKind::hue && depth.bytes_per_sample == 2;
    for (int y = 0; y < depth.height; ++y) {
        unsigned char* to = rows + y * stride;
        const auto* samples = reinterpret_cast<const std::uint16_t*>(depth.row(y));
        for (int x = 0; x < depth.width; ++x, to += sizeof(float))
            std::memcpy(to, &metres[is_wide ? samples[x] : stored_code(depth, coding, x, y)], sizeof(float));
    }
}

/// A program's memory for `count` floats in each row; none if it has none.
Result<FloatRows> rows_for(const std::string& name, float* data, std::int64_t stride, int count) {
    if (!data) return FloatRows{};
    const std::int64_t row = std::int64_t{count} * std::int64_t{sizeof(float)};
    if (std::abs(stride) < row || std::abs(stride) > (std::int64_t{1} << 40) || stride % 4 != 0 ||
        reinterpret_cast<std::uintptr_t>(data) % alignof(float) != 0)
        return usage_error(name + "_stride_bytes is " + std::to_string(stride) + "; must be at least " +
                           std::to_string(row) + " and, like the address, a multiple of 4");
    return FloatRows{data, stride};
}

constexpr touch_surface_settings default_surface_settings{sizeof(touch_surface_settings), 1, 4, 0};

double hand_scale_of(const Scene& scene, const SurfaceFrame& first) {
    std::vector<double> depths = valid_depths(scene, first);
    return default_workspace(scene, quantile(depths, 0.5)).metres_per_scene_unit;
}

Result<touch_status> push(SurfaceObject& surface, const touch_frame& frame, touch_error* error) {
    SurfaceTimeline& timeline = surface.queue.timeline();
    if (!timeline.acquire())
        return fail(error, TOUCH_FULL,
                    "every frame is still needed; push this one again once ticks have gone on");
    const bool is_first = surface.hand_scale.load(std::memory_order_relaxed) == 0;
    if (is_first) surface.settle(frame.depth.sample);
    const Scene& scene = surface.queue.scene();
    TRY_ASSIGN(auto raw, raw_frame(frame, scene, surface.scratch));
    raw.epoch = timeline.epoch();
    if (surface.epoch_has_ended) return usage_error("the epoch has ended; begin another one first");
    if (surface.newest && (raw.number <= surface.newest->number || raw.time_ns <= surface.newest->time_ns))
        return usage_error("the frame's number or time_ns is not later than the one before");
    const MediaMoment moment{raw.epoch, raw.time_ns, raw.time_ns};
    const SurfaceObject::FramePlace place{raw.number, raw.time_ns};
    TRY(surface.queue.give({std::move(raw)}, [&](const SurfaceFrame& built) {
        if (is_first) surface.hand_scale.store(hand_scale_of(scene, built), std::memory_order_release);
    }));
    surface.newest = place;
    // Without a solver this thread is the reader, and gives earlier frames up.
    FramePair pair;
    if (surface.settings.frames == 1) timeline.pair_at(moment, pair);
    return TOUCH_OK;
}

constexpr int most_fingers = 256;

static_assert(TOUCH_GUARD_STIFFNESS == guard_stiffness && TOUCH_GUARD_FORCE == guard_force &&
              TOUCH_GUARD_RAMP == guard_ramp && TOUCH_GUARD_FAULT == guard_fault &&
              TOUCH_GUARD_RISE == guard_rise && TOUCH_GUARD_DAMPING == guard_damping &&
              TOUCH_GUARD_PASSIVITY == guard_passivity && TOUCH_GUARD_JUMP == guard_jump &&
              TOUCH_GUARD_WAITING == guard_waiting && TOUCH_GUARD_GAP == guard_gap &&
              TOUCH_GUARD_STALE == guard_stale);

touch_solver_settings default_solver_settings() {
    const GuardSettings guard;
    touch_solver_settings defaults{};
    defaults.fingers = 1;
    defaults.max_force_n = guard.max_force;
    defaults.max_stiffness_n_per_m = guard.max_stiffness;
    defaults.ramp_in_ticks = guard.ramp_in_ticks;
    defaults.ramp_out_ticks = guard.ramp_out_ticks;
    return defaults;
}

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
    auto made = TouchSolver::create(surface.queue.scene(), settings);
    if (!made) return usage_error(made.error().message);
    return made;
}

touch_status fail_has_reader(const touch_surface_settings& settings, touch_error* error) {
    return settings.frames == 1
               ? fail(error, TOUCH_USAGE, "the surface keeps 1 frame, for its filters alone; make one of 4")
               : fail(error, TOUCH_BUSY, "the surface has a solver already; destroy that first");
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
    out.error_degrees = contact.error_degrees;
    out.error_newtons = contact.error_newtons;
    return out;
}

/// Writes as many bytes as the program's struct has.
void write_contact(touch_contact contact, unsigned char* to, std::size_t stride) {
    contact.struct_size = static_cast<std::uint32_t>(std::min(stride, sizeof(touch_contact)));
    std::memcpy(to, &contact, contact.struct_size);
}

bool is_sound(const touch_tick& tick) {
    return is_countable(tick.tick) && is_countable(tick.time_ns) && is_countable(tick.epoch_start_ns);
}

/// One tick of a solver that no other thread uses.
void run_tick(SolverObject& solver, std::int64_t tick, const MediaMoment& moment, const touch_vec3* goals,
              unsigned char* contacts, std::size_t stride) {
    const std::span<glm::dvec3> to = solver.run.goals();
    for (std::size_t k = 0; k < to.size(); ++k) to[k] = {goals[k].x, goals[k].y, goals[k].z};
    solver.run.meet(tick, moment);
    const TouchTick done = solver.run.solve();
    for (std::size_t k = 0; k < to.size(); ++k)
        write_contact(contact_of(done.contacts[k], done.forces[k]), contacts + k * stride, stride);
    solver.last_tick = tick;
}

bool is_stride(std::size_t stride) {
    constexpr std::size_t widest = std::size_t{1} << 20;
    return stride >= first_size<touch_contact> && stride <= widest;
}

/// The scene with all friction set to 0.
Scene without_friction(Scene scene) {
    scene.default_properties.static_friction = scene.default_properties.dynamic_friction = 0;
    scene.haptic.static_friction = scene.haptic.dynamic_friction = {};
    return scene;
}

/// Calls `use` with what a solver remembers, once it has ticked.
touch_status with_saved(touch_solver solver, auto&& use) {
    return without_exceptions(nullptr, [&]() -> touch_status {
        bool has_ticked = false;
        const touch_status found = with_object(solvers(), solver, &SolverObject::ticking, [&](auto& object) {
            has_ticked = object.last_tick.has_value();
            if (has_ticked) use(object.run.save());
        });
        return found == TOUCH_OK && !has_ticked ? TOUCH_USAGE : found;
    });
}

constexpr std::size_t resting_at_a_time = 8;  // few, because all tick until the last one rests
constexpr std::int64_t most_ticks_to_rest = 500;

/// Whether a force equals that of the previous tick.
bool is_steady(const GuardedForce& now, const glm::dvec3& before) {
    constexpr double still = 1e-9;  // newtons, and share of the force
    constexpr std::uint32_t coming = guard_ramp | guard_rise | guard_jump;
    return (now.reasons & coming) == 0 &&
           glm::distance(now.force, before) <= still * (1 + glm::length(now.force));
}

/// Solves fingers at rest, `resting_at_a_time` or fewer: each begins where its ray meets the surface, and
/// ticks until its force is steady. Its contact is written at that tick, so it does not depend on other
/// fingers.
void rest(TouchRun& run, const FramePair& pair, const touch_vec3* points, unsigned char* contacts,
          std::size_t stride) {
    const std::size_t count = run.goals().size();
    for (std::size_t k = 0; k < count; ++k) run.goals()[k] = {points[k].x, points[k].y, points[k].z};
    std::array<glm::dvec3, resting_at_a_time> before;
    std::array<bool, resting_at_a_time> rests{};
    std::size_t moving = count;
    for (std::int64_t tick = 0; tick < most_ticks_to_rest && moving > 0; ++tick) {
        run.meet(tick, pair.next.time_ns, pair);
        const TouchTick done = run.solve();
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

}  // namespace

uint32_t touch_version(void) {
    return TOUCH_VERSION;
}

const char* touch_status_name(touch_status status) {
    constexpr std::pair<touch_status, const char*> names[] = {{TOUCH_OK, "done"},
                                                              {TOUCH_INTERNAL, "internal fault"},
                                                              {TOUCH_USAGE, "bad argument"},
                                                              {TOUCH_INPUT, "bad input"},
                                                              {TOUCH_INTERRUPTED, "interrupted"},
                                                              {TOUCH_STALE, "stale handle"},
                                                              {TOUCH_BUSY, "busy"},
                                                              {TOUCH_FULL, "full"},
                                                              {TOUCH_END, "no more frames"},
                                                              {TOUCH_NO_MEMORY, "not enough memory"},
                                                              {TOUCH_FORKED, "belongs to the parent process"},
                                                              {TOUCH_EXISTS, "file exists"}};
    for (const auto& [known, name] : names)
        if (known == status) return name;
    return "unknown status";
}

touch_status touch_camera_defaults(touch_camera* camera, uint32_t struct_size) {
    return give_defaults(default_camera(), camera, struct_size);
}

touch_status touch_scene_from_camera(const touch_camera* camera, touch_scene* scene, touch_error* error) {
    return without_exceptions(error, [&]() -> Result<touch_status> {
        if (!scene || !has_known_size(camera))
            return usage_error("camera or scene is NULL, or struct_size is not sizeof(touch_camera)");
        TRY_ASSIGN(auto made, scene_of(over_defaults(camera, default_camera())));
        SceneDescription described(std::move(made));
        described.unstated.filters = all_unstated;
        return give_handle(scenes(), std::make_shared<SceneObject>(std::move(described)), *scene, error);
    });
}

touch_status touch_scene_from_text(const char* text, size_t length, touch_scene* scene, touch_error* error) {
    return without_exceptions(error, [&]() -> Result<touch_status> {
        constexpr std::size_t longest = std::size_t{1} << 28;
        if (!text || !scene || length > longest)
            return usage_error("text or scene is NULL, or the text is longer than 256 MiB");
        TRY_ASSIGN(auto described, scene_of_text({text, length}));
        return give_handle(scenes(), std::make_shared<SceneObject>(std::move(described)), *scene, error);
    });
}

touch_status touch_scene_text(touch_scene scene, char* text, size_t capacity, size_t* length) {
    return without_exceptions(nullptr, [&]() -> touch_status {
        if (!length || (!text && capacity > 0)) return TOUCH_USAGE;
        return with_object(scenes(), scene, [&](const SceneObject& object) {
            write_text(scene_to_json(object.described), text, capacity, *length);
        });
    });
}

touch_status touch_scene_describe(touch_scene scene, touch_scene_facts* facts) {
    if (!has_known_size(facts)) return TOUCH_USAGE;
    return with_object(scenes(), scene, [&](const auto& object) { hand_out(facts_of(object), *facts); });
}

touch_status touch_scene_destroy(touch_scene scene) {
    return end(scenes(), scene);
}

touch_status touch_scene_metres(touch_scene scene, const touch_plane* depth, float* metres,
                                int64_t stride_bytes, touch_error* error) {
    return without_exceptions(error, [&]() -> Result<touch_status> {
        constexpr std::int64_t longest = std::int64_t{1} << 40;
        if (!depth || !depth->data || !metres) return usage_error("depth, its data or metres is NULL");
        const auto use = scenes().find(scene.id);
        if (!use) return fail_without(use, error, "scene");
        const std::int64_t row = std::int64_t{use->scene().width} * std::int64_t{sizeof(float)};
        if (stride_bytes < -longest || stride_bytes > longest || std::abs(stride_bytes) < row)
            return usage_error("stride_bytes is " + std::to_string(stride_bytes) + "; must be at least " +
                               std::to_string(row));
        FrameScratch scratch;
        TRY_ASSIGN(const auto codes, depth_codes(*depth, use->scene(), scratch));
        write_metres(codes, use->scene().depth, metres_of_codes(*use),
                     reinterpret_cast<unsigned char*>(metres), stride_bytes);
        return TOUCH_OK;
    });
}

touch_status touch_scene_with_filters(touch_scene scene, const touch_frame* frames, size_t frame_stride_bytes,
                                      size_t count, touch_scene* filtered, touch_error* error) {
    return without_exceptions(error, [&]() -> Result<touch_status> {
        if (!filtered || (!frames && count > 0) || (count > 1 && !holds_frames(frame_stride_bytes)))
            return usage_error("frames or filtered is NULL, or frame_stride_bytes is too small");
        const auto use = scenes().find(scene.id);
        if (!use) return fail_without(use, error, "scene");
        Scene chosen = use->scene();
        const std::int32_t sample = count > 0 && has_known_size(frames) ? frames->depth.sample : TOUCH_U16;
        Scene seen = scene_of_depth(chosen, sample);
        TRY_ASSIGN(const auto measured,
                   measure(seen, reinterpret_cast<const unsigned char*>(frames), frame_stride_bytes, count,
                           integer_scale_after(chosen, sample)));
        TRY(settle_filters(measured, use->described.unstated.filters, seen));
        chosen.filter = seen.filter;
        return give_handle(scenes(), std::make_shared<SceneObject>(std::move(chosen)), *filtered, error);
    });
}

touch_status touch_frame_defaults(touch_frame* frame, uint32_t struct_size) {
    return give_defaults(touch_frame{}, frame, struct_size);
}

touch_status touch_surface_settings_defaults(touch_surface_settings* settings, uint32_t struct_size) {
    return give_defaults(default_surface_settings, settings, struct_size);
}

touch_status touch_surface_create(touch_scene scene, const touch_surface_settings* settings,
                                  touch_surface* surface, touch_error* error) {
    return without_exceptions(error, [&]() -> Result<touch_status> {
        if (!surface || (settings && !has_known_size(settings)))
            return usage_error("surface is NULL, or struct_size is not sizeof(touch_surface_settings)");
        const touch_surface_settings wanted = over_defaults(settings, default_surface_settings);
        if (wanted.threads < 1 || wanted.threads > 16)
            return usage_error("threads is out of range; must be 1 to 16");
        if (wanted.frames != 1 && (wanted.frames < 4 || wanted.frames > 64))
            return usage_error("frames is out of range; must be 4 to 64, or 1 without a solver");
        if (wanted.error_bars != 0 && wanted.error_bars != 1)
            return usage_error("error_bars is out of range; must be 0 or 1");
        const auto use = scenes().find(scene.id);
        if (!use) return fail_without(use, error, "scene");
        return give_handle(surfaces(), std::make_shared<SurfaceObject>(use->scene(), wanted), *surface,
                           error);
    });
}

touch_status touch_surface_push(touch_surface surface, const touch_frame* frame, touch_error* error) {
    return without_exceptions(error, [&]() -> Result<touch_status> {
        if (!has_known_size(frame))
            return usage_error("frame is NULL, or struct_size is not sizeof(touch_frame)");
        const auto use = surfaces().find(surface.id);
        if (!use) return fail_without(use, error, "surface");
        const TryLock lock(use->pushing);
        if (!lock) return fail(error, TOUCH_BUSY, "another thread is pushing to this surface");
        return push(*use, *frame, error);
    });
}

touch_status touch_surface_begin_epoch(touch_surface surface, uint64_t epoch, touch_error* error) {
    return without_exceptions(error, [&]() -> Result<touch_status> {
        const auto use = surfaces().find(surface.id);
        if (!use) return fail_without(use, error, "surface");
        const TryLock lock(use->pushing);
        if (!lock) return fail(error, TOUCH_BUSY, "another thread is pushing to this surface");
        if (epoch <= use->queue.timeline().epoch() || epoch == std::numeric_limits<std::uint64_t>::max())
            return usage_error("the epoch's number is not larger than the one before");
        use->queue.timeline().begin_epoch(epoch);
        use->epoch_has_ended = false;
        use->newest.reset();
        return TOUCH_OK;
    });
}

touch_status touch_surface_end_epoch(touch_surface surface) {
    return with_object(surfaces(), surface, &SurfaceObject::pushing, [](SurfaceObject& object) {
        object.queue.timeline().end_epoch();
        object.epoch_has_ended = true;
    });
}

touch_status touch_surface_newest_ns(touch_surface surface, int64_t* time_ns) {
    if (!time_ns) return TOUCH_USAGE;
    return with_object(surfaces(), surface,
                       [&](const auto& object) { *time_ns = object.queue.timeline().newest_time(); });
}

touch_status touch_surface_hand_scale(touch_surface surface, double* metres_per_scene_unit,
                                      touch_error* error) {
    return without_exceptions(error, [&]() -> Result<touch_status> {
        if (!metres_per_scene_unit) return usage_error("metres_per_scene_unit is NULL");
        const auto use = surfaces().find(surface.id);
        if (!use) return fail_without(use, error, "surface");
        const double scale = use->hand_scale.load(std::memory_order_acquire);
        if (scale == 0) return usage_error("no frame was pushed yet; push the first one before");
        *metres_per_scene_unit = scale;
        return TOUCH_OK;
    });
}

touch_status touch_surface_filtered(touch_surface surface, const touch_filtered* filtered,
                                    touch_error* error) {
    return without_exceptions(error, [&]() -> Result<touch_status> {
        if (!has_known_size(filtered))
            return usage_error("filtered is NULL, or struct_size is not sizeof(touch_filtered)");
        const auto use = surfaces().find(surface.id);
        if (!use) return fail_without(use, error, "surface");
        const TryLock lock(use->pushing);
        if (!lock) return fail(error, TOUCH_BUSY, "another thread is pushing to this surface");
        const SurfaceFrame* const pushed = use->queue.newest();
        if (!pushed) return usage_error("no frame was pushed yet; push the first one before");
        TRY_ASSIGN(const auto metres,
                   rows_for("metres", filtered->metres, filtered->metres_stride_bytes, pushed->width));
        TRY_ASSIGN(const auto normals,
                   rows_for("normals", filtered->normals, filtered->normals_stride_bytes, 3 * pushed->width));
        TRY_ASSIGN(const auto degrees, rows_for("error_degrees", filtered->error_degrees,
                                                filtered->error_degrees_stride_bytes, pushed->width));
        if (degrees.data && use->settings.error_bars == 0)
            return usage_error("error_degrees needs a surface with error_bars");
        if (metres.data) use->floats->metres(*pushed, metres);
        if (normals.data) use->floats->normals(*pushed, normals);
        if (degrees.data) use->floats->error_degrees(*pushed, degrees);
        return TOUCH_OK;
    });
}

touch_status touch_surface_destroy(touch_surface surface) {
    return end(surfaces(), surface);
}

touch_status touch_solver_settings_defaults(touch_solver_settings* settings, uint32_t struct_size) {
    return give_defaults(default_solver_settings(), settings, struct_size);
}

touch_status touch_solver_create(touch_surface surface, const touch_solver_settings* settings,
                                 touch_solver* solver, touch_error* error) {
    return without_exceptions(error, [&]() -> Result<touch_status> {
        if (!solver || (settings && !has_known_size(settings)))
            return usage_error("solver is NULL, or struct_size is not sizeof(touch_solver_settings)");
        const touch_solver_settings wanted = over_defaults(settings, default_solver_settings());
        if (wanted.fingers < 1 || wanted.fingers > most_fingers)
            return usage_error("fingers is out of range; must be 1 to 256");
        auto use = surfaces().find(surface.id);
        if (!use) return fail_without(use, error, "surface");
        TRY_ASSIGN(const auto made, solver_of(*use, wanted));
        Reading reading(std::move(use));
        if (!reading) return fail_has_reader(reading->settings, error);
        return give_handle(
            solvers(),
            std::make_shared<SolverObject>(std::move(reading), made, guard_of(wanted), wanted.fingers),
            *solver, error);
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
    const touch_tick begin = over_defaults(first, touch_tick{});
    if (!is_sound(begin)) return TOUCH_USAGE;
    const auto use = solvers().find(solver.id);
    if (!use) return status_without(use);
    const TryLock lock(use->ticking);
    if (!lock) return TOUCH_BUSY;
    if (use->last_tick && begin.tick <= *use->last_tick) return TOUCH_USAGE;
    const auto fingers = static_cast<std::size_t>(use->run.fingers());
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
    return with_object(solvers(), solver, &SolverObject::ticking,
                       [](auto& object) { object.run.come_back(); });
}

touch_status touch_solver_force_hash(touch_solver solver, uint64_t* hash) {
    if (!hash) return TOUCH_USAGE;
    return with_object(solvers(), solver, &SolverObject::ticking,
                       [&](const auto& object) { *hash = object.run.hash().value(); });
}

touch_status touch_solver_save(touch_solver solver, void* state, size_t capacity, size_t* length) {
    if (!length || (!state && capacity > 0)) return TOUCH_USAGE;
    return with_saved(solver, [&](const std::vector<std::uint8_t>& saved) {
        *length = saved.size();
        if (capacity > 0) std::memcpy(state, saved.data(), std::min(capacity, saved.size()));
    });
}

touch_status touch_solver_state_hash(touch_solver solver, uint64_t* hash) {
    if (!hash) return TOUCH_USAGE;
    return with_saved(solver, [&](const std::vector<std::uint8_t>& saved) {
        ByteHash of_state;
        of_state.add(saved.data(), saved.size());
        *hash = of_state.value();
    });
}

touch_status touch_solver_load(touch_solver solver, const void* state, size_t length, touch_error* error) {
    return without_exceptions(error, [&]() -> Result<touch_status> {
        if (!state) return usage_error("state is NULL");
        const auto use = solvers().find(solver.id);
        if (!use) return fail_without(use, error, "solver");
        const TryLock lock(use->ticking);
        if (!lock) return fail(error, TOUCH_BUSY, "another thread is using the solver");
        TouchRun& run = use->run;
        const std::vector<std::uint8_t> before = run.save();
        TRY(run.load({static_cast<const std::uint8_t*>(state), length}));
        if (auto resumed = run.resume(); !resumed) {
            TRY(run.load(before));
            return resumed.error();
        }
        use->last_tick = run.tick();
        return TOUCH_OK;
    });
}

touch_status touch_solver_destroy(touch_solver solver) {
    return end(solvers(), solver);
}

touch_status touch_surface_forces_at(touch_surface surface, const touch_solver_settings* settings,
                                     const touch_tick* moment, int32_t friction, const touch_vec3* points,
                                     size_t count, touch_contact* contacts, size_t contact_stride_bytes,
                                     touch_error* error) {
    return without_exceptions(error, [&]() -> Result<touch_status> {
        constexpr std::size_t most_points = std::size_t{1} << 40;
        if (!has_known_size(moment) || (settings && !has_known_size(settings)) || count > most_points ||
            (count > 0 && (!points || !contacts)) || !is_stride(contact_stride_bytes))
            return usage_error(
                "moment, points or contacts is NULL, or a struct_size or contact_stride_bytes is not "
                "that of the struct");
        if (friction != TOUCH_FRICTION_OFF && friction != TOUCH_FRICTION_ON)
            return usage_error("friction is " + std::to_string(friction) +
                               "; must be TOUCH_FRICTION_OFF or TOUCH_FRICTION_ON");
        const touch_tick at = over_defaults(moment, touch_tick{});
        if (!is_sound(at)) return usage_error("the moment is out of range; must be -2^60 to 2^60");
        touch_solver_settings wanted = over_defaults(settings, default_solver_settings());
        wanted.ramp_in_ticks = wanted.waits_to_be_free = 0;
        wanted.stale_after_ns = 0;
        auto use = surfaces().find(surface.id);
        if (!use) return fail_without(use, error, "surface");
        TRY_ASSIGN(const auto solver, solver_of(*use, wanted));
        const Reading reading(std::move(use));
        if (!reading) return fail_has_reader(reading->settings, error);
        FramePair pair;
        if (!reading->queue.timeline().pair_at(MediaMoment{at.epoch, at.time_ns, at.epoch_start_ns}, pair))
            return usage_error("no frame was pushed yet; push the first one before");
        const Scene scene =
            friction == TOUCH_FRICTION_ON ? reading->queue.scene() : without_friction(reading->queue.scene());
        SurfaceQueue still(scene, nullptr);
        auto* out = reinterpret_cast<unsigned char*>(contacts);
        for (std::size_t k = 0; k < count; k += resting_at_a_time) {
            const std::size_t some = std::min(resting_at_a_time, count - k);
            TouchRun run(still, nullptr, solver, guard_of(wanted), static_cast<int>(some));
            rest(run, pair, points + k, out + k * contact_stride_bytes, contact_stride_bytes);
        }
        return TOUCH_OK;
    });
}
