#include "player/session/standard_stroke.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "engine/base/try.hpp"
#include "engine/surface/surface_builder.hpp"
#include "player/run/clip_workspace.hpp"
#include "player/run/field_probe.hpp"
#include "player/run/progress.hpp"
#include "player/run/surface_feed.hpp"
#include "player/run/touch_session.hpp"
#include "player/session/chosen_filters.hpp"

namespace touchable {

namespace {

constexpr const char* wandering = "wander:seed=1";

/// Goals of one finger that were given before.
class GoalsAgain final : public Hand {
public:
    explicit GoalsAgain(const ForceTable& before) : before_(before) {}
    int fingers() const override { return 1; }
    void goals_at(std::int64_t tick, const SurfaceProbe&, std::span<glm::dvec3> goals) override {
        goals[0] = before_.at(static_cast<std::size_t>(tick), 0).goal;
    }

private:
    const ForceTable& before_;
};

class ForcesInHand final : public TouchSink {
public:
    Result<void> take(const TouchTick& tick) override {
        table.samples.push_back({tick.goals[0], tick.forces[0].force, tick.contacts[0].touching});
        return {};
    }
    ForceTable table{1, {}};
};

/// Wanders, or repeats what was done `before`.
Result<Stroke> stroke(std::unique_ptr<ClipReader> reader, const Stroke* before) {
    reader->leave_out_colour();
    Scene scene = reader->scene();
    TRY(settle_filters(reader, reader->unstated_filters(), scene));
    auto builder = make_cpu_builder(scene);
    SurfaceFeed feed(std::move(reader), std::move(builder), scene);
    feed.leave_out_hash();
    TRY_ASSIGN(const auto first, feed.pair_at(0));
    Workspace workspace = clip_workspace(scene, *first.prev.frame);
    if (before) workspace.metres_per_scene_unit = before->metres_per_scene_unit;

    std::unique_ptr<Hand> hand;
    if (before) {
        hand = std::make_unique<GoalsAgain>(before->forces);
    } else {
        const HeightField field(scene, first);
        TRY_ASSIGN(auto made, make_hand(wandering, 1, workspace, FieldProbe(field)));
        hand = std::move(made);
    }
    TouchSessionSettings settings;
    settings.ticks = standard_stroke_ticks;
    settings.touch.metres_per_scene_unit = workspace.metres_per_scene_unit;
    TRY_ASSIGN(const auto solver, TouchSolver::create(scene, settings.touch));
    ForcesInHand forces;
    TickProgress progress(standard_stroke_ticks);
    std::array<TouchSink*, 2> sinks{&forces, &progress};
    TRY(TouchSession(scene, feed, *hand, solver, settings).run(sinks));
    return Stroke{std::move(forces.table), workspace.metres_per_scene_unit};
}

}  // namespace

Result<Stroke> standard_stroke(std::unique_ptr<ClipReader> clip) {
    return stroke(std::move(clip), nullptr);
}

Result<ForceComparison> compare_by_stroke(const Stroke& first, std::unique_ptr<ClipReader> second) {
    TRY_ASSIGN(const auto repeated, stroke(std::move(second), &first));
    return compare_forces(first.forces, repeated.forces);
}

}  // namespace touchable
