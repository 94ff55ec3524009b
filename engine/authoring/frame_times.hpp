#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/scene/raw_frame.hpp"

namespace touchable {

/// How frames follow each other.
struct FrameTimes {
    std::int64_t frames = 0;
    /// Whose depth, haptic and height are those of the one before, though the surface moves: it changes
    /// within longest_repeat frames before and after. A surface that stands still for longer is no fault.
    std::int64_t repeated = 0;
    std::int64_t changed = 0;        ///< that are others than the one before
    std::int64_t of_new_colour = 0;  ///< of those: colour has changed
    static constexpr std::int64_t longest_repeat = 4;
    double usual_ms = 0;       ///< from one to the next, the median
    std::int64_t missing = 0;  ///< as many fit into longer times
    std::int64_t jumps = 0;    ///< times that stand still, go back, or follow within a quarter of the usual
    double longest_ms = 0;
    std::int64_t longest_at = 0;  ///< the frame after it
};

/// Looks at all frames of a clip, in order.
class FrameTimesEstimator {
public:
    void add(const RawFrame& frame);
    FrameTimes times() const;

private:
    FrameTimes so_far_;
    std::optional<RawFrame> before_;
    std::vector<std::int64_t> steps_ns_;
    std::int64_t same_ = 0, same_of_new_colour_ = 0;  // since the last change
};

}  // namespace touchable
