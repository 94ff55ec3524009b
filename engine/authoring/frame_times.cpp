#include "engine/authoring/frame_times.hpp"

#include <algorithm>
#include <cstddef>

namespace touchable {

void FrameTimesEstimator::add(const RawFrame& frame) {
    ++so_far_.frames;
    if (before_) {
        const std::int64_t step = frame.time_ns - before_->time_ns;
        const double ms = static_cast<double>(step) * 1e-6;
        steps_ns_.push_back(step);
        if (ms > so_far_.longest_ms) {
            so_far_.longest_ms = ms;
            so_far_.longest_at = frame.number;
        }
        if (same_touch_planes(*before_, frame)) {
            ++same_;
            same_of_new_colour_ += same_samples(before_->colour, frame.colour) ? 0 : 1;
        } else {
            if (same_ <= FrameTimes::longest_repeat && so_far_.changed > 0) {
                so_far_.repeated += same_;
                so_far_.of_new_colour += same_of_new_colour_;
            }
            same_ = same_of_new_colour_ = 0;
            ++so_far_.changed;
        }
    }
    before_ = frame;
}

FrameTimes FrameTimesEstimator::times() const {
    FrameTimes times = so_far_;
    if (steps_ns_.empty()) return times;
    std::vector<std::int64_t> sorted = steps_ns_;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    const std::int64_t usual = std::max<std::int64_t>(*middle, 1);
    times.usual_ms = static_cast<double>(usual) * 1e-6;
    for (const std::int64_t step : steps_ns_) {
        if (step > usual + usual / 2) times.missing += (step + usual / 2) / usual - 1;
        if (step < usual / 4) ++times.jumps;
    }
    return times;
}

}  // namespace touchable
