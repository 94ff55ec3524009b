#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <utility>

#include "player/audio/window_sound.hpp"
#include "player/run/playback_clock.hpp"
#include "player/run/touch_session.hpp"

namespace touchable {

/// Hears what the fingers of one session do.
class TouchListener final : public TouchSink {
public:
    /// `sound` outlives it. `width`: of the clip, pixels.
    TouchListener(WindowSound& sound, int width) : sound_(sound), width_(width) {}
    /// Until then nothing is heard: one clip at a time, each after the session of the one before has ended.
    /// `clock` is the clip's, which ends at `end_ns`.
    void begin(PlaybackClock clock, std::int64_t end_ns) {
        clock_ = std::move(clock);
        end_ns_ = end_ns;
        sound_.begin_session();
        begun_.store(true, std::memory_order_release);
    }
    Result<void> take(const TouchTick& tick) override;

private:
    /// Of a finger, the tick before.
    struct Before {
        bool touching = false, stuck = false;
        glm::dvec3 goal{0.0}, force{0.0};
    };
    HeardFinger hear(const TouchTick& tick, std::size_t finger);
    HeardClip hear_clip(std::int64_t tick);

    WindowSound& sound_;
    int width_;
    std::atomic<bool> begun_{false};
    std::optional<PlaybackClock> clock_;  // once it has begun
    std::int64_t end_ns_ = 0;
    std::array<Before, HeardTick::most_fingers> before_{};
    std::int64_t last_tick_ = -1;
};

}  // namespace touchable
