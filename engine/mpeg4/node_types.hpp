#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "engine/mpeg4/scene_tree.hpp"

namespace touchable::mpeg4 {

/// The number of a kind of node in the binary form, where it may stand.
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
    /// Fields that only text has (the paper's `hapticSurface`) are the last ones, so many.
    int paper_fields = 0;
};

/// Null where this program knows no such node.
const NodeType* node_type(std::string_view name);
/// The kind that has this number there; null where there is none.
const NodeType* node_type(NodeSlot slot, int version, int code);
/// Bits of a number of this version there; 0 where that version has no node.
int code_bits(NodeSlot slot, int version);
inline constexpr int versions = 5;

/// A scene's prototype of that name; null where there is none.
const Prototype* prototype_named(std::span<const Prototype> prototypes, std::string_view name);
/// The field of that name; null where there is none.
const FieldSpec* field_named(std::span<const FieldSpec> fields, std::string_view name);
/// The fields of a node; null where it is neither a prototype nor a node that is known.
const std::vector<FieldSpec>* fields_of(std::span<const Prototype> prototypes, std::string_view type);

/// A prototype whose fields have the types of those of a prototype of ours, in that order, gets its name, and
/// they get theirs: HapticTextureSurface, Depth, HapticAppearance. Any other stays as it is.
void name_by_fields(Prototype& prototype);

/// "SFFloat", "MFURL".
std::string_view kind_name(FieldKind kind);
std::optional<FieldKind> kind_named(std::string_view name);

}  // namespace touchable::mpeg4
