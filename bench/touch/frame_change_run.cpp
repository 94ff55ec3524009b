// SPDX-License-Identifier: Apache-2.0
#include "bench/touch/frame_change_run.hpp"

#include <algorithm>
#include <vector>

#include "bench/clocks.hpp"
#include "bench/touch/timing_run.hpp"
#include "engine/run/touch_run.hpp"

namespace touchable {
namespace {

constexpr int slots = 4;

/// Copies a built frame into other memory, as a builder would leave it.
void copy_frame(const SurfaceFrame& from, SurfaceFrame& to) {
    to.width = from.width;
    to.height = from.height;
    to.coding = from.coding;
    to.codes = from.codes;
    to.validity = from.validity;
    to.tiles = from.tiles;
    if (!to.vertices) to.vertices = std::make_unique<FilteredVertices>(to);
}

/// Publishes the frames of a surface in order.
class Publisher {
public:
    Publisher(const TouchSurface& surface, SurfaceTimeline& timeline)
        : surface_(surface), timeline_(timeline) {}

    /// Publishes until a frame is later than `time_ns`.
    Result<void> publish_past(std::int64_t time_ns) {
        const FrameRate& rate = surface_.scene().rate;
        while (next_ == 0 || rate.time_ns(next_ - 1) <= time_ns) {
            SurfaceFrame* slot = timeline_.acquire();
            if (slot == nullptr)
                return Error{ErrorKind::internal, "the timeline has no slot for a new frame"};
            copy_frame(*surface_.pair_at(rate.time_ns(next_)).prev.frame, *slot);
            if (auto published = timeline_.publish(next_, rate.time_ns(next_)); !published) return published;
            ++next_;
        }
        return {};
    }

private:
    const TouchSurface& surface_;
    SurfaceTimeline& timeline_;
    std::int64_t next_ = 0;
};

double at_share(std::vector<double>& values, double share) {
    std::sort(values.begin(), values.end());
    const auto rank = static_cast<std::size_t>(share * static_cast<double>(values.size()));
    return values.empty() ? 0 : values[std::min(rank, values.size() - 1)];
}

}  // namespace

Result<void> measure_frame_changes(const TouchSurface& surface, const FrameChangeRun& run, Figures& figures) {
    Scene scene = surface.scene();
    scene.default_properties = timing_grip;
    TouchSettings settings;
    settings.metric = run.setup.metric;
    settings.metres_per_scene_unit = scene.device_metres_per_unit.value();
    const auto solver = TouchSolver::create(scene, settings);
    if (!solver) return solver.error();
    const std::vector<glm::dvec3> goals = timing_goals(run.setup, run.ticks);

    SurfaceTimeline timeline(slots);
    Publisher publisher(surface, timeline);
    FingerState finger;
    Contact contact;
    std::vector<double> changed_us, other_us;
    std::int64_t last = -1;
    const double root = std::min({root_ns(), root_ns(), root_ns()});
    for (int k = 0; k < run.ticks; ++k) {
        const std::int64_t now = k * tick_length_ns;
        // Publish half a frame ahead, so that the copied data no longer fill the caches.
        if (auto published = publisher.publish_past(now + scene.rate.time_ns(1) / 2); !published)
            return published;
        const std::int64_t begin = monotonic_ns();
        FramePair pair;
        timeline.pair_at(now, pair);
        solver->tick(HeightField(scene, pair), {&goals[static_cast<std::size_t>(k)], 1}, {&finger, 1},
                     {&contact, 1});
        const double us = (static_cast<double>(monotonic_ns() - begin) - clock_costs().monotonic) / 1000.0;
        if (pair.next.frame == pair.prev.frame)
            return Error{ErrorKind::internal, "tick " + std::to_string(k) + " found no frame after its time"};
        (pair.prev.number != last && last >= 0 ? changed_us : other_us).push_back(us);
        last = pair.prev.number;
    }
    const double changed = at_share(changed_us, 0.5), other = at_share(other_us, 0.5);
    figures.push_back({"new_frame_us", changed - other, "us"});
    figures.push_back({"new_frame_roots", 1000 * (changed - other) / root, ""});
    figures.push_back({"new_frames", static_cast<double>(changed_us.size()), ""});
    figures.push_back({"new_frame_tick_us_p50", changed, "us"});
    figures.push_back({"new_frame_tick_us_p99", at_share(changed_us, 0.99), "us"});
    figures.push_back({"other_tick_us_p50", other, "us"});
    figures.push_back({"other_tick_us_p99", at_share(other_us, 0.99), "us"});
    return {};
}

}  // namespace touchable
