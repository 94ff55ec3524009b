#pragma once

#include <memory>
#include <vector>

#include "engine/media/clip.hpp"

namespace touchable {

/// A clip of which these frames, its first ones, were read already: `next` gives them before it reads on, so
/// that looking ahead costs no second decoding.
std::unique_ptr<ClipReader> with_frames_in_hand(std::unique_ptr<ClipReader> reader,
                                                std::vector<RawFrame> frames);

}  // namespace touchable
