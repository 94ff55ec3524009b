// SPDX-License-Identifier: Apache-2.0
#include "engine/picture/exr_layers.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <set>
#include <string_view>
#include <utility>

#include "engine/base/words.hpp"

namespace touchable {

namespace {

using ExrChannelNames = std::vector<ExrChannelName>;
using ExrColour = std::array<std::size_t, 3>;

ExrChannelNames in_small_letters(ExrChannelNames channels) {
    for (ExrChannelName& channel : channels) channel.name = small_letters(std::move(channel.name));
    return channels;
}

/// The words of a name between its dots: the last is the channel's own.
std::vector<std::string> words_of(const std::string& channel) {
    std::vector<std::string> words(1);
    for (const char c : channel)
        if (c == '.')
            words.emplace_back();
        else
            words.back() += c;
    return words;
}

std::string joined_words(const std::vector<std::string>& words) {
    std::string name;
    for (const std::string& word : words)
        if (!word.empty()) name += (name.empty() ? "" : ".") + word;
    return name;
}

/// The channel of this name, from part `home` if that has one. From here on names are in small letters.
std::optional<std::size_t> channel_named(const ExrChannelNames& channels, const std::string& name, int home) {
    std::optional<std::size_t> elsewhere;
    for (std::size_t k = 0; k < channels.size(); ++k) {
        if (channels[k].name != name) continue;
        if (channels[k].part == home) return k;
        if (!elsewhere) elsewhere = k;
    }
    return elsewhere;
}

/// R, G and B of a layer, all from one part.
std::optional<ExrColour> colour_in_layer(const ExrChannelNames& channels, const std::string& layer,
                                         int home) {
    const std::string before = layer.empty() ? "" : layer + '.';
    const auto red = channel_named(channels, before + "r", home);
    if (!red) return std::nullopt;
    const int part = channels[*red].part;
    const auto green = channel_named(channels, before + "g", part),
               blue = channel_named(channels, before + "b", part);
    if (!green || !blue || channels[*green].part != part || channels[*blue].part != part) return std::nullopt;
    return ExrColour{*red, *green, *blue};
}

/// Unreal's passes are called FinalImageMovieRenderQueue_WorldDepth or FinalImageSceneDepth.
bool is_depth_of_unreal(const std::string& word) {
    return word.ends_with("worlddepth") || word.ends_with("scenedepth");
}
bool is_depth_word(const std::string& word) {
    return word == "depth" || word == "denoising depth" || is_depth_of_unreal(word);
}
bool is_named_depth(const std::string& channel) {
    const auto words = words_of(channel);
    return std::ranges::any_of(words, is_depth_word);
}

/// Another channel of the same layer and part, by its own name.
std::optional<std::size_t> channel_beside(const ExrChannelNames& channels, std::size_t k, const char* own) {
    const std::string layer = exr_layer_of(channels[k].name);
    const auto beside = channel_named(channels, (layer.empty() ? "" : layer + '.') + own, channels[k].part);
    const bool is_beside = beside && *beside != k && channels[*beside].part == channels[k].part;
    return is_beside ? beside : std::nullopt;
}

/// Green and blue beside red, or the chroma beside luminance.
bool is_rest_of_colour(const ExrChannelNames& channels, std::size_t k, const std::string& own) {
    if (own == "g" || own == "b") return channel_beside(channels, k, "r").has_value();
    return (own == "ry" || own == "by") && channel_beside(channels, k, "y");
}

/// Whether a pass is known not to be depth, whatever its channels are called.
bool is_of_other_pass(const std::vector<std::string>& words) {
    constexpr std::string_view others[] = {"mist",           "normal",       "denoising normal", "position",
                                           "vector",         "uv",           "indexma",          "indexob",
                                           "material index", "object index", "combined"};
    return std::any_of(words.begin(), words.end() - 1, [&](const std::string& word) {
        return std::ranges::find(others, word) != std::end(others);
    });
}

/// Whether that channel's layer is the file's only one.
bool is_only_layer(const ExrChannelNames& channels, std::size_t k) {
    return std::ranges::all_of(channels, [&](const ExrChannelName& other) {
        return other.part == channels[k].part && exr_layer_of(other.name) == exr_layer_of(channels[k].name);
    });
}

/// How well a channel fits as depth; 0: not at all.
int depth_rank(const ExrChannelNames& channels, std::size_t k) {
    const std::string& name = channels[k].name;
    const std::vector<std::string> words = words_of(name);
    const std::string& own = words.back();
    const bool is_of_vector = channel_beside(channels, k, "x").has_value();
    if (is_of_other_pass(words)) return 0;
    if (own == "z" && !is_of_vector) return std::ranges::count(words, "depth") > 0 ? 5 : 4;
    if (is_named_depth(name) && own != "a" && !is_rest_of_colour(channels, k, own)) return 3;
    if (is_of_vector || !is_only_layer(channels, k)) return 0;
    return own == "y" ? 2 : own == "r" ? 1 : 0;
}

/// A layer's name with `pass` in place of `count` words from words[first]; the rest names the view layer.
std::string layer_of_pass(const std::vector<std::string>& words, std::size_t first, std::size_t count,
                          const std::string& pass) {
    std::vector<std::string> layer(words.begin(), words.begin() + static_cast<std::ptrdiff_t>(first));
    layer.push_back(pass);
    layer.insert(layer.end(), words.begin() + static_cast<std::ptrdiff_t>(first + count), words.end() - 1);
    return joined_words(layer);
}

/// The name of another pass in the view layer of a depth.
std::string pass_beside(const std::string& depth, const std::string& pass) {
    const std::vector<std::string> words = words_of(depth);
    const auto found = std::find_if(words.begin(), words.end() - 1, is_depth_word);
    const bool is_in_layer = found != words.end() - 1;
    return layer_of_pass(words, static_cast<std::size_t>(found - words.begin()), is_in_layer ? 1 : 0, pass);
}

constexpr const char* colour_passes[] = {"combined", "", "rgba", "beauty", "color", "colour", "image"};
constexpr const char* material_passes[] = {"indexma", "material index"};

std::optional<ExrColour> colour_beside(const ExrChannelNames& channels, std::size_t depth) {
    for (const char* pass : colour_passes)
        if (const auto found =
                colour_in_layer(channels, pass_beside(channels[depth].name, pass), channels[depth].part))
            return found;
    return std::nullopt;
}

/// The first channel of a layer.
std::optional<std::size_t> channel_in_layer(const ExrChannelNames& channels, const std::string& layer) {
    for (std::size_t k = 0; k < channels.size(); ++k)
        if (exr_layer_of(channels[k].name) == layer) return k;
    return std::nullopt;
}

std::optional<std::size_t> materials_beside(const ExrChannelNames& channels, std::size_t depth) {
    for (const char* pass : material_passes)
        if (const auto found = channel_in_layer(channels, pass_beside(channels[depth].name, pass)))
            return found;
    return std::nullopt;
}

/// Number of view layers that these depths are in.
int view_layers_of(const ExrChannelNames& channels, const std::vector<std::size_t>& depths) {
    std::set<std::pair<int, std::string>> layers;
    for (const std::size_t k : depths) layers.emplace(channels[k].part, pass_beside(channels[k].name, ""));
    return static_cast<int>(layers.size());
}

/// Finds the channels that must equal depth; otherwise it is a picture in colour.
void find_rest_of_colour(const ExrChannelNames& channels, ExrLayers& layers) {
    const std::size_t depth = *layers.depth;
    const std::string own = words_of(channels[depth].name).back();
    for (const char* rest : {"g", "b"})
        if (const auto beside = channel_beside(channels, depth, rest); own == "r" && beside)
            layers.same_as_depth.push_back(*beside);
    layers.depth_is_luminance =
        own == "y" && (channel_beside(channels, depth, "ry") || channel_beside(channels, depth, "by"));
}

ExrLayers depth_and_beside(const ExrChannelNames& channels) {
    ExrLayers layers;
    int best = 0;
    std::vector<std::size_t> depths;
    for (std::size_t k = 0; k < channels.size(); ++k) {
        const int rank = depth_rank(channels, k);
        if (rank > best) depths.clear();
        best = std::max(best, rank);
        if (rank == best && rank > 0) depths.push_back(k);
    }
    if (depths.empty()) {
        if (channels.size() == 1 && !is_of_other_pass(words_of(channels[0].name))) layers.depth = 0;
        return layers;
    }
    layers.depth = depths.front();
    layers.depths = view_layers_of(channels, depths);
    if (best < 3) return layers;  // a picture of one channel, or of colour that is grey
    for (const std::size_t depth : depths)
        if (const auto colour = colour_beside(channels, depth)) {
            layers.depth = depth;
            layers.colour = colour;
            break;
        }
    if (!layers.colour) layers.colour = colour_in_layer(channels, "", channels[*layers.depth].part);
    layers.materials = materials_beside(channels, *layers.depth);
    return layers;
}

ExrLayers layers_among(const ExrChannelNames& channels) {
    ExrLayers layers = depth_and_beside(channels);
    if (layers.depth) find_rest_of_colour(channels, layers);
    return layers;
}

/// By Newton's method, of a number between 0.01 and 1.1.
double fifth_root(double number) {
    double root = 1;
    for (int step = 0; step < 30; ++step) root = (4 * root + number / (root * root * root * root)) / 5;
    return root;
}

double light_of(double srgb) {
    if (srgb <= 0.04045) return srgb / 12.92;
    const double base = (srgb + 0.055) / 1.055, root = fifth_root(base);
    return base * base * root * root;  // to the power of 2.4
}

/// By a float's upper 16 bits: a sample that is the right one or next to it.
struct SrgbTable {
    std::array<float, 257> least{};  // least light of each sample, then infinity
    std::array<std::uint8_t, 0x3f80> first{};

