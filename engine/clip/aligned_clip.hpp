#pragma once

#include <memory>

#include "engine/base/result.hpp"
#include "engine/clip/clip_reader.hpp"

namespace touchable {

/// Whether depth without a scale gets one for all frames. Automatic: where it pumps, which some frames tell.
enum class DepthAlignment { automatic, on, off };

/// The clip with codes of one scale (ShotAlignment), of 16 bits: near and far are those of the whole clip.
/// All its frames are read once before, so that a frame is the same whichever frames were read before it;
/// where depth does not pump (automatic), and of a clip of one frame, it is the clip as it was. A note says
/// how far what stands still moved, before and after. Refused (`on`) where codes are not evenly spaced in
/// depth or in 1 / depth. The clip is at its beginning, before and after, with its colour.
Result<std::unique_ptr<ClipReader>> with_aligned_depth(std::unique_ptr<ClipReader> clip,
                                                       DepthAlignment wanted);

}  // namespace touchable
