#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <set>
#include <type_traits>
#include <utility>

#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"
#include "engine/mpeg4/bifs.hpp"
#include "engine/mpeg4/bit_stream.hpp"
#include "engine/mpeg4/node_types.hpp"

namespace touchable::mpeg4 {
namespace {

constexpr std::uint64_t scene_replace = 3;

void find_named(const NodePtr& node, std::vector<const Node*>& found);

void find_named(const std::vector<FieldValue>& values, std::vector<const Node*>& found) {
    for (const FieldValue& value : values)
        if (const auto* inner = std::get_if<NodePtr>(&value)) find_named(*inner, found);
}

/// The nodes that have names, each once, in the order in which the binary form meets them.
void find_named(const NodePtr& node, std::vector<const Node*>& found) {
    if (!node || std::find(found.begin(), found.end(), node.get()) != found.end()) return;
    if (!node->name.empty()) found.push_back(node.get());
    for (const Field& field : node->fields) find_named(field.values, found);
}

std::vector<const Node*> named_nodes(const SceneTree& scene) {
    std::vector<const Node*> found;
    for (const Prototype& prototype : scene.prototypes) {
        for (const FieldSpec& field : prototype.fields) find_named(field.initial, found);
        for (const NodePtr& part : prototype.body) find_named(part, found);
    }
    find_named(scene.root, found);
    return found;
}

/// What a field of an EXTERNPROTO, which says no value, has.
FieldValue zero_of(FieldType type) {
    switch (type) {
        case FieldType::boolean:
            return false;
        case FieldType::real:
            return 0.0F;
        case FieldType::time:
            return 0.0;
        case FieldType::string:
            return std::string();
        case FieldType::integer:
            return std::int32_t{0};
        case FieldType::vec2:
            return std::array<float, 2>{};
        case FieldType::vec3:
        case FieldType::colour:
            return std::array<float, 3>{};
        case FieldType::rotation:
            return std::array<float, 4>{};
        case FieldType::node:
            return NodePtr();
        case FieldType::url:
            break;
    }
    return Url();
}

class SceneEncoder {
public:
    SceneEncoder(const SceneTree& scene, const BifsConfig& config) : scene_(scene), config_(config) {
        for (const Node* node : named_nodes(scene)) ids_.emplace(node, ids_.size());
    }
    Result<std::vector<std::uint8_t>> encode();

private:
    Result<void> prototype(const Prototype& prototype);
    void prototype_id(const Prototype& prototype) {  // from 1
        bits_.put(static_cast<std::uint64_t>(1 + (&prototype - scene_.prototypes.data())),
                  config_.prototype_id_bits);
    }
    Result<void> node(const NodePtr& node, NodeSlot slot);
    Result<void> type_code(const Node& node, NodeSlot slot);
    Result<void> fields(const Node& node);
    Result<void> field(const Field& field, const FieldSpec& spec);
    Result<void> values(const FieldSpec& spec, const std::vector<FieldValue>& values);
    Result<void> value(const FieldValue& value, NodeSlot slot);
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

Result<std::vector<std::uint8_t>> SceneEncoder::encode() {
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

Result<void> SceneEncoder::prototype(const Prototype& prototype) {
    bits_.put(1, 1);
    prototype_id(prototype);
    name(prototype.name);
    for (const FieldSpec& spec : prototype.fields) {
        bits_.put(1, 1);
        bits_.put(static_cast<std::uint64_t>(spec.event), 2);
        bits_.put(static_cast<std::uint64_t>(spec.kind.type) + (spec.kind.is_list ? 32 : 0), 6);
        name(spec.name);
        const bool is_said = spec.kind.is_list || !spec.initial.empty();
        const std::vector<FieldValue> initial = is_said ? spec.initial : std::vector{zero_of(spec.kind.type)};
        if (auto put = values(spec, initial); !put) return put;
    }
    bits_.put(0, 1);
    bits_.put(prototype.elsewhere.empty() ? 0 : 1, 1);
    if (!prototype.elsewhere.empty()) {
        const FieldSpec urls{"url", {FieldType::url, true}};
        if (auto put = values(urls, {prototype.elsewhere.begin(), prototype.elsewhere.end()}); !put)
            return put;
    } else {
        bits_.put(0, 1);  // no prototypes of its own
        inside_ = &prototype;
        for (const NodePtr& part : prototype.body) {
            if (auto put = node(part, NodeSlot::world); !put) return put;
            bits_.put(&part == &prototype.body.back() ? 0 : 1, 1);
        }
        inside_ = nullptr;
        bits_.put(0, 1);  // no routes
    }
    bits_.put(0, 2);  // neither quantised nor animated
    return {};
}

Result<void> SceneEncoder::node(const NodePtr& node, NodeSlot slot) {
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
    if (auto put = type_code(*node, slot); !put) return put;
    bits_.put(node->name.empty() ? 0 : 1, 1);
    if (!node->name.empty()) {
        bits_.put(ids_.at(node.get()), config_.node_id_bits);
        name(node->name);
    }
    return fields(*node);
}

/// By version: 0 leads to the next one's numbers, and 1 of version 2 to prototypes.
Result<void> SceneEncoder::type_code(const Node& node, NodeSlot slot) {
    const Prototype* const prototype = prototype_named(scene_.prototypes, node.type);
    NodeCode wanted{slot, 2, 1};
    if (!prototype) {
        const NodeType* const type = node_type(node.type);
        const auto fits = [slot](const NodeCode& each) { return each.slot == slot; };
        const auto code = type ? std::find_if(type->codes.begin(), type->codes.end(), fits)
                               : std::vector<NodeCode>::const_iterator();
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

/// Those that differ from their initial values, by a mask or as a list, whichever is shorter. The body of a
/// prototype numbers all fields of a node, everything else only those that can have a value.
Result<void> SceneEncoder::fields(const Node& node) {
    const auto& specs = *fields_of(scene_.prototypes, node.type);
    const NodeType* const known =
        prototype_named(scene_.prototypes, node.type) ? nullptr : node_type(node.type);
    const std::size_t standard = specs.size() - static_cast<std::size_t>(known ? known->paper_fields : 0);
    struct Item {
        const FieldSpec* spec;
        const Field* given;  // null: nothing to say
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

Result<void> SceneEncoder::field(const Field& field, const FieldSpec& spec) {
    if (field.is.empty()) return values(spec, field.values);
    const auto& outer = inside_->fields;
    const auto meant = std::find_if(outer.begin(), outer.end(),
                                    [&](const FieldSpec& each) { return each.name == field.is; });
    bits_.put(static_cast<std::uint64_t>(meant - outer.begin()), bits_for(outer.size() - 1));
    return {};
}

Result<void> SceneEncoder::values(const FieldSpec& spec, const std::vector<FieldValue>& values) {
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
        if (auto put = value(each, spec.slot); !put) return put;
    }
    if (as_list) bits_.put(1, 1);
    return {};
}

Result<void> SceneEncoder::value(const FieldValue& value, NodeSlot slot) {
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
            for (const float number : each)
                if (auto written = real(number); !written) return written;
        }
        return {};
    };
    return std::visit(put, value);
}

}  // namespace

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
