#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"
#include "engine/mpeg4/bifs.hpp"
#include "engine/mpeg4/bit_stream.hpp"
#include "engine/mpeg4/node_types.hpp"

namespace touchable::mpeg4 {
namespace {

constexpr std::size_t longest_name = 256, longest_string = 4096, most_bytes = std::size_t{64} << 10;

class SceneDecoder {
public:
    SceneDecoder(std::span<const std::uint8_t> bytes, const BifsConfig& config)
        : bits_(bytes), config_(config) {}
    Result<SceneTree> decode();

private:
    Error wrong(const std::string& what) const {
        return bits_.is_over() ? input_error("the scene ends within a node")
                               : input_error("bit " + std::to_string(bits_.position()) + ": " + what);
    }
    Result<std::string> name(const char* of_what);
    Result<std::string> string();
    void forget_names() {
        named_.clear();
        names_.clear();
    }
    Result<Prototype> prototype();
    Result<void> prototype_fields(Prototype& made);
    Result<NodePtr> node(NodeSlot slot, int depth);
    Result<std::string> type(NodeSlot slot);
    Result<void> fields(Node& node, int depth);
    Result<void> field_list(Node& node, std::span<const FieldSpec> specs, int depth);
    Result<Field> field(const FieldSpec& spec, bool is_outer, int depth);
    Result<std::vector<FieldValue>> values(FieldKind kind, NodeSlot slot, int depth);
    Result<FieldValue> value(FieldType type, NodeSlot slot, int depth);
    Result<float> real();
    template <std::size_t n>
    Result<FieldValue> reals();

