#include "engine/import/touch_maps/gltf_material.hpp"

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "engine/import/guess/number_words.hpp"
#include "engine/scene/checked_json.hpp"

namespace touchable {
namespace {

using checked_json::Json;
using checked_json::Node;
using checked_json::Refusal;

constexpr const char* extension = "MPEG_haptic_material";
/// Values of three bytes of text take a hundred of memory.
constexpr std::size_t largest_json = std::size_t{8} << 20U;
constexpr std::size_t most_elements = 1'000'000;

/// The two parts of a file: what it says, and the bytes it carries.
struct GltfParts {
    std::string_view json;
    std::optional<std::string_view> carried;
};

std::uint32_t word_at(std::string_view bytes, std::size_t at) {
    std::uint32_t word = 0;
    for (std::size_t k = 4; k-- > 0;) word = word << 8U | static_cast<unsigned char>(bytes[at + k]);
    return word;
}

/// Throws Refusal.
GltfParts parts_of(std::string_view bytes) {
    if (!bytes.starts_with("glTF")) return {bytes, std::nullopt};
    if (bytes.size() < 12 || word_at(bytes, 4) != 2)
        throw Refusal{"is no GLB of version 2, which is the one that is read"};
    GltfParts parts;
    for (std::size_t at = 12; at + 8 <= bytes.size();) {
        const std::size_t length = word_at(bytes, at);
        const std::string_view kind = bytes.substr(at + 4, 4);
        at += 8;
        if (length > bytes.size() - at) throw Refusal{"is damaged: it ends within a chunk"};
        if (kind == "JSON" && parts.json.empty()) parts.json = bytes.substr(at, length);
        if (kind == std::string_view("BIN\0", 4) && !parts.carried) parts.carried = bytes.substr(at, length);
        at += length;
    }
    if (parts.json.empty()) throw Refusal{"is damaged: has no JSON"};
    return parts;
}

/// One of the arrays at the root. Throws Refusal.
Node element_of(const Node& root, const char* array, const Node& index) {
    const auto elements = root[array].elements(0, most_elements, "an array");
    const auto k = static_cast<std::size_t>(index.integer(0, std::numeric_limits<int>::max()));
    if (k >= elements.size())
        index.refuse("a number of one of " + std::to_string(elements.size()) + " " + array);
    return elements[k];
}

/// Everything here throws Refusal; an Error within becomes one.
class MaterialReader {
public:
    MaterialReader(const std::filesystem::path& file, const Node& root,
                   std::optional<std::string_view> carried, const Scene& scene)
        : file_(file), root_(root), carried_(carried), scene_(scene) {
        layers_.files.push_back(file);
    }
    HapticLayers read();

private:
    Node material();
    std::optional<Node> entry(const Node& material, const char* property);
    HapticLayer layer(const std::optional<Node>& entry, PropertyRange range, double otherwise);
    LinkedFile picture(const Node& info);
    LinkedFile linked(const Node& uri);
    LinkedFile carried_picture(const Node& view);
    void say(const std::string& what) { layers_.notes.push_back(what); }

