#include "player/draw/scale_bar.hpp"

#include <algorithm>
#include <cmath>

#include "engine/base/number_words.hpp"
#include "player/draw/colour_ramp.hpp"
#include "player/draw/panel.hpp"

namespace touchable {
namespace {

// In pixels of a picture of 720 lines.
constexpr double bar_width = 280, bar_height = 14, swatch = 14, between_marks = 12, mark_height = 5;

void colour_ink(cairo_t* c, PackedColour colour) {
    cairo_set_source_rgb(c, (colour & 255U) / 255.0, (colour >> 8 & 255U) / 255.0,
                         (colour >> 16 & 255U) / 255.0);
}

/// With as many decimals as a distance from one mark to the next needs.
std::string number(double value, double step) {
    const int decimals = std::clamp(static_cast<int>(-std::floor(std::log10(step) + 1e-9)), 0, 9);
    return formatted("%.*f", decimals, value == 0 ? 0.0 : value);
}

std::vector<ScaleMark> marks_at(const ValueRange& range, double step) {
    std::vector<ScaleMark> marks;
    const double slack = 1e-9 * (range.greatest - range.least);
    for (double k = std::ceil((range.least - slack) / step); k * step <= range.greatest + slack; ++k)
        marks.push_back({k * step, number(k * step, step)});
    return marks;
}

/// Where a panel goes: the lower right; the upper one where the legend would be in its way.
struct Corner {
    double left, top;
};
Corner corner_for(double width, double height, const panel::Frame& frame) {
    constexpr double beside_the_legend = 820;
    const double left = frame.width - panel::margin - width;
    if (frame.width < beside_the_legend) return {left, panel::margin};
    return {left, frame.height - panel::margin - height};
}

void draw_words(cairo_t* c, double x, double y, const std::string& words) {
    panel::ink(c, 1);
    cairo_move_to(c, x, y);
    cairo_show_text(c, words.c_str());
}

void draw_classes(cairo_t* c, const OverlayScale& scale, const panel::Frame& frame) {
    double widest = panel::text_width(c, scale.name);
    for (const auto& one : scale.classes)
        widest = std::max(widest, swatch + 10 + panel::text_width(c, one.words));
    const double rows = 1.0 + static_cast<double>(scale.classes.size());
    const double width = widest + 2 * panel::padding, height = rows * panel::row_height + 2 * panel::padding;
    const auto [left, top] = corner_for(width, height, frame);
    panel::ground(c, left, top, width, height);
    const double x = left + panel::padding;
    double y = top + panel::padding + 0.5 * panel::row_height;
    draw_words(c, x, y + 5, scale.name);
    for (const auto& one : scale.classes) {
        y += panel::row_height;
        colour_ink(c, one.colour);
        cairo_rectangle(c, x, y - swatch / 2, swatch, swatch);
        cairo_fill(c);
        draw_words(c, x + swatch + 10, y + 5, one.words);
    }
}

void draw_ramp(cairo_t* c, double x, double y, bool backward) {
    constexpr int steps = 256;
    cairo_set_antialias(c, CAIRO_ANTIALIAS_NONE);  // or seams show between them
    for (int k = 0; k < steps; ++k) {
        const double share = static_cast<double>(k) / (steps - 1);
        colour_ink(c, ramp_colour(backward ? 1 - share : share));
        cairo_rectangle(c, x + bar_width * k / steps, y, bar_width - bar_width * k / steps, bar_height);
        cairo_fill(c);
    }
    cairo_set_antialias(c, CAIRO_ANTIALIAS_DEFAULT);
}

/// The same everywhere: one colour, and why.
void draw_even(cairo_t* c, const OverlayScale& scale, const panel::Frame& frame) {
    OverlayScale one;
    one.name = scale.name;
    one.classes = {{ramp_colour(0.5), scale.everywhere()}};
    draw_classes(c, one, frame);
}

/// Words below the bar, in pixels from its left end.
struct PlacedMark {
    double at;
    std::string text;
};

/// Round values where they lie evenly; otherwise the scale's levels, which lie at equal distances.
std::vector<PlacedMark> placed_marks(cairo_t* c, const OverlayScale& scale) {
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

void draw_bar(cairo_t* c, const OverlayScale& scale, const panel::Frame& frame) {
    const auto marks = placed_marks(c, scale);
    // Words of the first and the last mark may stand out beyond the bar.
    const double over = std::max(panel::text_width(c, marks.front().text) / 2 - marks.front().at,
                                 panel::text_width(c, marks.back().text) / 2 + marks.back().at - bar_width);
    const double side = panel::padding + std::max(0.0, over);
    const double width = bar_width + 2 * side,
                 height = 2 * panel::row_height + bar_height + mark_height + 2 * panel::padding;
    const auto [left, top] = corner_for(width, height, frame);
    panel::ground(c, left, top, width, height);
    const double x = left + side, y = top + panel::padding + panel::row_height;
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

}  // namespace

std::vector<ScaleMark> scale_marks(const ValueRange& range,
                                   const std::function<bool(const std::vector<ScaleMark>&)>& fits) {
    const double size = range.greatest - range.least;
    // From too close together to too far apart.
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

Result<void> draw_scale_bar(const OverlayScale& scale, Image& image) {
    return panel::draw(image, "scale", [&](cairo_t* c, const panel::Frame& frame) {
        if (!scale.classes.empty()) return draw_classes(c, scale, frame);
        if (!(scale.range.greatest > scale.range.least)) return draw_even(c, scale, frame);
        draw_bar(c, scale, frame);
    });
}

}  // namespace touchable
