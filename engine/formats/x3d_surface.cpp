// SPDX-License-Identifier: Apache-2.0
// Surfaces of touch in X3D: H3DAPI's HapticTexturesSurface (SurfaceReader).

#include "engine/formats/touch_maps.hpp"

#include <algorithm>
#include <pugixml.hpp>
#include <unordered_map>
#include <vector>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/formats/picture_files.hpp"

namespace touchable {
namespace {

/// A larger mesh belongs into a file of its own; a tag of four bytes takes 64 of memory.
constexpr std::size_t largest_x3d = std::size_t{16} << 20U;

constexpr std::string_view blanks = " \t\r\n,";

/// Parses a list of strings: each in double quotes, or a single one without.
std::vector<std::string> strings_in(std::string_view text) {
    text = trimmed(text, blanks);
    if (text.empty()) return {};
    if (text.front() != '"') return {std::string(text)};
    std::vector<std::string> strings;
    bool inside = false;
    for (std::size_t k = 0; k < text.size(); ++k) {
        if (inside && text[k] == '\\' && k + 1 < text.size())
            strings.back() += text[++k];
        else if (text[k] == '"') {
            inside = !inside;
            if (inside) strings.emplace_back();
        } else if (inside)
            strings.back() += text[k];
    }
    return strings;
}

struct Property {
    const char *map, *value, *least, *most;
    double usual;  ///< value without a map
};
constexpr std::array<Property, 3> properties{
    {{"stiffnessMap", "stiffness", "minStiffness", "maxStiffness", 0.5},
     {"staticFrictionMap", "staticFriction", "minStaticFriction", "maxStaticFriction", 0.1},
     {"dynamicFrictionMap", "dynamicFriction", "minDynamicFriction", "maxDynamicFriction", 0.4}}};

/// A surface's child node for a map.
pugi::xml_node map_of(const pugi::xml_node& surface, std::string_view name) {
    return surface.find_child([&](const pugi::xml_node& child) {
        return std::string_view(child.attribute("containerField").value()) == name;
    });
}

/// The file's surfaces, and its nodes with names.
struct Nodes : pugi::xml_tree_walker {
    std::vector<pugi::xml_node> with_maps;
    bool any_surface = false;
    std::unordered_map<std::string_view, pugi::xml_node> named;

    bool for_each(pugi::xml_node& node) override {
        if (const auto name = node.attribute("DEF")) named.emplace(name.value(), node);
        if (std::string_view(node.name()) != "HapticTexturesSurface") return true;
        any_surface = true;
        if (std::ranges::any_of(
                properties, [&](const char* map) { return !map_of(node, map).empty(); }, &Property::map))
            with_maps.push_back(node);
        return true;
    }
};

class SurfaceReader {
public:
    SurfaceReader(const std::filesystem::path& file, const Scene& scene, const Nodes& nodes)
        : file_(file), unit_(scene.haptic.stiffness.max), nodes_(nodes), surface_(nodes.with_maps.front()) {}

    Result<HapticLayers> read() {
        HapticLayers layers;
        layers.files.push_back(file_);
        TRY_ASSIGN(const auto relative, is_relative());
        for (std::size_t k = 0; k < properties.size(); ++k)
            TRY(assign(layers.properties[k], layer(properties[k])));
        PropertyRange& stiffness = layers.properties[0].range;
        const double unit = relative ? unit_ : 1e-3;
        stiffness = {stiffness.min * unit, stiffness.max * unit};
        add_notes(relative, layers);
        return layers;
    }

private:
    /// A field's number; an empty field counts as left out.
    Result<double> number(const char* field, double usual) const {
        const std::string_view given = surface_.attribute(field).value();
        std::string_view text = trimmed(given, blanks);
        if (text.empty()) return usual;
        if (text.front() == '+') text.remove_prefix(1);
        const auto value = parsed_number(text);
        if (!value || *value < 0) return refused(field, given, "a number, 0 or above");
        return *value;
    }

    Result<bool> is_relative() const {
        const std::string_view given = surface_.attribute("useRelativeValues").value(),
                               text = trimmed(given, blanks);
        if (text.empty() || text == "true" || text == "TRUE") return true;
        if (text == "false" || text == "FALSE") return false;
        return refused("useRelativeValues", given, "true or false");
    }

