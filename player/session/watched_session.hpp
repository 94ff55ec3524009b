// SPDX-License-Identifier: Apache-2.0
#pragma once

// A live run with a watcher, such as a window.
//
// A WatchedSession is a LiveSession on threads of its own, made from a setup. `look` returns the frames, the
// blend and the tick that the hand holds, and the fingers' contacts and forces; figures count ticks and late
// frames; commands take effect at the next tick.
//
// Threads: the window's calls a session's `ask`, `look` and `stop`; any may call members under "Any thread".
// Only `stop` waits for the haptic thread.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <thread>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/scene/frames.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "player/run/touch_session.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {

/// A tick's goals, contacts and forces, per finger.
struct WatchedTick {
    struct Finger {
        glm::dvec3 goal{0.0};  ///< as given by the hand
        Contact contact;       ///< the goal used, proxy, whether it touches, local properties
        GuardedForce force;    ///< as sent to the hand, and why it differs from the spring's; no energy
    };
    std::int64_t tick = -1;
    std::vector<Finger> fingers;
};

/// What the hand touches at a tick, for drawing.
struct WatchedMoment {
    SurfaceTimeline::HeldPair held;    ///< its frames stay valid until the next look
    std::optional<HeldPlanes> stored;  ///< of the pair's frame nearer in time, if kept by its reader
    WatchedTick felt;                  ///< all fingers, at that tick or a few later

    PlaneView colour() const { return stored ? stored->colour : PlaneView{}; }  ///< empty: no colour
};

/// Figures of a running session.
struct WatchedFigures {
    struct Ticks {
        std::int64_t ticks = 0;
        std::int64_t late = 0;   ///< ticks that began a millisecond or more late
        double solve_us = 0;     ///< of the newest tick, us
        double late_us_p99 = 0;  ///< 99th percentile of all ticks, us, in steps of 10; 1000: that or later
    };
    FeedFigures feed;
    Ticks ticks;                   ///< so far
    std::int64_t late_frames = 0;  ///< except the two that begin an epoch
};

/// A live session on its own threads, with a watcher that draws it and commands the clip's clock. Runs until
/// stopped or until the device fails; when the clip ends or fails, its surface stands still. Never blocks the
/// haptic thread.
class WatchedSession : NonCopyable {
public:
    /// Limit of commands in a session: one every tenth of a second for an hour and a half.
    static constexpr std::size_t most_commands = 65536;

    /// Begins at once. `setup` was made for a watched live run. `sinks` get every tick on the session's own
    /// thread and must outlive it. Refused (ErrorKind::usage): playback commands of later ticks than 0, which
    /// only a run without a watcher takes.
    /// `stepped`: in virtual time, on the watcher's thread, which runs the ticks.
    static Result<std::unique_ptr<WatchedSession>> start(std::unique_ptr<TouchSetup> setup,
                                                         std::vector<TouchSink*> sinks, bool stepped = false);
    ~WatchedSession();  ///< calls stop

    /// Sends zero force, ends the threads, closes the device; the setup's settings then hold all commands.
    void stop();
    bool running() const { return running_.load(std::memory_order_acquire); }

    // One thread, the watcher's.
    /// Stepped: runs the next tick (LiveSession::run_tick); no effect after the end.
    void run_tick();
    /// Takes effect at the next tick. Refused (ErrorKind::usage): invalid commands, moments beyond the clip's
    /// end, any command to a camera or after the end, and more than `most_commands`.
    Result<void> ask(PlaybackVerb verb, std::int64_t first = 0, std::int64_t second = 0);
    /// Whether a command has yet to take effect; after the end it never will.
    bool is_asked() const { return log_->is_waiting(); }
    /// Number of commands that have taken effect.
    std::size_t commands() const { return log_->size(); }
    /// What the hand touched last; nullptr before the first tick. Waits only for a tick being copied.
    const WatchedMoment* look();

    // Any thread.
    PlaybackState playback() const;
    /// The clip's clock as applied to every tick.
    PlaybackClock clock() const { return {setup_->scene.rate, log_}; }
    WatchedFigures figures() const;
    /// As LiveSession::clip_failure.
    std::optional<Error> clip_failure() const { return live_->clip_failure(); }
    /// As ClipReader::remarks.
    std::vector<std::string> remarks() const { return setup_->feed->reader().remarks(); }
    /// silence_in_words, of the source at that moment.
    std::string silence(const WatchedMoment& moment) const;
    /// First frames after a cut, among the frames read so far.
    std::set<std::int64_t> cuts() const { return setup_->feed->cuts(); }

    // After the end.
    const LiveFacts& facts() const { return facts_; }
    /// Why it ended, unless stopped.
    std::optional<Error> failure() const { return ran_ ? facts_.failure : std::optional(ran_.error()); }
    TouchSetup& setup() { return *setup_; }

private:
    class Ticks;
    WatchedSession(std::unique_ptr<TouchSetup> setup, std::vector<TouchSink*> sinks);
    void run();
    void note_end();
    void close_devices();

    std::unique_ptr<TouchSetup> setup_;
    std::optional<std::int64_t> clip_end_ns_;
    std::shared_ptr<PlaybackLog> log_;
    std::unique_ptr<HapticPort> port_;
    std::optional<LiveSession> live_;
    std::unique_ptr<Ticks> ticks_;
    std::vector<TouchSink*> sinks_;
    WatchedMoment seen_;
    std::atomic<bool> running_{false};
    bool is_stopped_ = false;
    // Owned by the session's thread until it has ended.
    Result<void> ran_;
    LiveFacts facts_;
    std::thread thread_;
};

}  // namespace touchable
