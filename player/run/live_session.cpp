// SPDX-License-Identifier: Apache-2.0

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "player/run/surface_feed.hpp"
#include "player/run/touch_session.hpp"

namespace touchable {
namespace {

/// Statistics of a camera's frames, gathered tick by tick.
class CameraFigures {
public:
    /// `source` must outlive this. `first`: first frame that the run waits for; earlier ones existed at its
    /// start.
    CameraFigures(const ClipReader& source, std::int64_t first) : source_(source), newest_(first - 1) {}
    /// Ticks and frames share one clock; a force exists once its tick is solved.
    void consume(const TouchTick& tick) {
        const TimedFrame& felt = tick.pair.prev;
        if (felt.number <= newest_) return;
        newest_ = felt.number;
        ++shown_;
        const std::int64_t taken_ns = felt.time_ns - source_.taken_before(felt.number);
        latency_ms_.add(static_cast<double>(tick.time_ns - taken_ns) * 1e-6 +
                        (tick.late_us + tick.solve_us) * 1e-3);
    }
    std::int64_t frames_shown() const { return shown_; }
    LiveFacts::Camera facts() const { return {shown_, latency_ms_.spread()}; }

private:
    const ClipReader& source_;
    std::int64_t newest_;  // newest frame felt
    std::int64_t shown_ = 0;
    TimeSpread latency_ms_;
};

// Ticks that may wait for the sinks: four seconds, far longer than a disk's pauses.
constexpr int log_ticks = 4096;
constexpr std::chrono::milliseconds sink_pause(2);

/// Whether a frame published now was needed earlier: with `hold` from its own time on, with `linear` as soon
/// as the surface leaves the previous frame.
bool comes_late(const RawFrame& raw, const Scene& scene, const MediaMoment& now) {
    if (raw.epoch != now.epoch) return raw.epoch < now.epoch;
    if (scene.interpolation == FrameInterpolation::hold) return now.time_ns >= raw.time_ns;
    return now.time_ns > scene.rate.time_ns(raw.number - 1);
}

/// Starts a live source's clock with the hand's, so that no frame arrives before its exposure time.
Result<void> begin_source(const HapticLoop& loop, SurfaceFeed& feed, FeedThreads& threads) {
    while (!loop.zero() && loop.running()) std::this_thread::sleep_for(sink_pause);
    if (!loop.zero()) return {};
    TRY(feed.begin(*loop.zero()));
    return threads.start();
}

}  // namespace

LiveSession::LiveSession(SurfaceFeed& feed, HapticPort& port, const TouchSolver& solver,
                         const TouchSessionSettings& settings, std::shared_ptr<PlaybackLog> log)
    : feed_(feed),
      port_(port),
      settings_(settings),
      run_(feed.queue(), log ? std::move(log) : std::make_shared<PlaybackLog>(settings.playback), solver,
           settings.guard, settings.fingers) {}

bool LiveSession::is_over(const HapticLoop& loop, const std::optional<MediaMoment>& end) const {
    if (settings_.ticks) return loop.time_ns() >= (*settings_.ticks - 1) * tick_ns;
    if (run_.log().is_open()) return false;
    const std::size_t commands = run_.log().size();
    if (commands > 0 && loop.time_ns() / tick_ns < run_.log()[commands - 1].tick) return false;
    const MediaMoment now = run_.playback().moment;
    return end && now.epoch == end->epoch && now.time_ns + tick_ns >= end->time_ns &&
           loop.time_ns() + tick_ns >= shortest_run_ns;
}

/// Whether the hand continues: no failure of the clip, or an open log, which lets the hand outlast it.
bool LiveSession::outlasts(const FeedThreads& threads) {
    if (clip_failure_) return true;
    auto failed = threads.error();
    if (!failed) return true;
    if (!run_.log().is_open()) return false;
    const std::lock_guard lock(failure_mutex_);
    clip_failure_ = std::move(failed);
    return true;
}

void LiveSession::stop() {
    stopping_.store(true, std::memory_order_relaxed);
    const std::lock_guard lock(loop_mutex_);
    if (loop_) loop_->ask_to_stop();
}

/// Stops the loop at once if stop() was called before.
void LiveSession::set_loop(HapticLoop* loop) {
    const std::lock_guard lock(loop_mutex_);
    loop_ = loop;
    if (loop && stopping_.load(std::memory_order_relaxed)) loop->ask_to_stop();
}

Result<void> LiveSession::run(std::span<TouchSink* const> sinks) {
    if (stop_requested()) return interrupted_error();
    TickLog log(log_ticks, settings_.fingers);
    const Scene& scene = feed_.queue().scene();
    const bool live_source = feed_.reader().is_live();
    CameraFigures camera(feed_.reader(), feed_.frames());
    FeedThreads threads(
        feed_,
        [&](const RawFrame& raw) {
            const MediaMoment now = run_.playback().moment;
            // A command's target moment was unknown before, so its first frames are never late.
            const bool begins = run_.log().is_open() && raw.number <= scene.rate.frame_at(now.start_ns) + 1;
            return !live_source && !begins && comes_late(raw, scene, now);
        },
        run_.clock(), [this] { return run_.playback().moment; });
    HapticLoop loop(run_.ticks(), port_, log);

    const struct Known {
        Known(LiveSession& of, HapticLoop& loop) : session(of) { session.set_loop(&loop); }
        ~Known() { session.set_loop(nullptr); }
        LiveSession& session;
    } known(*this, loop);
    if (settings_.ticks) loop.end_before(*settings_.ticks);

    Result<void> taken;
    auto drain = [&] {
        const auto give = [&](const TouchTick& tick) {
            for (TouchSink* sink : sinks)
                if (taken) taken = sink->consume(tick);
            if (taken && live_source) camera.consume(tick);
        };
        while (log.pop(give)) {
        }
    };
    const auto is_asked_to_stop = [this] {
        facts_.interrupted = stop_requested();
        return facts_.interrupted || stopping_.load(std::memory_order_relaxed);
    };
    if (!live_source) {
        TRY(threads.start());
        // The first frame after the initial pair is the slowest, because memory is new: start the hand once
        // it is published, or if no frame can come before the hand starts.
        while (threads.published() == 0 && !threads.end() && !threads.waits_for_the_hand() &&
               !threads.error() && !is_asked_to_stop())
            std::this_thread::sleep_for(sink_pause);
    }
    TRY(loop.start());
    if (live_source) TRY(begin_source(loop, feed_, threads));
    std::size_t commands = run_.log().size();
    while (loop.running() && taken && outlasts(threads) && !is_asked_to_stop()) {
        const auto end = threads.end();
        if (end) clip_end_ns_.store(end->time_ns, std::memory_order_relaxed);
        if (is_over(loop, end) || (settings_.hand_is_over && settings_.hand_is_over())) break;
        if (const std::size_t there = run_.log().size(); there > std::exchange(commands, there))
            threads.look_at_commands();
        drain();
        late_frames_.store(threads.late_frames(), std::memory_order_relaxed);
        // With an open log a window shows these figures.
        if (settings_.on_status && live_source)
            settings_.on_status({true, camera.frames_shown(), end.has_value()});
        else if (settings_.on_status && !run_.log().is_open())
            settings_.on_status({false, threads.late_frames(), end.has_value()});
        std::this_thread::sleep_for(sink_pause);
    }
    loop.stop();
    threads.stop();
    drain();
    facts_.late_frames = threads.late_frames();
    if (live_source) facts_.camera = camera.facts();
    facts_.failure = threads.error();
    return conclude(loop, taken);
}

Result<void> LiveSession::run_tick(std::span<TouchSink* const> sinks) {
    if (stop_requested()) return interrupted_error();
    const std::int64_t tick = next_tick_++;
    const auto fed = clip_failure_ ? Result<void>(*clip_failure_) : feed_.feed_to(run_.moment_at(tick));
    const bool met = run_.meet(tick);
    if (!fed) {
        if (fed.error().kind == ErrorKind::interrupted || !run_.log().is_open() || !met) return fed;
        const std::lock_guard lock(failure_mutex_);  // the hand outlasts the clip
        if (!clip_failure_) facts_.failure = clip_failure_ = fed.error();
    } else if (!met) {
        return input_error("the clip has no frames; there is nothing to touch");
    }
    if (feed_.ended()) clip_end_ns_.store(feed_.end_ns(), std::memory_order_relaxed);
    if (!port_.read_goals(tick, run_.field(), run_.goals()))
        return device_error("the fingers have no places");
    for (std::size_t k = 0; k < run_.hops().size(); ++k) run_.hops()[k] = port_.hops(k);
    const TouchTick done = run_.solve();
    for (TouchSink* const sink : sinks) TRY(sink->consume(done));
    return {};
}

Error fell_behind_error(const std::string& files, std::int64_t ticks_missing) {
    const std::string slow = files.empty() ? "this machine was" : files + ": its disk or its reader was";
    return input_error(slow + " too slow for 1000 ticks a second: " + std::to_string(ticks_missing) +
                       " ticks are missing, so it is not complete, and no file is kept");
}

/// Fills in facts_ and returns the run's result.
Result<void> LiveSession::conclude(const HapticLoop& loop, const Result<void>& taken) {
    facts_.loop = loop.facts();
    if (!facts_.failure && facts_.loop.port_failed)
        facts_.failure = device_error("the device stopped answering in the middle of the session");
    if (!taken && facts_.loop.ticks == 0) return taken;
    if (!taken && !facts_.failure) facts_.failure = taken.error();
    if (facts_.loop.broke_off)
        return internal_error("the haptic thread met a fault of this program and ended");
    if (facts_.loop.ticks == 0 && facts_.failure) return *facts_.failure;
    if (facts_.loop.ticks == 0 && facts_.interrupted) return interrupted_error();
    facts_.sinks_fell_behind = facts_.loop.lost > 0;
    if (facts_.sinks_fell_behind) return fell_behind_error("what is written of the run", facts_.loop.lost);
    return {};
}

}  // namespace touchable
