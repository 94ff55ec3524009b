#include "bench/capi/tick_run.hpp"

#include <algorithm>
#include <limits>
#include <memory>
#include <string>

#include "bench/clocks.hpp"
#include "capi/api_common.hpp"
#include "capi/touchable.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/content/scenes.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/surface_builder.hpp"
#include "haptics_cpu/touch_step.hpp"

namespace touchable {
namespace {

constexpr int path_ticks = 1000;

/// Two frames a second apart, so that every tick uses a blend of both, and a path of fingers over them.
struct TickPath {
    std::unique_ptr<AnalyticScene> scene;
    RawFrame first, second;
    std::vector<touch_vec3> goals;  ///< all fingers of tick 0, of tick 1, ...

    static Result<TickPath> make(int fingers) {
        SceneOptions options;
        options.width = 640;
        options.height = 480;
        auto scene = make_scene("globe", options);
        if (!scene) return scene.error();
        TickPath path{std::move(*scene), {}, {}, {}};
        path.first = path.scene->frame(0);
        path.second = path.scene->frame(1);
        path.second.time_ns = std::int64_t{path_ticks} * tick_length_ns;
        const DepthCoding& depth = path.scene->scene().depth;
        const double deep = depth.far * 0.45 + depth.near * 0.55;
        for (int tick = 0; tick < path_ticks; ++tick)
            for (int finger = 0; finger < fingers; ++finger) {
                const double phase = tick / 130.0 + finger;
                path.goals.push_back({0.1 * deep * sine(phase), 0.1 * deep * cosine(phase), -deep});
            }
        return path;
    }
};

/// Least CPU time per tick of a second of ticks, and the hash of its forces.
struct TimedSecond {
    double us_per_tick = std::numeric_limits<double>::infinity();
    std::uint64_t hash = 0;
    void take(std::int64_t began_ns, std::uint64_t now) {
        us_per_tick =
            std::min(us_per_tick, static_cast<double>(thread_cpu_ns() - began_ns) / 1e3 / path_ticks);
        hash = now;
    }
};

/// The solver without the C API, as called by the program's sessions.
class OwnTicks {
public:
    OwnTicks(const TickPath& path, double scale) : path_(path), timeline_(4) {
        const Scene& scene = path.scene->scene();
        const auto builder = make_cpu_builder(scene, CpuPlan{1});
        for (const RawFrame* frame : {&path.first, &path.second}) {
            (void)builder->build(*frame, *timeline_.acquire());
            (void)timeline_.publish(frame->number, frame->time_ns);
        }
        settings_.metres_per_scene_unit = scale;
    }
    Result<void> run(int fingers, TimedSecond& second) {
        const Scene& scene = path_.scene->scene();
        const auto solver = TouchSolver::create(scene, settings_);
        if (!solver) return solver.error();
        TouchStep step(*solver, GuardSettings{}, fingers);
        ForceHash hash;
        FramePair pair;
        const touch_vec3* goal = path_.goals.data();
        const std::int64_t began = thread_cpu_ns();
        for (std::int64_t tick = 0; tick < path_ticks; ++tick) {
            const std::int64_t time_ns = tick * tick_length_ns;
            timeline_.pair_at(time_ns, pair);
            for (glm::dvec3& to : step.goals()) {
                to = {goal->x, goal->y, goal->z};
                ++goal;
            }
            for (const GuardedForce& force : step.run(tick, time_ns, scene, pair).forces)
                hash.add(force.force);
        }
        second.take(began, hash.value());
        return {};
    }

private:
    const TickPath& path_;
    SurfaceTimeline timeline_;
    TouchSettings settings_;
};

/// The same with touchable.h. A surface's times cannot go back, so each second has its own surface.
class CTicks {
public:
    explicit CTicks(const TickPath& path) : path_(path), scene_(scene_to_json(path.scene->scene())) {
        for (const RawFrame* raw : {&path.first, &path.second}) {
            touch_frame frame = touch::frame();
            frame.number = raw->number;
            frame.time_ns = raw->time_ns;
            frame.depth = capi::plane_for_program(raw->depth);
            frame.haptic = capi::plane_for_program(raw->haptic);
            frame.height = capi::plane_for_program(raw->height);
            frames_.push_back(frame);
        }
    }
    double hand_scale() const {
        touch::Surface surface(scene_);
        surface.push(frames_[0]);
        return surface.hand_scale();
    }
    void run(int fingers, bool in_one_call, TimedSecond& second) {
        touch::Surface surface(scene_);
        for (const touch_frame& frame : frames_) surface.push(frame);
        touch_solver_settings settings = touch::solver_settings();
        settings.fingers = fingers;
        touch::Solver solver(surface, settings);
        const auto per_tick = static_cast<std::size_t>(fingers);
        contacts_.resize(per_tick * path_ticks);
        const std::int64_t began = thread_cpu_ns();
        if (in_one_call)
            solver.run(touch::tick_at(0), path_ticks, path_.goals.data(), contacts_.data());
        else
            for (std::size_t tick = 0; tick < path_ticks; ++tick)
                solver.tick(touch::tick_at(static_cast<std::int64_t>(tick)), &path_.goals[tick * per_tick],
                            &contacts_[tick * per_tick]);
        second.take(began, solver.force_hash());
    }
    std::int64_t touching() const {
        return std::count_if(contacts_.begin(), contacts_.end(),
                             [](const touch_contact& contact) { return contact.touching != 0; });
    }

private:
    const TickPath& path_;
    touch::Scene scene_;
    std::vector<touch_frame> frames_;
    std::vector<touch_contact> contacts_;
};

}  // namespace

Result<void> measure_c_ticks(int fingers, int repeats, Figures& figures) {
    auto path = TickPath::make(fingers);
    if (!path) return path.error();
    CTicks api(*path);
    TimedSecond own, tick, batch;
    for (int repeat = 0; repeat < repeats; ++repeat) {
        OwnTicks fresh(*path, api.hand_scale());  // restarts at time 0
        if (auto ran = fresh.run(fingers, own); !ran) return ran;
        api.run(fingers, false, tick);
        api.run(fingers, true, batch);
    }
    if (own.hash != tick.hash || own.hash != batch.hash)
        return Error{ErrorKind::check, "forces by touchable.h differ from the solver's own"};
    const auto touching = static_cast<double>(api.touching()) / (fingers * path_ticks);
    if (touching < 0.5) return Error{ErrorKind::check, "hardly anything was touched"};
    figures.insert(figures.end(), {{"own_us", own.us_per_tick, "us"},
                                   {"c_tick_us", tick.us_per_tick, "us"},
                                   {"c_batch_us", batch.us_per_tick, "us"},
                                   {"c_tick_ratio", tick.us_per_tick / own.us_per_tick, ""},
                                   {"c_batch_ratio", batch.us_per_tick / own.us_per_tick, ""},
                                   {"touching", 100 * touching, "%"}});
    return {};
}

}  // namespace touchable