    BitReader bits_;
    BifsConfig config_;
    bool has_names_ = false;
    SceneTree scene_;
    std::vector<std::uint64_t> prototype_ids_;
    std::map<std::uint64_t, NodePtr> named_;
    std::set<std::string> names_;        // theirs
    const Prototype* inside_ = nullptr;  // whose body is read
};

Result<SceneTree> SceneDecoder::decode() {
    constexpr std::uint64_t scene_replace = 3;
    if (bits_.get(2) != scene_replace)
        return wrong("an update of a scene: must be one that begins it (SceneReplace)");
    bits_.get(6);
    has_names_ = scene_.has_names = bits_.flag();
    while (bits_.flag()) {
        TRY_ASSIGN(auto made, prototype());
        scene_.prototypes.push_back(std::move(made));
        if (scene_.prototypes.size() > most_prototypes) return wrong("more than 64 prototypes");
    }
    TRY_ASSIGN(auto root, node(NodeSlot::top, 0));
    if (!root) return wrong("the scene is NULL: must be a node");
    scene_.root = std::move(root);
    if (bits_.flag()) return wrong("a ROUTE: a touchable clip's scene has no behaviour");
    if (bits_.is_over()) return wrong("");
    return std::move(scene_);
}

Result<std::string> SceneDecoder::name(const char* of_what) {
    std::string text;
    while (const auto c = bits_.get(8)) {
        text += static_cast<char>(c);
        if (text.size() > longest_name) break;
    }
    if (bits_.is_over()) return wrong("");
    if (is_name(text)) return text;
    return wrong("the name of a " + std::string(of_what) + ", " + in_quotes(text) +
                 ": must be a word of 1 to 256 letters");
}

Result<std::string> SceneDecoder::string() {
    const auto size = bits_.get(static_cast<int>(bits_.get(5)));
    if (size > longest_string || size > bits_.left() / 8)
        return wrong("a string of " + std::to_string(size) + " bytes: must be 4096 at most, and there");
    std::string text;
    for (std::uint64_t k = 0; k < size; ++k) text += static_cast<char>(bits_.get(8));
    return text;
}

Result<Prototype> SceneDecoder::prototype() {
    const auto id = bits_.get(config_.prototype_id_bits);
    if (std::find(prototype_ids_.begin(), prototype_ids_.end(), id) != prototype_ids_.end())
        return wrong("a second PROTO of number " + std::to_string(id));
    Prototype made{.name = "Proto" + std::to_string(id)};
    if (has_names_) {
        TRY_ASSIGN(auto text, name("PROTO"));
        made.name = std::move(text);
    }
    TRY(prototype_fields(made));
    if (!has_names_) name_by_fields(made);
    if (prototype_named(scene_.prototypes, made.name))
        return wrong("PROTO " + in_quotes(made.name) + ": must have a name of its own");
    if (bits_.flag()) {
        TRY_ASSIGN(auto urls, values({FieldType::url, true}, NodeSlot::world, 1));
        for (FieldValue& each : urls) made.elsewhere.push_back(std::get<Url>(std::move(each)));
        if (made.elsewhere.empty())
            return wrong("EXTERNPROTO " + printable(made.name) + ": must say where it is");
        for (FieldSpec& spec : made.fields) spec.initial.clear();
    } else {
        if (bits_.flag())
            return wrong("PROTO " + printable(made.name) + ": has a PROTO in its body, which is not read");
        inside_ = &made;
        do {
            TRY_ASSIGN(auto part, node(NodeSlot::world, 1));
            if (!part) return wrong("PROTO " + printable(made.name) + ": NULL is no node of its body");
            made.body.push_back(std::move(part));
        } while (bits_.flag());
        inside_ = nullptr;
        if (bits_.flag()) return wrong("PROTO " + printable(made.name) + ": has a ROUTE, which is not read");
    }
    forget_names();  // its own end with it
    if (bits_.get(2) != 0)
        return wrong("PROTO " + printable(made.name) +
                     ": its fields are quantised or animated, which is not read");
    prototype_ids_.push_back(id);
    return made;
}

Result<void> SceneDecoder::prototype_fields(Prototype& made) {
    while (bits_.flag()) {
        FieldSpec spec{.name = "field" + std::to_string(made.fields.size()), .kind = {}};
        spec.event = static_cast<FieldEvent>(bits_.get(2));
        const auto number = bits_.get(6);
        spec.kind = {static_cast<FieldType>(number & 31), number >= 32};
        if (kind_name(spec.kind) == "?")
            return wrong("PROTO " + printable(made.name) + ": has a field of type " + std::to_string(number) +
                         ", which is not read");
        if (has_names_) {
            TRY_ASSIGN(auto text, name("field"));
            spec.name = std::move(text);
        }
        if (field_named(made.fields, spec.name))
            return wrong("PROTO " + printable(made.name) + ": has " + spec.name + " twice");
        if (!spec.has_value())
            return wrong("PROTO " + printable(made.name) + ": has an event, " + printable(spec.name) +
                         ": a touchable clip's scene has no behaviour");
        TRY_ASSIGN(auto initial, values(spec.kind, NodeSlot::world, 1));
        spec.initial = std::move(initial);
        made.fields.push_back(std::move(spec));
        if (made.fields.size() > most_fields)
            return wrong("PROTO " + printable(made.name) + ": has more than 64 fields");
    }
    return bits_.is_over() ? Result<void>(wrong("")) : Result<void>();
}

Result<NodePtr> SceneDecoder::node(NodeSlot slot, int depth) {
    const auto too_deep = [&] {
        return wrong("nodes stand in each other more than " + std::to_string(deepest_node) + " deep");
    };
    if (depth > deepest_node) return too_deep();
    if (bits_.flag()) {
        const auto id = bits_.get(config_.node_id_bits);
        if (id + 1 == std::uint64_t{1} << config_.node_id_bits) return NodePtr();
        const auto known = named_.find(id);
        if (known == named_.end())
            return wrong("a node is used again that is not there, number " + std::to_string(id + 1));
        if (depth + known->second->levels - 1 > deepest_node) return too_deep();
        return known->second;
    }
    TRY_ASSIGN(auto of_type, type(slot));
    auto made = std::make_shared<Node>(Node{.type = std::move(of_type)});
    std::optional<std::uint64_t> id;
    if (bits_.flag()) {
        id = bits_.get(config_.node_id_bits);
        made->name = "N" + std::to_string(*id + 1);
        if (has_names_) {
            TRY_ASSIGN(auto text, name("node"));
            made->name = std::move(text);
        }
    }
    TRY(fields(*made, depth));
    if (bits_.is_over()) return wrong("");
    made->levels = levels_of(*made);
    if (!id) return NodePtr(std::move(made));
    if (!named_.emplace(*id, made).second)
        return wrong(made->type + ": a second node of number " + std::to_string(*id + 1));
    if (!names_.insert(made->name).second)
        return wrong(made->type + ": DEF " + made->name + ": must have a name of its own");
    return NodePtr(std::move(made));
}

/// By version: 0 leads to the next one's numbers, and 1 of version 2 to prototypes.
Result<std::string> SceneDecoder::type(NodeSlot slot) {
    for (int version = 1; version <= versions; ++version) {
        const auto code = bits_.get(code_bits(slot, version));
        if (code == 0) continue;
        if (version == 2 && code == 1) {
            const auto id = bits_.get(config_.prototype_id_bits);
            const auto known = std::find(prototype_ids_.begin(), prototype_ids_.end(), id);
            if (known == prototype_ids_.end())
                return wrong("a node of PROTO number " + std::to_string(id) + ", which is not there");
            return scene_.prototypes[static_cast<std::size_t>(known - prototype_ids_.begin())].name;
        }
        if (const NodeType* type = node_type(slot, version, static_cast<int>(code))) return type->name;
        return wrong("node " + std::to_string(code) + " of version " + std::to_string(version) +
                     " is none that a touchable clip has");
    }
    return wrong("a node of no kind");
}

/// By a mask or as a list, as SceneEncoder::fields.
Result<void> SceneDecoder::fields(Node& node, int depth) {
    const auto& all = *fields_of(scene_.prototypes, node.type);
    const NodeType* const known =
        prototype_named(scene_.prototypes, node.type) ? nullptr : node_type(node.type);
    const std::span specs(all.data(), all.size() - static_cast<std::size_t>(known ? known->paper_fields : 0));
    if (!bits_.flag()) return field_list(node, specs, depth);
    for (const FieldSpec& spec : specs) {
        if (!inside_ && !spec.has_value()) continue;
        if (!bits_.flag()) continue;
        TRY_ASSIGN(auto read, field(spec, inside_ && bits_.flag(), depth));
        node.fields.push_back(std::move(read));
    }
    return {};
}

Result<void> SceneDecoder::field_list(Node& node, std::span<const FieldSpec> specs, int depth) {
    std::vector<const FieldSpec*> with_values;
    for (const FieldSpec& spec : specs)
        if (spec.has_value()) with_values.push_back(&spec);
    while (!bits_.flag()) {
        if (bits_.is_over()) return wrong("");
        const bool is_outer = inside_ && bits_.flag();
        const std::size_t count = is_outer ? specs.size() : with_values.size();
        const auto number = count == 0 ? 0 : bits_.get(bits_for(count - 1));
        if (number >= count)
            return wrong(printable(node.type) + ": has no field of number " + std::to_string(number));
        const FieldSpec& spec = is_outer ? specs[number] : *with_values[number];
        if (node.field(spec.name))
            return wrong(printable(node.type) + ": has " + printable(spec.name) + " twice");
        TRY_ASSIGN(auto read, field(spec, is_outer, depth));
        node.fields.push_back(std::move(read));
    }
    const auto place = [specs](const Field& each) {
        return std::find_if(specs.begin(), specs.end(),
                            [&](const FieldSpec& spec) { return spec.name == each.name; });
    };
    std::stable_sort(node.fields.begin(), node.fields.end(),
                     [&](const Field& a, const Field& b) { return place(a) < place(b); });
    return {};
}

Result<Field> SceneDecoder::field(const FieldSpec& spec, bool is_outer, int depth) {
    Field made{spec.name};
    if (!is_outer) {
        TRY_ASSIGN(auto read, values(spec.kind, spec.slot, depth + 1));
        made.values = std::move(read);
        return made;
    }
    const auto& outer = inside_->fields;
    const auto number = outer.empty() ? 0 : bits_.get(bits_for(outer.size() - 1));
    if (number >= outer.size() || !(outer[number].kind == spec.kind))
        return wrong("PROTO " + printable(inside_->name) + ": has no field of number " +
                     std::to_string(number) + " and type " + std::string(kind_name(spec.kind)));
    made.is = outer[number].name;
    return made;
}

Result<std::vector<FieldValue>> SceneDecoder::values(FieldKind kind, NodeSlot slot, int depth) {
    std::vector<FieldValue> all;
    const auto add = [&]() -> Result<void> {
        TRY_ASSIGN(auto each, value(kind.type, slot, depth));
        if (bits_.is_over()) return wrong("");
        all.push_back(std::move(each));
        return {};
    };
    if (!kind.is_list) {
        TRY(add());
        return all;
    }
    if (bits_.flag()) return wrong("a list in a way of the future");
    if (bits_.flag()) {
        while (!bits_.flag()) TRY(add());
        return all;
    }
    const auto count = bits_.get(static_cast<int>(bits_.get(5)));
    if (count > bits_.left()) return wrong("a list of " + std::to_string(count) + " values: must be there");
    for (std::uint64_t k = 0; k < count; ++k) TRY(add());
    return all;
}

Result<FieldValue> SceneDecoder::value(FieldType type, NodeSlot slot, int depth) {
    switch (type) {
        case FieldType::boolean:
            return FieldValue(bits_.flag());
        case FieldType::integer:
            return FieldValue(static_cast<std::int32_t>(bits_.get(32)));
        case FieldType::time: {
            const auto seconds = std::bit_cast<double>(bits_.get(64));
            if (!std::isfinite(seconds)) return wrong("a time that is no number");
            return FieldValue(seconds);
        }
        case FieldType::real: {
            TRY_ASSIGN(const auto read, real());
            return FieldValue(read);
        }
        case FieldType::vec2:
            return reals<2>();
        case FieldType::vec3:
        case FieldType::colour:
            return reals<3>();
        case FieldType::rotation:
            return reals<4>();
        case FieldType::string: {
            TRY_ASSIGN(auto text, string());
            return FieldValue(std::move(text));
        }
        case FieldType::node: {
            TRY_ASSIGN(auto made, node(slot, depth));
            return FieldValue(std::move(made));
        }
        case FieldType::url:
            break;
    }
    Url made;
    if (bits_.flag()) {
        made.object = static_cast<std::uint16_t>(bits_.get(10));
        if (made.object == 0) return wrong("an object descriptor of number 0: must be 1 to 1023");
        return FieldValue(std::move(made));
    }
    TRY_ASSIGN(auto text, string());
    auto url = url_of(std::move(text));
    if (!url) return wrong("the number of an object descriptor in a URL: must be 1 to 1023");
    return FieldValue(std::move(*url));
}

Result<float> SceneDecoder::real() {
    const auto value = std::bit_cast<float>(static_cast<std::uint32_t>(bits_.get(32)));
    if (!std::isfinite(value)) return wrong("a number that is none");
    return value;
}

template <std::size_t n>
Result<FieldValue> SceneDecoder::reals() {
    std::array<float, n> all{};
    for (float& each : all) {
        TRY_ASSIGN(const auto read, real());
        each = read;
    }
    return FieldValue(all);
}

}  // namespace

Result<BifsConfig> decode_config(std::span<const std::uint8_t> bytes, int object_type) {
    if (object_type != 1 && object_type != 2)
        return input_error("a scene of object type " + std::to_string(object_type) +
                           ": must be BIFS, 1 or 2");
    BitReader bits(bytes);
    BifsConfig config{.version = object_type};
    if (object_type == 2 && bits.get(2) != 0)
        return input_error("a scene with compressed meshes or predicted fields, which is not read");
    config.node_id_bits = static_cast<int>(bits.get(5));
    config.route_id_bits = static_cast<int>(bits.get(5));
    config.prototype_id_bits = object_type == 2 ? static_cast<int>(bits.get(5)) : 0;
    if (!bits.flag()) return input_error("a stream that animates a scene: must be one that describes it");
    bits.get(1);
    if (bits.flag()) {
        config.width = static_cast<int>(bits.get(16));
        config.height = static_cast<int>(bits.get(16));
    }
    if (bits.is_over()) return input_error("its configuration is too short");
    return config;
}

Result<SceneTree> decode_scene(std::span<const std::uint8_t> bytes, const BifsConfig& config) {
    if (bytes.size() > most_bytes)
        return input_error("the scene has " + std::to_string(bytes.size()) +
                           " bytes: must be 64 KiB at most");
    return SceneDecoder(bytes, config).decode();
}

}  // namespace touchable::mpeg4
