#pragma once

#include <functional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/picture/image_file.hpp"
#include "player/draw/overlays.hpp"

namespace touchable {

/// A value that a scale names.
struct ScaleMark {
    double value;
    std::string text;
};

/// Round values within a range (1, 2 or 5 times a power of ten apart), as many as find room: `fits` says
/// whether some do. Never none: where not even two fit, the one nearest to the middle.
std::vector<ScaleMark> scale_marks(const ValueRange& range,
                                   const std::function<bool(const std::vector<ScaleMark>&)>& fits);

/// Draws into the lower right of `image` (RGB, 8 bits; upper right of a narrow one) what its colours mean.
/// Nothing below 480x270 pixels, where it would hide the scene.
Result<void> draw_scale_bar(const OverlayScale& scale, Image& image);

}  // namespace touchable
