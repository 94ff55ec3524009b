// SPDX-License-Identifier: Apache-2.0
#pragma once

// An MPEG-4 scene (ISO/IEC 14496-11), the same for its text and its binary form (BIFS): nodes with fields,
// and prototypes of nodes.
//
// parse_scene_text and decode_scene read a SceneTree, scene_text and encode_scene write it. It can hold only
// those of MPEG-4's nodes that node_type knows: each NodeType has its fields, in order, and its numbers in
// the binary form. fields_of finds the fields of a node, of a known kind or of a prototype. Plain values and
// pure functions, for any thread.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "engine/base/words.hpp"

namespace touchable::mpeg4 {

/// Type of a field, numbered as in the binary form.
enum class FieldType : std::uint8_t {
    boolean = 0,
    real = 1,
    time = 2,
    string = 3,
    integer = 4,
    vec3 = 5,
    vec2 = 6,
    colour = 7,
    rotation = 8,
    node = 10,
    url = 11,
};

/// One value (SF) or a list of them (MF).
struct FieldKind {
    FieldType type = FieldType::real;
    bool is_list = false;
    bool operator==(const FieldKind&) const = default;
};

/// How a field changes while a scene is shown, numbered as in the binary form.
enum class FieldEvent : std::uint8_t { field = 0, exposed = 1, in = 2, out = 3 };

/// Where a node may be placed. The binary form numbers nodes by this (a node data type).
enum class NodeSlot : std::uint8_t {
    world,
    three_d,
    geometry,
    appearance,
    texture,
    other,
    depth_texture,
    top
};

struct Node;
/// Null stands for NULL. A node that is used again (USE) is the same object.
using NodePtr = std::shared_ptr<Node>;

/// The target of a URL field: a stream, by its object descriptor, or a file.
struct Url {
    std::uint16_t object = 0;  ///< 1 to 1023; 0: none, so it is a file
    std::string file{};
    bool operator==(const Url&) const = default;
};
/// Parses its text: "od:10" is object 10, anything else a file; nullopt for an impossible object number.
std::optional<Url> url_of(std::string text);

using FieldValue = std::variant<bool, float, double, std::string, std::int32_t, std::array<float, 2>,
                                std::array<float, 3>, std::array<float, 4>, NodePtr, Url>;

/// A field that a kind of node has.
struct FieldSpec {
    std::string name;
    FieldKind kind;
    FieldEvent event = FieldEvent::exposed;
    std::vector<FieldValue> initial{};  ///< if none is given: one value, or a list
    NodeSlot slot = NodeSlot::world;    ///< of a field of nodes
    /// Whether a scene can give it a value.
    bool has_value() const { return event == FieldEvent::field || event == FieldEvent::exposed; }
};

/// A field that has a value: one, or those of a list.
struct Field {
    std::string name;
    std::vector<FieldValue> values{};
    std::string is{};  ///< in a prototype's body: the prototype's field that gives the value; else empty
};

struct Node {
    std::string type;             ///< "Shape", or a prototype's name
    std::string name{};           ///< by which it is used again (DEF); empty: none
    std::vector<Field> fields{};  ///< in the order of its kind
    int levels = 1;               ///< of nodes, with itself, as its reader counted
    const Field* field(std::string_view wanted) const { return named_in(fields, wanted, &Field::name); }
};

/// A kind of node that a scene defines (PROTO), or that is defined elsewhere (EXTERNPROTO).
struct Prototype {
    std::string name;
    std::vector<FieldSpec> fields{};
    std::vector<NodePtr> body{};   ///< of a PROTO, one or more; the first takes the node's place
    std::vector<Url> elsewhere{};  ///< of an EXTERNPROTO, one or more
};

struct SceneTree {
    std::vector<Prototype> prototypes;
    NodePtr root;
    bool has_names = true;  ///< the binary form may leave them out (name_by_fields)
};

/// Whether a word may name nodes, prototypes and fields: both forms can hold it, and text reads it as nothing
/// else. 256 bytes at most.
bool is_name(std::string_view word);

/// Limits of a scene's prototypes, and of a prototype's fields. A touchable clip has up to 3, of up to 6.
inline constexpr std::size_t most_prototypes = 64, most_fields = 64;

/// Limit of nesting. Nodes of a touchable clip are 5 deep.
inline constexpr int deepest_node = 32;
/// Finds `Node::levels` from the nodes in its fields.
int levels_of(const Node& node);

/// The number of a kind of node in a slot of the binary form.
struct NodeCode {
    NodeSlot slot;
    int version;  ///< of the nodes' table, from 1
    int code;
};

/// A kind of node that MPEG-4 or the paper defines.
struct NodeType {
    std::string name;
    std::vector<FieldSpec> fields;
    std::vector<NodeCode> codes;  ///< none: only text has it, as the paper wrote it
    /// Number of fields, at the end, that only text has (the paper's `hapticSurface`).
    int paper_fields = 0;
};

/// Null: this program knows no such node.
const NodeType* node_type(std::string_view name);
/// The kind that has this number in a slot; null: none.
const NodeType* node_type(NodeSlot slot, int version, int code);
/// Bits of a number of this version in a slot; 0: the version has no node there.
int code_bits(NodeSlot slot, int version);
inline constexpr int versions = 5;

/// A scene's prototype of that name; null: none.
const Prototype* prototype_named(std::span<const Prototype> prototypes, std::string_view name);
/// The field of that name; null: none.
const FieldSpec* field_named(std::span<const FieldSpec> fields, std::string_view name);
/// Sorts a node's fields into the order of `specs`, which must have all of them.
void sort_fields(Node& node, std::span<const FieldSpec> specs);
/// The fields of a node; null if it is neither a prototype nor a known node.
const std::vector<FieldSpec>* fields_of(std::span<const Prototype> prototypes, std::string_view type);

/// Names a prototype and its fields like the one of touchable whose fields have the same types in the same
/// order: HapticTextureSurface, Depth, HapticAppearance. Any other stays as it is.
void name_by_fields(Prototype& prototype);

/// "SFFloat", "MFURL".
std::string_view kind_name(FieldKind kind);
std::optional<FieldKind> kind_named(std::string_view name);
/// False, 0, an empty text, NULL: a value that a reader fills in, or that stands where a field states none.
FieldValue zero_of(FieldType type);

}  // namespace touchable::mpeg4
