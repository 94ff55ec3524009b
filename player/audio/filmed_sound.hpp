#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <utility>

#include "player/audio/heard_sound.hpp"

namespace touchable {

/// Keeps the sound of a film in step with its pictures, while sessions end and others begin. Within a session
/// ticks count the time, and come a few at a time; between two sessions the film's own clock does.
class FilmedSound {
public:
    /// Takes samples; `first`: the number of the first of them in the film.
    using Keep = std::function<void(std::int64_t first, std::span<const StereoSample>)>;
    explicit FilmedSound(Keep keep) : keep_(std::move(keep)) {}

    /// Another session begins, after a time without ticks. Any thread.
    void align() { aligns_.store(true, std::memory_order_relaxed); }
    /// As WindowSound::take has it; `now_ms`: of the film.
    void take(const HeardTick& tick, std::int64_t passed, ClipSound& clip, std::int64_t now_ms);

private:
    void render(const HeardTick& tick, ClipSound& clip);
    void skip_to(std::int64_t now_ms, const HeardTick& tick, ClipSound& clip);

    Keep keep_;
    std::atomic<bool> aligns_{true};
    HeardSound sound_;
    std::int64_t next_ms_ = 0;
    std::optional<HeardTick> early_;  // what happened in ticks that were left out
    ContactSound::Samples samples_{};
};

}  // namespace touchable
