// SPDX-License-Identifier: Apache-2.0
#include "engine/mpeg4/bifs.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <set>
#include <type_traits>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable::mpeg4 {

namespace {

constexpr std::size_t longest_name = 256, longest_string = 4096, most_bytes = std::size_t{64} << 10;
constexpr std::uint64_t scene_replace = 3;  // the command that begins a scene

/// The fields of a node's type that MPEG-4 has: all but the paper's own.
std::span<const FieldSpec> fields_in_bits(const SceneTree& scene, const Node& node) {
    const std::vector<FieldSpec>& all = *fields_of(scene.prototypes, node.type);
    const NodeType* const known =
        prototype_named(scene.prototypes, node.type) ? nullptr : node_type(node.type);
    return std::span(all).first(all.size() - static_cast<std::size_t>(known ? known->paper_fields : 0));
}

class SceneDecoder {
public:
    SceneDecoder(std::span<const std::uint8_t> bytes, const BifsConfig& config)
        : bits_(bytes), config_(config) {}
    Result<SceneTree> decode() {
        if (bits_.get(2) != scene_replace)
            return wrong("an update of a scene: must be one that begins it (SceneReplace)");
        bits_.get(6);
        has_names_ = scene_.has_names = bits_.flag();
        while (bits_.flag()) {
            TRY_ASSIGN(auto made, prototype());
            scene_.prototypes.push_back(std::move(made));
            if (scene_.prototypes.size() > most_prototypes) return wrong("more than 64 prototypes");
        }
        TRY_ASSIGN(scene_.root, node(NodeSlot::top, 0));
        if (!scene_.root) return wrong("the scene is NULL: must be a node");
        if (bits_.flag()) return wrong("a ROUTE: a touchable clip's scene has no behaviour");
        if (bits_.is_over()) return wrong("");
        return std::move(scene_);
    }

private:
    Error wrong(const std::string& what) const {
        return bits_.is_over() ? input_error("the scene ends within a node")
                               : input_error("bit " + std::to_string(bits_.position()) + ": " + what);
    }
    Error wrong_in(const Prototype& made, const std::string& what) const {
        return wrong("PROTO " + printable(made.name) + ": " + what);
    }
    Result<std::string> name(const char* of_what) {
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

    Result<std::string> string() {
        const auto size = bits_.get(static_cast<int>(bits_.get(5)));
        if (size > longest_string || size > bits_.left() / 8)
            return wrong("a string of " + std::to_string(size) + " bytes: must be 4096 at most, and there");
        std::string text;
        for (std::uint64_t k = 0; k < size; ++k) text += static_cast<char>(bits_.get(8));
        return text;
    }

    void forget_names() {
        named_.clear();
        names_.clear();
    }
    Result<Prototype> prototype() {
        const auto id = bits_.get(config_.prototype_id_bits);
        if (std::ranges::find(prototype_ids_, id) != prototype_ids_.end())
            return wrong("a second PROTO of number " + std::to_string(id));
        Prototype made{.name = "Proto" + std::to_string(id)};
        if (has_names_) TRY(assign(made.name, name("PROTO")));
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
            if (bits_.flag()) return wrong_in(made, "has a PROTO in its body, which is not read");
            inside_ = &made;
            do {
                TRY_ASSIGN(auto part, node(NodeSlot::world, 1));
                if (!part) return wrong_in(made, "NULL is no node of its body");
                made.body.push_back(std::move(part));
            } while (bits_.flag());
            inside_ = nullptr;
            if (bits_.flag()) return wrong_in(made, "has a ROUTE, which is not read");
        }
        forget_names();  // its names end with it
        if (bits_.get(2) != 0)
            return wrong_in(made, "its fields are quantised or animated, which is not read");
        prototype_ids_.push_back(id);
        return made;
    }

