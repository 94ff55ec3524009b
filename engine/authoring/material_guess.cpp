#include "engine/authoring/material_guess.hpp"

#include <algorithm>
#include <string_view>

#include "engine/scene/unseen_colour.hpp"

namespace touchable {
namespace {

/// By the largest channel and the one between.
enum class Hue { grey, red, orange, green, blue, violet, any };

struct Seen {
    Hue hue;
    int brightness;  // 0.30 R + 0.59 G + 0.11 B
    int chroma;      // largest less least channel
    int contrast;    // 1/16 levels
    int permille;    // of the picture
};

Hue hue_of(int red, int green, int blue, int chroma) {
    const int largest = std::max({red, green, blue});
    if (chroma < 16 || chroma * 6 < largest) return Hue::grey;
    if (green == largest) return Hue::green;
    if (blue == largest) return red > green ? Hue::violet : Hue::blue;
    if (blue > green) return Hue::violet;
    return (green - blue) * 4 < chroma ? Hue::red : Hue::orange;
}

struct Span {
    int least, most;
    bool holds(int number) const { return least <= number && number <= most; }
};
constexpr Span any_number{0, 4080};
constexpr int smooth = 32, rough = 96;  // contrast: 2 and 6 levels

/// The first one that holds counts.
struct Rule {
    Hue hue;
    Span brightness, chroma, contrast, permille;
    std::string_view material;
};
constexpr Rule rules[] = {
    // What has no colour: by how bright and how rough it is. Few kinds: shading makes greys of one surface
    // darker and brighter.
    {Hue::grey, any_number, any_number, {rough, 4080}, any_number, "stone"},
    {Hue::grey, {200, 255}, any_number, any_number, any_number, "paper"},
    {Hue::grey, {60, 255}, any_number, {0, smooth}, {80, 1000}, "plastic"},  // as paint on a wall is
    {Hue::grey, {110, 255}, any_number, {0, smooth}, any_number, "metal"},
    {Hue::grey, {0, 32}, any_number, {0, smooth / 2}, any_number, "rubber"},
    {Hue::grey, any_number, any_number, {smooth, 4080}, {150, 1000}, "carpet"},
    {Hue::grey, any_number, any_number, any_number, any_number, "cloth"},
    // Brown, from skin to bark.
    {Hue::orange, {140, 230}, {45, 110}, {0, smooth}, {0, 250}, "skin"},
    {Hue::orange, any_number, {150, 255}, {0, smooth}, any_number, "plastic"},
    {Hue::orange, {0, 80}, any_number, {0, rough}, {0, 60}, "leather"},
    {Hue::orange, {170, 255}, {0, 90}, any_number, any_number, "cardboard"},
    {Hue::orange, any_number, any_number, any_number, any_number, "wood"},
    {Hue::red, any_number, {50, 255}, {smooth, 4080}, {20, 1000}, "brick"},
    {Hue::green, any_number, any_number, {smooth, 4080}, any_number, "grass"},
    {Hue::blue, {60, 255}, {40, 255}, {0, smooth}, {300, 1000}, "water"},
    // Whatever else has a colour: smooth, as paint on something, or woven.
    {Hue::any, any_number, {90, 255}, {0, smooth}, any_number, "plastic"},
    {Hue::any, any_number, any_number, any_number, {250, 1000}, "carpet"},
    {Hue::any, any_number, any_number, any_number, any_number, "cloth"},
};

/// What no colour camera saw feels much as a clip does without materials.
constexpr std::string_view of_unseen = "cloth";

}  // namespace

const PaletteMaterial& guess_material(const SegmentLook& look) {
    const int red = look.colour[0], green = look.colour[1], blue = look.colour[2];
    const int chroma = std::max({red, green, blue}) - std::min({red, green, blue});
    if (is_unseen_colour(look.colour.data())) return *find_material(of_unseen);
    const auto permille =
        static_cast<int>(std::int64_t{look.pixels} * 1000 / std::max<std::int64_t>(look.of_pixels, 1));
    const Seen seen{hue_of(red, green, blue, chroma), (30 * red + 59 * green + 11 * blue) / 100, chroma,
                    std::clamp(look.contrast, 0, 4080), permille};
    const auto* const rule = std::find_if(std::begin(rules), std::end(rules), [&](const Rule& each) {
        return (each.hue == Hue::any || each.hue == seen.hue) && each.brightness.holds(seen.brightness) &&
               each.chroma.holds(seen.chroma) && each.contrast.holds(seen.contrast) &&
               each.permille.holds(seen.permille);
    });
    return *find_material(rule->material);
}

}  // namespace touchable
