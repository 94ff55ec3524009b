#include "engine/authoring/background_model.hpp"

#include <algorithm>
#include <cstdlib>

namespace touchable {
namespace {

constexpr std::int32_t colour_tolerance = 16;  // of 255, in each channel
constexpr std::int32_t code_parts = 256, colour_parts = 16;
constexpr std::int32_t longest_mean = 64, most_counted = 65535;  // frames
/// A mode that tells was seen so often, and in such a share of the frames.
constexpr std::int32_t least_seen = 3, share_with_colour = 16, share_without = 4;

Rgb colour_of(const std::array<std::uint16_t, 3>& mean) {
    Rgb rgb{};
    for (std::size_t k = 0; k < 3; ++k)
        rgb[k] = static_cast<std::uint8_t>((mean[k] + colour_parts / 2) / colour_parts);
    return rgb;
}

}  // namespace

bool agree(const Rgb& a, const Rgb& b) {
    for (std::size_t k = 0; k < 3; ++k)
        if (std::abs(a[k] - b[k]) > colour_tolerance) return false;
    return true;
}

BackgroundModel::BackgroundModel(const CodedDepth& depth, int width, int height)
    : depth_(depth),
      width_(width),
      pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {}

void BackgroundModel::begin() {
    std::fill(pixels_.begin(), pixels_.end(), Modes{});
    frames_ = 0;
}

/// The mode that it belongs to, by depth and colour, is moved towards it; what belongs to none replaces the
/// one seen least. (A hand that rests on a table is nearly as deep, and must not draw the table to it.)
void BackgroundModel::see(Modes& modes, std::uint16_t code, const std::uint8_t* rgb) const {
    const std::int32_t exact = code * code_parts, tolerance = depth_.tolerance(code) * code_parts;
    const auto may_be = [&](const Mode& mode) {
        return mode.count > 0 && std::abs(exact - mode.mean) <= tolerance &&
               (!rgb || agree({rgb[0], rgb[1], rgb[2]}, colour_of(mode.colour)));
    };
    Mode* nearest = nullptr;
    for (Mode& mode : modes)
        if (may_be(mode) && (!nearest || std::abs(exact - mode.mean) < std::abs(exact - nearest->mean)))
            nearest = &mode;
    if (!nearest) {
        nearest = &*std::min_element(modes.begin(), modes.end(),
                                     [](const Mode& a, const Mode& b) { return a.count < b.count; });
        *nearest = {exact, code, 0, {}};
    }
    Mode& mode = *nearest;
    if (mode.count < most_counted) ++mode.count;
    const std::int32_t frames = std::min<std::int32_t>(mode.count, longest_mean);
    mode.mean += (exact - mode.mean) / frames;
    if (std::abs(exact - mode.mean) <= std::abs(mode.code * code_parts - mode.mean)) mode.code = code;
    if (!rgb) return;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t now = rgb[k] * colour_parts, mean = mode.colour[k];
        mode.colour[k] = static_cast<std::uint16_t>(mean + (now - mean) / frames);
    }
}

void BackgroundModel::add_rows(const PlaneView& codes, const PlaneView& colour, const RowBand& band) {
    for (int y = band.first; y < band.last; ++y) {
        Modes* modes = pixels_.data() + std::ptrdiff_t{y} * width_;
        const std::uint8_t* rgb = colour.empty() ? nullptr : colour.row(y);
        for (int x = 0; x < width_; ++x, ++modes) {
            const std::uint16_t code = codes.sample(x, y);
            if (depth_.is_valid(code)) see(*modes, code, rgb ? rgb + std::ptrdiff_t{3} * x : nullptr);
        }
    }
}

void BackgroundModel::add(const PlaneView& codes, const PlaneView& colour, RowBands& bands) {
    ++frames_;
    bands.for_each_band(codes.height, 1, [&](const RowBand& band) { add_rows(codes, colour, band); });
}

BackgroundPixel BackgroundModel::behind(const Modes& modes, std::int32_t least, bool has_colour) const {
    const Mode* chosen = nullptr;
    for (const Mode& mode : modes)
        if (mode.count >= least && (!chosen || depth_.deeper_by(mode.code, chosen->code) > 0)) chosen = &mode;
    if (!chosen) return {};
    // Noise and shades may have made several modes of one surface: then it is as it mostly was.
    const Mode deepest = *chosen;
    const auto is_apart = [&](const Mode& mode) {
        return std::abs(mode.code - deepest.code) > 2 * depth_.tolerance(deepest.code);
    };
    for (const Mode& mode : modes)
        if (mode.count > chosen->count && !is_apart(mode)) chosen = &mode;
    BackgroundPixel pixel{chosen->code, true, false, colour_of(chosen->colour)};
    for (const Mode& mode : modes)
        if (has_colour && mode.count >= least_seen && is_apart(mode) &&
            agree(colour_of(mode.colour), pixel.colour))
            pixel.is_ambiguous = true;
    return pixel;
}

Background BackgroundModel::finish(bool has_colour) {
    const std::int32_t least =
        std::clamp(frames_ / (has_colour ? share_with_colour : share_without), least_seen, most_counted);
    Background background;
    background.reserve(pixels_.size());
    for (const Modes& modes : pixels_) background.push_back(behind(modes, least, has_colour));
    begin();
    return background;
}

}  // namespace touchable
