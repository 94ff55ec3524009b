#include <set>
#include <type_traits>

#include "engine/base/number_words.hpp"
#include "engine/mpeg4/node_types.hpp"
#include "engine/mpeg4/scene_text.hpp"

namespace touchable::mpeg4 {
namespace {

std::string quoted_text(const std::string& text) {
    std::string quoted = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') quoted += '\\';
        quoted += c;
    }
    return quoted + '"';
}

class TextWriter {
public:
    std::string write(const SceneTree& scene);

private:
    void prototype(const Prototype& prototype);
    void node(const NodePtr& node, int depth);
    void values(FieldKind kind, const std::vector<FieldValue>& values, int depth);
    void value(const FieldValue& value, int depth);
    void line(int depth) { text_ += '\n' + std::string(2 * static_cast<std::size_t>(depth), ' '); }

    std::span<const Prototype> prototypes_;
    std::set<const Node*> written_;  // those with names, which are used from now on
    std::string text_;
};

std::string TextWriter::write(const SceneTree& scene) {
    prototypes_ = scene.prototypes;
    for (const Prototype& each : scene.prototypes) prototype(each);
    node(scene.root, 0);
    text_ += '\n';
    return std::move(text_);
}

void TextWriter::prototype(const Prototype& prototype) {
    text_ += (prototype.elsewhere.empty() ? "PROTO " : "EXTERNPROTO ") + prototype.name + " [";
    for (const FieldSpec& spec : prototype.fields) {
        line(1);
        text_ += spec.event == FieldEvent::field ? "field " : "exposedField ";
        text_ += std::string(kind_name(spec.kind)) + ' ' + spec.name;
        if (!prototype.elsewhere.empty()) continue;
        text_ += ' ';
        values(spec.kind, spec.initial, 1);
    }
    line(0);
    text_ += "] ";
    if (!prototype.elsewhere.empty()) {
        values({FieldType::url, true}, {prototype.elsewhere.begin(), prototype.elsewhere.end()}, 0);
    } else {
        text_ += '{';
        for (const NodePtr& part : prototype.body) {
            line(1);
            node(part, 1);
        }
        line(0);
        text_ += '}';
    }
    text_ += '\n';
}

void TextWriter::node(const NodePtr& node, int depth) {
    if (!node) {
        text_ += "NULL";
        return;
    }
    if (!node->name.empty()) {
        const bool is_new = written_.insert(node.get()).second;
        text_ += (is_new ? "DEF " : "USE ") + node->name;
        if (!is_new) return;
        text_ += ' ';
    }
    text_ += node->type + " {";
    const auto* specs = fields_of(prototypes_, node->type);
    for (const Field& field : node->fields) {
        line(depth + 1);
        text_ += field.name + ' ';
        if (!field.is.empty()) {
            text_ += "IS " + field.is;
            continue;
        }
        for (const FieldSpec& spec : *specs)
            if (spec.name == field.name) values(spec.kind, field.values, depth + 1);
    }
    if (!node->fields.empty()) line(depth);
    text_ += '}';
}

void TextWriter::values(FieldKind kind, const std::vector<FieldValue>& values, int depth) {
    if (!kind.is_list) {
        value(values.front(), depth);
        return;
    }
    const bool by_line =
        kind.type == FieldType::node || (kind.type == FieldType::string && values.size() > 1);
    text_ += '[';
    for (const FieldValue& each : values) {
        if (by_line)
            line(depth + 1);
        else if (&each != &values.front())
            text_ += ' ';
        value(each, depth + 1);
    }
    if (by_line) line(depth);
    text_ += ']';
}

void TextWriter::value(const FieldValue& value, int depth) {
    const auto say = [&](const auto& each) {
        using T = std::decay_t<decltype(each)>;
        if constexpr (std::is_same_v<T, bool>) {
            text_ += each ? "TRUE" : "FALSE";
        } else if constexpr (std::is_arithmetic_v<T>) {
            text_ += exact_number(each);
        } else if constexpr (std::is_same_v<T, std::string>) {
            text_ += quoted_text(each);
        } else if constexpr (std::is_same_v<T, NodePtr>) {
            node(each, depth);
        } else if constexpr (std::is_same_v<T, Url>) {
            text_ += each.object > 0 ? exact_number(each.object) : quoted_text(each.file);
        } else {
            for (const float& number : each)
                text_ += (&number == each.data() ? "" : " ") + exact_number(number);
        }
    };
    std::visit(say, value);
}

}  // namespace

std::string scene_text(const SceneTree& scene) {
    return TextWriter().write(scene);
}

}  // namespace touchable::mpeg4
