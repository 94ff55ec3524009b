#include "engine/stream/level_choice.hpp"

#include <algorithm>

namespace touchable {
namespace {

constexpr double quick_share = 0.5, slow_share = 0.2;  // of the newest segment in the means
constexpr double rate_to_spare = 2;
constexpr int segments_before_up = 4;

double in_seconds(std::int64_t ns) {
    return static_cast<double>(ns) * 1e-9;
}

}  // namespace

double LevelChoice::rate() const {
    return std::min(quick_, slow_);
}

double LevelChoice::need(bool of_low) const {
    const OfRenditions& needs = needs_[of_low ? 1 : 0];
    return needs[0] + needs[1];
}

void LevelChoice::leave_out_colour() {
    bytes_[1] = seconds_[1] = needs_[0][1] = needs_[1][1] = 0;
}

void LevelChoice::add(const FetchedSegment& fetched) {
    if (fetched.duration_ns <= 0) return;
    const bool failed = fetched.bytes <= 0;
    if (failed && fetched.fetch_ns <= fetched.duration_ns)
        return;  // a missing file tells nothing of the link
    const std::size_t k = fetched.is_touch ? 0 : 1;
    bytes_[k] = static_cast<double>(fetched.bytes);
    seconds_[k] = std::max(in_seconds(fetched.fetch_ns), 1e-9);
    if (!failed) needs_[fetched.is_low ? 1 : 0][k] = bytes_[k] / in_seconds(fetched.duration_ns);
    if (!fetched.is_touch) return;  // it is judged together with touch
    const double seconds = seconds_[0] + seconds_[1], newest = (bytes_[0] + bytes_[1]) / seconds;
    quick_ += (has_rate_ ? quick_share : 1) * (newest - quick_);
    slow_ += (has_rate_ ? slow_share : 1) * (newest - slow_);
    has_rate_ = true;
    if (!is_low_) {
        is_low_ = seconds > in_seconds(fetched.duration_ns) || rate() < need(false);
        good_ = 0;
        return;
    }
    good_ = rate() >= rate_to_spare * need(false) ? good_ + 1 : 0;
    is_low_ = good_ < segments_before_up;
}

}  // namespace touchable
