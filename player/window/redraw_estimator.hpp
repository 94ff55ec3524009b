#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace touchable {

/// How long a picture takes in which the clip's frame is the one before, and only fingers or words have
/// changed: the window draws one between two frames where so much time is left. It is the median of the last
/// few, as one of them may have waited for decoding; with every frame that passes without one it becomes a
/// little less, so that a few slow ones are not the last; and one that takes less than half makes those
/// before it count no more, as when a clip plays on after a rest, in which more is drawn.
class RedrawEstimator {
public:
    /// Such a picture took so many ms.
    void add(double ms) {
        if (ms < ms_ / 2) next_ = 0;
        newest_[next_++ % newest_.size()] = ms;
        auto sorted = newest_;
        const std::size_t count = std::min(next_, sorted.size());
        std::sort(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(count));
        ms_ = sorted[(count - 1) / 2];
    }
    /// A picture of another frame was drawn.
    void add_frame() { ms_ *= 0.99; }

    /// 0: there was none yet.
    double ms() const { return ms_; }

private:
    std::array<double, 8> newest_{};
    std::size_t next_ = 0;
    double ms_ = 0;
};

}  // namespace touchable
