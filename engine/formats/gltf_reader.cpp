// SPDX-License-Identifier: Apache-2.0
// A glTF file of version 2, its haptic material, and the clip in its textures. All functions before read_gltf
// may throw: a checked_json::Refusal, or the Error of a file that the glTF names.

#include "engine/formats/formats_read.hpp"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>

#include "engine/base/result.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/formats/touch_maps.hpp"
#include "engine/scene/checked_json.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {
namespace {

using checked_json::Node;
using checked_json::Refusal;

/// A video as a texture (MPEG_texture_video): tracks of a file.
struct GltfVideo {
    std::string file;                   ///< as its uri says
    std::vector<std::uint32_t> tracks;  ///< their numbers in that file; empty: not stated
    int width = 0, height = 0;          ///< pixels
};

/// The value of a Result; throws its error.
template <class T>
T or_throw(Result<T> result) {
    if (!result) throw result.error();
    return std::move(*result);
}

std::vector<Node> gltf_array(const Node& array) {
    constexpr std::size_t most = 1'000'000;
    return array.elements(0, most, "an array");
}

/// A node's extension of this name, if it has it.
std::optional<Node> gltf_extension(const Node& node, const char* name) {
    if (!node.has("extensions")) return std::nullopt;
    const Node all = node["extensions"];
    if (!all.is_object()) all.refuse("an object {...}");
    return all.has(name) ? std::optional(all[name]) : std::nullopt;
}

/// The array's element with the number `index`; `what`: the array in words, such as "textures".
Node one_of(const Node& array, const Node& index, const std::string& what) {
    const auto found = array.element(static_cast<std::size_t>(index.whole()));
    if (!found) index.refuse("a number of one of " + std::to_string(array.size()) + " " + what);
    return *found;
}

/// Bytes; a value of three bytes of text takes a hundred of memory.
constexpr std::size_t largest_json = std::size_t{8} << 20U;

std::size_t word_at(std::string_view bytes, std::size_t at) {
    return number_in_bytes(bytes.substr(at, 4), false);
}

/// A file's JSON; `carried` becomes the bytes that a GLB carries beside it.
std::string_view json_in(std::string_view bytes, std::optional<std::string_view>& carried) {
    if (!bytes.starts_with("glTF")) return bytes;
    if (bytes.size() < 12 || word_at(bytes, 4) != 2)
        throw Refusal{"is no GLB of version 2, which is the one that is read"};
    std::string_view json;
    for (std::size_t at = 12; at + 8 <= bytes.size();) {
        const std::size_t length = word_at(bytes, at);
        const std::string_view kind = bytes.substr(at + 4, 4);
        at += 8;
        if (length > bytes.size() - at) throw Refusal{"is damaged: it ends within a chunk"};
        if (kind == "JSON" && json.empty()) json = bytes.substr(at, length);
        if (kind == std::string_view("BIN\0", 4) && !carried) carried = bytes.substr(at, length);
        at += length;
    }
    if (json.empty()) throw Refusal{"is damaged: has no JSON"};
    return json;
}

/// The number in "#track_ID=2" (ISO/IEC 14496-12, Annex C).
std::uint32_t track_number(const Node& track) {
    constexpr std::string_view begin = "#track_ID=";
    const std::string text = track.text();
    if (!text.starts_with(begin)) track.refuse("\"#track_ID=N\"");
    const auto number = parsed_as<std::uint32_t>(std::string_view(text).substr(begin.size())).value_or(0);
    if (number == 0) track.refuse("\"#track_ID=N\", N from 1");
    return number;
}

/// The first alternative that is a local file; nothing is ever fetched.
Node local_alternative(const Node& media) {
    const std::vector<Node> all = gltf_array(media["alternatives"]);
    for (const Node& one : all)
        if (is_local_link(one["uri"].text())) return one;
    if (all.empty()) media["alternatives"].refuse("an array with an element");
    all.front()["uri"].refuse("the name of a file beside it, as nothing is fetched");
}

/// A file's JSON, .gltf or .glb, and the bytes that it carries. `bytes` must outlive it.
class GltfFile : NonCopyable {
public:
    GltfFile(const std::filesystem::path& file, std::string_view bytes) : file_(file) {
        json_ = checked_json::parse(json_in(bytes, carried_), largest_json);
        if (!root().has("asset") || !root()["asset"].has("version")) return;
        const Node version = root()["asset"]["version"];
        if (!version.text().starts_with("2.")) version.refuse("2.0 or another 2, which alone is read");
    }

