// SPDX-License-Identifier: Apache-2.0
#include "player/draw/light_picture.hpp"

#include <cairo.h>

#include <glm/common.hpp>

#include "engine/base/words.hpp"
#include "player/draw/finger_marks.hpp"

// Colours of a scale, overlay names, and text panels in a corner of a picture, all in one style: the legend
// of fingers, the bar of a scale. Drawn with Cairo, in pixels of a 720-line picture.

namespace touchable {
namespace {

namespace panel {

constexpr double margin = 16, padding = 12, row_height = 24, text_size = 14;

/// A picture's size in 720-line pixels; `scale`: its own pixels per such pixel.
struct Frame {
    double width, height, scale;
};

/// The colour of words and signs, 0 to 1.
void ink(cairo_t* c, double opacity) {
    cairo_set_source_rgba(c, 0.93, 0.94, 0.96, opacity);
}

void fill_rectangle(cairo_t* c, double x, double y, double width, double height) {
    cairo_rectangle(c, x, y, width, height);
    cairo_fill(c);
}

/// A dark background for text; x and y of its upper left corner.
void ground(cairo_t* c, double x, double y, double width, double height) {
    cairo_set_source_rgba(c, 0.05, 0.06, 0.08, 0.72);
    fill_rectangle(c, x, y, width, height);
}

double text_width(cairo_t* c, const std::string& text) {
    cairo_text_extents_t extents;
    cairo_text_extents(c, text.c_str(), &extents);
    return extents.x_advance;
}

/// Draws into an image of RGB, 8 bits; does nothing below 480x270, where it would hide the scene. `name`:
/// what is drawn, for messages.
Result<void> draw(Image& image, const std::string& name,
                  const std::function<void(cairo_t*, const Frame&)>& drawing) {
    if (image.width < 480 || image.height < 270) return {};
    // Cairo's pixels are host-endian words: red, green and blue from bit 16 down.
    std::vector<std::uint32_t> words(image.samples.size() / 3);
    for (std::size_t k = 0; k < words.size(); ++k)
        words[k] = std::uint32_t{image.samples[3 * k]} << 16 | std::uint32_t{image.samples[3 * k + 1]} << 8 |
                   image.samples[3 * k + 2];
    auto* memory = static_cast<unsigned char*>(static_cast<void*>(words.data()));
    const std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)> surface(
        cairo_image_surface_create_for_data(memory, CAIRO_FORMAT_RGB24, image.width, image.height,
                                            4 * image.width),
        cairo_surface_destroy);
    const std::unique_ptr<cairo_t, decltype(&cairo_destroy)> context(cairo_create(surface.get()),
                                                                     cairo_destroy);
    // Proportional to the picture; small ones use the smallest legible letters.
    const double scale = std::max(std::min(image.height / 720.0, image.width / 900.0), 0.8);
    cairo_scale(context.get(), scale, scale);
    cairo_select_font_face(context.get(), "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(context.get(), text_size);
    drawing(context.get(), {image.width / scale, image.height / scale, scale});
    cairo_surface_flush(surface.get());
    if (const cairo_status_t status = cairo_status(context.get()); status != CAIRO_STATUS_SUCCESS)
        return internal_error("the " + name + " cannot be drawn: " + cairo_status_to_string(status));
    for (std::size_t k = 0; k < words.size(); ++k)
        for (std::size_t channel = 0; channel < 3; ++channel)
            image.samples[3 * k + channel] = static_cast<std::uint8_t>(words[k] >> (16 - 8 * channel) & 255U);
    return {};
}

}  // namespace panel

// Layout of the legend.
constexpr double icon_width = 92;
constexpr double longest_arrow = icon_width - 16;
constexpr double first_dot = 60, dot_distance = 32;
constexpr int fingers_at_most = 10;  // with different colours

void draw_words(cairo_t* c, double x, double y, const std::string& words) {
    panel::ink(c, 1);
    cairo_move_to(c, x, y);
    cairo_show_text(c, words.c_str());
}

void colour_ink(cairo_t* c, PackedColour colour) {
    cairo_set_source_rgb(c, (colour & 255U) / 255.0, (colour >> 8 & 255U) / 255.0,
                         (colour >> 16 & 255U) / 255.0);
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
    draw_words(c, x, y + 5, "finger");
    for (int k = 0; k < fingers; ++k) {
        const double at = x + first_dot + dot_distance * k;
        colour_ink(c, finger_colour(static_cast<std::size_t>(k)));
        disc(c, at, y, 6);
        draw_words(c, at + 10, y + 5, std::to_string(k + 1));
    }
}

void draw_panel(cairo_t* c, const Legend& legend, double bottom) {
    const int fingers = static_cast<int>(std::min<std::size_t>(legend.fingers, fingers_at_most));
    const double newtons = scale_newtons(legend.pixels_per_newton, longest_arrow);
    const std::string texts[] = {"finger; where it touches, held by the surface", "where the hand is (goal)",
                                 formatted("force on the finger; this long: %g N", newtons),
                                 "its way while it touched, 0.5 s at most"};
    double widest = first_dot + dot_distance * fingers - icon_width;
    for (const std::string& text : texts) widest = std::max(widest, panel::text_width(c, text));
    const double height = 5 * panel::row_height + 2 * panel::padding, top = bottom - panel::margin - height;
    panel::ground(c, panel::margin, top, 2 * panel::padding + icon_width + widest, height);
    const double x = panel::margin + panel::padding, text_x = x + icon_width;
    auto row = [&](int number) { return top + panel::padding + panel::row_height * (number + 0.5); };
    for (int k = 0; k < 4; ++k) draw_words(c, text_x, row(k) + 5, texts[k]);
    const double middle = x + 0.5 * longest_arrow;
    disc(c, middle, row(0), 8);
    panel::ink(c, 0.45);
    disc(c, middle, row(1), 8);
    panel::ink(c, 1);
    arrow(c, x, row(2), newtons * legend.pixels_per_newton);
    thread(c, x, row(3));
    finger_dots(c, x, row(4), fingers);
}

// Layout of a scale.
constexpr double bar_width = 280, bar_height = 14, swatch = 14, between_marks = 12, mark_height = 5;

/// With the decimals that the distance between marks needs.
std::string number(double value, double step) {
    const int decimals = std::clamp(static_cast<int>(-std::floor(std::log10(step) + 1e-9)), 0, 9);
    return formatted("%.*f", decimals, value == 0 ? 0.0 : value);
}

std::vector<ScaleMark> marks_at(const Overlays::Range& range, double step) {
    std::vector<ScaleMark> marks;
    const double slack = 1e-9 * (range.greatest - range.least);
    for (double k = std::ceil((range.least - slack) / step); k * step <= range.greatest + slack; ++k)
        marks.push_back({k * step, number(k * step, step)});
    return marks;
}

/// Draws a background in the lower right, or in the upper right if the legend is in the way. Returns its
/// upper left corner.
glm::dvec2 draw_ground(cairo_t* c, double width, double height, const panel::Frame& frame) {
    constexpr double beside_the_legend = 820;
    const double left = frame.width - panel::margin - width, low = frame.height - panel::margin - height,
                 top = frame.width < beside_the_legend ? panel::margin : low;
    panel::ground(c, left, top, width, height);
    return {left, top};
}

void draw_classes(cairo_t* c, const Overlays::Scale& scale, const panel::Frame& frame) {
    double widest = panel::text_width(c, scale.name);
    for (const auto& one : scale.classes)
        widest = std::max(widest, swatch + 10 + panel::text_width(c, one.words));
    const double rows = 1.0 + static_cast<double>(scale.classes.size());
    const double width = widest + 2 * panel::padding, height = rows * panel::row_height + 2 * panel::padding;
    const glm::dvec2 corner = draw_ground(c, width, height, frame);
    const double x = corner.x + panel::padding;
    double y = corner.y + panel::padding + 0.5 * panel::row_height;
    draw_words(c, x, y + 5, scale.name);
    for (const auto& one : scale.classes) {
        y += panel::row_height;
        colour_ink(c, one.colour);
        panel::fill_rectangle(c, x, y - swatch / 2, swatch, swatch);
        draw_words(c, x + swatch + 10, y + 5, one.words);
    }
}

void draw_ramp(cairo_t* c, double x, double y, bool backward) {
    constexpr int steps = 256;
    cairo_set_antialias(c, CAIRO_ANTIALIAS_NONE);  // or seams show between the steps
    for (int k = 0; k < steps; ++k) {
        const double share = static_cast<double>(k) / (steps - 1);
        colour_ink(c, ramp_colour(backward ? 1 - share : share));
        const double before = bar_width * k / steps;
        panel::fill_rectangle(c, x + before, y, bar_width - before, bar_height);
    }
    cairo_set_antialias(c, CAIRO_ANTIALIAS_DEFAULT);
}

/// One value everywhere: one colour, and the reason.
void draw_even(cairo_t* c, const Overlays::Scale& scale, const panel::Frame& frame) {
    Overlays::Scale one;
    one.name = scale.name;
    one.classes = {{ramp_colour(0.5), scale.everywhere()}};
    draw_classes(c, one, frame);
}

/// A label below the bar; `at`: pixels from the bar's left end.
struct PlacedMark {
    double at;
    std::string text;
};

/// Round values on a linear scale; otherwise the scale's levels, which lie at equal distances.
std::vector<PlacedMark> placed_marks(cairo_t* c, const Overlays::Scale& scale) {
    std::vector<PlacedMark> placed;
    for (const double level : scale.levels) {
        const auto steps = static_cast<double>(scale.levels.size() - 1);
        placed.push_back({bar_width * static_cast<double>(placed.size()) / steps, formatted("%.3g", level)});
    }
    if (!placed.empty()) return placed;
    const auto place_of = [&](double value) {
        return bar_width * (value - scale.range.least) / (scale.range.greatest - scale.range.least);
    };
    const auto fits = [&](const std::vector<ScaleMark>& marks) {
        double end = -1e9;
        for (const ScaleMark& mark : marks) {
            const double half = panel::text_width(c, mark.text) / 2;
            if (place_of(mark.value) - half < end + between_marks) return false;
            end = place_of(mark.value) + half;
        }
        return true;
    };
    for (const ScaleMark& mark : scale_marks(scale.range, fits))
        placed.push_back({place_of(mark.value), mark.text});
    return placed;
}

void draw_bar(cairo_t* c, const Overlays::Scale& scale, const panel::Frame& frame) {
    const auto marks = placed_marks(c, scale);
    // Labels of the first and last mark may extend beyond the bar.
    const double over = std::max(panel::text_width(c, marks.front().text) / 2 - marks.front().at,
                                 panel::text_width(c, marks.back().text) / 2 + marks.back().at - bar_width);
    const double side = panel::padding + std::max(0.0, over);
    const double width = bar_width + 2 * side,
                 height = 2 * panel::row_height + bar_height + mark_height + 2 * panel::padding;
    const glm::dvec2 corner = draw_ground(c, width, height, frame);
    const double x = corner.x + side, y = corner.y + panel::padding + panel::row_height;
    draw_words(c, x, y - 8, scale.title());
    draw_ramp(c, x, y, scale.least_is_light);
    cairo_set_line_width(c, 1.5);
    for (const PlacedMark& mark : marks) {
        const double at = x + mark.at;
        panel::ink(c, 1);
        cairo_move_to(c, at, y + bar_height);
        cairo_line_to(c, at, y + bar_height + mark_height);
        cairo_stroke(c);
        draw_words(c, at - panel::text_width(c, mark.text) / 2, y + bar_height + mark_height + 16, mark.text);
    }
}

/// In Overlay's order.
constexpr std::array<std::string_view, 11> names_of_overlays{
    "colour", "depth",   "depth-linear", "stiffness", "friction", "dynamic-friction",
    "height", "normals", "errors",       "tiles",     "validity"};
static_assert(static_cast<std::size_t>(Overlay::validity) + 1 == names_of_overlays.size());

}  // namespace

std::string name_of(Overlay overlay) {
    return std::string(names_of_overlays[static_cast<std::size_t>(overlay)]);
}

std::vector<std::string> overlay_names() {
    return {names_of_overlays.begin(), names_of_overlays.end()};
}

Result<Overlay> overlay_after(Overlay now, const std::string& name) {
    constexpr std::size_t count = names_of_overlays.size();
    if (name.empty()) {
        const auto next = static_cast<Overlay>((static_cast<std::size_t>(now) + 1) % count);
        return next == Overlay::tiles ? Overlay::validity : next;
    }
    const auto named = std::ranges::find(names_of_overlays, name);
    if (named != names_of_overlays.end()) return static_cast<Overlay>(named - names_of_overlays.begin());
    return usage_error("unknown overlay '" + printable(name) + "'; must be one of " +
                       listed(names_of_overlays));
}

Result<Lighting> light_after(Lighting now, std::string_view name) {
    constexpr std::size_t count = light_names.size();
    if (name.empty()) return static_cast<Lighting>((static_cast<std::size_t>(now) + 1) % count);
    const auto named = std::ranges::find(light_names, name);
    if (named != light_names.end()) return static_cast<Lighting>(named - light_names.begin());
    return usage_error("unknown light '" + printable(std::string(name)) + "'; must be one of " +
                       listed(light_names));
}

double Overlays::Scale::share_of(double value) const {
    if (!(range.greatest > range.least)) return 0.5;
    const double share = std::clamp((value - range.least) / (range.greatest - range.least), 0.0, 1.0);
    return least_is_light ? 1 - share : share;
}

std::string Overlays::Scale::everywhere() const {
    if (!classes.empty() || range.greatest > range.least) return "";
    const auto words = [this](double value) {
        return formatted("%.4g", value) + (unit.empty() ? "" : " " + unit);
    };
    return words(range.least) + " everywhere" + (has_map ? "" : ": this clip has no map") +
           (at_holes ? "; " + words(*at_holes) + " at holes" : "");
}

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

std::vector<ScaleMark> scale_marks(const Overlays::Range& range,
                                   const std::function<bool(const std::vector<ScaleMark>&)>& fits) {
    const double size = range.greatest - range.least;
    // From too dense to too sparse.
    double power = std::pow(10.0, std::floor(std::log10(size)) - 1);
    for (int tries = 0; tries < 3; ++tries, power *= 10)
        for (const double step : {1.0, 2.0, 5.0}) {
            auto marks = marks_at(range, step * power);
            if (marks.size() >= 2 && fits(marks)) return marks;
        }
    const double step = power / 100, middle = 0.5 * (range.least + range.greatest);
    const double value = std::floor(middle / step + 0.5) * step;
    return {{value, number(value, step)}};
}

Result<void> draw_scale_bar(const Overlays::Scale& scale, Image& image) {
    return panel::draw(image, "scale", [&](cairo_t* c, const panel::Frame& frame) {
        if (!scale.classes.empty()) return draw_classes(c, scale, frame);
        if (!(scale.range.greatest > scale.range.least)) return draw_even(c, scale, frame);
        draw_bar(c, scale, frame);
    });
}

}  // namespace touchable
