#include "engine/authoring/pixel_features.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>

#include "engine/scene/stored_code.hpp"

namespace touchable {
namespace {

constexpr int window = 3, window_pixels = window * window;
/// Hue is taken as a share of brightness and this: in the dark it is mostly noise.
constexpr int dark = 96;
/// A level of hue weighs as much as one of colour in a pixel of middle brightness.
constexpr int hue_weight = 4 * (128 + dark), share_bits = 14;
constexpr int brightness_weight = 2;

constexpr int per_quantum = PixelFeatures::depth_per_octave / 8;
constexpr std::size_t quanta = 32 * 8;

}  // namespace

std::int32_t fixed_log2(double number) {
    const auto fixed = static_cast<std::uint64_t>(number * 4294967296.0);
    const int octave = std::bit_width(fixed) - 1;
    std::uint64_t mantissa = octave >= 31 ? fixed >> (octave - 31) : fixed << (31 - octave);
    std::int32_t log = (octave - 32) * PixelFeatures::depth_per_octave;
    for (int bit = PixelFeatures::depth_per_octave / 2; bit > 0; bit /= 2) {
        mantissa = (mantissa * mantissa) >> 31;
        if (mantissa >> 32) {
            log += bit;
            mantissa >>= 1;
        }
    }
    return log;
}

FeatureReader::FeatureReader(const Scene& scene)
    : width_(scene.width), height_(scene.height), coding_(scene.depth) {
    quanta_.assign(quanta, 0);
    depth_of_code_.assign(std::size_t{1} << 16, PixelFeatures::no_surface);
    if (coding_.valid_min <= coding_.valid_max) {
        const double nearest = coding_.nearest_depth();
        for (int code = coding_.valid_min; code <= coding_.valid_max; ++code) {
            const auto valid = static_cast<std::uint16_t>(code);
            if (!coding_.is_valid(valid)) continue;
            const std::int32_t depth = fixed_log2(std::clamp(coding_.depth(valid) / nearest, 1.0, 2e9));
            depth_of_code_[valid] = depth;
            const std::int32_t before = code > coding_.valid_min ? depth_of_code_[valid - 1U] : depth;
            if (before == PixelFeatures::no_surface) continue;
            std::int32_t& quantum = quanta_[static_cast<std::size_t>(depth / per_quantum)];
            quantum = std::max(quantum, std::abs(depth - before));
        }
    }
    if (coding_.semantics == DepthSemantics::range)
        for (int y = 0; y < height_; ++y)
            for (int x = 0; x < width_; ++x)
                ray_.push_back(fixed_log2(std::min(scene.camera.ray_length(x, y), 2e9)));
    for (int level = 0; level <= 255 * window_pixels; ++level)
        shares_.push_back((hue_weight << share_bits) / (level + dark * window_pixels));
}

std::int32_t FeatureReader::quantum(std::int32_t depth) const {
    return quanta_[std::min(static_cast<std::size_t>(std::max(depth, 0) / per_quantum), quanta - 1)];
}

void FeatureReader::read(const RawFrame& frame, PixelFeatures& features, RowBands& bands) const {
    const std::size_t pixels = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
    features.width = width_;
    features.height = height_;
    for (auto* plane : {&features.brightness, &features.red_green, &features.yellow_blue})
        plane->resize(pixels);
    features.depth.resize(pixels);
    bands.for_each_band(height_, 1, [&](const RowBand& band) {
        read_depth(frame.depth, features, band);
        if (!frame.colour.empty())
            read_colour(frame.colour, features, band);
        else
            for (auto* plane : {&features.brightness, &features.red_green, &features.yellow_blue})
                std::fill(plane->begin() + static_cast<std::ptrdiff_t>(features.place(0, band.first)),
                          plane->begin() + static_cast<std::ptrdiff_t>(features.place(0, band.last)),
                          std::int16_t{0});
    });
}

void FeatureReader::read_depth(const PlaneView& depth, PixelFeatures& features, const RowBand& band) const {
    for (int y = band.first; y < band.last; ++y) {
        const std::size_t row = features.place(0, y);
        for (int x = 0; x < width_; ++x)
            features.depth[row + static_cast<std::size_t>(x)] =
                depth_of_code_[stored_code(depth, coding_, x, y)];
        if (ray_.empty()) continue;
        for (std::size_t k = row; k < row + static_cast<std::size_t>(width_); ++k)
            if (features.has_surface(k)) features.depth[k] -= ray_[k];
    }
}

void FeatureReader::read_colour(const PlaneView& colour, PixelFeatures& features, const RowBand& band) const {
    /// Red, green and blue of three rows, added up by column.
    std::vector<std::array<std::int32_t, 3>> columns(static_cast<std::size_t>(width_));
    for (int y = band.first; y < band.last; ++y) {
        std::fill(columns.begin(), columns.end(), std::array<std::int32_t, 3>{});
        for (int dy = -1; dy <= 1; ++dy) {
            const int from = std::clamp(y + dy, 0, height_ - 1);
            for (int x = 0; x < width_; ++x) {
                const std::uint8_t* rgb = colour_at(colour, x, from, width_, height_);
                for (std::size_t c = 0; c < 3; ++c) columns[static_cast<std::size_t>(x)][c] += rgb[c];
            }
        }
        for (int x = 0; x < width_; ++x) {
            const auto& left = columns[static_cast<std::size_t>(std::max(x - 1, 0))];
            const auto& here = columns[static_cast<std::size_t>(x)];
            const auto& right = columns[static_cast<std::size_t>(std::min(x + 1, width_ - 1))];
            const std::int32_t red = left[0] + here[0] + right[0], green = left[1] + here[1] + right[1],
                               blue = left[2] + here[2] + right[2];
            const std::int32_t level = (77 * red + 150 * green + 29 * blue) / 256;
            const std::int32_t share = shares_[static_cast<std::size_t>(level)];
            const std::size_t k = features.place(x, y);
            features.brightness[k] = static_cast<std::int16_t>(level * brightness_weight / window_pixels);
            features.red_green[k] = static_cast<std::int16_t>(((red - green) * share) >> share_bits);
            features.yellow_blue[k] =
                static_cast<std::int16_t>((((red + green) / 2 - blue) * share) >> share_bits);
        }
    }
}

}  // namespace touchable
