// SPDX-License-Identifier: Apache-2.0
// Touch in pictures of other programs: links to them, layers of one property each, joined into one plane,
// maps of a whole clip, videos of touch (TouchPictures).

#include "engine/formats/touch_maps.hpp"

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/tracks.hpp"
#include "engine/formats/formats_read.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/formats/stored_clip.hpp"
#include "engine/formats/video_picture.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/stream/stream_url.hpp"

namespace touchable {
namespace {

/// "http" of "http://host/a.png"; a drive's letter counts, too.
std::string scheme_of(std::string_view url) {
    const std::size_t colon = url.find(':');
    if (colon == std::string_view::npos ||
        url.substr(0, colon).find_first_of("/\\?#") != std::string_view::npos)
        return "";
    return small_letters(std::string(url.substr(0, colon)));
}

Result<LinkedFile> data_of(std::string_view url, const std::filesystem::path& holder) {
    const std::size_t comma = url.find(',');
    const bool is_base64 = comma != std::string_view::npos && url.substr(0, comma).ends_with(";base64");
    auto bytes = is_base64 ? decode_base64(url.substr(comma + 1), Base64Padding::optional) : std::nullopt;
    if (!bytes)
        return input_error(holder.string() + ": " + in_quotes(url.substr(0, 40)) +
                           " is damaged: must be data:TYPE;base64, and base64");
    return LinkedFile{{}, std::make_shared<const std::string>(std::move(*bytes)), holder.string()};
}

constexpr std::array<std::string_view, 3> channel_names{"red", "green", "blue"};

/// A pixel's channel in 8 bits; grey has only one. (A picture of floats has no samples.)
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

/// A picture of one property: grey, 8 bits.
struct LayerPicture {
    LinkedFile from;
    int channel = 0;  ///< of that picture
    Image image{};
};
/// `notes` gets what is lost.
Result<LayerPicture> read_layer(const LinkedFile& link, int channel, std::string_view property,
                                std::vector<ClipNote>& notes) {
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
    LayerPicture picture{link, channel, blank_image(image.width, image.height, 1, 1)};
    auto& samples = picture.image.samples;
    for (std::size_t k = 0; k < samples.size(); ++k) samples[k] = channel_of(stored, k, channel);
    return picture;
}

/// Index of the sample of `from` for each of `to`, resampled by way of a picture of `between`.
std::vector<int> samples_by_way(int from, int between, int to) {
    const std::vector<int> first = nearest_samples(from, between);
    std::vector<int> samples = nearest_samples(between, to);
    for (int& sample : samples) sample = first[static_cast<std::size_t>(sample)];
    return samples;
}

/// Copies a channel of a picture into one of an RGB picture, from these columns and rows.
void put_channel(const PlaneView& from, int channel, const std::vector<int>& columns,
                 const std::vector<int>& rows, std::size_t to_channel, Image& to) {
    std::uint8_t* pixel = to.samples.data() + to_channel;
    for (const int row : rows) {
        const std::uint8_t* const samples = from.row(row) + channel;
        for (const int column : columns) {
            *pixel = samples[std::ptrdiff_t{column} * from.channels];
            pixel += 3;
        }
    }
}

/// A picture to fill, no larger than the scene: 16000x16000 pixels for a small clip need not be held.
Image room_for(const TrackInfo& whole, const Scene& scene) {
    const std::size_t wanted = pixel_count(scene.width, scene.height);
    const bool is_smaller = wanted > 0 && wanted < pixel_count(whole.width, whole.height);
    return is_smaller ? blank_image(scene.width, scene.height, 1, 3)
                      : blank_image(whole.width, whole.height, 1, 3);
}

/// What a property's values are, for a person. `varies`: from black to white in a picture.
std::string property_words(std::size_t property, const PropertyRange& range, bool varies) {
    const std::string unit = property == 0 ? " N/mm" : "", name(property_names[property]);
    if (!varies) return name + " is " + short_number(range.min) + unit + " everywhere";
    return name + " goes from " + short_number(range.min) + " to " + short_number(range.max) + unit;
}

/// Joins all layers into one haptic picture, of the size of the first picture, or of the scene if that is
/// smaller; others are resampled to the nearest pixel. Pictures must be of integers: of grey 8 bits are kept,
/// of colour a channel. `scene` gets the ranges and remarks.
Result<StillPlane> join_layers(HapticLayers layers, std::string_view format, Scene& scene) {
    std::vector<ClipNote> notes = std::move(layers.notes);
    TrackInfo info{"haptic", std::string(format), "rgb24", 0, 0};
    Image joined{0, 0, 1, 3, {}};
    LayerPicture last;
    for (std::size_t k = 0; k < layers.properties.size(); ++k) {
        const auto& [picture, range, channel] = layers.properties[k];
        const std::string property(property_names[k]);
        if (!picture) {
            notes.push_back(property_words(k, range, false));
            continue;
        }
        if (last.image.samples.empty() || !(last.from == *picture) || last.channel != channel) {
            last = {};  // freed first: two large ones would be one too many
            TRY_ASSIGN(last, read_layer(*picture, channel, property, notes));
            if (!picture->file.empty()) layers.files.push_back(picture->file);
        }
        if (joined.samples.empty()) {
            info.width = last.image.width;
            info.height = last.image.height;
            joined = room_for(info, scene);
        }
        const int width = last.image.width, height = last.image.height;
        if (width != info.width || height != info.height)
            notes.push_back(property + " is " + size_text(width, height) +
                            ": resampled to the nearest pixel of " + size_text(info.width, info.height));
        put_channel(last.image.view(), 0, samples_by_way(width, info.width, joined.width),
                    samples_by_way(height, info.height, joined.height), k, joined);
        notes.push_back(property_words(k, range, true));
    }
    const auto& [stiffness, held, sliding] = layers.properties;
    if (sliding.range.max > held.range.max)
        notes.emplace_back(
            "dynamic friction goes beyond static friction: where it is above, both are as the static one");
    scene.remarks = joined_remarks(std::move(scene.remarks), layers.remarks);
    scene.haptic = {stiffness.range, held.range, sliding.range};
    return StillPlane{PlaneRole::haptic, plane_from(std::move(joined)), info, std::move(layers.files),
                      std::move(notes)};
}

/// The first letter after a byte order mark and blanks.
char first_letter(std::string_view text) {
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
    text = trimmed(text, " \t\r\n");
    return text.empty() ? '\0' : text.front();
}

TrackInfo track_of(PlaneRole role, const StoredImage& stored) {
    return {std::string(role_name(role)), stored.codec, stored.pixel_format, stored.image.width,
            stored.image.height};
}

/// Decodes a picture; an error if it cannot be touched.
Result<StoredImage> touch_picture(std::string_view bytes, PlaneRole role, const std::string& where) {
    TRY_ASSIGN(auto stored, decode_stored_image(std::string(bytes), where));
    if (!stored.values.empty()) return input_error(where + ": is a picture of floats: must be of integers");
    TRY_ASSIGN(auto fits, track_picture(std::move(stored), role, {}, where));
    return std::move(fits.image);
}

/// Widens samples of fewer than 8 bits to 8.
void widen(StoredImage& stored) {
    if (stored.bits >= 8) return;
    const int white = 255 / ((1 << stored.bits) - 1);
    for (auto& sample : stored.image.samples) sample = static_cast<std::uint8_t>(white * sample);
    stored.bits = 8;
}

Result<StillPlane> haptic_picture(const std::filesystem::path& file, std::string_view bytes, Scene& scene) {
    TRY_ASSIGN(auto stored, touch_picture(bytes, PlaneRole::haptic, file.string()));
    StillPlane still{PlaneRole::haptic, {}, track_of(PlaneRole::haptic, stored), {file}, {}};
    if (stored.image.channels == 1) {
        widen(stored);
        still.notes.push_back(take_grey_haptic(scene));
    }
    still.plane = plane_from(std::move(stored.image), stored.bits);
    return still;
}

/// Sets the height of white in a scene without one: a level, at most half of the nearest depth. Metric codes
/// begin near 0; those without room for a height become no depth.
void give_height(Scene& scene) {
    HeightCoding& height = scene.height_coding;
    DepthCoding& depth = scene.depth;
    const bool in_levels = depth.kind == DepthCodingKind::linear;
    double length = depth.level();
    if (depth.kind == DepthCodingKind::metric && depth.near < 2 * length) {
        depth.near = 2 * length;
        derive_valid_range(depth);
        add_remark(scene.remarks, {"depths below " + short_number(depth.near * scene.metres_per_unit * 1000) +
                                   " mm are taken for none, so that heights have room before the camera"});
    }
    length = std::min(length, depth.nearest_depth() / 2);
    height.units = in_levels ? HeightUnits::levels : HeightUnits::world;
    height.max_height = in_levels ? length / depth.level() : length;
}

/// Joins the pictures of all properties, one frame after the other.
class TouchPictures {
public:
    explicit TouchPictures(const ClipReader& clip) : scene_(clip.scene()), frames_(clip.frame_count()) {}

