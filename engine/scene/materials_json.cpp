#include "engine/scene/materials_json.hpp"

#include <algorithm>
#include <charconv>
#include <string>

#include "engine/base/printable.hpp"

namespace touchable {
namespace {

using MaterialNode = checked_json::Node;
using MaterialJson = nlohmann::ordered_json;

constexpr double stiffest = 1e6;  // N/mm

/// A name of digits as somebody writes a number.
int read_index(const MaterialNode& materials, const std::string& name) {
    int index = -1;
    const char* const end = name.data() + name.size();
    const auto read = std::from_chars(name.data(), end, index);
    const bool is_plain = read.ec == std::errc() && read.ptr == end && name == std::to_string(index);
    if (!is_plain || index < 0 || index > largest_material_index)
        materials.refuse(
            "an object whose names are material indices from 0 to 65535, such as \"1\", and not " +
            in_quotes(name));
    return index;
}

void check(const MaterialNode& node, const HapticProperties& properties) {
    const double stiffness = properties.stiffness / 1000;
    if (!(stiffness > 0 && stiffness <= stiffest)) node.refuse("of a stiffness above 0 and at most 1e6 N/mm");
    if (!(properties.dynamic_friction >= 0)) node.refuse("of a dynamic_friction of 0 or more");
    if (!(properties.static_friction >= properties.dynamic_friction))
        node.refuse("of a static_friction (" + MaterialJson(properties.static_friction).dump() +
                    ") that is not below dynamic_friction (" +
                    MaterialJson(properties.dynamic_friction).dump() + ")");
}

/// Makes room for what the range is to hold, or refuses what is stated.
void hold(const MaterialNode& haptic, const char* member, bool is_first, double value, PropertyRange& range) {
    if (!haptic.has(member)) {
        range = is_first ? PropertyRange{value, value}
                         : PropertyRange{std::min(range.min, value), std::max(range.max, value)};
    } else if (value < range.min || value > range.max) {
        haptic[member].refuse("a range that holds " + MaterialJson(value).dump() +
                              ", which a material or default_properties has (or be left out)");
    }
}

}  // namespace

void read_properties(const MaterialNode& node, HapticProperties& properties) {
    node.allow_only({"stiffness", "stiffness_n_per_m", "static_friction", "dynamic_friction"});
    if (node.has("stiffness") && node.has("stiffness_n_per_m"))
        node["stiffness_n_per_m"].refuse("left out where stiffness (in N/mm) is given");
    if (node.has("stiffness")) properties.stiffness = node["stiffness"].number() * 1000.0;
    if (node.has("stiffness_n_per_m")) properties.stiffness = node["stiffness_n_per_m"].number();
    if (node.has("static_friction")) properties.static_friction = node["static_friction"].number();
    if (node.has("dynamic_friction")) properties.dynamic_friction = node["dynamic_friction"].number();
}

MaterialJson write_properties(const HapticProperties& properties) {
    // Not every double in N/m is a thousand times a double; those are written in N/m.
    MaterialJson json;
    const double in_n_per_mm = properties.stiffness / 1000.0;
    if (in_n_per_mm * 1000.0 == properties.stiffness)
        json["stiffness"] = in_n_per_mm;
    else
        json["stiffness_n_per_m"] = properties.stiffness;
    json["static_friction"] = properties.static_friction;
    json["dynamic_friction"] = properties.dynamic_friction;
    return json;
}

std::vector<Material> read_materials(const MaterialNode& haptic, const HapticProperties& otherwise,
                                     HapticRanges& ranges) {
    const MaterialNode node = haptic["materials"];
    const std::vector<std::string> names = node.members();
    if (names.empty() || names.size() > most_materials)
        node.refuse("an object of 1 to 256 materials, such as {\"1\": {\"stiffness\": 0.8}}");
    std::vector<Material> materials;
    for (const std::string& name : names) {
        Material material{read_index(node, name), otherwise};
        read_properties(node[name.c_str()], material.properties);
        check(node[name.c_str()], material.properties);
        materials.push_back(material);
    }
    std::sort(materials.begin(), materials.end(),
              [](const Material& a, const Material& b) { return a.index < b.index; });
    const auto hold_all = [&](const HapticProperties& properties, bool is_first) {
        hold(haptic, "stiffness", is_first, properties.stiffness / 1000, ranges.stiffness);
        hold(haptic, "static_friction", is_first, properties.static_friction, ranges.static_friction);
        hold(haptic, "dynamic_friction", is_first, properties.dynamic_friction, ranges.dynamic_friction);
    };
    hold_all(otherwise, true);
    for (const Material& material : materials) hold_all(material.properties, false);
    return materials;
}

MaterialJson write_materials(const std::vector<Material>& materials) {
    MaterialJson json = MaterialJson::object();
    for (const Material& material : materials)
        json[std::to_string(material.index)] = write_properties(material.properties);
    return json;
}

}  // namespace touchable
