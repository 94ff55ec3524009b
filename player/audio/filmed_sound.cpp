#include "player/audio/filmed_sound.hpp"

#include <algorithm>

namespace touchable {
namespace {

constexpr std::int64_t fade_ms = 60;            // of what sounded when a session ended
constexpr std::int64_t longest_skip_ms = 1000;  // of ticks that are not known: longer, and the computer slept

}  // namespace

void FilmedSound::render(const HeardTick& tick, ClipSound& clip) {
    sound_.render(tick, clip, samples_);
    keep_(next_ms_++ * ContactSound::samples_per_tick, samples_);
}

void FilmedSound::skip_to(std::int64_t now_ms, const HeardTick& tick, ClipSound& clip) {
    const HeardTick silence = silence_after(tick);
    for (std::int64_t k = 0; k < fade_ms && next_ms_ < now_ms; ++k) render(silence, clip);
    next_ms_ = std::max(next_ms_, now_ms);
}

/// No tick comes before its time. Where one would be placed later than now, an earlier one had come late, so
/// it is left out, but for what happened in it.
void FilmedSound::take(const HeardTick& tick, std::int64_t passed, ClipSound& clip, std::int64_t now_ms) {
    if (aligns_.exchange(false, std::memory_order_relaxed) || passed > longest_skip_ms)
        skip_to(now_ms, tick, clip);
    else
        for (std::int64_t k = passed; k > 1; --k) render(going_on(tick), clip);
    const HeardTick now = early_ ? merged(*early_, tick) : tick;
    early_.reset();
    if (next_ms_ > now_ms)
        early_ = now;
    else
        render(now, clip);
}

}  // namespace touchable