    const std::filesystem::path& file_;
    const Node root_;
    const std::optional<std::string_view> carried_;
    const Scene& scene_;
    HapticLayers layers_;
};

Node MaterialReader::material() {
    const char* const right =
        "has no material with stiffness or friction in the whole file's "
        "extensions.MPEG_haptic_material.materials";
    if (!root_.has("extensions") || !root_["extensions"].has(extension)) throw Refusal{right};
    const auto materials = root_["extensions"][extension]["materials"].elements(0, most_elements, "an array");
    std::optional<std::size_t> first;
    std::size_t count = 0;
    for (std::size_t k = 0; k < materials.size(); ++k) {
        if (!materials[k].has("stiffness") && !materials[k].has("friction")) continue;
        if (!first) first = k;
        ++count;
    }
    if (!first) throw Refusal{right};
    if (count > 1)
        say(file_.string() + " has " + std::to_string(count) + " haptic materials: the first is taken");
    return materials[*first];
}

/// Of the textures of a property the one of high resolution, or of low where there is none. References to
/// other haptic objects are no values.
std::optional<Node> MaterialReader::entry(const Node& material, const char* property) {
    if (!material.has(property)) return std::nullopt;
    const auto entries = material[property].elements(0, most_elements, "an array");
    for (const std::string wanted : {"High_Resolution", "Low_Resolution"})
        for (const Node& one : entries) {
            if ((one.has("type") ? one["type"].text() : "High_Resolution") != wanted) continue;
            if (entries.size() > 1)
                say(std::string(property) + " has " + std::to_string(entries.size()) +
                    " textures: the first of type " + wanted + " is taken");
            return one;
        }
    if (!entries.empty())
        say(std::string(property) +
            " has only textures of other types than High_Resolution and Low_Resolution, "
            "which are not used");
    return std::nullopt;
}

LinkedFile MaterialReader::linked(const Node& uri) {
    auto link = follow_link(uri.text(), file_);
    if (!link) throw link.error();
    return std::move(*link);
}

/// A stretch of a buffer.
LinkedFile MaterialReader::carried_picture(const Node& view) {
    const Node buffer = element_of(root_, "buffers", view["buffer"]);
    constexpr std::int64_t most = std::int64_t{1} << 40;
    const auto begin =
        static_cast<std::size_t>(view.has("byteOffset") ? view["byteOffset"].integer(0, most) : 0);
    const auto length = static_cast<std::size_t>(view["byteLength"].integer(1, most));
    std::shared_ptr<const std::string> owned;
    std::string_view bytes;
    if (buffer.has("uri")) {
        const LinkedFile link = linked(buffer["uri"]);
        auto read = bytes_of(link);
        if (!read) throw read.error();
        if (!link.file.empty()) layers_.files.push_back(link.file);
        owned = std::move(*read);
        bytes = *owned;
    } else if (carried_) {
        bytes = *carried_;
    } else {
        buffer["uri"].text();  // is missing
    }
    if (begin > bytes.size() || length > bytes.size() - begin)
        view["byteLength"].refuse("within its buffer, which has " + std::to_string(bytes.size()) + " bytes");
    return {{}, std::make_shared<const std::string>(bytes.substr(begin, length)), file_.string()};
}

LinkedFile MaterialReader::picture(const Node& info) {
    if (info.has("extensions") && info["extensions"].has("KHR_texture_transform"))
        say("KHR_texture_transform of " + file_.string() +
            " is not used: pictures lie over the whole of depth's");
    const Node texture = element_of(root_, "textures", info["index"]);
    if (!texture.has("source"))
        throw Refusal{"a texture has no source: must be a PNG or JPEG; pictures of extensions are not read"};
    const Node image = element_of(root_, "images", texture["source"]);
    if (!image.has("bufferView")) return linked(image["uri"]);
    return carried_picture(element_of(root_, "bufferViews", image["bufferView"]));
}

HapticLayer MaterialReader::layer(const std::optional<Node>& entry, PropertyRange range, double otherwise) {
    if (!entry) return {{}, {otherwise, otherwise}};
    if (entry->has("extras") && (*entry)["extras"].has("touchable_range")) {
        const auto ends = (*entry)["extras"]["touchable_range"].elements(2, 2, "[black, white], two numbers");
        range = {ends[0].number(), ends[1].number()};
    }
    return {picture((*entry)["texture"]), range};
}

HapticLayers MaterialReader::read() {
    const Node chosen = material();
    const HapticProperties& usual = scene_.default_properties;
    const auto stiffness = entry(chosen, "stiffness"), friction = entry(chosen, "friction");
    if (!stiffness && !friction)
        throw Refusal{
            "its haptic material has no texture of stiffness or friction that is High_Resolution or "
            "Low_Resolution"};
    layers_.properties[0] = layer(stiffness, scene_.haptic.stiffness, usual.stiffness / 1000.0);
    layers_.properties[1] = layer(friction, scene_.haptic.static_friction, usual.static_friction);
    layers_.properties[2] = {layers_.properties[1].picture, layers_.properties[1].range};
    if (!friction) layers_.properties[2].range = {usual.dynamic_friction, usual.dynamic_friction};
    if (friction) {
        const bool is_stated = friction->has("extras") && (*friction)["extras"].has("touchable_range");
        if (!is_stated) layers_.properties[2].range = scene_.haptic.dynamic_friction;
        say("friction of " + file_.string() + " is static and dynamic friction alike");
    }
    const auto states_range = [](const std::optional<Node>& texture) {
        return !texture || (texture->has("extras") && (*texture)["extras"].has("touchable_range"));
    };
    if (!states_range(stiffness) || !states_range(friction))
        add_remark(layers_.remarks,
                   {file_.filename().string() +
                        " states no units: black and white are the ends of haptic in the clip's scene file",
                    true, "\"extras\": {\"touchable_range\": [black, white]} beside a texture say others"});
    for (const char* other : {"vibrotactileTexture", "temperature", "vibration", "custom"})
        if (chosen.has(other)) say(std::string(other) + " of " + file_.string() + " is not used");
    return std::move(layers_);
}

}  // namespace

Result<HapticLayers> read_gltf_material(const std::filesystem::path& file, std::string_view bytes,
                                        const Scene& scene) {
    const auto refused = [&](const std::string& what) { return input_error(file.string() + ": " + what); };
    try {
        const GltfParts parts = parts_of(bytes);
        const Json json = checked_json::parse(parts.json, largest_json);
        return MaterialReader(file, Node(json, ""), parts.carried, scene).read();
    } catch (const Refusal& reason) {
        return refused(reason.message);
    } catch (const Json::exception& fault) {
        return refused(fault.what());
    } catch (const Error& error) {
        return error;
    }
}

}  // namespace touchable
