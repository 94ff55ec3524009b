#pragma once

#include <string>
#include <vector>

#include "engine/clip/clip_reader.hpp"

namespace touchable {

/// What a person should know of a clip's planes, once its first frame is there; `scene` is made to say what
/// grey haptic pictures mean (take_grey_haptic).
std::vector<std::string> describe_planes(const std::vector<TrackInfo>& tracks, const RawFrame& first,
                                         Scene& scene);

}  // namespace touchable
