#pragma once

// Panels of words and signs in a corner of a picture: a legend of fingers, and the marks of a scale.

#include <cstddef>
#include <functional>

#include "engine/base/result.hpp"
#include "engine/picture/image.hpp"
#include "player/draw/overlays.hpp"

namespace touchable {

/// What there is to explain in a picture of fingers.
struct Legend {
    std::size_t fingers = 0;
    double pixels_per_newton = 1;  ///< of an arrow across the line of sight, at the middle of the scene
};

/// The newtons of the legend's arrow: of 1, 2 and 5 times powers of ten the largest that is at most `pixels`
/// long.
double scale_newtons(double pixels_per_newton, double pixels);

/// Draws a panel into the lower left of `image` (RGB, 8 bits): what ball, bubble, arrow and thread are, how
/// long an arrow of so many newtons is, and the fingers' colours by number. Nothing below 480x270 pixels,
/// where it would hide the scene.
Result<void> draw_legend(const Legend& legend, Image& image);

/// A value that a scale names.
struct ScaleMark {
    double value;
    std::string text;
};

/// Round values within a range (1, 2 or 5 times a power of ten apart), as many as there is space for: `fits`
/// says whether some do. Never none: where not even two fit, the one nearest to the middle.
std::vector<ScaleMark> scale_marks(const Overlays::Range& range,
                                   const std::function<bool(const std::vector<ScaleMark>&)>& fits);

}  // namespace touchable
