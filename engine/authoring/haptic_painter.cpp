#include "engine/authoring/haptic_painter.hpp"

#include <algorithm>
#include <cstddef>
#include <cstring>

namespace touchable {
namespace {

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

Image HapticPainter::haptic(const std::vector<std::uint16_t>& labels, int width, int height) {
    labels_ = labels;
    nearest_.fill(labels_, width, height);
    Image image{width, height, 1, 3, {}};
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
