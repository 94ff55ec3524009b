// SPDX-License-Identifier: Apache-2.0
#pragma once

// The solver of one tick: a goal in, a proxy on the surface and a force out (docs/solver.md). touch_step.hpp
// includes it for its users.
//
// TouchSolver::create checks TouchSettings against a scene. `tick` moves each finger's proxy over a
// HeightField, keeps its FingerState for the next tick, and fills in a Contact: proxy, force before any
// guard, properties at the proxy, and how the surface moved under it. TouchMetric is where distances are
// measured.
//
// Threads: any may call a solver's `tick`, each with a field and fingers of its own; it neither waits nor
// allocates.

#include <glm/vec3.hpp>
#include <span>
#include <string_view>

#include "engine/base/result.hpp"
#include "haptics_cpu/slide.hpp"
#include "haptics_cpu/world_space.hpp"

namespace touchable {

/// Where distances are measured: in the world (exact); or, for comparison, in pixels and grey levels (the
/// paper's), or in pixels and grey levels scaled by kappa at the finger, anew in each tick.
enum class TouchMetric { world, pixel, scaled };

/// "world", "pixel", "scaled".
std::string_view name_of(TouchMetric metric);

struct TouchSettings {
    TouchMetric metric = TouchMetric::world;
    double metres_per_scene_unit = 0.001;    ///< S of F = k S (P - G), from the Workspace
    int event_limit = SolveLimits{}.events;  ///< features a proxy may pass in a tick, 1 to 1000000
    int cell_limit = SolveLimits{}.cells;    ///< lattice lines and faces it may test, 1 to 1000000
    double stribeck_speed = 0;  ///< v_s, m/s: friction that falls with speed (stribeck_slip); 0: Coulomb's
    /// A surface that carries a proxy faster than this (device metres per second of the hand) moves suddenly:
    /// see `carry` and `Contact::jumped`. Infinite: never, except into a new epoch.
    double sudden_speed = 0.1;
};

/// State of a finger from tick to tick.
struct FingerState {
    Proxy proxy;
    bool started = false;
    glm::dvec3 goal{0.0};     ///< the last usable one, world
    double slip_speed = 0;    ///< of the proxy over the surface, m/s, filtered; kept for Stribeck's friction
    int ticks_held = 0;       ///< since `goal` was new
    double moment_ns = 0;     ///< of the surface it last met
    std::uint64_t epoch = 0;  ///< of that surface
    double stiffness = 0;     ///< at the proxy, N/m; 0 out of contact
    bool near_hole = false;   ///< part of it comes from holes
    glm::dvec3 place{0.0};    ///< of the proxy after its last tick, world
};

/// A finger's contact in a tick. World, scene units, newtons.
struct Contact {
    glm::dvec3 goal{0.0};
    glm::dvec3 proxy{0.0};
    glm::dvec3 force{0.0};  ///< k S (P - G), before any guard
    bool touching = false;
    /// The goal was NaN, beyond `largest_goal`, or (metrics of pixels) seen by no pixel: the last one was
    /// used.
    bool goal_held = false;
    bool hops = false;                ///< TouchStep: the hand lifts the finger over broken or rough ground
    double pixel_x = 0, pixel_y = 0;  ///< of the proxy; NaN if no pixel sees it
    HapticProperties properties;      ///< at the proxy; zero out of contact
    /// Bars of the force's direction and of the spring's size (ErrorBar); NaN out of contact, and where the
    /// frame was not measured.
    double error_degrees = std::numeric_limits<double>::quiet_NaN();
    double error_newtons = std::numeric_limits<double>::quiet_NaN();
    bool in_hole = false;   ///< the proxy rests on a hole's wall or ground: `is_in_hole`
    double hole_share = 0;  ///< share of holes in the stiffness at the proxy: HeightField
    /// Where the surface of this tick carried the proxy, before the goal moved; and k there, N/m. No k if
    /// that is off the surface: 0 is an ordinary stiffness.
    glm::dvec3 carried{0.0};
    std::optional<double> carried_stiffness;
    int ticks = 1;             ///< since the finger's previous tick: more if some were skipped
    bool off_its_ray = false;  ///< the surface moved suddenly, and pushed the proxy aside or left it behind
    /// The surface moved suddenly, away or with the proxy: a cut, a new epoch, a late frame, a fast object.
    /// Or it became much stiffer or softer under the proxy.
    bool jumped = false;
    glm::dvec3 jumped_force{0.0};  ///< if so: what the previous tick's goal meets on this tick's surface
    SolveCounts counts;
};

/// The touch solver (docs/solver.md): goals of N fingers in, proxies and forces out. A pure function of
/// settings, field, goals and state; no allocation, lock or I/O. Fingers do not feel each other.
class TouchSolver {
public:
    /// Refuses the metrics of pixels if the scene's depth is not linear or its pixels are not square, S <= 0,
    /// and limits out of their range.
    static Result<TouchSolver> create(const Scene& scene, const TouchSettings& settings);

    /// `goals`, `fingers` and `contacts` have one element per finger. `ticks`: since the previous tick, 1 or
    /// more. Wait-free.
    void tick(const HeightField& field, std::span<const glm::dvec3> goals, std::span<FingerState> fingers,
              std::span<Contact> contacts, int ticks = 1) const;

    const TouchSettings& settings() const { return settings_; }

private:
    TouchSolver(const TouchSettings& settings, double goal_limit)
        : settings_(settings), goal_limit_(goal_limit) {}
    TouchSettings settings_;
    double goal_limit_;
};

/// Goals with a coordinate beyond this (scene units) are not used: it is far outside the scene, and in
/// proportion to the scene's size in depth and sideways.
double largest_goal(const Scene& scene);

/// Whether a world point is behind the surface: its 1 / planar depth is less than the surface's under its
/// pixel by more than `tolerance`, relative. False for points that no pixel sees.
bool is_behind_surface(const HeightField& field, const glm::dvec3& point, double tolerance);
/// Whether a free proxy gets straight from one world point, in front of the surface, to another.
bool is_way_free(const HeightField& field, const glm::dvec3& from, const glm::dvec3& to);

}  // namespace touchable
