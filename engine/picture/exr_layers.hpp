// SPDX-License-Identifier: Apache-2.0
#pragma once

// Roles of an OpenEXR file's channels, by their names, and linear light as samples.
//
// A file lists channels such as ViewLayer.Combined.R, of one part or several. exr_layers says which of them
// are depth, the colour that belongs to it, and material indices; exr_colour and exr_materials are for files
// that are read for these alone. srgb_sample makes a sample of a picture from linear light. Pure functions,
// for any thread.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace touchable {

/// A channel of an OpenEXR file: its part, and its whole name, such as ViewLayer.Depth.Z.
struct ExrChannelName {
    int part = 0;
    std::string name;
};

/// Roles of a file's channels, as places in the list of all. Depth is a channel Z, or one in a layer `depth`
/// or Unreal's `...WorldDepth` (R, if that is in colour), or else Y, R or the only one. Z of a vector (a
/// normal, a position) is not depth. Of several depths the first with colour of its own is taken: R, G and B
/// in the layer Combined of its view layer, or beside it. Material indices are the channel of its layer
/// IndexMA.
struct ExrLayers {
    std::optional<std::size_t> depth;
    std::optional<std::array<std::size_t, 3>> colour;  ///< red, green, blue
    std::optional<std::size_t> materials;
    std::vector<std::size_t> same_as_depth{};  ///< G and B if depth is R; colour if they differ
    bool depth_is_luminance = false;           ///< depth is Y, and beside it is chroma: a picture in colour
    /// Number of view layers that have depth.
    int depths = 0;
};
/// `depth`: the name of its channel, or of its layer (its R, or else its first channel); empty: found as
/// above. Case matters only if names differ in nothing else. Without depth if no name fits.
ExrLayers exr_layers(const std::vector<ExrChannelName>& channels, const std::string& depth = {});

/// Colour of a file with or without depth: of the depth's view layer, else of the first layer that has any.
std::optional<std::array<std::size_t, 3>> exr_colour(const std::vector<ExrChannelName>& channels);
/// The same for material indices; in a file with one channel it is that.
std::optional<std::size_t> exr_materials(const std::vector<ExrChannelName>& channels);

/// The name of a channel in one of several parts: if it has no layer of its own, a part named after a pass
/// (depth, normal, ...) is its layer.
std::string exr_name_in_part(const std::string& part, const std::string& channel);

/// "ViewLayer.Combined" of ViewLayer.Combined.R; empty for R.
std::string exr_layer_of(const std::string& channel);

/// Linear light, as renderers compute it, as a sample of an sRGB picture (IEC 61966-2-1): the nearest of 256;
/// 1 and beyond are 255, negative numbers and NaN are 0. The same bits everywhere.
std::uint8_t srgb_sample(float light);
/// The same for a float of 16 bits, by its bits.
std::uint8_t srgb_sample(std::uint16_t half);

}  // namespace touchable
