#pragma once

#include <iosfwd>
#include <memory>
#include <vector>

#include "tests/stress/suites.hpp"

namespace touchable::stress {

/// A goal and a moment, in steps that shrink well.
struct PickedTick {
    int x = 0, y = 0;  ///< eighths of a pixel
    int depth = 0;     ///< hundredths of the way from the camera to beyond the far plane
    int moment = 0;    ///< eighths from the first frame to the second, 0 to 7
};

/// A touch picked by RapidCheck: small enough to print, and to be made smaller where it fails.
struct PickedTouch {
    int width = 1, height = 1;
    DepthCodingKind kind = DepthCodingKind::linear;
    DepthSemantics semantics = DepthSemantics::planar;
    bool near_is_high = true, hold = false;
    int focal = 1, off_axis = 0;                       ///< eighths of the picture's width; pixels
    int friction = 0;                                  ///< tenths
    int height_share = 0;                              ///< of the nearest depth, hundredths, at the highest
    std::vector<std::uint8_t> first, second, heights;  ///< pictures; code 7 is invalid
    std::vector<PickedTick> ticks;

    Scene scene(double unit = 1) const;  ///< `unit`: how many scene units one of the picked is
};

std::ostream& operator<<(std::ostream& out, const PickedTouch& touch);

/// The touch, once or (`unit`) in other units.
std::unique_ptr<StressRun> run_of(const PickedTouch& touch, double unit = 1);

}  // namespace touchable::stress
