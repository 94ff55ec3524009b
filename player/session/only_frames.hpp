#pragma once

#include <memory>
#include <vector>

#include "engine/media/clip.hpp"
#include "player/session/planes_hash.hpp"

namespace touchable {

/// A clip of which only these frames are there: those that a live run got of its camera. Runs are in order.
std::unique_ptr<ClipReader> only_frames(std::unique_ptr<ClipReader> reader, std::vector<FrameRun> runs);

}  // namespace touchable
