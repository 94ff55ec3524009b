#pragma once

#include <vector>

#include "engine/clip/shot_alignment.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// What a finger that rests on what stands still feels of depth that changes from frame to frame.
struct RestingPulse {
    double hand_metres = 0;  ///< root mean square over cells and frames, of the device
    double newtons = 0;      ///< that times the scene's stiffness where no haptic picture says another
};
/// `lines` take the frames' cells to sixteenths of the scene's codes. The scale of the hand is the scene's,
/// or that by which the picture is 0.16 m wide at the median depth of frame 0.
RestingPulse resting_pulse(const std::vector<RestingCells>& resting, const std::vector<Line>& lines,
                           const Scene& scene, const CellPicture& first);

}  // namespace touchable