    /// Opens the sources. Returns the plane of frame 0, with notes for a person.
    Result<StillPlane> open(const TouchSources& sources) {
        StillPlane still{PlaneRole::haptic, {}, {"haptic", "", "rgb24", scene_.width, scene_.height}};
        const std::array<const PropertyRange*, 3> ranges{
            &scene_.haptic.stiffness, &scene_.haptic.static_friction, &scene_.haptic.dynamic_friction};
        for (std::size_t k = 0; k < sources.size(); ++k) {
            still.notes.push_back(property_words(k, *ranges[k], sources[k].has_value()));
            if (!sources[k]) continue;
            const TouchSource& wanted = *sources[k];
            const bool is_picture = wanted.video.empty();
            const auto known = std::ranges::find_if(layers_, [&](const auto& layer) {
                const TouchSource& source = layer->source;
                return source.video == wanted.video && source.track == wanted.track &&
                       source.picture == wanted.picture && (!is_picture || source.channel == wanted.channel);
            });
            const bool is_new = known == layers_.end();
            Layer& layer =
                is_new ? *layers_.emplace_back(std::make_unique<Layer>(Layer{.source = wanted})) : **known;
            properties_[k] = {&layer, wanted.channel};
            if (!is_new) continue;
            TRY(open_layer(layer, k, still));
            const auto& file = is_picture ? wanted.picture.file : wanted.video;
            if (!file.empty()) still.files.push_back(file);
        }
        TRY_ASSIGN(still.plane, at(0, 0));
        for (const auto& layer : layers_) {
            const PlaneView& view = layer->plane.view;
            if (view.width != scene_.width || view.height != scene_.height)
                still.notes.push_back(resampling_note(PlaneRole::haptic, view.width, view.height, scene_));
            if (!layer->video) continue;
            const TrackInfo stored = layer->video->info();
            still.info.codec = stored.codec;
            auto note = stored.lossless ? std::nullopt : lossy_note(PlaneRole::haptic, stored.codec);
            if (note && (still.notes.empty() || still.notes.back() != *note))
                still.notes.push_back(std::move(*note));
        }
        return still;
    }

