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

void SurfaceQueue::return_to(const MediaMoment& moment, std::int64_t frame) {
    if (!place_.is_of(moment)) place_ = first_place(moment.epoch, moment.start_ns, std::nullopt);
    // Frames before are only needed by a filter that remembers them; those from there on may have been read
    // already.
    if (!remembers_) place_.next_number = std::max(place_.next_number, frame);
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
    Published published = std::move(begun_.front());
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
    guard_ = guard;
    step_.emplace(*solver_, guard, fingers);
}

MediaMoment TouchRun::moment_at(std::int64_t tick) {
    log_->take(tick);
    return clock_.at(tick);
}

bool TouchRun::meet(std::int64_t tick, bool after_gap) {
    log_->take(tick);
    const PlaybackState now = clock_.state_at(tick);
    moment_ = now.moment;
    if (!surface_.timeline().pair_at(moment_, pair_)) return false;
    board_.set(now);
    meet(tick, tick * tick_ns, pair_, after_gap);
    return true;
}

bool TouchRun::meet(std::int64_t tick, const MediaMoment& moment) {
    moment_ = moment;
    const bool is_there = surface_.timeline().pair_at(moment, pair_);
    meet(tick, moment.time_ns, pair_);
    return is_there;
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

namespace {

constexpr std::uint64_t state_magic = 0x6e75726863756f74;  // "touchrun"
constexpr int state_version = 1;
constexpr std::int64_t last_commanded_tick = latest_moment_ns / tick_ns;

std::uint64_t hash_of(std::span<const std::uint8_t> bytes) {
    ByteHash hash;
    hash.add(bytes.data(), bytes.size());
    return hash.value();
}

/// What forces depend on in a frame, whatever builder made it.
void add_content(const SurfaceFrame& frame, ByteHash& hash) {
    std::vector<double> row(static_cast<std::size_t>(frame.width));
    for (int y = 0; y < frame.height; ++y) {
        for (int x = 0; x < frame.width; ++x) {
            const DepthSample at = frame.vertices->at(x, y);
            row[static_cast<std::size_t>(x)] = at.valid ? at.depth : -1;
        }
        hash.add(row.data(), row.size() * sizeof(double));
    }
    hash.add(frame.haptic.data(), frame.haptic.size());
    hash.add(frame.heights.data(), frame.heights.size() * sizeof(std::uint16_t));
}

/// What forces depend on beside frames, goals and state.
std::uint64_t settings_hash(const Scene& scene, TouchSettings touch, GuardSettings guard, int fingers) {
    StateBytes bytes;
    for (SceneNumber& number : numbers_of(scene)) bytes(number.value);
    std::int64_t first_ns = scene.rate.time_ns(1), later_ns = scene.rate.time_ns(1000);
    bytes(first_ns, later_ns, fingers, touch.metric, touch.metres_per_scene_unit, touch.event_limit,
          touch.cell_limit, touch.stribeck_speed, touch.sudden_speed, guard.max_force, guard.max_stiffness,
          guard.ramp_in_ticks, guard.ramp_out_ticks, guard.rise.paid, guard.rise.per_tick, guard.damping,
          guard.passivity, guard.waits_to_be_free, guard.stale_after_ns);
    return hash_of(bytes.written());
}

}  // namespace

/// All that is saved: what names the run, its clock, its last tick, and the state of fingers and hash.
struct TouchRun::Saved {
    std::uint64_t magic = state_magic, settings = 0;
    int version = state_version, rules = force_rules;
    std::int64_t tick = 0, time_ns = 0;
    MediaMoment moment;
    SavedPair pair;
    std::vector<PlaybackCommand> commands;

    void each_state(StateBytes& bytes, TouchStep& step, ForceHash& hash) {
        bytes(magic, version, rules, settings);
        bytes.expect(magic == state_magic && version == state_version && rules == force_rules);
        bytes(tick, time_ns, moment.epoch, moment.time_ns, moment.start_ns, pair.prev, pair.next, pair.blend,
              pair.epoch, pair.content);
        constexpr std::int64_t farthest = std::int64_t{1} << 60;
        for (const std::int64_t number : {tick, time_ns, moment.time_ns, moment.start_ns})
            bytes.expect(number >= -farthest && number <= farthest);
        std::uint64_t count = commands.size();
        bytes(count);
        bytes.expect(!bytes.reads() || count <= bytes.left() / 32);
        if (bytes.is_sound()) commands.resize(count);
        for (PlaybackCommand& command : commands)
            bytes(command.tick, command.verb, command.first, command.second);
        step.each_state(bytes);
        hash.each_state(bytes);
    }
};

TouchRun::SavedPair TouchRun::pair_now() const {
    SavedPair now{pair_.prev.number, pair_.next.number, pair_.blend, pair_.epoch};
    if (!pair_.prev.frame) return now;
    ByteHash content;
    add_content(*pair_.prev.frame, content);
    if (pair_.next.frame != pair_.prev.frame) add_content(*pair_.next.frame, content);
    now.content = content.value();
    return now;
}

std::vector<std::uint8_t> TouchRun::save() {
    Saved saved{.settings = settings_hash(surface_.scene(), solver_->settings(), guard_, fingers()),
                .tick = tick_,
                .time_ns = time_ns_,
                .moment = moment_,
                .pair = pair_now(),
                .commands = log_->commands()};
    StateBytes bytes;
    saved.each_state(bytes, *step_, hash_);
    std::uint64_t all = hash_of(bytes.written());
    bytes(all);
    return bytes.written();
}

Result<void> TouchRun::load(std::span<const std::uint8_t> bytes) {
    Saved saved;
    StateBytes in(bytes);
    TouchStep step(*solver_, guard_, fingers());
    ForceHash hash;
    saved.each_state(in, step, hash);
    const auto wrong = [](const std::string& what) {
        return input_error("the saved moment is " + what + "; save it again, by this version");
    };
    if (saved.magic != state_magic) return input_error("these bytes are no saved moment of a run");
    if (saved.version != state_version) return wrong("of version " + std::to_string(saved.version));
    if (saved.rules != force_rules) return wrong("of rules of force " + std::to_string(saved.rules));
    if (saved.settings != settings_hash(surface_.scene(), solver_->settings(), guard_, fingers()))
        return input_error("the moment was saved in a run of another scene, other settings or fingers");
    std::uint64_t all = 0;
    in(all);
    const bool is_whole = in.is_sound() && in.left() == 0 && all == hash_of(bytes.first(bytes.size() - 8));
    const bool is_clocked = saved.commands.empty() || saved.tick <= last_commanded_tick;
    if (!is_whole || !is_clocked || !validate(saved.commands)) return wrong("damaged");
    StateBytes again(bytes);
    saved.each_state(again, *step_, hash_);
    tick_ = saved.tick;
    time_ns_ = saved.time_ns;
    moment_ = saved.moment;
    expected_ = saved.pair;
    log_ = std::make_shared<PlaybackLog>(std::move(saved.commands), log_->room());
    clock_ = PlaybackClock(surface_.scene().rate, log_);
    surface_.return_to(moment_, expected_.prev);
    return {};
}

Result<void> TouchRun::resume() {
    surface_.timeline().pair_at(moment_, pair_);
    const SavedPair now = pair_now();
    if (now == expected_) return {};
    const auto in_words = [](const SavedPair& pair) {
        return std::to_string(pair.prev) + " and " + std::to_string(pair.next) + " of epoch " +
               std::to_string(pair.epoch);
    };
    if (now.prev == expected_.prev && now.next == expected_.next && now.epoch == expected_.epoch)
        return input_error("frames " + in_words(now) + " are not those on which the moment was saved");
    return input_error("the moment was saved on frames " + in_words(expected_) + "; those there are " +
                       in_words(now));
}

}  // namespace touchable
