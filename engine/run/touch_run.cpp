// SPDX-License-Identifier: Apache-2.0
#include "engine/run/touch_run.hpp"

#include "engine/base/try.hpp"

namespace touchable {

SurfaceQueue::SurfaceQueue(const Scene& scene, std::unique_ptr<SurfaceBuilder> builder, int warm_up_frames,
                           SurfaceTimeline::Eye eye, int slots)
    : warm_up_frames_(FilterPlan(scene).remembers() ? warm_up_frames : 0),
      timeline_(slots > 0 ? slots : (eye == SurfaceTimeline::Eye::none ? 4 : 6), eye) {
    build_with(scene, std::move(builder));
}

void SurfaceQueue::build_with(const Scene& scene, std::unique_ptr<SurfaceBuilder> builder) {
    builder_ = std::move(builder);
    remembers_ = FilterPlan(scene).remembers();
    scene_.store(&scene, std::memory_order_release);
}

ReadPlace SurfaceQueue::first_place(std::uint64_t epoch, std::int64_t start_ns,
                                    std::optional<std::int64_t> frames) const {
    ReadPlace place{epoch, start_ns, scene().rate.frame_at(start_ns), 0};
    if (frames && *frames > 0) place.first_shown = std::min(place.first_shown, *frames - 1);
    place.next_number = std::max<std::int64_t>(0, place.first_shown - warm_up_frames_);
    return place;
}

bool SurfaceQueue::follow(const MediaMoment& moment, std::optional<std::int64_t> frames) {
    if (moment.epoch <= place_.epoch) return false;
    place_ = first_place(moment.epoch, moment.start_ns, frames);
    return true;
}

std::optional<std::int64_t> SurfaceQueue::wanted(const MediaMoment& moment, std::int64_t frames) {
    follow(moment, frames);
    const bool has_ended = place_.next_number >= frames;
    if (has_ended && timeline_.epoch() == place_.epoch) timeline_.end_epoch();
    if (has_ended || !timeline_.acquire()) return std::nullopt;
    return place_.next_number;
}

FedFrame SurfaceQueue::taken(RawFrame raw) {
    raw.epoch = place_.epoch;
    place_.next_number = raw.number + 1;
    const bool shown = raw.number >= place_.first_shown;
    return {std::move(raw), shown};
}

bool SurfaceQueue::has(const MediaMoment& moment) const {
    return timeline_.epoch() >= moment.epoch && timeline_.newest_time() > moment.time_ns;
}

bool SurfaceQueue::is_unchanged(const RawFrame& raw) const {
    if (!newest_ || newest_->epoch != raw.epoch || !same_touch_planes(*newest_, raw)) return false;
    return newest_->filled == raw.filled ||
           (newest_->filled && raw.filled && *newest_->filled == *raw.filled);
}

Result<void> SurfaceQueue::begin(FedFrame frame) {
    const RawFrame& raw = frame.raw;
    const bool unchanged = is_unchanged(raw);
    if (!unchanged) TRY(builder_->begin(raw));
    if (!unchanged && frame.shown) {
        newest_.reset();
        if (!remembers_ && raw.storage) newest_ = raw;
    }
    begun_.push_back({std::move(frame), unchanged});
    return {};
}

Result<std::optional<SurfaceQueue::Published>> SurfaceQueue::publish(const OnBuilt& on_built) {
    const auto& [fed, unchanged] = begun_.front();
    const RawFrame& raw = fed.raw;
    if (raw.epoch != timeline_.epoch()) timeline_.begin_epoch(raw.epoch);
    if (unchanged) {
        TRY_ASSIGN(const bool has_room, timeline_.republish(raw.number, raw.time_ns));
        if (!has_room) return std::optional<Published>();
    } else {
        SurfaceFrame* const slot = timeline_.acquire();
        if (!slot) return std::optional<Published>();
        newest_built_ = nullptr;
        TRY(builder_->finish(*slot));
        newest_built_ = slot;
        if (on_built) on_built(*slot);
        // A frame that is not shown stays in the writer's slot; the next one overwrites it.
        if (fed.shown) TRY(timeline_.publish(raw.number, raw.time_ns));
    }
    Published published{std::move(begun_.front().fed), unchanged};
    begun_.pop_front();
    return std::optional(std::move(published));
}

Result<std::optional<SurfaceQueue::Published>> SurfaceQueue::give(FedFrame frame, const OnBuilt& on_built) {
    if (frame.raw.epoch != timeline_.epoch()) timeline_.begin_epoch(frame.raw.epoch);
    begun_.clear();  // an unchanged frame that found no room
    if (!is_unchanged(frame.raw) && !timeline_.acquire()) return std::optional<Published>();
    TRY(begin(std::move(frame)));
    return publish(on_built);
}

Result<void> SurfaceQueue::forget() {
    newest_.reset();
    for (; !begun_.empty(); begun_.pop_front()) {
        if (begun_.front().unchanged) continue;
        SurfaceFrame* const slot = timeline_.acquire();
        if (!slot) return internal_error("there is no room to finish a frame that was begun");
        newest_built_ = nullptr;
        TRY(builder_->finish(*slot));
    }
    return {};
}

bool comes_late(const RawFrame& raw, const Scene& scene, const MediaMoment& now) {
    if (raw.epoch != now.epoch) return raw.epoch < now.epoch;
    if (scene.interpolation == FrameInterpolation::hold) return now.time_ns >= raw.time_ns;
    return now.time_ns > scene.rate.time_ns(raw.number - 1);
}

TouchRun::TouchRun(SurfaceQueue& surface, std::shared_ptr<PlaybackLog> log)
    : surface_(surface),
      log_(log ? std::move(log) : std::make_shared<PlaybackLog>(std::vector<PlaybackCommand>())),
      clock_(surface.scene().rate, log_) {
    board_.set(clock_.state_at(0));
}

TouchRun::TouchRun(SurfaceQueue& surface, std::shared_ptr<PlaybackLog> log, const TouchSolver& solver,
                   const GuardSettings& guard, int fingers)
    : TouchRun(surface, std::move(log)) {
    touch(solver, guard, fingers);
}

void TouchRun::touch(const TouchSolver& solver, const GuardSettings& guard, int fingers) {
    solver_ = solver;
    step_.emplace(*solver_, guard, fingers);
}

MediaMoment TouchRun::moment_at(std::int64_t tick) {
    log_->take(tick);
    return clock_.at(tick);
}

bool TouchRun::meet(std::int64_t tick, bool after_gap) {
    log_->take(tick);
    const PlaybackState now = clock_.state_at(tick);
    if (!surface_.timeline().pair_at(now.moment, pair_)) return false;
    board_.set(now);
    meet(tick, tick * tick_ns, pair_, after_gap);
    return true;
}

void TouchRun::meet(std::int64_t tick, std::int64_t time_ns, const FramePair& pair, bool after_gap) {
    tick_ = tick;
    time_ns_ = time_ns;
    pair_ = pair;
    surface_.timeline().show(tick);
    if (after_gap) step_->come_back();
}

TouchTick TouchRun::solve() {
    const TouchTick felt = step_->run(tick_, time_ns_, surface_.scene(), pair_);
    for (const GuardedForce& force : felt.forces) hash_.add(force.force);
    return felt;
}

HapticTicks TouchRun::ticks() {
    return {goals(), hops(),
            [this](std::int64_t tick, bool after_gap) {
                meet(tick, after_gap);
                return field();
            },
            [this] { return solve(); }};
}

}  // namespace touchable
