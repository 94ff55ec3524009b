// SPDX-License-Identifier: Apache-2.0
#pragma once

// A clip's clock: which moment of the clip a tick meets, and the commands that a person gives it.
//
// A PlaybackClock computes the moment from the tick and a PlaybackLog of PlaybackCommands, in integers, so
// the same commands repeat a run. PlaybackControl is a person's side (play, pause, seek, loop), PlaybackBoard
// shows the clock's state to other threads.
//
// Threads: one gives commands to a log, one ticks the clock; neither waits for the other.

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/run/surface_timeline.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Commands to a clip's clock. The numbers are part of the recordings' format.
enum class PlaybackVerb : std::uint32_t {
    play = 0,
    pause = 1,
    rate = 2,   ///< `first`: thousandths of the clip's own speed
    seek = 3,   ///< `first`: target, ns
    step = 4,   ///< go to the next frame and pause
    loop = 5,   ///< repeat from `first` to before `second`, ns
    unloop = 6  ///< end the loop; play on beyond its end
};

/// Takes effect at its tick.
struct PlaybackCommand {
    std::int64_t tick = 0;
    PlaybackVerb verb = PlaybackVerb::play;
    std::int64_t first = 0, second = 0;
    bool operator==(const PlaybackCommand&) const = default;
};

/// Commands to a clip's clock, in order: all known before the run, or some given during it. Then one thread
/// adds commands with `ask`, and the haptic thread takes them at its next tick. The list only grows, in
/// memory allocated at the start; neither thread waits for the other.
class PlaybackLog {
public:
    /// `commands`: ordered by tick. `more`: room for others; the ticks of `commands` must then not exceed the
    /// first tick passed to `take`.
    explicit PlaybackLog(std::vector<PlaybackCommand> commands, std::size_t more = 0);

    /// Whether commands may come.
    bool is_open() const { return is_open_; }
    /// For how many more commands there is room. Called by the thread that calls `ask`.
    std::size_t room() const { return commands_.size() - asked_.load(std::memory_order_relaxed); }
    /// One thread only. Refused (ErrorKind::usage) if there is no room. Wait-free.
    Result<void> ask(PlaybackVerb verb, std::int64_t first, std::int64_t second);
    /// Called by the thread that calls `ask`: whether a command has no tick yet.
    bool is_waiting() const { return asked_.load(std::memory_order_relaxed) != size(); }
    /// Haptic thread, ticks must increase: gives all new commands this tick. Wait-free.
    void take(std::int64_t tick);

    /// Any thread: number of commands that have their tick. They no longer change.
    std::size_t size() const { return taken_.load(std::memory_order_acquire); }
    /// `k` < size().
    const PlaybackCommand& operator[](std::size_t k) const { return commands_[k]; }
    std::vector<PlaybackCommand> commands() const {
        return {commands_.begin(), commands_.begin() + static_cast<std::ptrdiff_t>(size())};
    }

private:
    const bool is_open_;
    std::vector<PlaybackCommand> commands_;       // those from `taken_` to `asked_` have no tick yet
    alignas(64) std::atomic<std::size_t> asked_;  // stored by the thread that calls `ask`
    alignas(64) std::atomic<std::size_t> taken_;  // stored by the haptic thread
};

inline constexpr std::int64_t slowest_rate = 1, fastest_rate = 8000;  ///< thousandths
inline constexpr std::int64_t shortest_loop_ns = 100'000'000;         ///< time in which a jump fades
/// The latest moment that a command may name, ns: eleven days.
inline constexpr std::int64_t latest_moment_ns = 1'000'000'000'000'000;
/// A person's seconds.
inline std::int64_t nanoseconds_of(double seconds) {
    return std::llround(seconds * 1e9);
}

/// Refuses (ErrorKind::input, naming the command by its place from 1) ticks that are negative or decrease,
/// unknown verbs, and rates, moments and loops out of range.
Result<void> validate(const std::vector<PlaybackCommand>& commands);

/// What is wrong with a command that follows one at `tick_before`; nothing: valid.
std::optional<std::string> fault_after(std::int64_t tick_before, const PlaybackCommand& command);

