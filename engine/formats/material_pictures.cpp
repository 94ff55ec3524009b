#include "engine/formats/material_pictures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <set>

namespace touchable {
namespace {

constexpr std::size_t no_index = largest_material_index + 1;
constexpr std::size_t most_told = 12;

std::size_t index_of(float value) {
    const bool is_index = value >= 0 && value <= largest_material_index && value == std::floor(value);
    return is_index ? static_cast<std::size_t>(value) : no_index;
}

std::size_t index_at(const StoredImage& picture, std::size_t k) {
    if (!picture.values.empty()) return index_of(picture.values[k]);
    if (picture.image.bytes_per_sample == 1) return picture.image.samples[k];
    std::uint16_t word = 0;
    std::memcpy(&word, picture.image.samples.data() + 2 * k, 2);
    return word;
}

std::size_t pixels_of(const StoredImage& picture) {
    return static_cast<std::size_t>(picture.image.width) * static_cast<std::size_t>(picture.image.height);
}

/// The nearest sample of the range.
std::uint8_t sample_of(double value, const PropertyRange& range) {
    if (!(range.max > range.min)) return 0;
    const double share = (value - range.min) / (range.max - range.min);
    return static_cast<std::uint8_t>(std::clamp(share, 0.0, 1.0) * 255 + 0.5);
}

}  // namespace

std::vector<int> indices_in(const StoredImage& picture) {
    std::set<int> found;
    for (std::size_t k = 0; k < pixels_of(picture) && found.size() < most_told; ++k)
        if (const std::size_t index = index_at(picture, k); index != no_index)
            found.insert(static_cast<int>(index));
    return {found.begin(), found.end()};
}

MaterialPictures::MaterialPictures(const SceneDescription& described) : samples_(3 * (no_index + 1)) {
    const Scene& scene = described.scene;
    const auto set = [&](std::size_t index, const HapticProperties& properties) {
        samples_[3 * index] = sample_of(properties.stiffness / 1000, scene.haptic.stiffness);
        samples_[3 * index + 1] = sample_of(properties.static_friction, scene.haptic.static_friction);
        samples_[3 * index + 2] = sample_of(properties.dynamic_friction, scene.haptic.dynamic_friction);
    };
    for (std::size_t index = 0; index <= no_index; ++index) set(index, scene.default_properties);
    for (const Material& material : described.materials)
        set(static_cast<std::size_t>(material.index), material.properties);
}

Result<StoredImage> MaterialPictures::haptic(const StoredImage& indices) const {
    if (indices.image.channels != 1)
        return input_error(
            "is in colour: where the scene has haptic.materials, haptic pictures are of material indices");
    StoredImage made{{indices.image.width, indices.image.height, 1, 3, {}}, indices.codec, "rgb24"};
    made.image.samples.resize(3 * pixels_of(indices));
    std::uint8_t* to = made.image.samples.data();
    for (std::size_t k = 0; k < pixels_of(indices); ++k, to += 3)
        std::memcpy(to, &samples_[3 * index_at(indices, k)], 3);
    return made;
}

}  // namespace touchable
