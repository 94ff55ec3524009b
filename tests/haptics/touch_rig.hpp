// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/same_bits.hpp"
#include "engine/content/families.hpp"
#include "engine/content/scenes.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/surface_builder.hpp"
#include "haptics_cpu/force_guard.hpp"
#include "haptics_cpu/height_field.hpp"
#include "haptics_cpu/touch_solver.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "tests/content/exact_touch.hpp"

namespace touchable::test {

using glm::dvec3;
using Path = std::vector<dvec3>;

inline SceneOptions sized(int width, int height) {
    SceneOptions options;
    options.width = width;
    options.height = height;
    return options;
}

/// A frame that stands still.
inline FramePair still(const SurfaceFrame& frame, std::int64_t number = 0, std::int64_t time_ns = 0) {
    const TimedFrame timed{number, time_ns, &frame};
    return {timed, timed, 0};
}

/// The frames around a moment of a clip whose frames are at `rate`.
template <class FrameOf>
FramePair pair_around(std::int64_t time_ns, const FrameRate& rate, FrameOf frame_of) {
    std::int64_t n = 0;
    while (rate.time_ns(n + 1) <= time_ns) ++n;
    const auto timed = [&](std::int64_t m) { return TimedFrame{m, rate.time_ns(m), frame_of(m)}; };
    FramePair pair{timed(n), timed(n + 1), 0};
    pair.blend = static_cast<double>(time_ns - pair.prev.time_ns) /
                 static_cast<double>(pair.next.time_ns - pair.prev.time_ns);
    return pair;
}

/// Stiffness as the map has it.
inline constexpr StiffnessRise at_once{.per_tick = std::numeric_limits<double>::infinity()};

/// A tick of one finger.
inline Contact tick_one(const TouchSolver& solver, const HeightField& field, FingerState& finger,
                        const dvec3& goal, int ticks = 1) {
    Contact contact;
    solver.tick(field, {&goal, 1}, {&finger, 1}, {&contact, 1}, ticks);
    return contact;
}

/// A contact made by hand.
inline Contact pressing(const dvec3& force, double stiffness = 1000) {
    Contact contact;
    contact.touching = true;
    contact.force = force;
    contact.goal = -1000.0 / stiffness * force;  // a unit is a millimetre
    contact.properties.stiffness = stiffness;
    return contact;
}

inline std::string name_of_run(const testing::TestParamInfo<FrameInterpolation>& run) {
    return run.param == FrameInterpolation::hold ? "Held" : "Linear";
}

/// A generated scene, frame 0 built either unquantised or from codes, and fingers on it.
class TouchRig {
public:
    enum class Depth { exact, codes };

    TouchRig(std::string_view name, const SceneOptions& options, Depth depth, int fingers = 1)
        : content_(std::move(make_scene(name, options)).value()),
          scene_(content_->scene()),
          fingers_(static_cast<std::size_t>(fingers)),
          contacts_(static_cast<std::size_t>(fingers)) {
        settings.metres_per_scene_unit = scene_.device_metres_per_unit.value_or(0.001);
        load(0, depth, frame_);
        pair = still(frame_);
    }

    void load(std::int64_t number, Depth depth, SurfaceFrame& frame) {
        if (depth == Depth::exact) return exact_frame(*content_, number, frame);
        const auto built = make_cpu_builder(scene_)->build(content_->frame(number), frame);
        ASSERT_TRUE(built);
    }

    /// One tick of one finger (or the same goal for all).
    const Contact& tick(const dvec3& goal) {
        Path goals(fingers_.size(), goal);
        const auto solver = TouchSolver::create(scene_, settings);
        solver.value().tick(field(), goals, fingers_, contacts_);
        return contacts_[0];
    }

    HeightField field() const { return {scene_, pair}; }
    Scene& scene() { return scene_; }
    FingerState& finger(std::size_t k = 0) { return fingers_[k]; }
    void lift_fingers() { fingers_.assign(fingers_.size(), {}); }

    TouchSettings settings;
    FramePair pair;

private:
    std::unique_ptr<AnalyticScene> content_;
    Scene scene_;
    SurfaceFrame frame_;
    std::vector<FingerState> fingers_;
    std::vector<Contact> contacts_;
};

inline double length(const dvec3& v) {
    return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
}

/// Straight lines from corner to corner, in equal steps no longer than `step` on each.
inline Path path_along(const Path& corners, double step) {
    Path path{corners.at(0)};
    for (std::size_t k = 1; k < corners.size(); ++k) {
        const dvec3 way = corners[k] - corners[k - 1];
        const int steps = static_cast<int>(std::ceil(std::sqrt(glm::dot(way, way)) / step));
        for (int n = 1; n <= steps; ++n) path.push_back(corners[k - 1] + way * (double(n) / steps));
    }
    return path;
}

inline void append(Path& path, const Path& more) {
    path.insert(path.end(), more.begin(), more.end());
}

/// No ramp and no slew, so that all that happens is the solver's.
inline GuardSettings without_ramp() {
    return {.ramp_in_ticks = 0, .rise = at_once};
}

/// A pair of small frames with depths set by hand; NaN is an invalid pixel.
class SmallField {
public:
    SmallField(int width, int height, double depth, DepthSemantics semantics = DepthSemantics::range) {
        scene.width = width;
        scene.height = height;
        scene.camera = {400, 400, width / 2.0, height / 2.0};
        scene.depth.near = 40;
        scene.depth.far = 400;
        scene.depth.semantics = semantics;
        scene.default_properties = {1000, 0, 0};
        for (SurfaceFrame* frame : {&prev, &next}) {
            frame->width = width;
            frame->height = height;
            frame->coding = scene.depth;
            fill(*frame, depth);
        }
    }