/// State of a clip's clock at a tick.
struct PlaybackState {
    MediaMoment moment;
    bool playing = true;
    std::int64_t rate = 1000;  ///< thousandths
    bool loops = false;
    std::int64_t loop_begin_ns = 0, loop_end_ns = 0;  ///< valid if `loops`
    bool at_end = false;  ///< the clip's last frame is reached and no loop leads away from it
};

/// The state of a clip that ends at `end_ns` (0: unknown): its clock goes on, the clip stands still.
PlaybackState until_end(PlaybackState state, const FrameRate& rate, std::int64_t end_ns);

/// A coming epoch.
struct ComingEpoch {
    std::uint64_t number = 0;
    std::int64_t start_ns = 0;
    std::int64_t left_ns = 0;  ///< the previous epoch's last moment
};

/// Maps a tick to a moment of the clip: a pure function of commands and tick, in integers. Without commands
/// tick k is at k ms in epoch 0. A seek and a loop's way back each begin a new epoch; within an epoch time
/// never decreases. Rates are thousandths, so that a tick is a whole number of nanoseconds at any rate.
class PlaybackClock {
public:
    /// `commands` must pass `validate`; `rate`: frame rate, for steps.
    explicit PlaybackClock(const FrameRate& rate, std::vector<PlaybackCommand> commands = {})
        : PlaybackClock(rate, std::make_shared<const PlaybackLog>(std::move(commands))) {}
    /// With a log that may still grow, by commands at later ticks than this clock was called with.
    PlaybackClock(const FrameRate& rate, std::shared_ptr<const PlaybackLog> log);

    /// Ticks must not decrease; skipping ticks changes nothing. No lock, no allocation.
    MediaMoment at(std::int64_t tick);
    /// The whole state at a tick, except at_end: this clock does not know the clip's length.
    PlaybackState state_at(std::int64_t tick);
    /// Advances to the next epoch's beginning by the commands known to this clock; nothing: none comes. For a
    /// prefetching reader with a clock of its own.
    std::optional<ComingEpoch> next_epoch();
    /// Whether the clip plays to its end after the last known command: neither paused nor in a loop.
    bool plays_to_the_end() const;

    // For a prefetching reader while commands may still come.
    const PlaybackLog& log() const { return *log_; }
    /// Number of commands known to this clock: those in the log at its construction or last
    /// at_newest_command.
    std::size_t known() const { return known_; }
    bool has_news() const { return log_->size() > known_; }
    /// Advances to the log's newest command; this clock must not be beyond it.
    MediaMoment at_newest_command();

private:
    /// Valid from a tick until the next command or the loop's end.
    struct State {
        std::int64_t tick = 0;
        MediaMoment moment;  // at that tick
        std::int64_t ns_per_tick = 1'000'000;
        bool playing = true;
        std::int64_t loop_begin = 0, loop_end = never;
    };
    static constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max();

    void go_on_to(std::int64_t tick) {
        while (tick_of_next_turn() <= tick) turn();
    }
    std::int64_t time_at(std::int64_t tick) const;
    std::int64_t tick_of_loops_end() const;
    /// Tick of the next command or loop's end; `never`: neither.
    std::int64_t tick_of_next_turn() const {
        return applied_ < known_ ? std::min((*log_)[applied_].tick, tick_of_loops_end())
                                 : tick_of_loops_end();
    }
    void turn();
    void apply(const PlaybackCommand& command);
    void begin_epoch(std::int64_t start_ns) { state_.moment = {state_.moment.epoch + 1, start_ns, start_ns}; }

    FrameRate rate_;
    std::shared_ptr<const PlaybackLog> log_;
    std::size_t known_, applied_ = 0;
    State state_;
};

/// The user's control of a clip's playback. Errors (ErrorKind::usage) come from `ask`.
class PlaybackControl {
public:
    static constexpr double slowest = 0.1, fastest = 4;  ///< times the clip's own speed
    using State = std::function<PlaybackState()>;
    using Ask = std::function<Result<void>(PlaybackVerb, std::int64_t first, std::int64_t second)>;

