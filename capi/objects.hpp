#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "capi/frames.hpp"
#include "capi/handle_table.hpp"
#include "capi/status.hpp"
#include "capi/touchable.h"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/surface_builder.hpp"
#include "haptics_cpu/touch_step.hpp"

namespace touchable::capi {

/// Metres of each code, NaN of invalid ones; made when it is first asked for.
struct MetresOfCodes {
    std::once_flag once;
    std::vector<float> metres;
};

/// Behind a touch_scene. It does not change.
struct SceneObject {
    SceneDescription
        described;  ///< its scene is settled; `unstated` lists the filters that the text leaves open
    std::shared_ptr<MetresOfCodes> metres_of_codes = std::make_shared<MetresOfCodes>();
    const Scene& scene() const { return described.scene; }
};

/// Which frame it was, and when.
struct FramePlaceInTime {
    std::int64_t number = 0, time_ns = 0;
};

/// Behind a touch_surface. One thread pushes, one solver reads the timeline.
struct SurfaceObject {
    SurfaceObject(const Scene& scene, int threads, int frames)
        : scene(scene), builder(make_cpu_builder(scene, CpuPlan{threads})), timeline(frames) {}

    const Scene scene;
    std::atomic_flag pushing = ATOMIC_FLAG_INIT;  ///< guards what follows up to the timeline
    std::unique_ptr<SurfaceBuilder> builder;
    std::uint64_t epoch = 0;
    bool epoch_has_ended = false;
    std::optional<FramePlaceInTime> newest;  ///< of this epoch
    FrameScratch scratch;
    std::atomic<double> hand_scale{0};  ///< 0 until there is a frame
    SurfaceTimeline timeline;
    std::atomic<bool> has_solver{false};
};

HandleTable<SceneObject>& scenes();
HandleTable<SurfaceObject>& surfaces();

/// Behind a touch_solver. Its use of the surface keeps that from being destroyed.
struct SolverObject {
    SolverObject(HandleTable<SurfaceObject>::Use surface, const TouchSolver& solver,
                 const GuardSettings& guard, int fingers)
        : surface(std::move(surface)), solver(solver), step(this->solver, guard, fingers) {}
    ~SolverObject() { surface->has_solver.store(false, std::memory_order_release); }

    const HandleTable<SurfaceObject>::Use surface;
    const TouchSolver solver;
    std::atomic_flag ticking = ATOMIC_FLAG_INIT;  ///< guards what follows
    TouchStep step;
    ForceHash hash;
    std::optional<std::int64_t> last_tick;
    FramePair pair;
};

HandleTable<SolverObject>& solvers();

}  // namespace touchable::capi
