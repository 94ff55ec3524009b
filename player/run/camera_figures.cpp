#include "player/run/camera_figures.hpp"

namespace touchable {

/// Ticks are counted by the clock by which frames are taken; a force is there once its tick is solved.
Result<void> CameraFigures::take(const TouchTick& tick) {
    const TimedFrame& felt = tick.pair.prev;
    if (felt.number <= newest_) return {};
    newest_ = felt.number;
    ++shown_;
    const std::int64_t taken_ns = felt.time_ns - source_.taken_before(felt.number);
    latency_ms_.add(static_cast<double>(tick.time_ns - taken_ns) * 1e-6 +
                    (tick.late_us + tick.solve_us) * 1e-3);
    return {};
}

CameraFacts CameraFigures::facts() const {
    return {frames_shown(), latency_ms_.spread()};
}

}  // namespace touchable