    const std::filesystem::path& file() const { return file_; }
    Node root() const { return {json_, ""}; }
    /// An element of one of the root's arrays, such as textures[2].
    Node element(const char* array, const Node& index) const { return one_of(root()[array], index, array); }
    Node texture(std::size_t number) const {
        const Node all = root()["textures"];
        const auto found = all.element(number);
        if (!found)
            throw Refusal{"names texture " + std::to_string(number) + ", but has " +
                          std::to_string(all.size())};
        return *found;
    }

    /// The picture that a texture shows. `texture`: an element of the array "textures".
    LinkedFile picture(const Node& texture) {
        if (!texture.has("source"))
            throw Refusal{
                "a texture has no source: must be a PNG or JPEG; pictures of extensions are not read"};
        const Node image = element("images", texture["source"]);
        if (!image.has("bufferView")) return linked(image["uri"].text());
        return carried_picture(element("bufferViews", image["bufferView"]));
    }

    /// The video that a texture shows, found through accessor, view and buffer; nothing if it has no
    /// MPEG_texture_video. Of a medium's alternatives, the first local file.
    std::optional<GltfVideo> video(const Node& texture) const {
        const auto moving = gltf_extension(texture, "MPEG_texture_video");
        if (!moving) return std::nullopt;
        GltfVideo video;
        video.width = (*moving)["width"].whole(1, largest_picture_side);
        video.height = (*moving)["height"].whole(1, largest_picture_side);
        const Node view = element("bufferViews", element("accessors", (*moving)["accessor"])["bufferView"]);
        const Node buffer = element("buffers", view["buffer"]);
        const auto frames = gltf_extension(buffer, "MPEG_buffer_circular");
        if (!frames)
            throw Refusal{"the buffer of a video has no MPEG_buffer_circular: must say of which media it is"};
        const auto files = gltf_extension(root(), "MPEG_media");
        if (!files) throw Refusal{"has no extensions.MPEG_media: must say which files its videos are"};
        const Node media = (*files)["media"];
        const Node file = local_alternative(one_of(media, (*frames)["media"], "media"));
        video.file = file["uri"].text();
        if (!file.has("tracks")) return video;
        const std::vector<Node> tracks = gltf_array(file["tracks"]);
        if (!frames->has("tracks")) {
            for (const Node& track : tracks) video.tracks.push_back(track_number(track["track"]));
            return video;
        }
        for (const Node& index : gltf_array((*frames)["tracks"]))
            video.tracks.push_back(track_number(one_of(file["tracks"], index, "tracks")["track"]));
        return video;
    }

    /// The file that a URI in this file names.
    LinkedFile linked(const std::string& uri) const { return or_throw(follow_link(uri, file_)); }

    /// Other files that were read for pictures.
    const std::vector<std::filesystem::path>& read_files() const { return read_files_; }

private:
    /// The bytes of a buffer view.
    LinkedFile carried_picture(const Node& view) {
        const Node buffer = element("buffers", view["buffer"]);
        constexpr std::int64_t most = std::int64_t{1} << 40;
        const auto begin =
            static_cast<std::size_t>(view.has("byteOffset") ? view["byteOffset"].integer(0, most) : 0);
        const auto length = static_cast<std::size_t>(view["byteLength"].integer(1, most));
        std::shared_ptr<const std::string> owned;
        std::string_view bytes;
        if (buffer.has("uri")) {
            const LinkedFile link = linked(buffer["uri"].text());
            owned = or_throw(bytes_of(link));
            if (!link.file.empty()) read_files_.push_back(link.file);
            bytes = *owned;
        } else if (carried_) {
            bytes = *carried_;
        } else {
            buffer["uri"].text();  // throws: it is missing
        }
        if (begin > bytes.size() || length > bytes.size() - begin)
            view["byteLength"].refuse("within its buffer, which has " + std::to_string(bytes.size()) +
                                      " bytes");
        return {{}, std::make_shared<const std::string>(bytes.substr(begin, length)), file_.string()};
    }

