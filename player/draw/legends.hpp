#pragma once

// Text panels in a corner of a picture: the legend of fingers, and the marks of a scale.

#include <cstddef>
#include <functional>

#include "engine/base/result.hpp"
#include "engine/picture/image.hpp"
#include "player/draw/overlays.hpp"

namespace touchable {

/// Contents of a legend of fingers.
struct Legend {
    std::size_t fingers = 0;
    double pixels_per_newton = 1;  ///< length of an arrow across the line of sight, at the scene's middle
};

/// The force of the legend's arrow, N: the largest of 1, 2 and 5 times powers of ten whose arrow is at most
/// `pixels` long.
double scale_newtons(double pixels_per_newton, double pixels);

/// Draws a panel into the lower left of `image` (RGB, 8 bits): the meaning of ball, bubble, arrow and thread,
/// an arrow's length for a force, and the fingers' colours by number. Draws nothing below 480x270 pixels,
/// where it would hide the scene.
Result<void> draw_legend(const Legend& legend, Image& image);

/// A labelled value of a scale.
struct ScaleMark {
    double value;
    std::string text;
};

/// Round values within a range (1, 2 or 5 times a power of ten apart), as many as `fits` accepts. Never
/// empty: if not even two fit, the round value nearest to the middle.
std::vector<ScaleMark> scale_marks(const Overlays::Range& range,
                                   const std::function<bool(const std::vector<ScaleMark>&)>& fits);

}  // namespace touchable
