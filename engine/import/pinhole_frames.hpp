#pragma once

#include <memory>

#include "engine/media/clip.hpp"
#include "engine/result.hpp"

namespace touchable {

/// A clip as one pinhole camera sees all of it: the lens of its depth is undone, and its colour brought onto
/// depth's pixels, where its scene has a `lens` or a `colour_camera`; the scene that it then gives has
/// neither. Other clips as they are.
///
/// Without its lens each pixel has the stored depth, haptic and height of the one nearest to where the lens
/// showed it; nothing is mixed. A picture of depth has no depth where the lens showed nothing.
Result<std::unique_ptr<ClipReader>> with_pinhole_frames(std::unique_ptr<ClipReader> clip);

}  // namespace touchable
