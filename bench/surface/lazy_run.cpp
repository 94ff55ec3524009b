// SPDX-License-Identifier: Apache-2.0
#include "bench/surface/lazy_run.hpp"

#include <array>
#include <memory>
#include <string>

#include "bench/tick_times.hpp"
#include "bench/touch/timing_run.hpp"
#include "engine/content/scenes.hpp"
#include "engine/surface/surface_builder.hpp"
#include "haptics_cpu/touch_solver.hpp"

namespace touchable {
namespace {

/// Ticks over 30 frames a second, all of one picture: a slot for each frame in use, which readers see as
/// distinct frames.
class FedRun final : public TimedRun {
public:
    /// `builds`: build frames within the ticks when due; otherwise all frames are built beforehand. All
    /// arguments except the builder must outlive this.
    FedRun(const Scene& scene, const RawFrame& raw, std::unique_ptr<SurfaceBuilder> builder, bool builds,
           const TouchSolver& solver, const std::vector<glm::dvec3>& goals, int fingers)
        : scene_(scene),
          raw_(raw),
          builder_(std::move(builder)),
          builds_(builds),
          solver_(solver),
          goals_(goals),
          fingers_(static_cast<std::size_t>(fingers)),
          contacts_(fingers_.size()) {}

    Result<void> fill() {
        for (SurfaceFrame& slot : slots_)
            if (auto built = builder_->build(raw_, slot); !built) return built;
        return {};
    }
    int ticks() const override { return static_cast<int>(goals_.size() / fingers_.size()); }
    void restart() override {
        fingers_.assign(fingers_.size(), {});
        built_ = 0;
    }
    void tick(int k) override {
        const std::int64_t now = k * tick_length_ns, number = now * 30 / 1'000'000'000;
        // Cannot fail: `fill` built the same frame.
        for (; builds_ && built_ <= number + 1; ++built_)
            static_cast<void>(builder_->build(raw_, slot(built_)));
        FramePair pair;
        pair.prev = {number, number * frame_ns, &slot(number)};
        pair.next = {number + 1, (number + 1) * frame_ns, &slot(number + 1)};
        pair.blend = static_cast<double>(now % frame_ns) / static_cast<double>(frame_ns);
        const auto goals =
            std::span(goals_).subspan(static_cast<std::size_t>(k) * fingers_.size(), fingers_.size());
        solver_.tick(HeightField(scene_, pair), goals, fingers_, contacts_);
    }
    std::span<const Contact> contacts() const { return contacts_; }

private:
    static constexpr std::int64_t tick_length_ns = 1'000'000, frame_ns = 33'333'333;
    SurfaceFrame& slot(std::int64_t number) {
        return slots_[static_cast<std::size_t>(number) % slots_.size()];
    }

    const Scene& scene_;
    const RawFrame& raw_;
    std::unique_ptr<SurfaceBuilder> builder_;
    const bool builds_;
    const TouchSolver& solver_;
    const std::vector<glm::dvec3>& goals_;
    std::array<SurfaceFrame, 3> slots_;
    std::int64_t built_ = 0;
    std::vector<FingerState> fingers_;
    std::vector<Contact> contacts_;
};

Result<void> check_forces(FedRun& lazy, FedRun& whole) {
    lazy.restart();
    whole.restart();
    int touching = 0;
    for (int k = 0; k < whole.ticks(); ++k) {
        lazy.tick(k);
        whole.tick(k);
        for (std::size_t finger = 0; finger < whole.contacts().size(); ++finger) {
            const Contact &a = lazy.contacts()[finger], &b = whole.contacts()[finger];
            if (a.touching != b.touching || a.force != b.force)
                return Error{ErrorKind::check,
                             "the lazy builder's force differs in tick " + std::to_string(k)};
            touching += b.touching;
        }
    }
    if (touching > 0) return {};
    return Error{ErrorKind::check, "no finger touches: there is nothing to time"};
}

/// `which`: suffix of the figures' names.
Result<void> measure_added(const Scene& scene, const RawFrame& raw, const TouchCase& c, bool quick,
                           const std::string& which, Figures& figures) {
    const bool has_target = c.fingers == 5 && c.median == 5;
    const int ticks = quick ? 2000 : 10000, repeats = has_target ? 30 : quick ? 3 : 5;
    TouchSettings settings;
    settings.metres_per_scene_unit = scene.device_metres_per_unit.value();
    const auto solver = TouchSolver::create(scene, settings);
    if (!solver) return solver.error();
    const std::vector<glm::dvec3> goals = timing_goals(c, ticks);
    FedRun lazy(scene, raw, make_lazy_builder(scene), true, *solver, goals, c.fingers);
    FedRun whole(scene, raw, make_cpu_builder(scene), false, *solver, goals, c.fingers);
    for (FedRun* run : {&lazy, &whole})
        if (auto filled = run->fill(); !filled) return filled.error();
    if (auto same = check_forces(lazy, whole); !same) return same.error();
    const TickTimes lazy_times = time_hot(lazy, repeats), whole_times = time_hot(whole, repeats);
    const double added = lazy_times.mean_us - whole_times.mean_us;
    figures.push_back({"lazy_us_per_tick_" + which, added, "us"});
    figures.push_back({"lazy_tick_us_p99_" + which, lazy_times.quantile_us(0.99), "us"});
    figures.push_back({"whole_tick_us_p99_" + which, whole_times.quantile_us(0.99), "us"});
    figures.push_back({"lazy_roots_per_tick_" + which, lazy_times.roots - whole_times.roots, ""});
    return {};
}

/// A picture of `bumps`, with the data for a stroke over it.
struct Bumps {
    std::unique_ptr<AnalyticScene> content;
    RawFrame raw;
    Scene scene;
    TouchCase c;
};
Result<Bumps> bumps_of(int width, int height, int bits) {
    SceneOptions options;
    options.width = width;
    options.height = height;
    options.bits = bits;
    auto content = make_scene("bumps", options);
    if (!content) return content.error();
    Bumps bumps{std::move(*content), {}, {}, {}};
    bumps.raw = bumps.content->frame(0);
    bumps.scene = bumps.content->scene();
    bumps.scene.default_properties = timing_grip;
    bumps.c.scene = "bumps";
    bumps.c.width = width;
    bumps.c.height = height;
    return bumps;
}

}  // namespace

Result<void> measure_lazy(int width, int height, bool quick, Figures& figures) {
    auto bumps = bumps_of(width, height, 16);
    if (!bumps) return bumps.error();
    auto& [content, raw, scene, c] = *bumps;
    for (const int median : {0, 3, 5})
        for (const int fingers : {1, 5, 10}) {
            c.median = scene.filter.median = median;
            c.fingers = fingers;
            const std::string which = std::to_string(fingers) + "f_m" + std::to_string(median);
            if (auto done = measure_added(scene, raw, c, quick, which, figures); !done) return done;
        }
    return {};
}

Result<void> measure_lazy_terraces(int width, int height, bool quick, Figures& figures) {
    auto bumps = bumps_of(width, height, 8);
    if (!bumps) return bumps.error();
    auto& [content, raw, scene, c] = *bumps;
    for (int reach = least_terrace_reach; reach <= most_terrace_reach; reach *= 2) {
        scene.filter = {.terraces = TerraceRemoval::on, .terrace_reach = reach};
        const std::string which = "1f_t" + std::to_string(reach);
        if (auto done = measure_added(scene, raw, c, quick, which, figures); !done) return done;
    }
    return {};
}

}  // namespace touchable
