#include "player/draw/legend.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "engine/base/number_words.hpp"
#include "player/draw/finger_marks.hpp"
#include "player/draw/panel.hpp"

namespace touchable {
namespace {

// Of the panel, in pixels of a picture of 720 lines.
constexpr double icon_width = 92;
constexpr double longest_arrow = icon_width - 16;
constexpr double first_dot = 60, dot_distance = 32;
constexpr int fingers_at_most = 10;  // that have a colour of their own

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
        panel::ink(c, 1);
        const std::string number = std::to_string(k);
        cairo_move_to(c, x + first_dot + 10 + dot_distance * k, y + 5);
        cairo_show_text(c, number.c_str());
    }
}

void draw_panel(cairo_t* c, const Legend& legend, double bottom) {
    const int fingers = static_cast<int>(std::min<std::size_t>(legend.fingers, fingers_at_most));
    const double newtons = scale_newtons(legend.pixels_per_newton, longest_arrow);
    const std::string force = formatted("force on the finger; this long: %g N", newtons);
    const char* texts[] = {"finger; where it touches, held by the surface", "where the hand is (goal)",
                           force.c_str(), "its way while it touched, 0.5 s at most"};
    double widest = first_dot + dot_distance * fingers - icon_width;
    for (const char* text : texts) widest = std::max(widest, panel::text_width(c, text));
    const double height = 5 * panel::row_height + 2 * panel::padding, top = bottom - panel::margin - height;
    panel::ground(c, panel::margin, top, 2 * panel::padding + icon_width + widest, height);
    const double x = panel::margin + panel::padding, text_x = x + icon_width;
    auto row = [&](int number) { return top + panel::padding + panel::row_height * (number + 0.5); };
    panel::ink(c, 1);
    for (int k = 0; k < 4; ++k) {
        cairo_move_to(c, text_x, row(k) + 5);
        cairo_show_text(c, texts[k]);
    }
    const double middle = x + 0.5 * longest_arrow;
    disc(c, middle, row(0), 8);
    panel::ink(c, 0.45);
    disc(c, middle, row(1), 8);
    panel::ink(c, 1);
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
    if (!(legend.pixels_per_newton > 0)) return {};
    return panel::draw(image, "legend", [&](cairo_t* c, const panel::Frame& frame) {
        draw_panel(c, {legend.fingers, legend.pixels_per_newton / frame.scale}, frame.height);
    });
}

}  // namespace touchable
