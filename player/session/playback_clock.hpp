#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "engine/frame/surface_timeline.hpp"
#include "engine/result.hpp"
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

inline constexpr std::int64_t slowest_rate = 1, fastest_rate = 8000;  ///< thousandths
inline constexpr std::int64_t shortest_loop_ns = 100'000'000;         ///< as long as a jump takes to fade
/// The latest moment that a command may name, ns: eleven days.
inline constexpr std::int64_t latest_moment_ns = 1'000'000'000'000'000;

/// Refuses (ErrorKind::input, the command named by its place from 1) ticks that are below 0 or go backward,
/// verbs that there are none, and rates, moments and loops out of their range.
Result<void> validate(const std::vector<PlaybackCommand>& commands);

/// What is wrong with a command after another one's tick; nothing where it will do.
std::optional<std::string> fault_after(std::int64_t tick_before, const PlaybackCommand& command);

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

    /// Ticks must not go backward; which of them are asked for changes nothing. No lock, no allocation.
    MediaMoment at(std::int64_t tick);
    /// Goes on to where the next epoch begins; nothing where none is to come. For whoever looks ahead, with a
    /// clock of his own.
    std::optional<ComingEpoch> next_epoch();
    /// After the last command the clip goes on to its end: neither paused nor in a loop.
    bool plays_to_the_end() const;
    const std::vector<PlaybackCommand>& commands() const { return commands_; }

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

    std::int64_t time_at(std::int64_t tick) const;
    std::int64_t tick_of_loops_end() const;
    std::int64_t tick_of_next_turn() const;
    void turn();
    void apply(const PlaybackCommand& command);
    void begin_epoch(std::int64_t start_ns);

    FrameRate rate_;
    std::vector<PlaybackCommand> commands_;
    std::size_t applied_ = 0;
    State state_;
};

}  // namespace touchable
