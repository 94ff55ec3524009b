#include "player/window/slow_reading.hpp"

namespace touchable {

void SlowReading::add(const WatchedFigures& figures, double period_ms) {
    constexpr std::int64_t least_late = 16, one_in = 4;
    if (figures.feed.frames == frames_) return;
    frames_ = figures.feed.frames;
    ++looks_;
    read_ms_ += figures.feed.read_ms;
    build_ms_ += figures.feed.build_ms;
    const std::int64_t late = figures.late_frames + figures.feed.dropped,
                       all = frames_ + figures.feed.dropped;
    is_why_ |=
        late >= least_late && one_in * late >= all && read_ms_ > build_ms_ && read_ms() >= 0.5 * period_ms;
}

}  // namespace touchable