    void fill(SurfaceFrame& frame, double depth) {
        depths(frame).assign(static_cast<std::size_t>(scene.width) * static_cast<std::size_t>(scene.height),
                             depth);
        refresh(frame);
    }
    void set(SurfaceFrame& frame, int x, int y, double depth) {
        depths(frame)[frame.index(x, y)] = depth;
        refresh(frame);
    }
    /// depth(x, y) over all pixels.
    template <class Function>
    void shape(SurfaceFrame& frame, Function depth) {
        for (int y = 0; y < scene.height; ++y)
            for (int x = 0; x < scene.width; ++x) depths(frame)[frame.index(x, y)] = depth(x, y);
        refresh(frame);
    }

    FramePair pair(double blend = 0) const { return {{0, 0, &prev}, {1, 1'000'000, &next}, blend}; }
    HeightField field(double blend = 0) const { return {scene, pair(blend)}; }

    /// One tick of one finger.
    Contact touch(FingerState& finger, const dvec3& goal, double blend = 0,
                  const TouchSettings& settings = {}, int ticks = 1) const {
        return tick_one(TouchSolver::create(scene, settings).value(), field(blend), finger, goal, ticks);
    }

    Scene scene;
    SurfaceFrame prev, next;

private:
    std::vector<double>& depths(const SurfaceFrame& frame) {
        return &frame == &prev ? prev_depths_ : next_depths_;
    }
    void refresh(SurfaceFrame& frame) {
        frame.vertices = std::make_unique<ExactVertices>(scene.width, scene.height, depths(frame));
    }
    std::vector<double> prev_depths_, next_depths_;
};

/// Contacts, forces and energy of a finger on a path.
struct PathResult {
    EnergyFigures energy;
    std::vector<Contact> contacts;
    std::vector<GuardedForce> forces;

    int ticks_with(GuardReason reason) const {
        int ticks = 0;
        for (const GuardedForce& force : forces) ticks += (force.reasons & reason) != 0;
        return ticks;
    }
    int touching() const {
        int ticks = 0;
        for (const Contact& contact : contacts) ticks += contact.touching;
        return ticks;
    }
};

/// A new finger along a path; `touch(finger, goal)` is a tick of the solver, `scale` its S.
template <class Touch>
PathResult run_path(const Path& path, const GuardSettings& settings, double scale, Touch touch) {
    PathResult result;
    ForceGuard guard(settings, scale);
    FingerState finger;
    for (const dvec3& goal : path) {
        result.contacts.push_back(touch(finger, goal));
        result.forces.push_back(guard.guard(result.contacts.back()));
    }
    result.energy = result.forces.back().energy;
    return result;
}
inline PathResult run_path(const Path& path, const GuardSettings& settings, const SmallField& field,
                           const TouchSettings& touch = {}) {
    return run_path(path, settings, 0.001, [&](FingerState& finger, const dvec3& goal) {
        return field.touch(finger, goal, 0, touch);
    });
}
inline PathResult run_path(const Path& path, const GuardSettings& settings, TouchRig& rig) {
    rig.lift_fingers();
    return run_path(path, settings, rig.settings.metres_per_scene_unit,
                    [&](FingerState&, const dvec3& goal) { return rig.tick(goal); });
}

/// One finger over a small field, by whole ticks.
struct StepRig {
    explicit StepRig(double depth = 100, DepthSemantics semantics = DepthSemantics::planar)
        : field(33, 33, depth, semantics) {
        guard.ramp_in_ticks = 0;
    }
    void begin() {
        solver.emplace(TouchSolver::create(field.scene, settings).value());
        step.emplace(*solver, guard, 1);
    }
    TouchTick run(std::int64_t tick, const FramePair& pair, const dvec3& goal) {
        step->goals()[0] = goal;
        return step->run(tick, tick * 1'000'000, field.scene, pair);
    }

    SmallField field;
    TouchSettings settings;
    GuardSettings guard;
    std::optional<TouchSolver> solver;
    std::optional<TouchStep> step;
};

/// A globe to press, slide along and retract from, on its flank 45 degrees from its axis; stiffness 1000 N/m,
/// no friction.
class GlobeFlank : public testing::Test {
protected:
    GlobeFlank() : rig("globe", sized(360, 240), TouchRig::Depth::codes) {
        rig.scene().default_properties = {1000, 0, 0};
    }
    /// From 1 mm outside straight in to 2 mm, 5 mm along, out and back through free space, in steps of
    /// `step_mm`, millimetres of the device; `limbward`: along away from the axis, or towards it.
    Path path(double azimuth, double step_mm, bool limbward) const {
        const GlobeSphere sphere = globe_sphere(CameraPreset::b, 360, 240);
        const double scale = 0.001 / rig.settings.metres_per_scene_unit, half = std::sqrt(0.5);
        const dvec3 aside{cosine(azimuth), sine(azimuth), 0}, axis{0, 0, 1};
        const dvec3 out = half * (aside + axis), along = half * (aside - axis);
        const dvec3 touching = sphere.centre + sphere.radius * out;
        auto at = [&](double mm_along, double mm_outside) {
            return touching + scale * (mm_along * along + mm_outside * out);
        };
        const double near = limbward ? -2.5 : 2.5, far = -near;
        return path_along({at(near, 1), at(near, -2), at(far, -2), at(far, 1), at(near, 1)}, step_mm * scale);
    }
    PathResult loop(double azimuth, double step_mm, bool limbward,
                    const GuardSettings& guard = without_ramp()) {
        return run_path(path(azimuth, step_mm, limbward), guard, rig);
    }

    TouchRig rig;
};

}  // namespace touchable::test
