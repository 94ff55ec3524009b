#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/frame/raw_frame.hpp"

namespace touchable {

/// How frames follow each other.
struct FrameTimes {
    std::int64_t frames = 0;
    std::int64_t repeated = 0;       ///< whose depth, haptic and height are those of the one before
    std::int64_t of_new_colour = 0;  ///< of those: colour has changed
    double usual_ms = 0;             ///< from one to the next, the median
    std::int64_t missing = 0;        ///< as many fit into longer times
    std::int64_t jumps = 0;  ///< times that stand still, go back, or follow within a quarter of the usual
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
};

}  // namespace touchable
