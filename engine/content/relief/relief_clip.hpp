#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/clip/clip_reader.hpp"
#include "engine/content/relief/relief_filter.hpp"
#include "engine/result.hpp"

namespace touchable {

/// The clip with heights that its colour suggests, in place of its own: codes of 8 bits, 128 is level, from
/// -max_height / 2 to max_height / 2 around it. Some frames are looked at first (telling_frames): they say
/// what the largest height stands for, and how much of it is the camera's noise. `max_height`: scene units,
/// more than 0; where that leaves no room before the camera it is half of the nearest depth, and a note says
/// so. `notes`: what else a person should know, before what is noted here. After the last frame a note says
/// how far heights flicker. Refused without colour.
Result<std::unique_ptr<ClipReader>> with_relief(std::unique_ptr<ClipReader> clip,
                                                const ReliefSettings& settings, double max_height,
                                                std::vector<std::string> notes = {});

}  // namespace touchable