    std::filesystem::path file_;
    checked_json::Json json_;
    std::optional<std::string_view> carried_;
    std::vector<std::filesystem::path> read_files_;
};

/// One property in a haptic material of glTF.
struct GltfLayer {
    std::size_t texture = 0;               ///< index in "textures"
    int channel = 0;                       ///< 0 (red) to 2; 0 if not stated
    std::optional<PropertyRange> range{};  ///< at black and white, if stated
};

/// What a material of MPEG_haptic_material has. The extension has one friction; "extras" beside a texture may
/// say more: "touchable_range" [black, white], "touchable_channel" 0 to 2, "touchable_kind" "static",
/// "dynamic", and of a custom texture "height".
struct GltfTouch {
    std::array<std::optional<GltfLayer>, 3> properties;  ///< as property_names
    std::optional<GltfLayer> height;
    std::vector<ClipNote> notes{};  ///< what is not used
};

constexpr const char* haptic_extension = "MPEG_haptic_material";
/// The name in a draft of 2022, in files of that time.
constexpr const char* haptic_extension_of_draft = "MPEG_material_haptic";

std::optional<Node> extra(const Node& entry, const char* name) {
    if (!entry.has("extras") || !entry["extras"].has(name)) return std::nullopt;
    return entry["extras"][name];
}

std::vector<Node> materials_of(const GltfFile& gltf) {
    if (const auto now = gltf_extension(gltf.root(), haptic_extension))
        return gltf_array((*now)["materials"]);
    if (const auto before = gltf_extension(gltf.root(), haptic_extension_of_draft))
        return gltf_array(*before);
    return {};
}

/// The number of the haptic material of the first mesh that names one.
std::optional<Node> material_of_mesh(const GltfFile& gltf) {
    if (!gltf.root().has("meshes")) return std::nullopt;
    for (const Node& mesh : gltf_array(gltf.root()["meshes"])) {
        if (const auto now = gltf_extension(mesh, haptic_extension)) return (*now)["hapticMaterialIndex"];
        if (const auto before = gltf_extension(mesh, haptic_extension_of_draft)) return before;
    }
    return std::nullopt;
}

bool is_height(const Node& custom) {
    const auto kind = extra(custom, "touchable_kind");
    return kind && kind->text() == "height";
}

bool is_touched(const Node& material) {
    if (!material.is_object()) material.refuse("an object {...}");
    if (material.has("stiffness") || material.has("friction")) return true;
    if (!material.has("custom")) return false;
    const auto all = gltf_array(material["custom"]);
    return std::ranges::any_of(all, is_height);
}

/// Picks the textures of one material: that of the file's first mesh with one, or else the first with touch.
class MaterialReader {
public:
    explicit MaterialReader(const GltfFile& gltf) : gltf_(gltf), name_(gltf.file().string()) {}

    GltfTouch read() {
        const Node material = chosen();
        const auto stiffness = entry(material, "stiffness", ""), held = entry(material, "friction", "static");
        if (stiffness) touch_.properties[0] = layer(*stiffness);
        if (held) touch_.properties[1] = layer(*held);
        const bool has_one_friction =
            held && !extra(*held, "touchable_kind");  // for static and dynamic alike
        const auto sliding = has_one_friction ? held : entry(material, "friction", "dynamic");
        if (sliding) touch_.properties[2] = layer(*sliding);
        if (has_one_friction) say("friction of " + name_ + " is static and dynamic friction alike");
        for (const char* other : {"vibrotactileTexture", "temperature", "vibration"})
            if (material.has(other)) say(std::string(other) + " of " + name_ + " is not used");
        if (!material.has("custom")) return std::move(touch_);
        for (const Node& custom : gltf_array(material["custom"])) {
            if (is_height(custom) && !touch_.height)
                touch_.height = layer(custom);
            else
                say("custom of " + name_ + " is not used");
        }
        return std::move(touch_);
    }

private:
    Node chosen() {
        const char* const right =
            "has no material with stiffness or friction in the whole file's "
            "extensions.MPEG_haptic_material.materials";
        const std::vector<Node> materials = materials_of(gltf_);
        const auto count = std::ranges::count_if(materials, is_touched);
        if (count == 0) throw Refusal{right};
        if (const auto index = material_of_mesh(gltf_)) {
            const auto k = static_cast<std::size_t>(index->whole());
            if (k >= materials.size())
                index->refuse("a number of one of " + std::to_string(materials.size()) + " materials");
            if (is_touched(materials[k])) return materials[k];
        }
        if (count > 1) say(name_ + " has " + std::to_string(count) + " haptic materials: the first is taken");
        return *std::ranges::find_if(materials, is_touched);
    }

