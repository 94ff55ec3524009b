#include "engine/formats/haptic_layers.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "engine/base/number_words.hpp"
#include "engine/base/stop_request.hpp"
#include "engine/base/try.hpp"
#include "engine/clip/resized_frame.hpp"
#include "engine/picture/stored_image.hpp"

namespace touchable {
namespace {

constexpr std::array<std::string_view, 3> channel_names{"red", "green", "blue"};

/// A sample's channel in 8 bits; of grey there is one. (A picture of floats has none.)
std::uint8_t channel_of(const StoredImage& stored, std::size_t pixel, int channel) {
    const Image& image = stored.image;
    const auto bytes = static_cast<std::size_t>(image.bytes_per_sample);
    const std::uint8_t* const sample =
        &image.samples[bytes * (pixel * static_cast<std::size_t>(image.channels) +
                                static_cast<std::size_t>(image.channels == 1 ? 0 : channel))];
    const unsigned most = image.channels == 1 ? (1U << static_cast<unsigned>(stored.bits)) - 1U : 255U;
    const unsigned value = bytes == 1 ? sample[0] : sample[0] | static_cast<unsigned>(sample[1]) << 8U;
    return static_cast<std::uint8_t>((std::min(value, most) * 255U + most / 2U) / most);
}

/// Samples of `from` for each of `to`, by way of a picture of `between`.
std::vector<int> samples_by_way(int from, int between, int to) {
    const std::vector<int> first = nearest_samples(from, between);
    std::vector<int> samples = nearest_samples(between, to);
    for (int& sample : samples) sample = first[static_cast<std::size_t>(sample)];
    return samples;
}

/// Into one channel of a picture of three, which stands for one of `whole`.
void put_channel(const LayerPicture& layer, std::size_t channel, const TrackInfo& whole, Image& to) {
    const auto columns = samples_by_way(layer.width, whole.width, to.width),
               rows = samples_by_way(layer.height, whole.height, to.height);
    std::uint8_t* pixel = to.samples.data() + channel;
    for (const int row : rows)
        for (const int column : columns) {
            *pixel = layer.samples[static_cast<std::size_t>(row) * static_cast<std::size_t>(layer.width) +
                                   static_cast<std::size_t>(column)];
            pixel += 3;
        }
}

/// No larger than what is made of it: a picture of 16000x16000 for a small clip need not be held.
Image room_for(const TrackInfo& whole, const Scene& scene) {
    const auto pixels = [](int width, int height) { return std::int64_t{width} * height; };
    const std::int64_t wanted = pixels(scene.width, scene.height);
    const bool is_smaller = wanted > 0 && wanted < pixels(whole.width, whole.height);
    Image image{is_smaller ? scene.width : whole.width, is_smaller ? scene.height : whole.height, 1, 3, {}};
    image.samples.resize(3 * static_cast<std::size_t>(pixels(image.width, image.height)));
    return image;
}

std::string size_words(int width, int height) {
    return std::to_string(width) + "x" + std::to_string(height);
}

}  // namespace

Result<LayerPicture> read_layer(const LinkedFile& link, int channel, std::string_view property,
                                std::vector<std::string>& notes) {
    TRY_ASSIGN(const auto bytes, bytes_of(link));
    const std::string where = link.name + " (" + std::string(property) + ")";
    TRY_ASSIGN(auto stored, decode_stored_image(std::string(*bytes), where));
    const Image& image = stored.image;
    if (!stored.values.empty()) return input_error(where + ": is a picture of floats: must be of integers");
    const std::string what = std::string(property) + ": " + link.name;
    const bool is_coloured = !is_grey(image);
    if (stop_requested()) return interrupted_error();
    if (is_coloured)
        notes.push_back(what + " is colour: its " +
                        std::string(channel_names[static_cast<std::size_t>(channel)]) + " is taken");
    if (image.channels == 1 && stored.bits > 8)
        notes.push_back(what + " has " + std::to_string(stored.bits) + " bits: 8 are kept");
    if (stored.codec == "mjpeg")
        notes.push_back(what + " is JPEG: where it changes sharply, values are a little off");
    LayerPicture picture{link, channel, image.width, image.height, {}};
    picture.samples.resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
    for (std::size_t k = 0; k < picture.samples.size(); ++k)
        picture.samples[k] = channel_of(stored, k, channel);
    return picture;
}

Result<StillPlane> join_layers(HapticLayers layers, std::string_view format, Scene& scene) {
    std::vector<std::string> notes = std::move(layers.notes);
    TrackInfo info{"haptic", std::string(format), "rgb24", 0, 0};
    Image joined{0, 0, 1, 3, {}};
    LayerPicture last;
    for (std::size_t k = 0; k < layers.properties.size(); ++k) {
        const auto& [picture, range, channel] = layers.properties[k];
        const std::string property(property_names[k]);
        if (!picture) {
            notes.push_back(property + " is " + short_number(range.min) + (k == 0 ? " N/mm" : "") +
                            " everywhere");
            continue;
        }
        if (last.samples.empty() || !(last.from == *picture) || last.channel != channel) {
            last = {};  // two large ones are one too many
            TRY_ASSIGN(auto read, read_layer(*picture, channel, property, notes));
            last = std::move(read);
            if (!picture->file.empty()) layers.files.push_back(picture->file);
        }
        if (joined.samples.empty()) {
            info.width = last.width;
            info.height = last.height;
            joined = room_for(info, scene);
        }
        if (last.width != info.width || last.height != info.height)
            notes.push_back(property + " is " + size_words(last.width, last.height) +
                            ": resampled to the nearest pixel of " + size_words(info.width, info.height));
        put_channel(last, k, info, joined);
        notes.push_back(property + " goes from " + short_number(range.min) + " to " +
                        short_number(range.max) + (k == 0 ? " N/mm" : ""));
    }
    const auto& [stiffness, held, sliding] = layers.properties;
    if (sliding.range.max > held.range.max)
        notes.push_back(
            "dynamic friction goes beyond static friction: where it is above, both are as the static one");
    scene.remarks = joined_remarks(std::move(scene.remarks), layers.remarks);
    scene.haptic = {stiffness.range, held.range, sliding.range};
    return StillPlane{PlaneRole::haptic, plane_from(std::move(joined)), info, std::move(layers.files),
                      std::move(notes)};
}

}  // namespace touchable
