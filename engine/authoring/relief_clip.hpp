#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/authoring/relief_estimator.hpp"
#include "engine/authoring/relief_filter.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip_reader.hpp"

namespace touchable {

/// A clip at its beginning, and what its relief is like.
struct LookedAt {
    std::unique_ptr<ClipReader> clip;
    ReliefRange range;
};
/// Looks at some frames (telling_frames) of a clip that is at its beginning: they say what the largest height
/// stands for, and how much of it is the camera's noise. Amount and direction change nothing of it. Refused
/// without colour.
Result<LookedAt> look_at_relief(std::unique_ptr<ClipReader> clip, const ReliefSettings& settings);

/// The clip with heights that its colour suggests, in place of its own: codes of 8 bits, 128 is level, from
/// -max_height / 2 to max_height / 2 around it. `max_height`: scene units, more than 0; where that leaves no
/// room before the camera it is half of the nearest depth, and a note says so. `notes`: what else a person
/// should know, before what is noted here. After the last frame a note says how far heights flicker.
Result<std::unique_ptr<ClipReader>> with_relief(std::unique_ptr<ClipReader> clip,
                                                const ReliefSettings& settings, const ReliefRange& range,
                                                double max_height, std::vector<std::string> notes = {});

}  // namespace touchable