    /// A property's texture of this kind or of none: the first of high resolution, or else of low. An error
    /// if there are only references, which lead to signals in binary form that are not read.
    std::optional<Node> entry(const Node& material, const char* property, const char* kind) {
        if (!material.has(property)) return std::nullopt;
        std::vector<Node> entries;
        bool has_reference = false;
        for (const Node& one : gltf_array(material[property])) {
            const auto own = extra(one, "touchable_kind");
            if (!own || own->text() == kind) entries.push_back(one);
            has_reference = has_reference || (one.has("type") && one["type"].text() == "Reference");
        }
        for (const std::string wanted : {"High_Resolution", "Low_Resolution"})
            for (const Node& one : entries) {
                if ((one.has("type") ? one["type"].text() : "High_Resolution") != wanted) continue;
                if (entries.size() > 1)
                    say(std::string(property) + " has " + std::to_string(entries.size()) +
                        " textures: the first of type " + wanted + " is taken");
                return one;
            }
        if (has_reference)
            throw Refusal{std::string(property) +
                          " has only a texture of type Reference, which leads to signals in binary form "
                          "(MPEG_haptic) that are not read: must be High_Resolution or Low_Resolution"};
        if (!entries.empty())
            say(std::string(property) +
                " has only textures of other types than High_Resolution and Low_Resolution, which are not "
                "used");
        return std::nullopt;
    }

    GltfLayer layer(const Node& entry) {
        const Node info = entry["texture"];
        if (gltf_extension(info, "KHR_texture_transform"))
            say("KHR_texture_transform of " + name_ + " is not used: pictures lie over the whole of depth's");
        gltf_.element("textures", info["index"]);
        GltfLayer layer{static_cast<std::size_t>(info["index"].whole())};
        if (const auto channel = extra(entry, "touchable_channel")) layer.channel = channel->whole(0, 2);
        if (const auto range = extra(entry, "touchable_range")) {
            const auto ends = range->elements(2, 2, "[black, white], two numbers");
            layer.range = {ends[0].number(), ends[1].number()};
        }
        return layer;
    }

    void say(const std::string& what) { touch_.notes.push_back(what); }