    SrgbTable() {
        for (std::size_t k = 1; k < 256; ++k)
            least[k] = static_cast<float>(light_of((static_cast<double>(k) - 0.5) / 255));
        least[256] = std::numeric_limits<float>::infinity();
        for (std::size_t k = 0, sample = 0; k < first.size(); ++k) {
            const auto light = std::bit_cast<float>(static_cast<std::uint32_t>(k) << 16U);
            while (light >= least[sample + 1]) ++sample;
            first[k] = static_cast<std::uint8_t>(sample);
        }
    }
};

/// The sample of every float of 16 bits from 0 to below 1.
struct HalfTable {
    std::array<std::uint8_t, 0x3c00> sample{};

    HalfTable() {
        double light = 0, step = 1.0 / (1 << 24);  // halves of an exponent are evenly spaced
        for (std::size_t bits = 0; bits < sample.size(); ++bits, light += step) {
            if (bits >= 2048 && bits % 1024 == 0) step *= 2;
            sample[bits] = srgb_sample(static_cast<float>(light));
        }
    }
};

}  // namespace

std::string exr_layer_of(const std::string& channel) {
    const std::size_t dot = channel.rfind('.');
    return dot == std::string::npos ? "" : channel.substr(0, dot);
}

std::string exr_name_in_part(const std::string& part, const std::string& channel) {
    const std::string whole = part + '.' + channel;
    const auto words = words_of(small_letters(whole));
    const bool tells = is_of_other_pass(words) || std::any_of(words.begin(), words.end() - 1, is_depth_word);
    return tells && channel.find('.') == std::string::npos ? whole : channel;
}

bool is_exr_depth_of_renderer(const std::string& channel) {
    const auto words = words_of(small_letters(channel));
    return words.back() == "z" || std::ranges::any_of(words, is_depth_word);
}

bool is_exr_depth_of_unreal(const std::string& channel) {
    return std::ranges::any_of(words_of(small_letters(channel)), is_depth_of_unreal);
}

ExrLayers exr_layers(const ExrChannelNames& named, const std::string& depth) {
    const ExrChannelNames channels = in_small_letters(named);
    if (depth.empty()) return layers_among(channels);
    const std::string small = small_letters(depth);
    ExrLayers layers;
    if (const auto exact = std::ranges::find(named, depth, &ExrChannelName::name); exact != named.end())
        layers.depth = static_cast<std::size_t>(exact - named.begin());
    for (const std::string& name : {small, small + ".r", small + ".z"})
        if (!layers.depth) layers.depth = channel_named(channels, name, 0);
    if (!layers.depth) layers.depth = channel_in_layer(channels, small);
    if (!layers.depth) return layers;
    layers.depths = 1;
    layers.colour = colour_beside(channels, *layers.depth);
    if (!layers.colour) layers.colour = colour_in_layer(channels, "", channels[*layers.depth].part);
    layers.materials = materials_beside(channels, *layers.depth);
    // A channel that is depth is nothing else.
    if (layers.colour && std::ranges::count(*layers.colour, *layers.depth) > 0) layers.colour.reset();
    if (layers.materials == layers.depth) layers.materials.reset();
    return layers;
}

std::optional<ExrColour> exr_colour(const ExrChannelNames& named) {
    const ExrChannelNames channels = in_small_letters(named);
    if (const auto of_depth = layers_among(channels).colour) return of_depth;
    std::optional<ExrColour> first;
    for (const ExrChannelName& channel : channels) {
        const std::string layer = exr_layer_of(channel.name);
        const auto found = colour_in_layer(channels, layer, channel.part);
        if (found && (layer.empty() || layer.ends_with("combined"))) return found;
        if (!first) first = found;
    }
    return first;
}

std::optional<std::size_t> exr_materials(const ExrChannelNames& named) {
    const ExrChannelNames channels = in_small_letters(named);
    if (const auto of_depth = layers_among(channels).materials) return of_depth;
    for (std::size_t k = 0; k < channels.size(); ++k) {
        const std::vector<std::string> words = words_of(channels[k].name);
        for (const char* pass : material_passes)
            if (std::find(words.begin(), words.end() - 1, pass) != words.end() - 1) return k;
    }
    return channels.size() == 1 ? std::optional<std::size_t>(0) : std::nullopt;
}

std::uint8_t srgb_sample(std::uint16_t half) {
    static const HalfTable table;
    if (half < table.sample.size()) return table.sample[half];
    return half <= 0x7c00 ? 255 : 0;  // 1 to infinity; NaN, or negative
}

std::uint8_t srgb_sample(float light) {
    static const SrgbTable table;
    if (!(light > 0)) return 0;
    if (light >= 1) return 255;
    std::size_t sample = table.first[std::bit_cast<std::uint32_t>(light) >> 16U];
    while (light >= table.least[sample + 1]) ++sample;
    return static_cast<std::uint8_t>(sample);
}

}  // namespace touchable
