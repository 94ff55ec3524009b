// SPDX-License-Identifier: Apache-2.0
#include "engine/mpeg4/node_types.hpp"

#include <algorithm>
#include <utility>

namespace touchable::mpeg4 {

namespace {

FieldSpec one(const char* name, FieldType type, FieldValue initial, FieldEvent event = FieldEvent::exposed) {
    return {name, {type, false}, event, {std::move(initial)}, NodeSlot::world};
}
FieldSpec list(const char* name, FieldType type, FieldEvent event = FieldEvent::exposed) {
    return {name, {type, true}, event, {}, NodeSlot::world};
}
FieldSpec node_in(const char* name, NodeSlot slot, FieldEvent event = FieldEvent::exposed) {
    return {name, {FieldType::node, false}, event, {NodePtr()}, slot};
}
FieldSpec nodes_in(const char* name, NodeSlot slot, FieldEvent event = FieldEvent::exposed) {
    return {name, {FieldType::node, true}, event, {}, slot};
}
FieldSpec range(const char* name, float least, float most) {
    return one(name, FieldType::vec2, std::array{least, most});
}

// Order of fields and numbers of nodes: ISO/IEC 14496-11, annex of node coding tables, and amendment 5's
// depth images. The paper's nodes are its Fig. 9 to 11.
std::vector<NodeType> make_types() {
    using enum NodeSlot;
    using enum FieldType;
    using enum FieldEvent;
    return {
        {"Group",
         {nodes_in("addChildren", three_d, in), nodes_in("removeChildren", three_d, in),
          nodes_in("children", three_d)},
         {{top, 1, 1}, {three_d, 1, 17}}},
        {"OrderedGroup",
         {nodes_in("addChildren", three_d, in), nodes_in("removeChildren", three_d, in),
          nodes_in("children", three_d), list("order", real)},
         {{top, 1, 4}, {three_d, 1, 26}}},
        {"Shape",
         {node_in("appearance", appearance), node_in("geometry", geometry)},
         {{three_d, 1, 38}, {world, 1, 81}}},
        {"Appearance",
         {node_in("material", other), node_in("texture", texture), node_in("textureTransform", other),
          node_in("hapticSurface", other)},
         {{appearance, 1, 1}, {world, 1, 3}},
         1},
        {"ImageTexture",
         {list("url", url), one("repeatS", boolean, true, field), one("repeatT", boolean, true, field)},
         {{texture, 1, 3}, {world, 1, 47}}},
        {"MovieTexture",
         {one("loop", boolean, false), one("speed", real, 1.0F), one("startTime", time, 0.0),
          one("stopTime", time, 0.0), list("url", url), one("repeatS", boolean, true, field),
          one("repeatT", boolean, true, field), one("duration_changed", time, 0.0, out),
          one("isActive", boolean, false, out)},
         {{texture, 1, 4}, {world, 1, 61}}},
        {"Rectangle", {one("size", vec2, std::array{2.0F, 2.0F})}, {{geometry, 1, 15}, {world, 1, 78}}},
        {"WorldInfo",
         {list("info", string, field), one("title", string, std::string(), field)},
         {{three_d, 1, 52}, {world, 1, 100}}},
        {"DepthImage",
         {node_in("diTexture", depth_texture, field), one("farPlane", real, 100.0F, field),
          one("fieldOfView", vec2, std::array{0.785398F, 0.785398F}, field),
          one("nearPlane", real, 10.0F, field),
          one("orientation", rotation, std::array{0.0F, 0.0F, 1.0F, 0.0F}, field),
          one("orthographic", boolean, true, field),
          one("position", vec3, std::array{0.0F, 0.0F, 10.0F}, field)},
         {{three_d, 5, 3}}},
        {"SimpleTexture",
         {node_in("depth", texture, field), node_in("texture", texture, field)},
         {{depth_texture, 5, 2}}},
        {"Depth",
         {one("focalLength", real, 4.7F, field), one("pixelWidth", real, 0.0112F, field),
          one("nearPlane", real, 40.0F, field), one("farPlane", real, 180.0F, field),
          node_in("texture", texture)},
         {}},
        {"HapticTextureSurface",
         {range("stiffnessRange", 0.1F, 10.0F), range("staticFrictionRange", 0.1F, 1.0F),
          range("dynamicFrictionRange", 0.1F, 1.0F), one("maxHeight", real, 1.0F),
          node_in("hapticTexture", texture), node_in("heightTexture", texture)},
         {}},
    };
}

const std::vector<NodeType>& types() {
    static const std::vector<NodeType> all = make_types();
    return all;
}

/// A type of field: its names, for one value and for a list, and its zero.
struct TypeFacts {
    FieldType type;
    std::array<std::string_view, 2> names;
    FieldValue zero;
};

const std::vector<TypeFacts>& type_facts() {
    using enum FieldType;
    static const std::vector<TypeFacts> all{
        {boolean, {"SFBool", "MFBool"}, false},
        {real, {"SFFloat", "MFFloat"}, 0.0F},
        {time, {"SFTime", "MFTime"}, 0.0},
        {string, {"SFString", "MFString"}, std::string()},
        {integer, {"SFInt32", "MFInt32"}, std::int32_t{0}},
        {vec3, {"SFVec3f", "MFVec3f"}, std::array<float, 3>{}},
        {vec2, {"SFVec2f", "MFVec2f"}, std::array<float, 2>{}},
        {colour, {"SFColor", "MFColor"}, std::array<float, 3>{}},
        {rotation, {"SFRotation", "MFRotation"}, std::array<float, 4>{}},
        {node, {"SFNode", "MFNode"}, NodePtr()},
        {url, {"SFURL", "MFURL"}, Url()},
    };
    return all;
}

}  // namespace

bool is_name(std::string_view word) {
    constexpr std::size_t longest = 256;
    constexpr std::string_view marks = "{}[]\"#,";
    constexpr std::array<std::string_view, 6> keywords{"DEF", "USE", "NULL", "IS", "PROTO", "EXTERNPROTO"};
    const auto is_letter = [marks](char c) { return c > ' ' && c <= '~' && marks.find(c) == marks.npos; };
    return !word.empty() && word.size() <= longest && std::ranges::all_of(word, is_letter) &&
           std::ranges::find(keywords, word) == keywords.end();
}

std::optional<Url> url_of(std::string text) {
    constexpr int most = 1023;
    constexpr std::string_view scheme = "od:";
    Url made;
    if (!text.starts_with(scheme)) {
        made.file = std::move(text);
        return made;
    }
    made.object = parsed_as<std::uint16_t>(std::string_view(text).substr(scheme.size())).value_or(0);
    return made.object >= 1 && made.object <= most ? std::optional(made) : std::nullopt;
}

int levels_of(const Node& node) {
    int most = 0;
    for (const Field& field : node.fields)
        for (const FieldValue& value : field.values)
            if (const auto* inner = std::get_if<NodePtr>(&value); inner && *inner)
                most = std::max(most, (*inner)->levels);
    return most + 1;
}

const NodeType* node_type(std::string_view name) {
    return named_in(types(), name, &NodeType::name);
}

const NodeType* node_type(NodeSlot slot, int version, int code) {
    for (const NodeType& type : types())
        for (const NodeCode& each : type.codes)
            if (each.slot == slot && each.version == version && each.code == code) return &type;
    return nullptr;
}

int code_bits(NodeSlot slot, int version) {
    // Of each slot in versions 1 to 5. Prototypes are numbered in version 2, so it has a bit everywhere.
    constexpr std::array<std::array<int, versions>, 8> bits{{
        {7, 4, 2, 3, 6},  // world
        {6, 3, 2, 3, 5},  // three_d
        {5, 2, 0, 0, 4},  // geometry
        {1, 1, 0, 0, 1},  // appearance
        {3, 1, 0, 1, 1},  // texture
        {2, 2, 0, 0, 0},  // other: materials
        {0, 1, 0, 0, 2},  // depth_texture
        {3, 1, 0, 0, 0},  // top
    }};
    return bits[static_cast<std::size_t>(slot)][static_cast<std::size_t>(version - 1)];
}

const Prototype* prototype_named(std::span<const Prototype> prototypes, std::string_view name) {
    return named_in(prototypes, name, &Prototype::name);
}

const FieldSpec* field_named(std::span<const FieldSpec> fields, std::string_view name) {
    return named_in(fields, name, &FieldSpec::name);
}

void sort_fields(Node& node, std::span<const FieldSpec> specs) {
    std::ranges::stable_sort(node.fields, [specs](const Field& a, const Field& b) {
        return field_named(specs, a.name) < field_named(specs, b.name);
    });
}

const std::vector<FieldSpec>* fields_of(std::span<const Prototype> prototypes, std::string_view type) {
    if (const Prototype* prototype = prototype_named(prototypes, type)) return &prototype->fields;
    const NodeType* known = node_type(type);
    return known ? &known->fields : nullptr;
}

void name_by_fields(Prototype& prototype) {
    const FieldSpec& surface = node_type("Appearance")->fields.back();
    std::vector<FieldSpec> depth = node_type("Depth")->fields, depth_of_ours = depth;
    depth_of_ours.push_back(surface);
    const std::pair<const char*, std::vector<FieldSpec>> known[] = {
        {"HapticTextureSurface", node_type("HapticTextureSurface")->fields},
        {"Depth", std::move(depth_of_ours)},
        {"Depth", std::move(depth)},
        {"HapticAppearance", node_type("Appearance")->fields}};
    for (const auto& [name, fields] : known) {
        if (!std::equal(fields.begin(), fields.end(), prototype.fields.begin(), prototype.fields.end(),
                        [](const FieldSpec& a, const FieldSpec& b) { return a.kind == b.kind; }))
            continue;
        prototype.name = name;
        for (std::size_t k = 0; k < fields.size(); ++k) prototype.fields[k].name = fields[k].name;
        return;
    }
}

std::string_view kind_name(FieldKind kind) {
    for (const TypeFacts& each : type_facts())
        if (each.type == kind.type) return each.names[kind.is_list ? 1 : 0];
    return "?";
}

std::optional<FieldKind> kind_named(std::string_view name) {
    for (const TypeFacts& each : type_facts())
        for (const bool is_list : {false, true})
            if (each.names[is_list ? 1 : 0] == name) return FieldKind{each.type, is_list};
    return std::nullopt;
}

FieldValue zero_of(FieldType type) {
    for (const TypeFacts& each : type_facts())
        if (each.type == type) return each.zero;
    return {};
}

}  // namespace touchable::mpeg4
