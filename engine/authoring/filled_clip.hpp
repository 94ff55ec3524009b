#pragma once

// Holes of depth, filled with what other frames saw there (docs/content.md): where a camera rests, what is
// behind a thing that moved. The clip is read once before it plays; a reader is one thread's, and a stop is
// heard between frames.

#include <memory>

#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"

namespace touchable {

/// The clip with holes of its depth filled from frames that saw what is behind (HoleFilling), where its
/// camera rests (CameraRest); RawFrame::filled says which. All frames are read once before, so that a frame
/// is the same whichever frames were read before it, and those of up to 32 places once more. What the camera
/// saw while it moved stays as it is, to the bit. A note says how large the share of holes is, before and
/// after, or why nothing is filled. Codes are those that some frame had. The clip is at its beginning, before
/// and after, with its colour, which goes on being read. Refused for live sources. Memory: per pixel 48 bytes
/// meanwhile, and 8 for each rest that is kept, of which as many are as 512 MiB hold.
Result<std::unique_ptr<ClipReader>> with_filled_holes(std::unique_ptr<ClipReader> clip);

}  // namespace touchable