    Result<Plane> at(std::int64_t frame, std::int64_t time_ns) {
        constexpr double ns_per_second = 1e9;
        bool is_other = newest_.view.empty();
        for (const auto& layer : layers_) {
            TRY_ASSIGN(const auto moved, go_on(*layer, frame, static_cast<double>(time_ns) / ns_per_second));
            is_other = is_other || moved;
        }
        if (!is_other) return newest_;
        Image joined = blank_image(scene_.width, scene_.height, 1, 3);
        for (std::size_t k = 0; k < properties_.size(); ++k) {
            if (!properties_[k].layer) continue;
            const PlaneView& from = properties_[k].layer->plane.view;
            const int channel = from.channels == 1 ? 0 : properties_[k].channel;
            put_channel(from, channel, nearest_samples(from.width, scene_.width),
                        nearest_samples(from.height, scene_.height), k, joined);
        }
        newest_ = plane_from(std::move(joined));
        return newest_;
    }

private:
    /// A video or a picture, of which several properties may be channels.
    struct Layer {
        TouchSource source;
        std::unique_ptr<VideoFile> video{};  // null: a picture
        RgbConverter converter{};
        std::int64_t number = -1;  // of the picture that `plane` is
        Plane plane{};
    };
    struct Property {
        Layer* layer = nullptr;
        int channel = 0;
    };

