#pragma once

// A live session with a person beside it, who sees what the hand holds and gives commands: what a window
// runs.
//
// A WatchedSession owns a LiveSession and its threads. `look` shows the frames, the blend and the tick that
// the hand holds, and what fingers felt; figures count ticks and late frames; commands take effect with the
// next tick. open_port opens the hand: a device, a pointer, a script.
//
// The window's thread calls `ask`, `look` and `stop`; what stands under "Any thread" is any thread's. Only
// `stop` waits for the haptic thread.

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <thread>
#include <vector>

#include "haptics_cpu/haptic_loop.hpp"
#include "player/run/live_session.hpp"
#include "player/run/touch_session.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {

/// A finger in a tick.
struct WatchedFinger {
    glm::dvec3 goal{0.0};  ///< as the hand gave it
    Contact contact;       ///< the goal that was used, proxy, whether it touches, properties there
    GuardedForce force;    ///< as it was sent to the hand, and why it is not the spring's; no energy
};

struct WatchedTick {
    std::int64_t tick = -1;
    std::vector<WatchedFinger> fingers;
};

/// Of the ticks so far.
struct TickFigures {
    std::int64_t ticks = 0;
    std::int64_t late = 0;   ///< that began a millisecond or more too late
    double solve_us = 0;     ///< of the newest
    double late_us_p99 = 0;  ///< of all, in steps of 10; 1000 stands for all that were later
};

/// The newest tick, from the session's thread to a watcher's.
class WatchedTicks final : public TouchSink {
public:
    Result<void> take(const TouchTick& tick) override {
        const std::lock_guard lock(mutex_);
        figures_.late += tick.tick > newest_.tick + 1;
        ++figures_.ticks;
        figures_.solve_us = tick.solve_us;
        ++late_[std::min(static_cast<std::size_t>(std::max(tick.late_us, 0.0) / late_step_us),
                         late_.size() - 1)];
        newest_.tick = tick.tick;
        newest_.fingers.resize(tick.contacts.size());
        for (std::size_t k = 0; k < tick.contacts.size(); ++k)
            newest_.fingers[k] = {
                tick.goals[k], tick.contacts[k], {tick.sent(k), tick.forces[k].reasons, {}}};
        return {};
    }
    void copy_newest(WatchedTick& to) const {
        const std::lock_guard lock(mutex_);
        to = newest_;
    }
    TickFigures figures() const {
        const std::lock_guard lock(mutex_);
        TickFigures figures = figures_;
        std::int64_t later = 0;
        std::size_t step = late_.size();
        while (step > 0 && 100 * (later + late_[step - 1]) <= figures.ticks) later += late_[--step];
        figures.late_us_p99 = late_step_us * static_cast<double>(step);
        return figures;
    }

private:
    mutable std::mutex mutex_;
    WatchedTick newest_;
    TickFigures figures_;
    static constexpr double late_step_us = 10;
    std::array<std::int64_t, 100> late_{};  // ticks by how late they were
};

/// What a live session's haptic thread is plugged into: the hand, the device that it holds, or the one that a
/// person holds. Opens the device. `setup` outlives the port.
Result<std::unique_ptr<HapticPort>> open_port(TouchSetup& setup);

/// After a session: why its device stopped, it knows best.
void explain_failure(const TouchSetup& setup, LiveFacts& facts);

/// What the hand was at, for whoever draws it.
struct WatchedMoment {
    HeldPair held;                     ///< its frames stay whole until the next look
    std::optional<HeldPlanes> stored;  ///< of the pair's frame nearer in time, where its reader keeps them
    WatchedTick felt;                  ///< by every finger: of that tick or one a few later

    PlaneView colour() const { return stored ? stored->colour : PlaneView{}; }  ///< empty: it has none
};

/// How a session goes while it does.
struct WatchedFigures {
    FeedFigures feed;
    TickFigures ticks;
    std::int64_t late_frames = 0;  ///< but for the two that an epoch begins with
};

/// A live session on threads of its own, beside somebody who watches it and tells its clip's clock what to
/// do. It goes on until it is stopped, or the device fails: where the clip ends or fails, its surface
/// stands still. Nothing here keeps the haptic thread waiting.
class WatchedSession {
public:
    /// As many commands as a session takes: one every tenth of a second for an hour and a half.
    static constexpr std::size_t most_commands = 65536;

    /// Begins at once. `setup` was made for a live run that is watched. `sinks` get every tick, on the
    /// session's own thread, and outlive it. Refused (ErrorKind::usage): commands known before that are not
    /// of tick 0, which are those of a run that nobody watches.
    static Result<std::unique_ptr<WatchedSession>> start(std::unique_ptr<TouchSetup> setup,
                                                         std::vector<TouchSink*> sinks);
    ~WatchedSession();  ///< stops it
    WatchedSession(const WatchedSession&) = delete;
    WatchedSession& operator=(const WatchedSession&) = delete;

    /// Zero force, threads ended, the device closed, and the setup as after any run: its settings have all
    /// commands.
    void stop();
    bool running() const { return running_.load(std::memory_order_acquire); }

    // The watcher's, one thread.
    /// Takes effect with the next tick. Refused (ErrorKind::usage): what `validate` refuses, moments beyond
    /// the clip's end, anything of a camera, after the end, and once there are `most_commands`.
    Result<void> ask(PlaybackVerb verb, std::int64_t first = 0, std::int64_t second = 0);
    /// Whether a command is still to take effect; after the end it never will.
    bool is_asked() const { return log_->is_waiting(); }
    /// That have taken effect so far.
    std::size_t commands() const { return log_->size(); }
    /// What the hand was at last; nothing before the first tick. Waits for nobody but a copy of the same.
    const WatchedMoment* look();

    // Any thread.
    PlaybackState playback() const;
    /// The clip's clock, as every tick has met it.
    PlaybackClock clock() const { return {setup_->scene.rate, log_}; }
    WatchedFigures figures() const;
    /// As LiveSession::clip_failure.
    std::optional<Error> clip_failure() const { return live_->clip_failure(); }
    /// As ClipReader::remarks.
    std::vector<std::string> remarks() const { return setup_->feed->reader().remarks(); }
    /// Frames with which the clip showed something else all at once, of those that came by.
    std::set<std::int64_t> cuts() const { return setup_->feed->cuts(); }

    // After the end.
    const LiveFacts& facts() const { return facts_; }
    /// Why it ended, if not because it was to.
    std::optional<Error> failure() const;
    TouchSetup& setup() { return *setup_; }

private:
    WatchedSession(std::unique_ptr<TouchSetup> setup, std::vector<TouchSink*> sinks);
    void run();
    void close_devices();

    std::unique_ptr<TouchSetup> setup_;
    std::optional<std::int64_t> clip_end_ns_;
    std::shared_ptr<PlaybackLog> log_;
    std::unique_ptr<HapticPort> port_;
    std::optional<LiveSession> live_;
    WatchedTicks ticks_;
    std::vector<TouchSink*> sinks_;
    WatchedMoment seen_;
    std::atomic<bool> running_{false};
    // Of the session's thread, until it has ended.
    Result<void> ran_;
    LiveFacts facts_;
    std::thread thread_;
};

}  // namespace touchable
