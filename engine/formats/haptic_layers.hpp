#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/still_planes.hpp"
#include "engine/formats/linked_file.hpp"
#include "engine/scene/remark.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// What the surface of another program says of one property.
struct HapticLayer {
    std::optional<LinkedFile> picture;  ///< nothing: the same everywhere
    PropertyRange range{};              ///< at black and white; both the same without a picture
    int channel = 0;                    ///< of a picture in colour: red, green or blue
};

/// Its stiffness (N/mm), static and dynamic friction.
struct HapticLayers {
    std::array<HapticLayer, 3> properties;
    std::vector<std::string> notes{};
    std::vector<Remark> remarks{};               ///< what was assumed of their values
    std::vector<std::filesystem::path> files{};  ///< that were read for it, its own first
};
inline constexpr std::array<std::string_view, 3> property_names{"stiffness", "static friction",
                                                                "dynamic friction"};

/// A picture of one property: grey, 8 bits.
struct LayerPicture {
    LinkedFile from;
    int channel = 0;  ///< of that
    int width = 0, height = 0;
    std::vector<std::uint8_t> samples;
};
/// `notes` gets what is lost.
Result<LayerPicture> read_layer(const LinkedFile& link, int channel, std::string_view property,
                                std::vector<std::string>& notes);

/// One haptic picture of all layers, of the size of the first that is a picture, or of the scene's where that
/// is smaller; others are resampled to the nearest pixel. Each must be whole: 8 bits are kept of grey, and
/// a channel of colour. `scene` gets the ranges, and the remarks.
Result<StillPlane> join_layers(HapticLayers layers, std::string_view format, Scene& scene);

}  // namespace touchable
