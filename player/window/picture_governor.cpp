#include "player/window/picture_governor.hpp"

#include <algorithm>

namespace touchable {

void PictureGovernor::go_to(std::size_t level, double now_s) {
    const bool rises = level < level_;
    // What was too much soon after it was tried is tried again later and later.
    if (!rises) wait_s_ = rose_ && now_s - changed_s_ < wait_s_ ? std::min(2 * wait_s_, most_s) : least_s;
    level_ = level;
    rose_ = rises;
    changed_s_ = now_s;
}

void PictureGovernor::add(double now_s, std::int64_t due, std::int64_t in_time, double drawing,
                          bool coarse_saves) {
    // Where both are the same, coarse is the first level.
    const std::size_t least = coarse_saves ? 0 : 1;
    level_ = std::max(level_, least);
    due_ += due;
    in_time_ += in_time;
    drawing_ += drawing;
    ++pictures_;
    // That too many are late is known before all are due; what less has saved is not.
    const bool is_lowest = level_ + 1 == levels_.size(), is_judged = before_ > 0 && is_lowest;
    if (due_ < few && (is_judged || static_cast<double>(due_ - in_time_) <= (1 - tolerated) * few)) return;
    const double drawing_each = drawing_ / static_cast<double>(pictures_);
    const bool is_late =
        drawing_each > cause && static_cast<double>(in_time_) < tolerated * static_cast<double>(due_);
    due_ = in_time_ = pictures_ = 0;
    drawing_ = 0;
    if (before_ > 0 && (is_lowest || !is_late)) {
        judge(drawing_each, is_late, now_s);
    } else if (is_late && !is_lowest && now_s >= not_before_s_) {
        if (before_ == 0) {
            before_ = drawing_each;
            from_ = level_;
            judged_ = 0;
        }
        go_to(level_ + 1, now_s);
    } else if (!is_late && level_ > least && now_s - changed_s_ >= wait_s_) {
        if (drawing_each * levels_[level_ - 1].dearer < room) go_to(level_ - 1, now_s);
    }
}

/// Judged at the end of the way down: a step of it may save too little to be seen in the time, as long as
/// decoding wants what it leaves. Pictures just after a clip has opened, or beside a busy program, may take
/// as long as before whatever is saved: while they are late, more of them are looked at.
void PictureGovernor::judge(double drawing_each, bool is_late, double now_s) {
    const bool saves = drawing_each <= worth * before_;
    if (!saves && is_late && ++judged_ < judgements) return;
    before_ = 0;
    if (saves) return;
    go_to(from_, now_s);
    not_before_s_ = now_s + most_s;
}

}  // namespace touchable
