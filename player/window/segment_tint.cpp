#include "player/window/segment_tint.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <string>

#include "engine/authoring/pixel_features.hpp"
#include "player/window/material_colours.hpp"

namespace touchable {
namespace {

using TintRgb = std::array<std::uint8_t, 3>;

constexpr TintRgb tint_of_holes{24, 24, 28}, tint_of_borders{12, 12, 16};
constexpr int pale = 150;                          // what half of a guess's colour is
constexpr int grey_brightness = 160;               // where the clip has no colour
constexpr int darkest = 104, of_brightness = 152;  // of 256: how bright black is, and white besides

int brightness_at(const PlaneView& colour, int x, int y, int width, int height) {
    if (colour.empty() || colour.channels < 3 || colour.bytes_per_sample != 1) return grey_brightness;
    const std::uint8_t* const rgb = colour_at(colour, x, y, width, height);
    return (77 * rgb[0] + 150 * rgb[1] + 29 * rgb[2]) >> 8;
}

/// Guesses are paler.
TintRgb tint_of(const SegmentPaint& paint) {
    TintRgb colour = material_colour(paint.material);
    if (paint.is_guess)
        for (std::uint8_t& c : colour) c = static_cast<std::uint8_t>((c + pale) / 2);
    return colour;
}

}  // namespace

PlaneView SegmentTint::paint(const std::shared_ptr<const PaintedSegments>& painted, std::int64_t frame,
                             const PlaneView& colour) {
    const SegmentStore& segments = *painted->segments;
    frame = std::clamp<std::int64_t>(frame, 0, segments.frames() - 1);
    if (painted != painted_ || frame != frame_ || colour.data != colour_) {
        painted_ = painted;
        frame_ = frame;
        colour_ = colour.data;
        paint_anew(colour);
    }
    const int width = segments.width();
    return {rgb_.data(), std::ptrdiff_t{3} * width, width, segments.height(), 1, 3};
}

void SegmentTint::paint_anew(const PlaneView& colour) {
    const SegmentStore& segments = *painted_->segments;
    const int width = segments.width(), height = segments.height();
    segments.read_labels(frame_, labels_);
    std::vector<TintRgb> colours(65536, material_colour(""));
    std::vector<std::uint16_t> things(65536);  // the first segment of that name: joined ones have no border
    std::map<std::string, std::uint16_t> by_name;
    for (const auto& [label, paint] : painted_->by_label) {
        colours[label] = tint_of(paint);
        things[label] = paint.name.empty() ? label : by_name.emplace(paint.name, label).first->second;
    }
    const auto label_at = [&](int x, int y) {
        return labels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                       static_cast<std::size_t>(x)];
    };
    const int line = std::max(1, width / 480);
    rgb_.resize(labels_.size() * 3);
    std::uint8_t* to = rgb_.data();
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x, to += 3) {
            const std::uint16_t label = label_at(x, y);
            const bool is_border = things[label_at(std::min(x + line, width - 1), y)] != things[label] ||
                                   things[label_at(x, std::min(y + line, height - 1))] != things[label];
            if (label == 0 || is_border) {
                std::ranges::copy(is_border ? tint_of_borders : tint_of_holes, to);
                continue;
            }
            const int share = darkest + of_brightness * brightness_at(colour, x, y, width, height) / 255;
            for (std::size_t c = 0; c < 3; ++c)
                to[c] = static_cast<std::uint8_t>(colours[label][c] * share >> 8);
        }
}

}  // namespace touchable