    /// `frames`: 0 if unknown. `state`: of the clip's clock now; `ask`: gives it a command.
    PlaybackControl(const FrameRate& rate, std::int64_t frames, State state, Ask ask)
        : rate_(rate), frames_(frames), state_(std::move(state)), give_(std::move(ask)) {}

    /// At the end, plays again from the beginning.
    Result<void> play_or_pause();
    Result<void> pause(bool on) { return ask(on ? PlaybackVerb::pause : PlaybackVerb::play); }
    void seek_to(double seconds);
    void seek_by(double seconds) {
        seek_to(static_cast<double>(wanted_ns_.value_or(state_().moment.time_ns)) * 1e-9 + seconds);
    }
    /// Steps a frame forward, or back if `frames` is negative; and pauses.
    Result<void> step(double frames);
    /// Clamped to slowest and fastest.
    Result<void> set_speed(double times) {
        return ask(PlaybackVerb::rate, std::lround(std::clamp(times, slowest, fastest) * 1000));
    }
    Result<void> change_speed(double factor) {
        return set_speed(factor * static_cast<double>(state_().rate) / 1000);
    }
    /// Restarts the clip with its initial commands, playing; `loops`: loops at least the whole clip, if it is
    /// long enough.
    Result<void> begin_anew(std::span<const PlaybackCommand> first, bool loops);
    /// Switches looping from end to beginning.
    Result<void> toggle_loop();
    /// Once a turn: seeks to the wanted moment, one seek at a time. So dragging the seek bar shows every
    /// place that there is time for, and finally the last. `shown`: the frames shown now; null: none.
    Result<void> go_on(const FramePair* shown);

private:
    Result<void> ask(PlaybackVerb verb, std::int64_t first = 0, std::int64_t second = 0) {
        return give_(verb, first, second);
    }

    FrameRate rate_;
    std::int64_t frames_;
    State state_;
    Ask give_;
    std::optional<std::int64_t> wanted_ns_;  // clip time to seek to
};

/// Publishes the clock's state to other threads (seqlock): each reader gets one tick's whole state. The
/// writer never waits; a reader retries if a write overlapped its read.
class PlaybackBoard {
public:
    /// Called by the haptic thread; before it starts, by the thread that starts it.
    void set(const PlaybackState& state) {
        const std::uint64_t writes = writes_.load(std::memory_order_relaxed);
        writes_.store(writes + 1, std::memory_order_relaxed);
        // Release: a thread that reads a new value also sees the odd count.
        constexpr auto release = std::memory_order_release;
        epoch_.store(state.moment.epoch, release);
        time_ns_.store(state.moment.time_ns, release);
        start_ns_.store(state.moment.start_ns, release);
        playing_.store(state.playing, release);
        rate_.store(state.rate, release);
        loops_.store(state.loops, release);
        loop_begin_ns_.store(state.loop_begin_ns, release);
        loop_end_ns_.store(state.loop_end_ns, release);
        writes_.store(writes + 2, release);
    }

    PlaybackState read() const {
        constexpr auto acquire = std::memory_order_acquire;
        while (true) {
            const std::uint64_t writes = writes_.load(acquire);
            PlaybackState state;
            state.moment = {epoch_.load(acquire), time_ns_.load(acquire), start_ns_.load(acquire)};
            state.playing = playing_.load(acquire);
            state.rate = rate_.load(acquire);
            state.loops = loops_.load(acquire);
            state.loop_begin_ns = loop_begin_ns_.load(acquire);
            state.loop_end_ns = loop_end_ns_.load(acquire);
            if (writes % 2 == 0 && writes_.load(std::memory_order_relaxed) == writes) return state;
        }
    }
    MediaMoment moment() const { return read().moment; }

private:
    alignas(64) std::atomic<std::uint64_t> writes_{0};  // twice the number of writes; odd: during a write
    std::atomic<std::uint64_t> epoch_{0};
    std::atomic<std::int64_t> time_ns_{0}, start_ns_{0}, rate_{1000}, loop_begin_ns_{0}, loop_end_ns_{0};
    std::atomic<bool> playing_{true}, loops_{false};
};

}  // namespace touchable