    const GltfFile& gltf_;
    const std::string name_;
    GltfTouch touch_;
};

/// Values of properties that are not stated: stiffness in N/mm, static and dynamic friction.
std::array<double, 3> untouched(const Scene& scene) {
    const HapticProperties& usual = scene.default_properties;
    return {usual.stiffness / 1000.0, usual.static_friction, usual.dynamic_friction};
}

HapticLayers as_pictures(GltfFile& gltf, const Scene& scene) {
    const GltfTouch touch = MaterialReader(gltf).read();
    if (!touch.properties[0] && !touch.properties[1] && !touch.properties[2])
        throw Refusal{
            "its haptic material has no texture of stiffness or friction that is High_Resolution or "
            "Low_Resolution"};
    const std::string name = gltf.file().string();
    const auto otherwise = untouched(scene);
    const std::array<PropertyRange, 3> ranges{scene.haptic.stiffness, scene.haptic.static_friction,
                                              scene.haptic.dynamic_friction};
    HapticLayers layers;
    layers.notes = touch.notes;
    bool states_all = true;
    for (std::size_t k = 0; k < touch.properties.size(); ++k) {
        const auto& property = touch.properties[k];
        layers.properties[k].range = {otherwise[k], otherwise[k]};
        if (!property) continue;
        const Node texture = gltf.texture(property->texture);
        const bool is_video = gltf_extension(texture, "MPEG_texture_video").has_value();
        if (is_video && !texture.has("source"))
            throw Refusal{std::string(property_names[k]) +
                          " is a video: must be a picture, which serves all frames of another clip"};
        layers.properties[k] = {gltf.picture(texture), property->range.value_or(ranges[k]),
                                property->channel};
        states_all = states_all && property->range;
        if (is_video)
            layers.notes.push_back(std::string(property_names[k]) + " of " + name +
                                   " is a video: the picture in its place is taken");
    }
    if (!states_all)
        add_remark(layers.remarks,
                   {gltf.file().filename().string() +
                        " states no units: black and white are the ends of haptic in the clip's scene file",
                    true, "\"extras\": {\"touchable_range\": [black, white]} beside a texture say others"});
    if (touch.height) layers.notes.push_back("custom of " + name + " is not used");
    layers.files = gltf.read_files();
    layers.files.insert(layers.files.begin(), gltf.file());
    return layers;
}

/// Source of a plane.
struct ClipTexture {
    std::optional<GltfVideo> video;
    std::string picture;  ///< if no video: a file in the scene's folder or below
};

/// The first result of `choose` for an array's elements that is not empty.
template <class Choose>
auto first_of(const Node& root, const char* array, const Choose& choose)
    -> decltype(choose(root, std::size_t{0})) {
    if (!root.has(array)) return {};
    const std::vector<Node> elements = gltf_array(root[array]);
    for (std::size_t k = 0; k < elements.size(); ++k)
        if (auto chosen = choose(elements[k], k)) return chosen;
    return {};
}

class GltfClip {
public:
    GltfClip(const Candidate& file, std::string_view bytes)
        : file_(file),
          gltf_(file.source.path(), bytes),
          folder_(file.home()),
          own_(first_of(gltf_.root(), "meshes",
                        [](const Node& mesh, std::size_t) { return extra(mesh, "touchable"); })) {}
    Opened open() {
        find_planes();
        SceneDescription scene = file_.scene ? SceneDescription(*file_.scene) : described();
        if (!file_.scene && touch_) take_touch(scene.scene);
        if (touch_ && !maps_.haptic)  // a map has the same notes
            for (const std::string& note : touch_->notes) add_remark(remarks_, {note});
        scene.scene.remarks = joined_remarks(std::move(scene.scene.remarks), remarks_);
        scene.scene.folder.reset();
        scene.scene.video.reset();
        const bool has_tracks = depth().video && !depth().video->tracks.empty();
        auto reader = has_tracks ? open_tracks(scene) : open_files(std::move(scene));
        if (sources_) reader = with_touch_videos(std::move(reader), *sources_);
        if (!reader) return reader;
        (*reader)->add_input(gltf_.file());
        for (auto& file : files_of_others()) (*reader)->add_input(std::move(file));
        return reader;
    }

private:
    /// The name of a file in the scene's folder or below.
    std::string name_beside(const std::string& uri) const {
        const std::filesystem::path file = gltf_.linked(uri).file;
        const std::filesystem::path named =
            file.lexically_normal().lexically_relative(folder_.lexically_normal());
        if (file.empty() || named.empty() || named.is_absolute() || *named.begin() == "..")
            throw Refusal{"a plane of it is " + in_quotes(uri.substr(0, 40)) +
                          ": must be a file beside it or in a folder below"};
        return named.string();
    }

    /// Index of depth's texture: as the mesh says, otherwise the first video of format DEPTH_COMPONENT.
    std::optional<std::size_t> depth_texture() const {
        if (own_) return static_cast<std::size_t>((*own_)["depth"].whole());
        return first_of(
            gltf_.root(), "textures", [](const Node& texture, std::size_t k) -> std::optional<std::size_t> {
                const auto moving = gltf_extension(texture, "MPEG_texture_video");
                const bool is_depth =
                    moving && moving->has("format") && (*moving)["format"].text() == "DEPTH_COMPONENT";
                return is_depth ? std::optional(k) : std::nullopt;
            });
    }

    /// Index of colour's texture: as the mesh says, otherwise the base colour of the first mesh that has one.
    std::optional<std::size_t> colour_texture() const {
        if (own_)
            return own_->has("colour") ? std::optional(static_cast<std::size_t>((*own_)["colour"].whole()))
                                       : std::nullopt;
        const auto of_primitive = [this](const Node& primitive, std::size_t) -> std::optional<std::size_t> {
            if (!primitive.has("material")) return std::nullopt;
            const Node material = gltf_.element("materials", primitive["material"]);
            if (!material.has("pbrMetallicRoughness")) return std::nullopt;
            const Node look = material["pbrMetallicRoughness"];
            if (!look.has("baseColorTexture")) return std::nullopt;
            return static_cast<std::size_t>(look["baseColorTexture"]["index"].whole());
        };
        return first_of(gltf_.root(), "meshes", [&](const Node& mesh, std::size_t) {
            return first_of(mesh, "primitives", of_primitive);
        });
    }

