#pragma once

#include <memory>

#include "engine/base/result.hpp"
#include "engine/clip/clip_reader.hpp"

namespace touchable {

/// A clip as one pinhole camera sees all of it: the lens of its depth is undone, and its colour brought onto
/// depth's pixels, where its scene has a `lens` or a `colour_camera`, and frames whose camera is another than
/// the scene's are brought onto that; the scene that it then gives has none of these. Other clips as they
/// are.
///
/// Each pixel then has the stored depth, haptic and height (and colour that has depth's pixels) of the one
/// nearest to where it was shown; nothing is mixed. A picture of depth has no depth where nothing was shown;
/// where other cameras make that necessary and every code is a depth, an error says so. Depth is not changed
/// by its new place, planar or range: both are what they were along the ray.
Result<std::unique_ptr<ClipReader>> with_pinhole_frames(std::unique_ptr<ClipReader> clip);

}  // namespace touchable
