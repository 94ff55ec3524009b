#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>

#include "engine/base/result.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// What a person may ask of a clip's clock. The numbers are part of the recordings' format.
enum class PlaybackVerb : std::uint32_t {
    play = 0,
    pause = 1,
    rate = 2,   ///< `first`: thousandths of the clip's own speed
    seek = 3,   ///< `first`: where to, ns
    step = 4,   ///< on to the next frame, and pause
    loop = 5,   ///< from `first` to before `second`, ns, and again
    unloop = 6  ///< on beyond the loop's end
};

/// Takes effect with its tick.
struct PlaybackCommand {
    std::int64_t tick = 0;
    PlaybackVerb verb = PlaybackVerb::play;
    std::int64_t first = 0, second = 0;
    bool operator==(const PlaybackCommand&) const = default;
};

/// What is asked of a clip's clock, in order: all known before the run, or given while it runs. Then one
/// thread asks, and the haptic thread takes what was asked for at its next tick. The list only grows, in
/// memory that is there from the start; neither thread waits for the other.
class PlaybackLog {
public:
    /// Of all commands that there will be, in the order of their ticks.
    explicit PlaybackLog(std::vector<PlaybackCommand> commands) : PlaybackLog(std::move(commands), 0) {}
    /// With room for `more`. The ticks of those that are there are not above the first that is taken with.
    PlaybackLog(std::vector<PlaybackCommand> commands, std::size_t more);

    /// Whether commands may come.
    bool is_open() const { return is_open_; }
    /// One thread. Refused (ErrorKind::usage) where there is no room. Wait-free.
    Result<void> ask(PlaybackVerb verb, std::int64_t first, std::int64_t second);
    /// The thread that asks: whether anything that was asked for has no tick yet.
    bool is_waiting() const { return asked_.load(std::memory_order_relaxed) != size(); }
    /// Haptic thread, with ticks that go forward: what was asked for takes effect with this one. Wait-free.
    void take(std::int64_t tick);

    /// Any thread: how many have their tick. Those stay as they are.
    std::size_t size() const { return taken_.load(std::memory_order_acquire); }
    /// Below `size`.
    const PlaybackCommand& operator[](std::size_t k) const { return commands_[k]; }
    std::vector<PlaybackCommand> commands() const {
        return {commands_.begin(), commands_.begin() + static_cast<std::ptrdiff_t>(size())};
    }

private:
    const bool is_open_;
    std::vector<PlaybackCommand> commands_;       // from `taken_` to `asked_` without a tick yet
    alignas(64) std::atomic<std::size_t> asked_;  // stored by who asks
    alignas(64) std::atomic<std::size_t> taken_;  // stored by the haptic thread
};

inline constexpr std::int64_t slowest_rate = 1, fastest_rate = 8000;  ///< thousandths
inline constexpr std::int64_t shortest_loop_ns = 100'000'000;         ///< as long as a jump takes to fade
/// The latest moment that a command may name, ns: eleven days.
inline constexpr std::int64_t latest_moment_ns = 1'000'000'000'000'000;

/// Refuses (ErrorKind::input, the command named by its place from 1) ticks that are below 0 or go backward,
/// verbs that there are none, and rates, moments and loops out of their range.
Result<void> validate(const std::vector<PlaybackCommand>& commands);

/// What is wrong with a command after another one's tick; nothing where it will do.
std::optional<std::string> fault_after(std::int64_t tick_before, const PlaybackCommand& command);

/// Whether the clip may never come to the moments that it would have come to without the command. True of all
/// but play, pause and rate, which only change when the clip comes there.
bool leads_elsewhere(PlaybackVerb verb);

/// What a clip's clock is doing in a tick.
struct PlaybackState {
    MediaMoment moment;
    bool playing = true;
    std::int64_t rate = 1000;  ///< thousandths
    bool loops = false;
    std::int64_t loop_begin_ns = 0, loop_end_ns = 0;  ///< where it does
    bool at_end = false;  ///< the clip's last frame has been reached, and nothing leads away from it
};

/// An epoch that is to come.
struct ComingEpoch {
    std::uint64_t number = 0;
    std::int64_t start_ns = 0;
    std::int64_t left_ns = 0;  ///< no moment of the epoch before lies beyond
};

/// Which moment of the clip a tick is of: a pure function of commands and tick, in integers. Without commands
/// tick k is at k ms, of epoch 0. A seek and a loop's way back each begin a new epoch; within one times never
/// go backward. Rates are thousandths, so that a tick is a whole number of nanoseconds at each of them.
class PlaybackClock {
public:
    /// Of commands that `validate` passes; `rate` says how far a step goes.
    explicit PlaybackClock(const FrameRate& rate, std::vector<PlaybackCommand> commands = {})
        : PlaybackClock(rate, std::make_shared<const PlaybackLog>(std::move(commands))) {}
    /// Of commands some of which may be still to come, with ticks that this clock has not been asked for.
    PlaybackClock(const FrameRate& rate, std::shared_ptr<const PlaybackLog> log);

    /// Ticks must not go backward; which of them are asked for changes nothing. No lock, no allocation.
    MediaMoment at(std::int64_t tick);
    /// The same, with all that there is to say; but for the end, which this clock does not know.
    PlaybackState state_at(std::int64_t tick);
    /// Goes on to where the next epoch begins, by the commands that the clock knows; nothing where none is to
    /// come. For a reader that looks ahead, with a clock of its own.
    std::optional<ComingEpoch> next_epoch();
    /// After the last command that it knows the clip goes on to its end: neither paused nor in a loop.
    bool plays_to_the_end() const;

    // For a reader that looks ahead of commands that are still to come.
    const PlaybackLog& log() const { return *log_; }
    /// How many commands this clock knows: those that there were at its making, or when it was last asked.
    std::size_t known() const { return known_; }
    bool has_news() const { return log_->size() > known_; }
    /// Goes on to the newest command there is; of a clock that has not been led beyond it.
    MediaMoment at_newest_command();

private:
    /// From a tick on, until the next command or the loop's end.
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
    /// Of the next command or end of a loop; `never` where there is neither.
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

/// What the clip's clock is doing, for other threads than the haptic one: each sees one tick's whole state.
/// The writer does not wait; a reader looks again where it was written to while it read.
class PlaybackBoard {
public:
    /// Haptic thread; before it begins, the thread that starts it.
    void set(const PlaybackState& state) {
        const std::uint64_t writes = writes_.load(std::memory_order_relaxed);
        writes_.store(writes + 1, std::memory_order_relaxed);
        // With release: a thread that reads one of them sees that they are being written.
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
    alignas(64) std::atomic<std::uint64_t> writes_{0};  // twice the times it was written; odd: it is being
    std::atomic<std::uint64_t> epoch_{0};
    std::atomic<std::int64_t> time_ns_{0}, start_ns_{0}, rate_{1000}, loop_begin_ns_{0}, loop_end_ns_{0};
    std::atomic<bool> playing_{true}, loops_{false};
};

}  // namespace touchable
