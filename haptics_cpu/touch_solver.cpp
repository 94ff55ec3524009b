// SPDX-License-Identifier: Apache-2.0
#include "haptics_cpu/touch_solver.hpp"

#include <glm/geometric.hpp>

#include "haptics_cpu/cast.hpp"
#include "haptics_cpu/force_guard.hpp"
#include "haptics_cpu/surface_carry.hpp"

namespace touchable {

namespace {

using glm::dvec3;

// Larger limits can only be a slip.
constexpr int largest_limit = 1'000'000;

bool is_usable(const dvec3& goal, double limit) {
    // Written so that NaN fails.
    return std::abs(goal.x) <= limit && std::abs(goal.y) <= limit && std::abs(goal.z) <= limit;
}

/// False if a number of the state is not finite. No tick leaves such a state; a finger with it begins anew.
bool is_sound(const FingerState& finger) {
    const Proxy& proxy = finger.proxy;
    const dvec3 sum = proxy.point + finger.goal + finger.place;
    return std::isfinite(sum.x + sum.y + sum.z + proxy.a + proxy.b + finger.slip_speed + finger.moment_ns +
                         finger.stiffness);
}

/// Cast, then slide: from a place on or in front of the surface to where the goal pulls the proxy.
void solve(const auto& space, Proxy& proxy, const dvec3& goal, const SolveLimits& limits, const Slip& slip,
           SolveCounts& counts) {
    if (!proxy.on_surface()) {
        const Cast flight = cast(space, proxy.point, nullptr, goal, counts.cells, limits.cells);
        counts.capped = flight.cut.has_value();
        if (!flight.hit) {
            proxy.point = flight.cut.value_or(goal);
            return;
        }
        proxy = {*flight.hit, surface_point(space, *flight.hit)};
    }
    slide(space, proxy, goal, limits, slip, counts);
}

SolveLimits limits_of(const TouchSettings& settings) {
    return {settings.event_limit, settings.cell_limit};
}

/// Friction in this tick.
Slip slip_of(const TouchSettings& settings, FingerState& finger) {
    if (!(settings.stribeck_speed > 0)) return {};
    if (is_slow(finger.slip_speed, settings.stribeck_speed)) finger.proxy.sliding = false;
    return stribeck_slip(finger.slip_speed, settings.stribeck_speed);
}

constexpr double never = std::numeric_limits<double>::infinity();

/// Whether the finger last met a surface of another epoch: then all that the surface did since is a jump.
bool is_in_new_epoch(const HeightField& field, const FingerState& finger) {
    return finger.started && finger.epoch != field.epoch();
}

/// How far (scene units) the surface may carry a proxy in this tick before that is sudden: as far as it gets
/// at `sudden_speed`, in the ticks that have passed if frames are interpolated (no longer than a frame, so
/// that no stall earns a kick) and in a frame if they are held. A surface that stood still for want of frames
/// and catches up has no more time for it. 0 into a new epoch. Infinite if the surface did not move, and in
/// the metrics of pixels, which know no suddenness.
double sudden_distance(const HeightField& field, const TouchSettings& settings, const FingerState& finger,
                       int ticks) {
    if (is_in_new_epoch(field, finger)) return 0;
    const Scene& scene = field.scene();
    const double moved_s = 1e-9 * std::abs(field.moment_ns() - finger.moment_ns);
    if (!finger.started || moved_s == 0 || settings.metric != TouchMetric::world) return never;
    const double nominal_s = static_cast<double>(scene.rate.den) / static_cast<double>(scene.rate.num);
    const double frame_s = field.frame_interval().value_or(nominal_s);
    // A hand feels the speed of the surface in its own time, at any playback rate.
    const double due_s = scene.interpolation == FrameInterpolation::hold
                             ? std::min(moved_s, frame_s)
                             : std::min(ticks * tick_seconds, std::max(frame_s, tick_seconds));
    return settings.sudden_speed * due_s / settings.metres_per_scene_unit;
}

void book_carried(const auto& space, const Proxy& proxy, Contact& contact) {
    contact.carried_stiffness.reset();
    if (!proxy.on_surface()) return;
    contact.carried = space.to_world(proxy.point);
    contact.carried_stiffness = space.field().stiffness(proxy.i, proxy.j, proxy.a, proxy.b);
}

/// Force change by stiffness from tick to tick under a resting finger, N: more is a jump of the surface.
constexpr double largest_step = 0.1;

/// Whether the surface has become so much stiffer or softer under a proxy that it counts as a jump. The guard
/// spreads what a hole does to stiffness (ContactStiffness).
bool is_other_stuff(const auto& space, const TouchSettings& settings, const dvec3& goal,
                    const FingerState& before, const Proxy& proxy, const Contact& contact) {
    if (!contact.carried_stiffness || before.near_hole) return false;
    const double per_metre = *contact.carried_stiffness - before.stiffness;
    return per_metre != 0 &&
           std::abs(per_metre) * settings.metres_per_scene_unit * glm::distance(contact.carried, goal) >
               largest_step &&
           space.field().hole_share(proxy.i, proxy.j, proxy.a, proxy.b) == 0;
}

/// Brings a proxy to the surface of this tick, and finds the force of a surface that jumped at `goal`, the
/// previous tick's. `felt`: how far the surface may carry it before its force counts as a jump's.
void bring(const auto& space, const TouchSettings& settings, double sudden, double felt, const dvec3& goal,
           const Slip& slip, FingerState& finger, Contact& contact) {
    Proxy& proxy = finger.proxy;
    const dvec3 before = proxy.point;
    const bool was_touching = proxy.on_surface();
    contact.off_its_ray = !carry(space, proxy, sudden);
    book_carried(space, proxy, contact);
    const bool other_stuff = was_touching && is_other_stuff(space, settings, goal, finger, proxy, contact);
    const bool left_behind = contact.off_its_ray && !proxy.on_surface();
    const bool far_along = sudden != never && glm::distance(before, proxy.point) > felt;
    const bool cut = is_in_new_epoch(space.field(), finger) && (was_touching || proxy.on_surface());
    if (!other_stuff && !left_behind && !far_along && !cut) return;
    const auto there = space.from_world(goal);
    if (!there) return;
    contact.jumped = true;
    Proxy still = proxy;
    SolveCounts of_the_jump;
    solve(space, still, *there, limits_of(settings), slip, of_the_jump);
    if (still.on_surface())
        contact.jumped_force = properties_at(space, still).stiffness * settings.metres_per_scene_unit *
                               (space.to_world(still.point) - goal);
    // A proxy that was left behind flies to where that goal pulls it, before the goal moves on.
    if (left_behind) {
        proxy = still;
        book_carried(space, proxy, contact);
    }
}

/// Updates the proxy's speed over the surface; being carried by a moving surface does not count. While its
/// goal is held a proxy rests for want of a goal, which says nothing of its speed.
void note_slip(const TouchSettings& settings, const Contact& contact, FingerState& finger) {
    finger.ticks_held = std::min(finger.ticks_held + contact.ticks, longest_ticks);
    if (contact.touching && contact.goal_held) return;
    if (!(settings.stribeck_speed > 0) || !contact.touching || !contact.carried_stiffness) {
        finger.slip_speed = 0;
    } else {
        const dvec3 way = contact.proxy - contact.carried;
        const double metres = settings.metres_per_scene_unit * std::sqrt(glm::dot(way, way));
        finger.slip_speed = filtered_velocity(finger.slip_speed, metres, finger.ticks_held);
    }
    finger.ticks_held = 0;
}

void fill_contact(const auto& space, const Proxy& proxy, double metres_per_scene_unit, Contact& contact) {
    contact.touching = proxy.on_surface();
    if (contact.touching) {
        contact.pixel_x = proxy.x();
        contact.pixel_y = proxy.y();
        const auto valid = valid_corners(space, proxy);
        const bool all_valid = valid[0] && valid[1] && valid[2] && valid[3];
        contact.properties = space.field().properties(proxy.i, proxy.j, proxy.a, proxy.b, valid);
        contact.force = contact.properties.stiffness * metres_per_scene_unit * (contact.proxy - contact.goal);
        contact.in_hole = !all_valid && is_in_hole(space, proxy);
        contact.hole_share = space.field().hole_share(proxy.i, proxy.j, proxy.a, proxy.b);
        const ErrorBar error = space.field().error_bar(contact.pixel_x, contact.pixel_y);
        contact.error_degrees = error.degrees;
        contact.error_newtons = contact.properties.stiffness * metres_per_scene_unit * error.depth;
        return;
    }
    contact.properties = {0, 0, 0};
    contact.error_degrees = contact.error_newtons = std::numeric_limits<double>::quiet_NaN();
    contact.force = dvec3(0.0);
    const auto image = project(space.field().scene().camera, contact.proxy);
    contact.pixel_x = image ? image->x : std::numeric_limits<double>::quiet_NaN();
    contact.pixel_y = image ? image->y : std::numeric_limits<double>::quiet_NaN();
}

/// The order of docs/solver.md, A tick, file by file.
void tick_in(const auto& space, const TouchSettings& settings, double goal_limit,
             std::span<const dvec3> goals, std::span<FingerState> fingers, std::span<Contact> contacts,
             int ticks) {
    const HeightField& field = space.field();
    for (std::size_t k = 0; k < goals.size(); ++k) {
        FingerState& finger = fingers[k];
        Contact& contact = contacts[k];
        std::construct_at(&contact);  // in place: a copy of what was just stored in pieces stalls
        contact.ticks = ticks;
        if (!is_sound(finger)) finger = {};
        auto there = space.from_world(goals[k]);
        const bool usable = is_usable(goals[k], goal_limit) && there;
        contact.goal_held = !usable;
        const dvec3 goal_before = finger.started ? finger.goal : goals[k];
        if (usable) finger.goal = goals[k];
        contact.goal = contact.proxy = finger.goal;
        if (!usable && !finger.started) continue;

        Proxy& proxy = finger.proxy;
        if (!usable) there = space.from_world(finger.goal);
        const dvec3 goal = *there;
        if (!finger.started) proxy.point = goal;
        // However many ticks were left out, the hand feels at once what the surface may do in one.
        const double sudden = sudden_distance(field, settings, finger, ticks),
                     felt = ticks == 1 ? sudden : sudden_distance(field, settings, finger, 1);
        if (!finger.started) finger.epoch = field.epoch();
        finger.started = true;
        finger.moment_ns = field.moment_ns();
        if (!proxy.on_surface() && is_clear(space, proxy.point, goal)) {
            proxy.point = goal;
        } else {
            const Slip slip = slip_of(settings, finger);
            bring(space, settings, sudden, felt, goal_before, slip, finger, contact);
            solve(space, proxy, goal, limits_of(settings), slip, contact.counts);
        }
        if (proxy.on_surface() || contact.counts.capped) contact.proxy = space.to_world(proxy.point);
        finger.place = contact.proxy;
        finger.epoch = field.epoch();
        fill_contact(space, proxy, settings.metres_per_scene_unit, contact);
        finger.stiffness = contact.properties.stiffness;
        finger.near_hole = contact.hole_share > 0;
        note_slip(settings, contact, finger);
    }
}

/// Each finger in a space scaled for its position. A free proxy's position is converted into the new space.
void tick_scaled(const HeightField& field, const TouchSettings& settings, double goal_limit,
                 std::span<const dvec3> goals, std::span<FingerState> fingers, std::span<Contact> contacts,
                 int ticks) {
    const Scene& scene = field.scene();
    for (std::size_t k = 0; k < goals.size(); ++k) {
        FingerState& finger = fingers[k];
        if (!is_sound(finger)) finger = {};
        dvec3 place = finger.started || !is_usable(goals[k], goal_limit) ? finger.place : goals[k];
        if (finger.proxy.on_surface()) place = surface_point(WorldSpace(field), finger.proxy);
        const PixelSpace space(field, place.z < 0 ? kappa_at(scene, place) : 1.0);
        if (finger.started && !finger.proxy.on_surface())
            finger.proxy.point = space.from_world(finger.place).value_or(finger.proxy.point);
        tick_in(space, settings, goal_limit, goals.subspan(k, 1), fingers.subspan(k, 1),
                contacts.subspan(k, 1), ticks);
    }
}

}  // namespace

std::string_view name_of(TouchMetric metric) {
    constexpr std::string_view names[] = {"world", "pixel", "scaled"};
    return names[static_cast<std::size_t>(metric)];
}

Result<TouchSolver> TouchSolver::create(const Scene& scene, const TouchSettings& settings) {
    if (!(settings.metres_per_scene_unit > 0) || !std::isfinite(settings.metres_per_scene_unit))
        return usage_error("workspace: " + std::to_string(settings.metres_per_scene_unit) +
                           " device metres per scene unit; it must be a positive number");
    if (!(settings.stribeck_speed >= 0) || !std::isfinite(settings.stribeck_speed))
        return usage_error("Stribeck speed: " + std::to_string(settings.stribeck_speed) +
                           " m/s; it must be a positive number, or 0 for friction that no speed changes");
    const std::pair<const char*, int> limits[] = {{"event limit", settings.event_limit},
                                                  {"cell limit", settings.cell_limit}};
    for (const auto& [name, limit] : limits)
        if (limit < 1 || limit > largest_limit)
            return usage_error(std::string(name) + ": " + std::to_string(limit) + "; it must be from 1 to " +
                               std::to_string(largest_limit));
    if (settings.metric != TouchMetric::world) {
        const std::string metric = "metric " + std::string(name_of(settings.metric));
        if (scene.depth.kind != DepthCodingKind::linear)
            return usage_error(metric +
                               ": the scene's depth is not linear; the paper's metric knows no other");
        if (scene.camera.fx != scene.camera.fy)
            return usage_error(metric + ": fx " + std::to_string(scene.camera.fx) + " and fy " +
                               std::to_string(scene.camera.fy) +
                               " differ; the paper's metric needs square pixels");
    }
    return TouchSolver(settings, largest_goal(scene));
}

double largest_goal(const Scene& scene) {
    constexpr double scenes = 1e7;  // this many times the scene's own farthest coordinate
    if (scene.depth.semantics == DepthSemantics::range) return scenes * scene.depth.far;
    const Camera& camera = scene.camera;
    const auto across = [](double first, double last) { return std::max(std::abs(first), std::abs(last)); };
    return scenes * scene.depth.far *
           std::max({1.0, across(camera.u(-1), camera.u(scene.width)),
                     across(camera.v(-1), camera.v(scene.height))});
}

void TouchSolver::tick(const HeightField& field, std::span<const dvec3> goals, std::span<FingerState> fingers,
                       std::span<Contact> contacts, int ticks) const {
    assert(goals.size() == fingers.size() && goals.size() == contacts.size());
    if (settings_.metric == TouchMetric::world)
        tick_in(WorldSpace(field), settings_, goal_limit_, goals, fingers, contacts, ticks);
    else if (settings_.metric == TouchMetric::scaled)
        tick_scaled(field, settings_, goal_limit_, goals, fingers, contacts, ticks);
    else
        tick_in(PixelSpace(field), settings_, goal_limit_, goals, fingers, contacts, ticks);
}

bool is_behind_surface(const HeightField& field, const dvec3& point, double tolerance) {
    const WorldSpace world(field);
    const auto at = world.chart(point);
    return at && at->w < surface_w(world, face_under(at->x, at->y)) * (1.0 - tolerance);
}

bool is_way_free(const HeightField& field, const dvec3& from, const dvec3& to) {
    const WorldSpace world(field);
    if (is_clear(world, from, to)) return true;
    int cells = 0;
    const Cast way = cast(world, from, nullptr, to, cells, SolveLimits{}.cells);
    return !way.hit && !way.cut;
}

}  // namespace touchable
