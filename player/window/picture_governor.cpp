#include "player/window/picture_governor.hpp"

#include <algorithm>
#include <utility>

namespace touchable {

void PictureGovernor::go_to(std::size_t level, double now_s) {
    const bool rises = level < level_;
    // What was too much soon after it was tried is tried again later and later.
    if (!rises) wait_s_ = rose_ && now_s - changed_s_ < wait_s_ ? std::min(2 * wait_s_, most_s) : least_s;
    level_ = level;
    rose_ = rises;
    changed_s_ = now_s;
}

void PictureGovernor::add(double now_s, std::int64_t due, std::int64_t in_time, double drawing) {
    due_ += due;
    in_time_ += in_time;
    drawing_ += drawing;
    ++pictures_;
    if (due_ < few) return;
    const double drawing_each = drawing_ / static_cast<double>(pictures_);
    const bool is_late =
        drawing_each > cause && static_cast<double>(in_time_) < tolerated * static_cast<double>(due_);
    const double before = std::exchange(before_, 0);
    due_ = in_time_ = pictures_ = 0;
    drawing_ = 0;
    if (before > 0 && drawing_each > worth * before) {
        go_to(level_ - 1, now_s);
        not_before_s_ = now_s + most_s;
    } else if (is_late && level_ + 1 < shares.size() && now_s >= not_before_s_) {
        go_to(level_ + 1, now_s);
        before_ = drawing_each;
    } else if (!is_late && level_ > 0 && now_s - changed_s_ >= wait_s_) {
        const double larger = shares[level_ - 1] / shares[level_];
        if (drawing_each * larger * larger < room) go_to(level_ - 1, now_s);
    }
}

}  // namespace touchable
