#include "player/session/camera_figures.hpp"

#include <iterator>

namespace touchable {

/// Ticks are counted by the clock by which frames are taken; a force is there once its tick is solved.
Result<void> CameraFigures::take(const TouchTick& tick) {
    const TimedFrame& felt = tick.pair.prev;
    if (felt.number <= newest_) return {};
    newest_ = felt.number;
    ++shown_;
    constexpr std::ptrdiff_t most = 262144;  // two hours and a half at 30 frames a second
    if (std::ssize(latency_ms_) == most)
        latency_ms_.erase(latency_ms_.begin(), latency_ms_.begin() + most / 2);
    latency_ms_.push_back(static_cast<double>(tick.time_ns - felt.time_ns) * 1e-6 +
                          (tick.late_us + tick.solve_us) * 1e-3);
    return {};
}

CameraFacts CameraFigures::facts() const {
    return {frames_shown(), spread_of(latency_ms_)};
}

}  // namespace touchable
