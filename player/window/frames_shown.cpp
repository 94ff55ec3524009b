#include "player/window/frames_shown.hpp"

namespace touchable {

void FramesShown::add(const FramePair& pair, std::int64_t now_ns, std::int64_t period_ns) {
    const bool is_next = pair.epoch == epoch_ && number_ >= 0 && pair.prev.number > number_;
    if (is_next) {
        due_ += pair.prev.number - number_;
        in_time_ += now_ns - pair.prev.time_ns <= period_ns;
    }
    epoch_ = pair.epoch;
    number_ = pair.prev.number;
}

}  // namespace touchable
