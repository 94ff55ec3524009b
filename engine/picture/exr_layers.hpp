#pragma once

// What the channels of an OpenEXR file are, by their names, and linear light as samples.
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

/// Which of a file's channels are what, by their places in the list of all. Depth is a channel Z, or one in a
/// layer `depth`, or `...WorldDepth` as Unreal calls it (R, where that is in colour), or else Y, R or the
/// only one. Z of a vector (a normal, a position) is none. Of several depths the first that has colour of its
/// own is taken: R, G and B in the layer Combined of its view layer, or beside it. Material indices are the
/// channel of its layer IndexMA.
struct ExrLayers {
    std::optional<std::size_t> depth;
    std::optional<std::array<std::size_t, 3>> colour;  ///< red, green, blue
    std::optional<std::size_t> materials;
    std::vector<std::size_t> same_as_depth{};  ///< G and B, where depth is R: a picture in colour is none
    bool depth_is_luminance = false;           ///< depth is Y, and beside it is chroma: a picture in colour
    /// How many view layers have depth.
    int depths = 0;
};
ExrLayers exr_layers(const std::vector<ExrChannelName>& channels);
/// The same where depth is said to be the channel of this name, or the first one (R before others) of the
/// layer of this name; capital letters count only where two names differ by these. Without depth: there is
/// none.
ExrLayers exr_layers(const std::vector<ExrChannelName>& channels, const std::string& depth);

/// Colour of a file with or without depth: of the depth's view layer, else of the first layer that has any.
std::optional<std::array<std::size_t, 3>> exr_colour(const std::vector<ExrChannelName>& channels);
/// The same of material indices; a file with one channel has nothing else.
std::optional<std::size_t> exr_materials(const std::vector<ExrChannelName>& channels);

/// A channel of one of several parts: where it has no layer of its own, a part whose name says which pass it
/// is (depth, normal, ...) is that.
std::string exr_name_in_part(const std::string& part, const std::string& channel);

/// "ViewLayer.Combined" of ViewLayer.Combined.R; empty for R.
std::string exr_layer_of(const std::string& channel);

/// Linear light, as renderers compute it, as a sample of an sRGB picture (IEC 61966-2-1): the nearest of 256;
/// 1 and beyond are 255, what is negative or no number is 0. The same bits everywhere.
std::uint8_t srgb_sample(float light);
/// The same of a float of 16 bits, by its bits.
std::uint8_t srgb_sample(std::uint16_t half);

}  // namespace touchable
