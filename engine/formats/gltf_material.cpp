#include "engine/formats/gltf_material.hpp"

#include <algorithm>
#include <utility>

#include "engine/base/number_words.hpp"

namespace touchable {
namespace {

using checked_json::Node;
using checked_json::Refusal;

constexpr const char* extension = "MPEG_haptic_material";
/// Of a draft of 2022, which files of that time have.
constexpr const char* extension_of_draft = "MPEG_material_haptic";

std::optional<Node> extra(const Node& entry, const char* name) {
    if (!entry.has("extras") || !entry["extras"].has(name)) return std::nullopt;
    return entry["extras"][name];
}

std::vector<Node> materials_of(const GltfFile& gltf) {
    if (const auto now = gltf_extension(gltf.root(), extension)) return gltf_array((*now)["materials"]);
    if (const auto before = gltf_extension(gltf.root(), extension_of_draft)) return gltf_array(*before);
    return {};
}

/// The number of the material that a mesh names: the first mesh with one.
std::optional<Node> material_of_mesh(const GltfFile& gltf) {
    if (!gltf.root().has("meshes")) return std::nullopt;
    for (const Node& mesh : gltf_array(gltf.root()["meshes"])) {
        if (const auto now = gltf_extension(mesh, extension)) return (*now)["hapticMaterialIndex"];
        if (const auto before = gltf_extension(mesh, extension_of_draft)) return before;
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
    return std::any_of(all.begin(), all.end(), is_height);
}

/// Picks the textures of one material.
class MaterialReader {
public:
    explicit MaterialReader(const GltfFile& gltf) : gltf_(gltf), name_(gltf.file().string()) {}
    GltfTouch read();

private:
    Node chosen();
    std::optional<Node> entry(const Node& material, const char* property, const char* kind);
    GltfLayer layer(const Node& entry);
    void say(const std::string& what) { touch_.notes.push_back(what); }

    const GltfFile& gltf_;
    const std::string name_;
    GltfTouch touch_;
};

Node MaterialReader::chosen() {
    const char* const right =
        "has no material with stiffness or friction in the whole file's "
        "extensions.MPEG_haptic_material.materials";
    const std::vector<Node> materials = materials_of(gltf_);
    const auto count = std::count_if(materials.begin(), materials.end(), is_touched);
    if (count == 0) throw Refusal{right};
    if (const auto index = material_of_mesh(gltf_)) {
        const auto k = static_cast<std::size_t>(index->whole());
        if (k >= materials.size())
            index->refuse("a number of one of " + std::to_string(materials.size()) + " materials");
        if (is_touched(materials[k])) return materials[k];
    }
    if (count > 1) say(name_ + " has " + std::to_string(count) + " haptic materials: the first is taken");
    return *std::find_if(materials.begin(), materials.end(), is_touched);
}

/// Of the textures of a property, and of this kind or of none, the one of high resolution, or of low where
/// there is none. A reference leads to signals in binary form, which is not read.
std::optional<Node> MaterialReader::entry(const Node& material, const char* property, const char* kind) {
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
            " has only textures of other types than High_Resolution and Low_Resolution, "
            "which are not used");
    return std::nullopt;
}

GltfLayer MaterialReader::layer(const Node& entry) {
    const Node info = entry["texture"];
    if (gltf_extension(info, "KHR_texture_transform"))
        say("KHR_texture_transform of " + name_ + " is not used: pictures lie over the whole of depth's");
    gltf_.element("textures", info["index"]);
    GltfLayer layer{static_cast<std::size_t>(info["index"].whole())};
    if (const auto channel = extra(entry, "touchable_channel"))
        layer.channel = static_cast<int>(channel->integer(0, 2));
    if (const auto range = extra(entry, "touchable_range")) {
        const auto ends = range->elements(2, 2, "[black, white], two numbers");
        layer.range = {ends[0].number(), ends[1].number()};
    }
    return layer;
}

GltfTouch MaterialReader::read() {
    const Node material = chosen();
    const auto stiffness = entry(material, "stiffness", ""), held = entry(material, "friction", "static");
    if (stiffness) touch_.properties[0] = layer(*stiffness);
    if (held) touch_.properties[1] = layer(*held);
    touch_.has_one_friction = held && !extra(*held, "touchable_kind");
    const auto sliding = touch_.has_one_friction ? held : entry(material, "friction", "dynamic");
    if (sliding) touch_.properties[2] = layer(*sliding);
    if (touch_.has_one_friction) say("friction of " + name_ + " is static and dynamic friction alike");
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

HapticLayers as_pictures(GltfFile& gltf, const Scene& scene) {
    const GltfTouch touch = touch_of(gltf);
    if (!touch.properties[0] && !touch.properties[1] && !touch.properties[2])
        throw Refusal{
            "its haptic material has no texture of stiffness or friction that is High_Resolution or "
            "Low_Resolution"};
    const std::string name = gltf.file().string();
    const HapticProperties& usual = scene.default_properties;
    const std::array<double, 3> otherwise{usual.stiffness / 1000.0, usual.static_friction,
                                          usual.dynamic_friction};
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

}  // namespace

bool has_touch(const GltfFile& gltf) {
    const std::vector<Node> materials = materials_of(gltf);
    return std::any_of(materials.begin(), materials.end(), is_touched);
}

GltfTouch touch_of(const GltfFile& gltf) {
    return MaterialReader(gltf).read();
}

Result<HapticLayers> read_gltf_material(const std::filesystem::path& file, std::string_view bytes,
                                        const Scene& scene) {
    return read_gltf(file, [&]() -> Result<HapticLayers> {
        GltfFile gltf(file, bytes);
        return as_pictures(gltf, scene);
    });
}

}  // namespace touchable