    Result<void> open_layer(Layer& layer, std::size_t property, StillPlane& still) {
        if (layer.source.video.empty()) {
            TRY_ASSIGN(auto read, read_layer(layer.source.picture, layer.source.channel,
                                             property_names[property], still.notes));
            layer.plane = plane_from(std::move(read.image));
            return {};
        }
        TRY_ASSIGN(layer.video,
                   VideoFile::open(SourceFile(layer.source.video), PlaneRole::haptic, layer.source.track));
        const VideoFile& opened = *layer.video;
        if (opened.note()) still.notes.push_back(*opened.note());
        if (!is_by_number(opened))
            still.notes.push_back(std::string(property_names[property]) + " has " +
                                  std::to_string(opened.count()) +
                                  " frames, depth another number: each depth has what is nearest in time");
        return {};
    }

    /// Moves a layer to a frame; returns whether its picture changed.
    Result<bool> go_on(Layer& layer, std::int64_t frame, double seconds) const {
        if (!layer.video) return false;
        VideoFile& video = *layer.video;
        const std::int64_t number = is_by_number(video) ? frame : video.nearest(seconds);
        if (number == layer.number) return false;
        TRY_ASSIGN(auto picture, picture_at(video, number, layer.converter));
        TRY_ASSIGN(layer.plane, picture.rgb());
        layer.number = number;
        return true;
    }

    bool is_by_number(const VideoFile& video) const { return frames_ && video.count() == *frames_; }