    Result<void> prototype_fields(Prototype& made) {
        while (bits_.flag()) {
            FieldSpec spec{.name = "field" + std::to_string(made.fields.size()), .kind = {}};
            spec.event = static_cast<FieldEvent>(bits_.get(2));
            const auto number = bits_.get(6);
            spec.kind = {static_cast<FieldType>(number & 31), number >= 32};
            if (kind_name(spec.kind) == "?")
                return wrong_in(made,
                                "has a field of type " + std::to_string(number) + ", which is not read");
            if (has_names_) TRY(assign(spec.name, name("field")));
            if (field_named(made.fields, spec.name)) return wrong_in(made, "has " + spec.name + " twice");
            if (!spec.has_value())
                return wrong_in(made, "has an event, " + printable(spec.name) +
                                          ": a touchable clip's scene has no behaviour");
            TRY_ASSIGN(spec.initial, values(spec.kind, NodeSlot::world, 1));
            made.fields.push_back(std::move(spec));
            if (made.fields.size() > most_fields) return wrong_in(made, "has more than 64 fields");
        }
        return bits_.is_over() ? Result<void>(wrong("")) : Result<void>();
    }

    Result<NodePtr> node(NodeSlot slot, int depth) {
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
            if (has_names_) TRY(assign(made->name, name("node")));
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

    /// Reads a number version by version: 0 leads to the next version, and 1 of version 2 to prototypes.
    Result<std::string> type(NodeSlot slot) {
        for (int version = 1; version <= versions; ++version) {
            const auto code = bits_.get(code_bits(slot, version));
            if (code == 0) continue;
            if (version == 2 && code == 1) {
                const auto id = bits_.get(config_.prototype_id_bits);
                const auto known = std::ranges::find(prototype_ids_, id);
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

    /// Reads fields by a mask or as a list, like SceneEncoder::fields.
    Result<void> fields(Node& node, int depth) {
        const auto specs = fields_in_bits(scene_, node);
        if (!bits_.flag()) return field_list(node, specs, depth);
        for (const FieldSpec& spec : specs) {
            if (!inside_ && !spec.has_value()) continue;
            if (!bits_.flag()) continue;
            TRY_ASSIGN(auto read, field(spec, inside_ && bits_.flag(), depth));
            node.fields.push_back(std::move(read));
        }
        return {};
    }

    Result<void> field_list(Node& node, std::span<const FieldSpec> specs, int depth) {
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
        sort_fields(node, specs);
        return {};
    }

    Result<Field> field(const FieldSpec& spec, bool is_outer, int depth) {
        Field made{spec.name};
        if (!is_outer) {
            TRY_ASSIGN(made.values, values(spec.kind, spec.slot, depth + 1));
            return made;
        }
        const auto& outer = inside_->fields;
        const auto number = outer.empty() ? 0 : bits_.get(bits_for(outer.size() - 1));
        if (number >= outer.size() || !(outer[number].kind == spec.kind))
            return wrong_in(*inside_, "has no field of number " + std::to_string(number) + " and type " +
                                          std::string(kind_name(spec.kind)));
        made.is = outer[number].name;
        return made;
    }

    Result<std::vector<FieldValue>> values(FieldKind kind, NodeSlot slot, int depth) {
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
        if (count > bits_.left())
            return wrong("a list of " + std::to_string(count) + " values: must be there");
        for (std::uint64_t k = 0; k < count; ++k) TRY(add());
        return all;
    }

    Result<FieldValue> value(FieldType type, NodeSlot slot, int depth) {
        FieldValue made = zero_of(type);
        const auto read = [&](auto& each) -> Result<void> {
            using T = std::decay_t<decltype(each)>;
            if constexpr (std::is_same_v<T, bool>) {
                each = bits_.flag();
            } else if constexpr (std::is_same_v<T, std::int32_t>) {
                each = static_cast<std::int32_t>(bits_.get(32));
            } else if constexpr (std::is_same_v<T, double>) {
                each = std::bit_cast<double>(bits_.get(64));
                if (!std::isfinite(each)) return wrong("a time that is no number");
            } else if constexpr (std::is_same_v<T, float>) {
                TRY(assign(each, real()));
            } else if constexpr (std::is_same_v<T, std::string>) {
                TRY(assign(each, string()));
            } else if constexpr (std::is_same_v<T, NodePtr>) {
                TRY(assign(each, node(slot, depth)));
            } else if constexpr (std::is_same_v<T, Url>) {
                TRY(assign(each, url()));
            } else {
                for (float& number : each) TRY(assign(number, real()));
            }
            return {};
        };
        TRY(std::visit(read, made));
        return made;
    }

    Result<Url> url() {
        Url made;
        if (bits_.flag()) {
            made.object = static_cast<std::uint16_t>(bits_.get(10));
            if (made.object == 0) return wrong("an object descriptor of number 0: must be 1 to 1023");
            return made;
        }
        TRY_ASSIGN(auto text, string());
        auto read = url_of(std::move(text));
        if (!read) return wrong("the number of an object descriptor in a URL: must be 1 to 1023");
        return std::move(*read);
    }

    Result<float> real() {
        const auto value = std::bit_cast<float>(static_cast<std::uint32_t>(bits_.get(32)));
        if (!std::isfinite(value)) return wrong("a number that is none");
        return value;
    }

    BitReader bits_;
    BifsConfig config_;
    bool has_names_ = false;
    SceneTree scene_;
    std::vector<std::uint64_t> prototype_ids_;
    std::map<std::uint64_t, NodePtr> named_;
    std::set<std::string> names_;        // their names
    const Prototype* inside_ = nullptr;  // whose body is read
};

/// Finds the nodes that have names, each once, in the order of the binary form.
void find_named(const std::vector<FieldValue>& values, std::vector<const Node*>& found) {
    for (const FieldValue& value : values) {
        const auto* const held = std::get_if<NodePtr>(&value);
        const Node* const node = held ? held->get() : nullptr;
        if (!node || std::ranges::find(found, node) != found.end()) continue;
        if (!node->name.empty()) found.push_back(node);
        for (const Field& field : node->fields) find_named(field.values, found);
    }
}

std::vector<const Node*> named_nodes(const SceneTree& scene) {
    std::vector<const Node*> found;
    for (const Prototype& prototype : scene.prototypes) {
        for (const FieldSpec& field : prototype.fields) find_named(field.initial, found);
        for (const NodePtr& part : prototype.body) find_named({part}, found);
    }
    find_named({scene.root}, found);
    return found;
}

class SceneEncoder {
public:
    SceneEncoder(const SceneTree& scene, const BifsConfig& config) : scene_(scene), config_(config) {
        for (const Node* node : named_nodes(scene)) ids_.emplace(node, ids_.size());
    }
    Result<std::vector<std::uint8_t>> encode() {
        bits_.put(scene_replace, 2);
        bits_.put(0, 6);
        bits_.put(1, 1);  // with names
        for (const Prototype& each : scene_.prototypes) TRY(prototype(each));
        bits_.put(0, 1);
        TRY(node(scene_.root, NodeSlot::top));
        bits_.put(0, 1);  // no routes
        bits_.put(0, 1);  // no command follows
        return bits_.take();
    }

private:
    Result<void> prototype(const Prototype& prototype) {
        bits_.put(1, 1);
        prototype_id(prototype);
        name(prototype.name);
        for (const FieldSpec& spec : prototype.fields) {
            bits_.put(1, 1);
            bits_.put(static_cast<std::uint64_t>(spec.event), 2);
            bits_.put(static_cast<std::uint64_t>(spec.kind.type) + (spec.kind.is_list ? 32 : 0), 6);
            name(spec.name);
            // A field of an EXTERNPROTO states no value.
            const bool is_said = spec.kind.is_list || !spec.initial.empty();
            const std::vector<FieldValue> initial =
                is_said ? spec.initial : std::vector{zero_of(spec.kind.type)};
            TRY(values(spec, initial));
        }
        bits_.put(0, 1);
        bits_.put(prototype.elsewhere.empty() ? 0 : 1, 1);
        if (!prototype.elsewhere.empty()) {
            const FieldSpec urls{"url", {FieldType::url, true}};
            TRY(values(urls, {prototype.elsewhere.begin(), prototype.elsewhere.end()}));
        } else {
            bits_.put(0, 1);  // no prototypes of its own
            inside_ = &prototype;
            for (const NodePtr& part : prototype.body) {
                TRY(node(part, NodeSlot::world));
                bits_.put(&part == &prototype.body.back() ? 0 : 1, 1);
            }
            inside_ = nullptr;
            bits_.put(0, 1);  // no routes
        }
        bits_.put(0, 2);  // neither quantised nor animated
        return {};
    }

    void prototype_id(const Prototype& prototype) {  // from 1
        bits_.put(static_cast<std::uint64_t>(1 + (&prototype - scene_.prototypes.data())),
                  config_.prototype_id_bits);
    }
    Result<void> node(const NodePtr& node, NodeSlot slot) {
        if (!node) {
            no_node();
            return {};
        }
        const bool is_new = node->name.empty() || written_.insert(node.get()).second;
        bits_.put(is_new ? 0 : 1, 1);
        if (!is_new) {
            bits_.put(ids_.at(node.get()), config_.node_id_bits);
            return {};
        }
        TRY(type_code(*node, slot));
        bits_.put(node->name.empty() ? 0 : 1, 1);
        if (!node->name.empty()) {
            bits_.put(ids_.at(node.get()), config_.node_id_bits);
            name(node->name);
        }
        return fields(*node);
    }

    /// Writes a number version by version: 0 leads to the next version, and 1 of version 2 to prototypes.
    Result<void> type_code(const Node& node, NodeSlot slot) {
        const Prototype* const prototype = prototype_named(scene_.prototypes, node.type);
        NodeCode wanted{slot, 2, 1};
        if (!prototype) {
            const NodeType* const type = node_type(node.type);
            const auto fits = [slot](const NodeCode& each) { return each.slot == slot; };
            const auto code =
                type ? std::ranges::find_if(type->codes, fits) : std::vector<NodeCode>::const_iterator();
            if (!type || code == type->codes.end())
                return input_error(printable(node.type) + ": MPEG-4 has no such node" +
                                   (type && !type->codes.empty() ? " there" : "; a PROTO could define it"));
            wanted = *code;
        }
        for (int version = 1; version < wanted.version; ++version) bits_.put(0, code_bits(slot, version));
        bits_.put(static_cast<std::uint64_t>(wanted.code), code_bits(slot, wanted.version));
        if (prototype) prototype_id(*prototype);
        return {};
    }

    /// Writes fields that differ from their initial values, by a mask or as a list, whichever is shorter. In
    /// a prototype's body the mask has all fields, and a field that is an outer one (IS) is numbered among
    /// all; otherwise only fields that can have a value count.
    Result<void> fields(const Node& node) {
        const auto& specs = *fields_of(scene_.prototypes, node.type);
        const std::size_t standard = fields_in_bits(scene_, node).size();
        struct Item {
            const FieldSpec* spec;
            const Field* given;  // null: the initial value
            std::size_t number;  // among those that can have a value
        };
        std::vector<Item> items;
        std::size_t with_values = 0, said = 0;
        for (std::size_t k = 0; k < specs.size(); ++k) {
            const FieldSpec& spec = specs[k];
            const Field* given = node.field(spec.name);
            if (given && given->is.empty() && given->values == spec.initial) given = nullptr;
            if (k >= standard) {
                if (given)
                    return input_error(node.type + '.' + spec.name +
                                       ": MPEG-4 has no such field; a PROTO could define it");
                continue;
            }
            items.push_back({&spec, given, with_values});
            with_values += spec.has_value() ? 1 : 0;
            said += given ? 1 : 0;
        }
        const int number_bits = bits_for(with_values - 1);
        const bool by_mask = with_values < 1 + said * (1 + static_cast<std::size_t>(number_bits));
        bits_.put(by_mask ? 1 : 0, 1);
        for (std::size_t k = 0; k < items.size(); ++k) {
            const Item& item = items[k];
            if (by_mask) {
                if (!inside_ && !item.spec->has_value()) continue;
                bits_.put(item.given ? 1 : 0, 1);
            }
            if (!item.given) continue;
            if (!by_mask) bits_.put(0, 1);
            const bool is_outer = !item.given->is.empty();
            if (inside_) bits_.put(is_outer ? 1 : 0, 1);
            if (!by_mask) {
                if (is_outer)
                    bits_.put(k, bits_for(items.size() - 1));
                else
                    bits_.put(item.number, number_bits);
            }
            if (auto put = field(*item.given, *item.spec); !put)
                return error_at(printable(node.type), put.error());
        }
        if (!by_mask) bits_.put(1, 1);
        return {};
    }

    Result<void> field(const Field& field, const FieldSpec& spec) {
        if (field.is.empty()) return values(spec, field.values);
        const auto& outer = inside_->fields;
        const FieldSpec* const meant = field_named(outer, field.is);
        bits_.put(static_cast<std::uint64_t>(meant - outer.data()), bits_for(outer.size() - 1));
        return {};
    }

    Result<void> values(const FieldSpec& spec, const std::vector<FieldValue>& values) {
        if (!spec.kind.is_list) return value(values.front(), spec.slot);
        const std::size_t count = values.size();
        const int count_bits = bits_for(count);
        bits_.put(0, 1);
        const bool as_list = static_cast<std::size_t>(count_bits) + 5 > count + 1;
        bits_.put(as_list ? 1 : 0, 1);
        if (!as_list) {
            bits_.put(static_cast<std::uint64_t>(count_bits), 5);
            bits_.put(count, count_bits);
        }
        for (const FieldValue& each : values) {
            if (as_list) bits_.put(0, 1);
            TRY(value(each, spec.slot));
        }
        if (as_list) bits_.put(1, 1);
        return {};
    }

    Result<void> value(const FieldValue& value, NodeSlot slot) {
        const auto put = [&](const auto& each) -> Result<void> {
            using T = std::decay_t<decltype(each)>;
            if constexpr (std::is_same_v<T, bool>) {
                bits_.put(each ? 1 : 0, 1);
            } else if constexpr (std::is_same_v<T, float>) {
                return real(each);
            } else if constexpr (std::is_same_v<T, double>) {
                bits_.put(std::bit_cast<std::uint64_t>(each), 64);
            } else if constexpr (std::is_same_v<T, std::int32_t>) {
                bits_.put(static_cast<std::uint32_t>(each), 32);
            } else if constexpr (std::is_same_v<T, std::string>) {
                string(each);
            } else if constexpr (std::is_same_v<T, NodePtr>) {
                return node(each, slot);
            } else if constexpr (std::is_same_v<T, Url>) {
                bits_.put(each.object > 0 ? 1 : 0, 1);
                if (each.object > 0)
                    bits_.put(each.object, 10);
                else
                    string(each.file);
            } else {
                for (const float number : each) TRY(real(number));
            }
            return {};
        };
        return std::visit(put, value);
    }

    void name(const std::string& text) {
        for (const char c : text) bits_.put(static_cast<std::uint8_t>(c), 8);
        bits_.put(0, 8);
    }
    void string(const std::string& text) {
        const int size_bits = bits_for(text.size());
        bits_.put(static_cast<std::uint64_t>(size_bits), 5);
        bits_.put(text.size(), size_bits);
        for (const char c : text) bits_.put(static_cast<std::uint8_t>(c), 8);
    }
    Result<void> real(float number) {
        if (!std::isfinite(number)) return input_error("has a number that four bytes cannot hold");
        bits_.put(std::bit_cast<std::uint32_t>(number), 32);
        return {};
    }
    void no_node() {
        bits_.put(1, 1);
        bits_.put(~std::uint64_t{0}, config_.node_id_bits);
    }

    const SceneTree& scene_;
    BifsConfig config_;
    BitWriter bits_;
    std::map<const Node*, std::size_t> ids_;
    std::set<const Node*> written_;
    const Prototype* inside_ = nullptr;  // whose body is written
};

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

BifsConfig config_for(const SceneTree& scene, int width, int height) {
    BifsConfig config{.width = width, .height = height};
    config.version = scene.prototypes.empty() ? 1 : 2;
    config.node_id_bits = std::max(1, bits_for(named_nodes(scene).size()));
    config.prototype_id_bits = bits_for(scene.prototypes.size());
    return config;
}

std::vector<std::uint8_t> encode_config(const BifsConfig& config) {
    BitWriter bits;
    if (config.version > 1) bits.put(0, 2);  // no compressed mesh, no predictive fields
    bits.put(static_cast<std::uint64_t>(config.node_id_bits), 5);
    bits.put(static_cast<std::uint64_t>(config.route_id_bits), 5);
    if (config.version > 1) bits.put(static_cast<std::uint64_t>(config.prototype_id_bits), 5);
    bits.put(1, 1);  // commands
    bits.put(1, 1);  // lengths are pixels
    const bool has_size = config.width > 0 && config.height > 0;
    bits.put(has_size ? 1 : 0, 1);
    if (has_size) {
        bits.put(static_cast<std::uint64_t>(config.width), 16);
        bits.put(static_cast<std::uint64_t>(config.height), 16);
    }
    return bits.take();
}

Result<std::vector<std::uint8_t>> encode_scene(const SceneTree& scene, const BifsConfig& config) {
    return SceneEncoder(scene, config).encode();
}

}  // namespace touchable::mpeg4
