#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "engine/base/result.hpp"

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
/// memory that is there from the start; nobody waits for anybody.
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
    /// Who asks: whether anything that was asked for has no tick yet.
    bool is_waiting() const { return asked_.load(std::memory_order_relaxed) != size(); }
    /// Haptic thread, with ticks that go forward: what was asked for takes effect with this one. Wait-free.
    void take(std::int64_t tick);

    /// Any thread: how many have their tick. Those stay as they are.
    std::size_t size() const { return taken_.load(std::memory_order_acquire); }
    /// Below `size`.
    const PlaybackCommand& operator[](std::size_t k) const { return commands_[k]; }
    std::vector<PlaybackCommand> commands() const;

private:
    const bool is_open_;
    std::vector<PlaybackCommand> commands_;       // from `taken_` to `asked_` without a tick yet
    alignas(64) std::atomic<std::size_t> asked_;  // stored by who asks
    alignas(64) std::atomic<std::size_t> taken_;  // stored by the haptic thread
};

}  // namespace touchable
