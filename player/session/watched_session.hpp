#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <thread>
#include <vector>

#include "player/run/live_session.hpp"
#include "player/session/touch_setup.hpp"
#include "player/session/watched_ticks.hpp"

namespace touchable {

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