    Scene scene_;
    std::optional<std::int64_t> frames_;
    std::vector<std::unique_ptr<Layer>> layers_;
    std::array<Property, 3> properties_;
    Plane newest_;
};

}  // namespace

bool is_local_link(std::string_view url) {
    const std::string scheme = scheme_of(url);
    return !url.empty() && !url.starts_with("//") && (scheme.empty() || scheme == "file" || scheme == "data");
}

Result<LinkedFile> follow_link(std::string_view url, const std::filesystem::path& holder) {
    const std::string scheme = scheme_of(url);
    if (scheme == "data") return data_of(url, holder);
    if (!is_local_link(url))
        return input_error(holder.string() + ": names " + in_quotes(url) +
                           ": must be a file here, its name relative to that file");
    if (scheme == "file") url.remove_prefix(url.find(':') + 1);
    if (scheme == "file" && url.starts_with("//")) url.remove_prefix(2);
    const auto place = [&](std::string_view name) { return holder.parent_path() / std::string(name); };
    std::error_code ignored;
    const std::string plain = without_percents(url);
    constexpr std::size_t longest = 1000;
    if (plain.size() > longest ||
        std::ranges::any_of(plain, [](unsigned char c) { return c < 0x20 || c == 0x7f; }))
        return input_error(holder.string() + ": names " + in_quotes(url) +
                           ": must be the name of a file, at most 1000 letters and no control characters");
    const auto file = std::filesystem::exists(place(url), ignored) ? place(url) : place(plain);
    return LinkedFile{file, nullptr, file.string()};
}

Result<std::shared_ptr<const std::string>> bytes_of(const LinkedFile& link) {
    if (link.bytes) return link.bytes;
    TRY_ASSIGN(auto bytes, read_picture_bytes(link.file));
    return std::make_shared<const std::string>(std::move(bytes));
}

bool is_surface_file(const std::filesystem::path& file) {
    constexpr std::array<std::string_view, 4> endings{".x3d", ".x3dv", ".gltf", ".glb"};
    return std::ranges::count(endings, small_letters(file.extension().string())) > 0;
}

Result<StillPlane> read_haptic_map(const std::filesystem::path& file, Scene& scene) {
    TRY_ASSIGN(const auto bytes, read_picture_bytes(file));
    if (!picture_kind(bytes).empty()) return haptic_picture(file, bytes, scene);
    const std::string ending = small_letters(file.extension().string());
    const bool is_gltf = bytes.starts_with("glTF") || ending == ".gltf" || first_letter(bytes) == '{';
    const bool is_x3d = first_letter(bytes) == '<' || first_letter(bytes) == '#' || ending == ".x3d";
    if (!is_gltf && !is_x3d)
        return input_error(file.string() +
                           ": is no haptic map: must be a picture (RGB: stiffness, static and dynamic "
                           "friction; grey: stiffness), X3D (.x3d) or glTF (.gltf, .glb)");
    TRY_ASSIGN(auto layers,
               is_gltf ? read_gltf_material(file, bytes, scene) : read_x3d_surface(file, bytes, scene));
    return join_layers(std::move(layers), is_gltf ? "gltf" : "x3d", scene);
}

Result<StillPlane> read_height_map(const std::filesystem::path& file, Scene& scene) {
    TRY_ASSIGN(const auto bytes, read_picture_bytes(file));
    TRY_ASSIGN(auto stored, touch_picture(bytes, PlaneRole::height, file.string()));
    widen(stored);
    StillPlane still{PlaneRole::height, {}, track_of(PlaneRole::height, stored), {file}, {}};
    if (auto note = lossy_note(PlaneRole::height, stored.codec)) still.notes.push_back(std::move(*note));
    const bool is_stated = scene.height_coding.max_height > 0;
    if (!is_stated) {
        scene.height_coding.code_max = static_cast<std::uint16_t>((1 << stored.bits) - 1);
        give_height(scene);
    }
    const std::string white =
        "white in " + file.filename().string() + " is " +
        short_number(largest_height(scene.height_coding, scene.depth) * scene.metres_per_unit * 1000) +
        " mm high";
    if (is_stated)
        still.notes.push_back(white + ", as height_map says");
    else
        add_remark(scene.remarks, {white, true, "height_map.max in a scene file says otherwise"});
    still.plane = plane_from(std::move(stored.image), stored.bits);
    return still;
}

Result<std::unique_ptr<ClipReader>> with_still_maps(Result<std::unique_ptr<ClipReader>> clip,
                                                    const StillMaps& maps) {
    if (!clip) return clip;
    Scene scene = (*clip)->scene();
    std::vector<StillPlane> planes;
    for (const auto& [file, read] :
         {std::pair(&maps.haptic, &read_haptic_map), {&maps.height, &read_height_map}})
        if (*file) TRY(assign(planes.emplace_back(), read(**file, scene)));
    return with_still_planes(std::move(*clip), std::move(planes), scene);
}

Result<std::unique_ptr<ClipReader>> with_touch_videos(Result<std::unique_ptr<ClipReader>> clip,
                                                      const TouchSources& sources) {
    if (!clip) return clip;
    const auto pictures = std::make_shared<TouchPictures>(**clip);
    TRY_ASSIGN(auto still, pictures->open(sources));
    still.at = [pictures](std::int64_t frame, std::int64_t time_ns) { return pictures->at(frame, time_ns); };
    const Scene scene = (*clip)->scene();
    std::vector<StillPlane> planes;
    planes.push_back(std::move(still));
    return with_still_planes(std::move(*clip), std::move(planes), scene);
}

}  // namespace touchable