    ClipTexture plane(std::size_t index) const {
        const Node texture = gltf_.texture(index);
        if (auto video = gltf_.video(texture)) {
            video->file = name_beside(video->file);
            return {std::move(video), ""};
        }
        if (!texture.has("source")) throw Refusal{"a texture is neither a picture nor a video"};
        const Node image = gltf_.element("images", texture["source"]);
        if (image.has("bufferView"))
            throw Refusal{"a plane of it is a picture within the file: must be a file beside it"};
        return {{}, name_beside(image["uri"].text())};
    }

    bool is_video(std::size_t texture) const {
        return gltf_extension(gltf_.texture(texture), "MPEG_texture_video").has_value();
    }
    void find_planes() {
        const auto depth = depth_texture();
        if (!depth)
            throw Refusal{
                "has no depth (a texture of format DEPTH_COMPONENT, or \"depth\" in the extras of a mesh): "
                "it is no clip; what it says of touch serves a clip of depth"};
        at(PlaneRole::depth) = plane(*depth);
        const auto colour = colour_texture();  // a picture only stands in for a video
        if (colour && (!at(PlaneRole::depth)->video || is_video(*colour)))
            at(PlaneRole::colour) = plane(*colour);
        find_touch();
    }

    /// In a clip of ours, a material's textures are one plane. Other programs' videos are sources of their
    /// own; pictures alone are a map, as for any other clip.
    void find_touch() {
        const std::vector<Node> materials = materials_of(gltf_);
        if (std::ranges::none_of(materials, is_touched)) return;
        touch_ = MaterialReader(gltf_).read();
        std::optional<std::size_t> texture;
        bool is_one = own_.has_value(), is_moving = false;
        for (std::size_t k = 0; k < touch_->properties.size(); ++k) {
            const auto& property = touch_->properties[k];
            if (!property) continue;
            is_one = is_one && (!texture || *texture == property->texture) &&
                     property->channel == static_cast<int>(k);
            texture = property->texture;
            is_moving = is_moving || is_video(*texture);
        }
        if (touch_->height) at(PlaneRole::height) = plane(touch_->height->texture);
        if (!texture) return;
        if (is_one) {
            at(PlaneRole::haptic) = plane(*texture);
            return;
        }
        if (!is_moving) {
            maps_.haptic = gltf_.file();
            return;
        }
        sources_.emplace();
        for (std::size_t k = 0; k < touch_->properties.size(); ++k)
            if (const auto& property = touch_->properties[k]) (*sources_)[k] = touch_source(*property);
    }

    /// The video of a property, or its picture.
    TouchSource touch_source(const GltfLayer& property) {
        if (!is_video(property.texture))
            return TouchSource{.picture = gltf_.picture(gltf_.texture(property.texture)),
                               .channel = property.channel};
        const GltfVideo video = *plane(property.texture).video;
        if (video.tracks.size() > 1)
            throw Refusal{"a texture of touch is " + std::to_string(video.tracks.size()) +
                          " tracks of its file: must be one"};
        return TouchSource{.video = folder_ / video.file,
                           .track = video.tracks.empty() ? std::nullopt : std::optional(video.tracks.front()),
                           .channel = property.channel};
    }

    SceneDescription described() const {
        if (!own_) return assumed();
        return or_throw(
            parse_scene((*own_)["scene"].json(), gltf_.file().string() + ": the scene in its mesh's extras"));
    }