    Result<LinkedFile> picture(pugi::xml_node texture, const char* map) const {
        if (const auto use = texture.attribute("USE")) {
            const auto named = nodes_.named.find(use.value());
            if (named == nodes_.named.end())
                return refused(map, std::string("USE ") + use.value(), "the DEF of a node in this file");
            texture = named->second;
        }
        if (std::string_view(texture.name()) != "ImageTexture")
            return refused(map, texture.name(), "an ImageTexture");
        const auto urls = strings_in(texture.attribute("url").value());
        const auto local = std::find_if(urls.begin(), urls.end(), is_local_link);
        if (local == urls.end())
            return refused(map, texture.attribute("url").value(),
                           "a picture in a file, such as url='\"stiff.png\"'");
        std::error_code ignored;
        for (const std::string& url : urls) {
            if (!is_local_link(url)) continue;
            auto link = follow_link(url, file_);
            if (link && !link->file.empty() && !std::filesystem::exists(link->file, ignored)) continue;
            return link;
        }
        return follow_link(*local, file_);
    }

    Result<HapticLayer> layer(const Property& property) const {
        const auto texture = map_of(surface_, property.map);
        TRY_ASSIGN(const auto least,
                   texture ? number(property.least, 0) : number(property.value, property.usual));
        if (!texture) return HapticLayer{{}, {least, least}};
        TRY_ASSIGN(const auto most, number(property.most, 1));
        if (most < least)
            return refused(
                property.most, short_number(most),
                (std::string("at least ") + property.least + ", which is " + short_number(least)).c_str());
        TRY_ASSIGN(auto from, picture(texture, property.map));
        return HapticLayer{std::move(from), {least, most}};
    }

    void add_notes(bool relative, HapticLayers& layers) const {
        const std::string name = file_.string();
        if (nodes_.with_maps.size() > 1)
            layers.notes.push_back(name + " has " + std::to_string(nodes_.with_maps.size()) +
                                   " HapticTexturesSurface nodes with maps: the first is taken");
        if (relative)
            add_remark(layers.remarks, {"stiffness of " + file_.filename().string() +
                                            " is relative to a device's largest: 1 is taken for " +
                                            short_number(unit_) + " N/mm",
                                        true,
                                        "the upper end of haptic.stiffness in the clip's scene file says it "
                                        "otherwise; or useRelativeValues='false' and N/m"});
        if (map_of(surface_, "dampingMap")) layers.notes.push_back("dampingMap of " + name + " is not used");
        if (surface_.parent().child("TextureTransform"))
            layers.notes.push_back("TextureTransform of " + name +
                                   " is not used: pictures lie over the whole of depth's");
    }

    Error refused(const char* field, std::string_view value, const char* right) const {
        return input_error(file_.string() + ": HapticTexturesSurface: " + field + " is " + in_quotes(value) +
                           ": must be " + right);
    }

    const std::filesystem::path& file_;
    const double unit_;  // N/mm of a relative 1
    const Nodes& nodes_;
    const pugi::xml_node surface_;
};

}  // namespace

Result<HapticLayers> read_x3d_surface(const std::filesystem::path& file, std::string_view text,
                                      const Scene& scene) {
    const auto refuse = [&](const std::string& what) { return input_error(file.string() + ": " + what); };
    if (text.starts_with("#X3D") || text.starts_with("#VRML"))
        return refuse("is X3D or VRML in its classic encoding: must be in XML (.x3d)");
    if (text.size() > largest_x3d)
        return refuse("is more than 16 MiB of X3D: keep the HapticTexturesSurface in a file of its own");
    pugi::xml_document document;
    // Entities that a document declares are never expanded.
    const pugi::xml_parse_result parsed = document.load_buffer(text.data(), text.size());
    if (!parsed) {
        const auto at = static_cast<std::ptrdiff_t>(std::min<std::size_t>(
            text.size(), static_cast<std::size_t>(std::max<std::ptrdiff_t>(parsed.offset, 0))));
        return refuse("line " + std::to_string(1 + std::count(text.begin(), text.begin() + at, '\n')) +
                      ": must be X3D in XML: " + parsed.description());
    }
    Nodes nodes;
    document.traverse(nodes);
    if (nodes.with_maps.empty())
        return refuse(std::string(nodes.any_surface ? "its HapticTexturesSurface has no map"
                                                    : "has no HapticTexturesSurface") +
                      ": must have one, with ImageTexture nodes whose containerField is stiffnessMap, "
                      "staticFrictionMap or dynamicFrictionMap");
    return SurfaceReader(file, scene, nodes).read();
}

}  // namespace touchable
