#include "engine/content/materials/haptic_painter.hpp"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <limits>

namespace touchable {
namespace {

constexpr std::int32_t straight = 3, diagonal = 4, nowhere = std::numeric_limits<std::int32_t>::max() / 2;
constexpr int level_height = 128, top_height = 255;

void widen_to(PropertyRange& range, double value) {
    range.min = std::min(range.min, value);
    range.max = std::max(range.max, value);
}

std::uint8_t nearest_code(double value, const PropertyRange& range) {
    if (!(range.max > range.min)) return 0;
    const double share = (value - range.min) / (range.max - range.min);
    return static_cast<std::uint8_t>(std::clamp(share, 0.0, 1.0) * 255 + 0.5);
}

}  // namespace

HapticRanges ranges_of_palette(const Scene& scene, const std::vector<Feel>& others) {
    PropertyRange stiffness{as_stiff_as_the_device, as_stiff_as_the_device}, friction{0, 0};
    const auto hold = [&](const HapticProperties& properties) {
        widen_to(stiffness, properties.stiffness / 1000);
        widen_to(friction, properties.static_friction);
        widen_to(friction, properties.dynamic_friction);
    };
    for (const PaletteMaterial& material : palette()) hold(material.feel().properties);
    hold(scene.default_properties);
    for (const Feel& feel : others) hold(feel.properties);
    return {stiffness, friction, friction};
}

std::array<std::uint8_t, 3> haptic_code(const HapticProperties& properties, const HapticRanges& ranges) {
    return {nearest_code(properties.stiffness / 1000, ranges.stiffness),
            nearest_code(properties.static_friction, ranges.static_friction),
            nearest_code(properties.dynamic_friction, ranges.dynamic_friction)};
}

void HapticPainter::set(std::uint16_t label, const Feel& feel) {
    codes_[label] = haptic_code(feel.properties, ranges_);
    reliefs_[label] = feel.relief;
}

/// The nearest segment's label, by a distance transform with weights of 3 and 4 (chamfer): once from the
/// upper left and once back.
void HapticPainter::fill(const Segmentation& segmentation) {
    labels_ = segmentation.labels;
    const std::ptrdiff_t width = segmentation.width, height = segmentation.height;
    if (std::find(labels_.begin(), labels_.end(), 0) == labels_.end()) return;
    distances_.resize(labels_.size());
    std::transform(labels_.begin(), labels_.end(), distances_.begin(),
                   [](std::uint16_t label) { return label == 0 ? nowhere : 0; });
    const auto pass = [&](std::ptrdiff_t step) {
        const auto count = static_cast<std::ptrdiff_t>(labels_.size());
        for (std::ptrdiff_t k = step > 0 ? 0 : count - 1; k >= 0 && k < count; k += step) {
            const auto at = static_cast<std::size_t>(k);
            if (distances_[at] == 0) continue;
            const std::ptrdiff_t x = k % width, y = k / width;
            const auto look = [&](std::ptrdiff_t dx, std::ptrdiff_t dy, std::int32_t weight) {
                if (x + dx < 0 || x + dx >= width || y + dy < 0 || y + dy >= height) return;
                const auto from = static_cast<std::size_t>(k + dy * width + dx);
                if (distances_[from] + weight >= distances_[at]) return;
                distances_[at] = distances_[from] + weight;
                labels_[at] = labels_[from];
            };
            look(-step, 0, straight);
            look(0, -step, straight);
            look(-step, -step, diagonal);
            look(step, -step, diagonal);
        }
    };
    pass(1);
    pass(-1);
}

Image HapticPainter::haptic(const Segmentation& segmentation) {
    fill(segmentation);
    Image image{segmentation.width, segmentation.height, 1, 3, {}};
    image.samples.resize(3 * labels_.size());
    std::uint8_t* to = image.samples.data();
    for (const std::uint16_t label : labels_) {
        std::memcpy(to, codes_[label].data(), 3);
        to += 3;
    }
    return image;
}

Image HapticPainter::scaled(const PlaneView& height) const {
    Image image{height.width, height.height, 1, 1, {}};
    image.samples.reserve(labels_.size());
    std::size_t k = 0;
    for (int y = 0; y < height.height; ++y)
        for (int x = 0; x < height.width; ++x, ++k) {
            const int above = (height.sample(x, y) - level_height) * reliefs_[labels_[k]] / 100;
            image.samples.push_back(
                static_cast<std::uint8_t>(std::clamp(level_height + above, 0, top_height)));
        }
    return image;
}

}  // namespace touchable