    /// The scene for depth without stated lengths: larger values are farther, as in a depth buffer.
    SceneDescription assumed() const {
        const auto& video = depth().video;
        if (!video)
            throw Refusal{"its mesh does not say what its depth means: describe it with a scene file"};
        if (video->tracks.size() > 1)
            throw Refusal{
                "its depth is two tracks, and its mesh does not say how many bits that is: describe it with "
                "a scene file"};
        constexpr double near = 0.5, far = 1.5;  // metres
        const DepthCoding coding{
            .semantics = DepthSemantics::planar, .near_is_high = false, .near = near, .far = far};
        StoredImage size;
        size.image = {video->width, video->height, 1, 1, {}};
        SceneDescription guessed = or_throw(guess_scene(gltf_.file(), size, {}, &coding));
        Scene& scene = guessed.scene;
        for (Remark& remark : scene.remarks)
            if (remark.is_guess || !remark.hints.empty()) remark.hints = {{Setting::scene_file, "FILE"}};
        add_remark(scene.remarks, {"depth goes from 0.5 m, black, to 1.5 m, white",
                                   true,
                                   "a scene file's depth.near and far say otherwise",
                                   {{Setting::scene_file, "FILE"}},
                                   RemarkKind::scale});
        return guessed;
    }

    /// Takes the ranges beside textures, where a person may have changed them. Returns whether they differ.
    bool take_ranges(Scene& scene) const {
        const std::array<PropertyRange*, 3> ranges{&scene.haptic.stiffness, &scene.haptic.static_friction,
                                                   &scene.haptic.dynamic_friction};
        const auto otherwise = untouched(scene);
        bool is_other = false;
        for (std::size_t k = 0; k < ranges.size(); ++k) {
            const auto& property = touch_->properties[k];
            const PropertyRange stated = !property         ? PropertyRange{otherwise[k], otherwise[k]}
                                         : property->range ? *property->range
                                                           : *ranges[k];
            is_other = is_other || ranges[k]->min != stated.min || ranges[k]->max != stated.max;
            *ranges[k] = stated;
        }
        return is_other;
    }

    /// The same for heights, which are metres there.
    bool take_height(Scene& scene) const {
        const GltfLayer& height = *touch_->height;
        if (height.channel != 0)
            throw Refusal{"its heights are channel " + std::to_string(height.channel) +
                          " of a texture: must be 0, as they are grey"};
        if (!height.range) return false;
        if (height.range->min != 0)
            throw Refusal{"black of its heights must be 0: touchable_range is [0, metres]"};
        HeightCoding& coding = scene.height_coding;
        const double now =
            coding.max_height > 0 ? largest_height(coding, scene.depth) * scene.metres_per_unit : 0;
        if (height.range->max == now) return false;
        coding.units = HeightUnits::world;
        coding.max_height = height.range->max / scene.metres_per_unit;
        return true;
    }

    void take_touch(Scene& scene) {
        const bool has_haptic = at(PlaneRole::haptic) || sources_;
        const bool has_others = has_haptic && take_ranges(scene);
        const bool is_other = (touch_->height && take_height(scene)) || has_others;
        if (own_ && is_other)
            add_remark(remarks_, {"the ranges of its haptic material are others than those of the scene in "
                                  "its mesh: the material's stand"});
        const bool states_all =
            std::none_of(touch_->properties.begin(), touch_->properties.end(),
                         [](const auto& property) { return property && !property->range; });
        if (!own_ && has_haptic && !states_all)
            add_remark(remarks_,
                       {"its haptic material states no units: black and white are the usual ends", true,
                        "\"extras\": {\"touchable_range\": [black, white]} beside a texture say others"});
        if (auto valid = validate(scene); !valid) throw Refusal{valid.error().message};
    }

    std::optional<ClipTexture>& at(PlaneRole role) { return planes_[static_cast<std::size_t>(role)]; }
    const std::optional<ClipTexture>& at(PlaneRole role) const {
        return planes_[static_cast<std::size_t>(role)];
    }
    const ClipTexture& depth() const { return *planes_.front(); }
    /// Files for programs without depth video: they are inputs, too, so that nothing overwrites them.
    std::vector<std::filesystem::path> files_of_others() const {
        std::vector<std::filesystem::path> files;
        for (const char* array : {"images", "buffers"}) {
            if (!gltf_.root().has(array)) continue;
            for (const Node& each : gltf_array(gltf_.root()[array])) {
                if (!each.has("uri")) continue;
                const auto link = follow_link(each["uri"].text(), gltf_.file());
                if (link && !link->file.empty()) files.push_back(link->file);
            }
        }
        return files;
    }

