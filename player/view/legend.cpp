#include "player/view/legend.hpp"

#include <cairo.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "player/view/finger_marks.hpp"

namespace touchable {
namespace {

using Surface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;
using Context = std::unique_ptr<cairo_t, decltype(&cairo_destroy)>;

// Of the panel, in pixels of a picture of 720 lines.
constexpr double margin = 16, padding = 12, row_height = 24, icon_width = 92, text_size = 14;
constexpr double longest_arrow = icon_width - 16;
constexpr double first_dot = 60, dot_distance = 32;
constexpr int fingers_at_most = 10;  // that have a colour of their own

void ink(cairo_t* c, double opacity) {
    cairo_set_source_rgba(c, 0.93, 0.94, 0.96, opacity);
}

void disc(cairo_t* c, double x, double y, double radius) {
    cairo_new_path(c);
    cairo_arc(c, x, y, radius, 0, 2 * 3.141592653589793);
    cairo_fill(c);
}

void arrow(cairo_t* c, double x, double y, double length) {
    const double head = std::min(11.0, 0.6 * length);
    cairo_set_line_width(c, 4);
    cairo_move_to(c, x, y);
    cairo_line_to(c, x + length - head, y);
    cairo_stroke(c);
    cairo_move_to(c, x + length, y);
    cairo_line_to(c, x + length - head, y - 5.5);
    cairo_line_to(c, x + length - head, y + 5.5);
    cairo_fill(c);
}

void thread(cairo_t* c, double x, double y) {
    cairo_move_to(c, x, y + 2.5);
    cairo_curve_to(c, x + 0.4 * icon_width, y - 9, x + 0.5 * icon_width, y + 8, x + longest_arrow, y - 1.5);
    cairo_line_to(c, x + longest_arrow, y + 1.5);
    cairo_curve_to(c, x + 0.5 * icon_width, y + 11, x + 0.4 * icon_width, y - 6, x, y + 2.5);
    cairo_fill(c);
}

void finger_dots(cairo_t* c, double x, double y, int fingers) {
    cairo_move_to(c, x, y + 5);
    cairo_show_text(c, "finger");
    for (int k = 0; k < fingers; ++k) {
        const PackedColour colour = finger_colour(static_cast<std::size_t>(k));
        cairo_set_source_rgb(c, (colour & 255U) / 255.0, (colour >> 8 & 255U) / 255.0,
                             (colour >> 16 & 255U) / 255.0);
        disc(c, x + first_dot + dot_distance * k, y, 6);
        ink(c, 1);
        const std::string number = std::to_string(k);
        cairo_move_to(c, x + first_dot + 10 + dot_distance * k, y + 5);
        cairo_show_text(c, number.c_str());
    }
}

void draw_panel(cairo_t* c, const Legend& legend, double bottom) {
    const int fingers = static_cast<int>(std::min<std::size_t>(legend.fingers, fingers_at_most));
    const double newtons = scale_newtons(legend.pixels_per_newton, longest_arrow);
    char force[64];
    std::snprintf(force, sizeof force, "force on the finger; this long: %g N", newtons);
    const char* texts[] = {"finger; where it touches, held by the surface", "where the hand is (goal)", force,
                           "its way while it touched, 0.5 s at most"};
    cairo_select_font_face(c, "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(c, text_size);
    double widest = first_dot + dot_distance * fingers - icon_width;
    for (const char* text : texts) {
        cairo_text_extents_t extents;
        cairo_text_extents(c, text, &extents);
        widest = std::max(widest, extents.x_advance);
    }
    const double height = 5 * row_height + 2 * padding, top = bottom - margin - height;
    cairo_set_source_rgba(c, 0.05, 0.06, 0.08, 0.72);
    cairo_rectangle(c, margin, top, 2 * padding + icon_width + widest, height);
    cairo_fill(c);
    const double x = margin + padding, text_x = x + icon_width;
    auto row = [&](int number) { return top + padding + row_height * (number + 0.5); };
    ink(c, 1);
    for (int k = 0; k < 4; ++k) {
        cairo_move_to(c, text_x, row(k) + 5);
        cairo_show_text(c, texts[k]);
    }
    const double middle = x + 0.5 * longest_arrow;
    disc(c, middle, row(0), 8);
    ink(c, 0.45);
    disc(c, middle, row(1), 8);
    ink(c, 1);
    arrow(c, x, row(2), newtons * legend.pixels_per_newton);
    thread(c, x, row(3));
    finger_dots(c, x, row(4), fingers);
}

}  // namespace

double scale_newtons(double pixels_per_newton, double pixels) {
    const double most = pixels / pixels_per_newton;
    const double power = std::pow(10.0, std::floor(std::log10(most)));
    for (const double step : {5.0, 2.0})
        if (step * power <= most) return step * power;
    return power;
}

Result<void> draw_legend(const Legend& legend, Image& image) {
    if (image.width < 480 || image.height < 270 || !(legend.pixels_per_newton > 0)) return {};
    // Cairo's pixels are words of the host: red, green and blue from bit 16 down.
    std::vector<std::uint32_t> words(image.samples.size() / 3);
    for (std::size_t k = 0; k < words.size(); ++k)
        words[k] = std::uint32_t{image.samples[3 * k]} << 16 | std::uint32_t{image.samples[3 * k + 1]} << 8 |
                   image.samples[3 * k + 2];
    auto* memory = static_cast<unsigned char*>(static_cast<void*>(words.data()));
    const Surface surface(cairo_image_surface_create_for_data(memory, CAIRO_FORMAT_RGB24, image.width,
                                                              image.height, 4 * image.width),
                          cairo_surface_destroy);
    const Context context(cairo_create(surface.get()), cairo_destroy);
    // Grows with the picture; a small one has the smallest letters that can be read.
    const double scale = std::max(std::min(image.height / 720.0, image.width / 900.0), 0.8);
    cairo_scale(context.get(), scale, scale);
    draw_panel(context.get(), {legend.fingers, legend.pixels_per_newton / scale}, image.height / scale);
    cairo_surface_flush(surface.get());
    if (const cairo_status_t status = cairo_status(context.get()); status != CAIRO_STATUS_SUCCESS)
        return Error{ErrorKind::internal,
                     std::string("the legend cannot be drawn: ") + cairo_status_to_string(status)};
    for (std::size_t k = 0; k < words.size(); ++k)
        for (std::size_t channel = 0; channel < 3; ++channel)
            image.samples[3 * k + channel] = static_cast<std::uint8_t>(words[k] >> (16 - 8 * channel) & 255U);
    return {};
}

}  // namespace touchable
