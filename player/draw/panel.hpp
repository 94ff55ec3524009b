#pragma once

#include <cairo.h>

#include <functional>
#include <string>

#include "engine/base/result.hpp"
#include "engine/picture/image_file.hpp"

/// Panels of words and signs in a corner of a picture, all of one style.
namespace touchable::panel {

// In pixels of a picture of 720 lines.
inline constexpr double margin = 16, padding = 12, row_height = 24, text_size = 14;

/// A picture's size in such pixels, and how many of its own each is.
struct Frame {
    double width, height, scale;
};

/// Draws into an image of RGB, 8 bits. Nothing into one below 480x270, where it would hide the scene.
/// `name`: of what is drawn, for messages.
Result<void> draw(Image& image, const std::string& name,
                  const std::function<void(cairo_t*, const Frame&)>& drawing);

/// The colour of words and signs, 0 to 1.
void ink(cairo_t* c, double opacity);
/// A dark ground for words; x and y of its upper left.
void ground(cairo_t* c, double x, double y, double width, double height);
double text_width(cairo_t* c, const std::string& text);

}  // namespace touchable::panel