    /// Opens tracks of one file, and pictures beside them.
    Opened open_tracks(const SceneDescription& described) const {
        const std::string& file = depth().video->file;
        PlaneTracks tracks;
        StillMaps maps = maps_;
        for (const PlaneRole role : all_roles) {
            const auto& plane = at(role);
            if (!plane) continue;
            const std::string name(role_name(role));
            if (!plane->video) {
                if (role == PlaneRole::haptic) maps.haptic = gltf_.file();
                if (role == PlaneRole::height) maps.height = folder_ / plane->picture;
                continue;  // a picture of colour is the poster for other programs
            }
            if (plane->video->file != file)
                throw Refusal{name + " and depth are videos in two files: must be tracks of one"};
            const auto& numbers = plane->video->tracks;
            if (numbers.empty() || numbers.size() > 2)
                throw Refusal{name + " is " + std::to_string(numbers.size()) +
                              " tracks of its file: must be one, or one of the high bits and one of the low"};
            tracks[static_cast<std::size_t>(role)] = numbers;
        }
        auto reader = open_mp4_tracks(SourceFile(folder_ / file), tracks, described, file_.wanted.colour);
        if (!maps.haptic && !maps.height) return reader;
        return with_still_maps(std::move(reader), maps);
    }

    /// Opens pictures, or videos that are each a file of its own.
    Opened open_files(SceneDescription described) const {
        FolderSource files;
        const bool is_moving = depth().video.has_value();
        for (const PlaneRole role : all_roles) {
            const auto& plane = at(role);
            if (!plane) continue;
            if (plane->video && (!is_moving || role == PlaneRole::haptic || role == PlaneRole::height))
                throw Refusal{
                    std::string(role_name(role)) +
                    " is a video in a file of its own: must be a picture, or a track of depth's file"};
            if (!plane->video && !is_still(plane->picture))
                throw Refusal{in_quotes(plane->picture) +
                              " is a name that stands for several files (%, *, .txt): rename it"};
            if (plane->video)
                pattern_of(files, role) = plane->video->file;
            else if (role != PlaneRole::colour || !is_moving)
                pattern_of(files, role) = plane->picture;
        }
        Scene& scene = described.scene;
        if (is_moving) {
            scene.video = VideoSource{files.depth, files.colour};
            scene.video->haptic = files.haptic;
            scene.video->height = files.height;
        } else {
            files.count = 1;
            scene.folder = std::move(files);
        }
        const auto open_planes = is_moving ? open_videos : open_image_folder;
        auto reader = open_planes(folder_, GuessedScene{std::move(described)}, file_.wanted.colour,
                                  DepthAlignment::automatic);
        return maps_.haptic ? with_still_maps(std::move(reader), maps_) : std::move(reader);
    }

    const Candidate& file_;
    GltfFile gltf_;
    std::filesystem::path folder_;
    const std::optional<Node> own_;  // "touchable" in a mesh's extras
    std::array<std::optional<ClipTexture>, all_roles.size()> planes_;
    std::optional<GltfTouch> touch_;
    StillMaps maps_;                       // pictures that serve all frames of a video
    std::optional<TouchSources> sources_;  // of moving touch that is no plane of ours
    std::vector<Remark> remarks_;
};

/// Calls `read` and turns what it throws into errors that begin with the file's name.
template <class Read>
auto read_gltf(const std::filesystem::path& file, const Read& read) -> decltype(read()) {
    try {
        TRY_ASSIGN(auto made, checked_json::checked(file.string(), read));
        return made;
    } catch (const Error& error) {
        return error;
    }
}

}  // namespace

Result<HapticLayers> read_gltf_material(const std::filesystem::path& file, std::string_view bytes,
                                        const Scene& scene) {
    return read_gltf(file, [&]() -> Result<HapticLayers> {
        GltfFile gltf(file, bytes);
        return as_pictures(gltf, scene);
    });
}

bool is_gltf(const Candidate& file) {
    const std::string ending = small_letters(file.source.path().extension().string());
    return ending == ".gltf" || ending == ".glb" || file.begin.starts_with("glTF");
}

Opened open_gltf_clip(const Candidate& file) {
    constexpr std::size_t largest = std::size_t{64} << 20;
    TRY_ASSIGN(const auto bytes, file.source.read("a glTF scene", largest));
    return read_gltf(file.source.path(), [&] { return GltfClip(file, bytes).open(); });
}

}  // namespace touchable
