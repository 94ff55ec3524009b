#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/scene/scene.hpp"
#include "engine/scene/surface_timeline.hpp"
#include "player/run/playback_log.hpp"

namespace touchable {

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
    explicit PlaybackClock(const FrameRate& rate, std::vector<PlaybackCommand> commands = {});
    /// Of commands some of which may be still to come, with ticks that this clock has not been asked for.
    PlaybackClock(const FrameRate& rate, std::shared_ptr<const PlaybackLog> log);

    /// Ticks must not go backward; which of them are asked for changes nothing. No lock, no allocation.
    MediaMoment at(std::int64_t tick);
    /// Likewise, with all that there is to say; but for the end, which this clock does not know.
    PlaybackState state_at(std::int64_t tick);
    /// Goes on to where the next epoch begins, by the commands that the clock knows; nothing where none is to
    /// come. For whoever looks ahead, with a clock of his own.
    std::optional<ComingEpoch> next_epoch();
    /// After the last command that it knows the clip goes on to its end: neither paused nor in a loop.
    bool plays_to_the_end() const;

    // For whoever looks ahead of commands that are still to come.
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

    void go_on_to(std::int64_t tick);
    std::int64_t time_at(std::int64_t tick) const;
    std::int64_t tick_of_loops_end() const;
    std::int64_t tick_of_next_turn() const;
    void turn();
    void apply(const PlaybackCommand& command);
    void begin_epoch(std::int64_t start_ns);

    FrameRate rate_;
    std::shared_ptr<const PlaybackLog> log_;
    std::size_t known_, applied_ = 0;
    State state_;
};

}  // namespace touchable
