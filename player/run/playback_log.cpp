#include "player/run/playback_log.hpp"

#include <string>
#include <utility>

namespace touchable {

PlaybackLog::PlaybackLog(std::vector<PlaybackCommand> commands, std::size_t more)
    : is_open_(more > 0), commands_(std::move(commands)), asked_(commands_.size()), taken_(commands_.size()) {
    commands_.resize(commands_.size() + more);
}

Result<void> PlaybackLog::ask(PlaybackVerb verb, std::int64_t first, std::int64_t second) {
    const std::size_t at = asked_.load(std::memory_order_relaxed);
    if (at == commands_.size())
        return usage_error("playback: " + std::to_string(at) +
                           " commands were given, which is all that a session takes; begin another");
    commands_[at] = {0, verb, first, second};
    asked_.store(at + 1, std::memory_order_release);
    return {};
}

void PlaybackLog::take(std::int64_t tick) {
    const std::size_t asked = asked_.load(std::memory_order_acquire);
    std::size_t at = taken_.load(std::memory_order_relaxed);
    if (at == asked) return;
    for (; at < asked; ++at) commands_[at].tick = tick;
    taken_.store(asked, std::memory_order_release);
}

std::vector<PlaybackCommand> PlaybackLog::commands() const {
    return {commands_.begin(), commands_.begin() + static_cast<std::ptrdiff_t>(size())};
}

}  // namespace touchable
